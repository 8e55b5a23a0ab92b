//! Presets of the numerics: how exact a run is to be at the spacing that it has.
//!
//! Values are those of `study accuracy` (`accuracy-knobs.csv`): at a given spacing the step decides, the support radius
//! decides the time, and the solvers' tolerance neither (a tenth and ten times the usual change errors by a tenth).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How exact a run is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// A small support radius: 0.65 of the time, errors of a channel 1.1 times as large. Pressure at rest may alternate
    /// from layer to layer.
    Fast,
    /// As if nothing were said.
    Balanced,
    /// A quarter of the step: three times the time, 0.35 of the error of a starting channel, 0.6 of an Oldroyd-B one (in
    /// a stirred tank 0.8: there the spacing decides).
    Accurate,
}

impl Accuracy {
    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            ("fast", Self::Fast),
            ("balanced", Self::Balanced),
            ("accurate", Self::Accurate),
        ];
        all.into_iter().find(|one| one.0 == name).map(|one| one.1)
    }

    /// The keys of a recipe that it stands for, and their values.
    pub fn keys(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Fast => &[
                ("stress", "coupled"),
                ("support_ratio", "2.0"),
                ("time_step.cfl", "0.4"),
            ],
            Self::Balanced => &[
                ("stress", "coupled"),
                ("support_ratio", "2.4"),
                ("time_step.cfl", "0.4"),
            ],
            Self::Accurate => &[
                ("stress", "coupled"),
                ("support_ratio", "2.4"),
                ("time_step.cfl", "0.1"),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Document, Recipe};
    use crate::sim::StressStep;

    const REST: &str = r#"
name = "drop"
spacing = "1 mm"
duration = "1 s"
frames_per_second = "10 1/s"
domain = { min = ["0 mm", "0 mm", "0 mm"], max = ["9 mm", "9 mm", "9 mm"] }
"#;

    fn recipe(more: &str, set: &str) -> Result<Recipe, String> {
        let text = format!("{more}{REST}");
        let mut document = Document::parse("r.toml", &text).unwrap();
        if !set.is_empty() {
            document.r#override(set).unwrap();
        }
        document.recipe().map_err(|error| error.to_string())
    }

    #[test]
    fn a_preset_fills_in_what_is_not_given() {
        let plain = recipe("", "").unwrap();
        let balanced = recipe("accuracy = \"balanced\"\n", "").unwrap();
        assert_eq!(balanced.accuracy, Some(Accuracy::Balanced));
        // Balanced is as if nothing were said.
        assert_eq!(
            Recipe {
                accuracy: None,
                ..balanced
            },
            plain
        );
        let [fast, accurate] =
            ["fast", "accurate"].map(|name| recipe("", &format!("accuracy={name}")).unwrap());
        assert!(accurate.time_step.cfl < plain.time_step.cfl);
        assert!(fast.support_ratio < plain.support_ratio);
        // The spacing stays the user's.
        assert!([fast, accurate].iter().all(|r| r.spacing == plain.spacing));
    }

    #[test]
    fn keys_that_are_given_win_and_a_filled_in_recipe_means_the_same() {
        let given = "accuracy = \"accurate\"\ntime_step = { cfl = 0.3 }\nstress = \"explicit\"\n";
        let first = recipe(given, "").unwrap();
        assert_eq!(first.time_step.cfl, Some(0.3));
        assert_eq!(first.stress, StressStep::Explicit);
        let text = first.to_toml();
        let again = Document::parse("lock.toml", &text).unwrap();
        assert_eq!(again.recipe().unwrap(), first);
        let fixed = "accuracy = \"accurate\"\ntime_step = { fixed = \"1 ms\" }\n";
        assert_eq!(recipe(fixed, "").unwrap().time_step.cfl, None);
        let set = recipe("accuracy = \"accurate\"\n", "time_step.cfl=0.2").unwrap();
        assert_eq!(set.time_step.cfl, Some(0.2));
    }

    #[test]
    fn a_preset_that_is_none_is_refused_at_its_key() {
        let message = recipe("accuracy = \"fastest\"\n", "").unwrap_err();
        assert!(
            message.starts_with("r.toml:1: accuracy: `fastest` is not known (known: fast,"),
            "{message}"
        );
        let table = recipe("accuracy = \"fast\"\ntime_step = 3\n", "").unwrap_err();
        assert!(table.starts_with("r.toml:2: time_step"), "{table}");
    }
}
