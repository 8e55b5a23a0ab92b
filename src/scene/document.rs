//! The text of a recipe: where each key stands, what `--set` puts in its place, and errors that say so.

use super::accuracy::Accuracy;
use super::error::{Finding, SceneError};
use super::recipe::Recipe;
use serde::Deserialize;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// A recipe as tables, with the place of every key.
pub struct Document<'a> {
    file: String,
    text: &'a str,
    overrides: Vec<&'a str>,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// Reads TOML; `file` is what messages call it.
    pub fn parse(file: &str, text: &'a str) -> Result<Self, SceneError> {
        let root = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(text.len(), |span| span.start);
            SceneError::Keys(vec![Finding {
                place: format!("{file}:{}", line(text, at)),
                key: String::new(),
                message: error.message().to_owned(),
            }])
        })?;
        Ok(Self {
            file: file.to_owned(),
            text,
            overrides: Vec::new(),
            root,
        })
    }

    /// Applies `path=value`, for example `inlet[0].flow_rate=4 ml/min`; the value is TOML, or else text.
    pub fn r#override(&mut self, text: &'a str) -> Result<(), SceneError> {
        let refuse = |reason: String| SceneError::Override {
            text: text.to_owned(),
            reason,
        };
        let (path, value) = text
            .split_once('=')
            .ok_or_else(|| refuse("expected path=value".to_owned()))?;
        let steps = steps(path.trim()).map_err(refuse)?;
        // Beyond the end of the text: the place of an override is its own words.
        let at = self.text.len() + 1 + self.overrides.len();
        set(self.root.get_mut(), &steps, typed(value.trim(), at), at).map_err(refuse)?;
        self.overrides.push(text);
        Ok(())
    }

    /// Gives every key its type; `accuracy` and the time step fill in what is not given.
    pub fn recipe(&self) -> Result<Recipe, SceneError> {
        let typed = Recipe::deserialize(toml::Deserializer::from(self.with_preset()));
        let recipe = typed.map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let key = path_of(self.root.get_ref(), &span).unwrap_or_default();
            let (key, message) = explain(key, error.message());
            SceneError::Keys(vec![Finding {
                place: self.place(span.start),
                key,
                message,
            }])
        })?;
        Ok(Recipe {
            time_step: recipe.time_step.filled(),
            ..recipe
        })
    }

    /// The tables with what the preset named by `accuracy` says about keys that are not given.
    fn with_preset(&self) -> Spanned<DeTable<'a>> {
        let mut root = self.root.clone();
        let named = self.root.get_ref().get("accuracy");
        let preset = named.and_then(|value| Accuracy::named(value.get_ref().as_str()?));
        let (Some(named), Some(preset)) = (named, preset) else {
            return root;
        };
        let at = named.span().start;
        for &(path, value) in preset.keys() {
            let steps = steps(path).unwrap_or_default();
            if !gives(root.get_ref(), &steps) {
                // A key that stands where a table belongs is refused when it gets its type.
                let _ = set(root.get_mut(), &steps, typed(value, at), at);
            }
        }
        root
    }

    /// Where a key stands, or else the table that should hold it.
    pub fn place_of(&self, key: &str) -> String {
        let mut at = 0;
        let mut table = Some(self.root.get_ref());
        let mut array: Option<&DeArray<'_>> = None;
        for step in steps(key).unwrap_or_default() {
            let value = match step {
                Step::Key(name) => table.and_then(|t| t.get_key_value(name)).map(|(k, v)| {
                    at = k.span().start;
                    v
                }),
                Step::Index(n) => array
                    .and_then(|a| a.get(n))
                    .inspect(|v| at = v.span().start),
            };
            let Some(value) = value else { break };
            table = value.get_ref().as_table();
            array = value.get_ref().as_array();
        }
        self.place(at)
    }

    fn place(&self, at: usize) -> String {
        match self.overrides.get(at.wrapping_sub(self.text.len() + 1)) {
            Some(set) => format!("--set {set}"),
            None => format!("{}:{}", self.file, line(self.text, at)),
        }
    }
}

fn line(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

enum Step<'p> {
    Key(&'p str),
    Index(usize),
}

/// `inlet[0].flow_rate` → inlet, 0, flow_rate.
fn steps(path: &str) -> Result<Vec<Step<'_>>, String> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() {
            return Err(format!("`{path}` is not a path such as inlet[0].flow_rate"));
        }
        steps.push(Step::Key(name));
        while let Some((index, after)) = rest.strip_prefix('[').and_then(|r| r.split_once(']')) {
            let index = index
                .parse()
                .map_err(|_| format!("[{index}] is not an index"))?;
            steps.push(Step::Index(index));
            rest = after;
        }
        if !rest.is_empty() {
            return Err(format!("`{rest}` is not an index such as [0]"));
        }
    }
    Ok(steps)
}

/// The value as TOML (`2.4`, `["0 m", "0 m", "1 m"]`), or else as text (`4 ml/min`); all of it stands at `at`.
fn typed(value: &str, at: usize) -> DeValue<'_> {
    match DeValue::parse(value) {
        Ok(parsed) => moved(parsed.into_inner(), at),
        Err(_) => DeValue::String(Cow::Borrowed(value)),
    }
}

