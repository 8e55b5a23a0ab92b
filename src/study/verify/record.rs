//! What each figure came to when it was last recorded in the project.

use crate::math::Real;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Figures by level, case and name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Record(BTreeMap<String, Real>);

impl Record {
    /// recorded.toml of the project.
    pub fn of_the_project() -> Self {
        toml::from_str(include_str!("recorded.toml")).expect("the project's own file")
    }

    pub fn get(&self, key: &str) -> Option<Real> {
        self.0.get(key).copied()
    }

    /// Notes a figure; what is not a number has no place in a record.
    pub fn set(&mut self, key: String, reached: Real) {
        if reached.is_finite() {
            self.0.insert(key, reached);
        }
    }

    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("words and numbers")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::verify::CASES;

    #[test]
    fn the_record_reads_back_and_names_only_cases_that_there_are() {
        let record = Record::of_the_project();
        assert!(!record.0.is_empty());
        assert_eq!(toml::from_str::<Record>(&record.to_toml()).unwrap(), record);
        for key in record.0.keys() {
            let mut parts = key.splitn(3, ": ");
            assert!(matches!(parts.next(), Some("quick" | "full")), "{key}");
            let case = parts.next().unwrap();
            assert!(CASES.iter().any(|c| c.name == case), "{key}");
            assert!(parts.next().is_some(), "{key}");
        }
    }
}