fn moved<'a>(value: DeValue<'a>, at: usize) -> DeValue<'a> {
    let place = |value: Spanned<DeValue<'a>>| Spanned::new(at..at, moved(value.into_inner(), at));
    match value {
        DeValue::Array(items) => DeValue::Array(items.into_iter().map(place).collect()),
        DeValue::Table(entries) => DeValue::Table(
            entries
                .into_iter()
                .map(|(key, value)| (Spanned::new(at..at, key.into_inner()), place(value)))
                .collect(),
        ),
        leaf => leaf,
    }
}

/// Walks to the place, making tables on the way, and puts the value there.
fn set<'a>(
    table: &mut DeTable<'a>,
    steps: &[Step<'a>],
    value: DeValue<'a>,
    at: usize,
) -> Result<(), String> {
    let Some((Step::Key(name), rest)) = steps.split_first() else {
        return Err("expected a key".to_owned());
    };
    if !table.contains_key(*name) {
        let empty = Spanned::new(at..at, DeValue::Table(DeTable::new()));
        table.insert(Spanned::new(at..at, Cow::Borrowed(*name)), empty);
    }
    let mut slot = table.get_mut(*name).ok_or("no such key")?;
    let mut rest = rest;
    while let Some((Step::Index(index), after)) = rest.split_first() {
        let DeValue::Array(items) = slot.get_mut() else {
            return Err(format!("`{name}` is no list"));
        };
        let length = items.len();
        slot = items
            .get_mut(*index)
            .ok_or_else(|| format!("`{name}` has {length} entries, counted from [0]"))?;
        rest = after;
    }
    if rest.is_empty() {
        *slot = Spanned::new(at..at, value);
        return Ok(());
    }
    match slot.get_mut() {
        DeValue::Table(inner) => set(inner, rest, value, at),
        _ => Err(format!("`{name}` is no table")),
    }
}

/// Whether a key is given, or for the step's length a `fixed` one, which leaves no room for others.
fn gives(table: &DeTable<'_>, steps: &[Step<'_>]) -> bool {
    match steps {
        [Step::Key(name)] => table.contains_key(*name) || table.contains_key("fixed"),
        [Step::Key(name), rest @ ..] => table
            .get(*name)
            .and_then(|value| value.get_ref().as_table())
            .is_some_and(|inner| gives(inner, rest)),
        _ => false,
    }
}

/// The path of the innermost key or value that covers `span`.
fn path_of(table: &DeTable<'_>, span: &Range<usize>) -> Option<String> {
    let mut best: Option<(usize, String)> = None;
    let mut offer = |covering: Range<usize>, path: &str| {
        let covers = covering.start <= span.start && span.end <= covering.end;
        let closer = best.as_ref().is_none_or(|b| covering.len() <= b.0);
        if covers && closer {
            best = Some((covering.len(), path.to_owned()));
        }
    };
    visit_table(table, "", &mut offer);
    best.map(|(_, path)| path)
}

fn visit_table(table: &DeTable<'_>, path: &str, offer: &mut dyn FnMut(Range<usize>, &str)) {
    for (key, value) in table {
        let dot = if path.is_empty() { "" } else { "." };
        let path = format!("{path}{dot}{}", key.get_ref());
        offer(key.span(), &path);
        visit(value, &path, offer);
    }
}

fn visit(value: &Spanned<DeValue<'_>>, path: &str, offer: &mut dyn FnMut(Range<usize>, &str)) {
    offer(value.span(), path);
    match value.get_ref() {
        DeValue::Table(table) => visit_table(table, path, offer),
        DeValue::Array(items) => {
            for (n, item) in items.iter().enumerate() {
                visit(item, &format!("{path}[{n}]"), offer);
            }
        }
        _ => {}
    }
}

/// Serde's words, made shorter and kinder: the missing key named, the nearest known word offered.
fn explain(key: String, message: &str) -> (String, String) {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let (Some((found, known)), is) = (quoted.split_first(), |start| message.starts_with(start))
    else {
        return (key, message.to_owned());
    };
    if is("missing field") {
        let dot = if key.is_empty() { "" } else { "." };
        return (format!("{key}{dot}{found}"), "is missing".to_owned());
    }
    if !is("unknown field") && !is("unknown variant") {
        return (key, message.to_owned());
    }
    let nearest = known
        .iter()
        .map(|word| (strsim::damerau_levenshtein(found, word), word))
        .filter(|(distance, word)| *distance <= 1 + word.len() / 3)
        .min_by_key(|(distance, _)| *distance);
    let what = if is("unknown field") {
        "is no key here".to_owned()
    } else {
        format!("`{found}` is not known")
    };
    let hint = nearest.map_or(String::new(), |(_, word)| {
        format!(", did you mean `{word}`?")
    });
    let list = known.join(", ");
    (key, format!("{what}{hint} (known: {list})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RECIPE: &str = r#"
name = "tank"
spacing = "1 mm"
duration = "1 s"
frames_per_second = "24 1/s"

[domain]
min = ["0 mm", "0 mm", "0 mm"]
max = ["40 mm", "40 mm", "40 mm"]

[cement]
relaxation_time = "0.1 s"

[[inlet]]
name = "needle"
position = ["20 mm", "20 mm", "30 mm"]
direction = [0, 0, -1]
diameter = "4 mm"
flow_rate = "4 ml/min"
ratio = "0.45:0.55"
dose = "0.01 ml"
"#;

    /// The one error of the recipe after `from` is written as `to`.
    fn error(from: &str, to: &str) -> String {
        assert!(RECIPE.contains(from));
        let text = RECIPE.replacen(from, to, 1);
        let document = Document::parse("scene.toml", &text);
        document.and_then(|d| d.recipe()).unwrap_err().to_string()
    }

    #[test]
    fn errors_name_file_line_key_and_cure() {
        assert_eq!(
            error("\"4 ml/min\"", "4"),
            "scene.toml:19: inlet[0].flow_rate: expected a flow rate such as \"4 ml/min\", found 4"
        );
        assert_eq!(
            error("\"1 mm\"", "\"1 s\""),
            "scene.toml:3: spacing: \"1 s\" is a time, a length belongs here"
        );
        assert_eq!(
            error("[\"40 mm\", \"40 mm\"", "[\"40 mm\", 40"),
            "scene.toml:9: domain.max[1]: expected a length such as \"0.5 mm\", found 40"
        );
        let unknown = error("relaxation_time", "relaxtion_time");
        assert!(
            unknown.starts_with(
                "scene.toml:12: cement.relaxtion_time: is no key here, did you mean `relaxation_time`?"
            ),
            "{unknown}"
        );
        let variant = error("name = \"tank\"", "name = \"tank\"\nscheme = \"imm-ct\"");
        assert!(
            variant
                .starts_with("scene.toml:3: scheme: `imm-ct` is not known, did you mean `imm_ct`?"),
            "{variant}"
        );
        let missing = error("dose = \"0.01 ml\"", "");
        assert_eq!(missing, "scene.toml:14: inlet[0].dose: is missing");
        assert_eq!(
            error("spacing = \"1 mm\"", ""),
            "scene.toml:1: spacing: is missing"
        );
        assert!(error("[domain]", "[domain").starts_with("scene.toml:7: "));
        assert!(error("duration", "name").starts_with("scene.toml:4: duplicate key"));
    }

    #[test]
    fn overrides_replace_and_add_keys_and_are_named_in_errors() {
        let mut document = Document::parse("scene.toml", RECIPE).unwrap();
        for set in [
            "inlet[0].flow_rate=2 ml/min",
            "time_step.cfl=0.3",
            "gravity=[\"0 m/s2\", \"0 m/s2\", \"-1 m/s2\"]",
            "name = \"other\"",
        ] {
            document.r#override(set).unwrap();
        }
        let recipe = document.recipe().unwrap();
        assert_eq!(recipe.inlet[0].flow_rate.si(), 2e-6 / 60.0);
        assert_eq!(recipe.time_step.cfl, Some(0.3));
        assert_eq!(recipe.gravity[2].si(), -1.0);
        assert_eq!(recipe.name, "other");
        assert_eq!(
            document.place_of("time_step.cfl"),
            "--set time_step.cfl=0.3"
        );
        assert_eq!(document.place_of("cement.relaxation_time"), "scene.toml:12");
        assert_eq!(
            document.place_of("inlet[0].polymer_fraction"),
            "scene.toml:14"
        );

        document.r#override("cement.thinning=5").unwrap();
        let message = document.recipe().unwrap_err().to_string();
        assert_eq!(
            message,
            "--set cement.thinning=5: cement.thinning: expected a rate such as \"0.5 1/s\", found 5"
        );
        for refused in [
            "spacing",
            "inlet[7].dose=1 ml",
            "spacing.x=1",
            "[0]=1",
            "inlet[0]]=1",
        ] {
            let message = document.r#override(refused).unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("--set {refused}: ")),
                "{message}"
            );
        }
    }

    #[test]
    fn the_lock_reads_back_to_the_same_recipe() {
        let recipe = Document::parse("scene.toml", RECIPE)
            .unwrap()
            .recipe()
            .unwrap();
        let lock = toml::to_string(&recipe).unwrap();
        let again = Document::parse("lock.toml", &lock)
            .unwrap()
            .recipe()
            .unwrap();
        assert_eq!(again, recipe);
    }

    proptest! {
        #[test]
        fn damaged_recipes_never_panic(at in 0..RECIPE.len(), with in ".{0,4}", set in "[a-z.\\[\\]0-9=]{0,12}") {
            let text = format!("{}{with}{}", &RECIPE[..at], &RECIPE[at..]);
            if let Ok(mut document) = Document::parse("scene.toml", &text) {
                let _ = document.r#override(&set).map_err(|e| e.to_string());
                let _ = document.recipe().map_err(|e| e.to_string());
            }
        }
    }
}
