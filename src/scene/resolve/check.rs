//! Collects everything that is wrong with a recipe, each with its key and line.

use crate::math::{Aabb, Real, Vec3};
use crate::scene::place::BoxRecipe;
use crate::scene::{Document, Finding};
use crate::units::Length;
use std::ops::RangeInclusive;

pub(super) struct Checker<'a> {
    document: &'a Document<'a>,
    pub errors: Vec<Finding>,
    pub warnings: Vec<Finding>,
}

impl<'a> Checker<'a> {
    pub fn new(document: &'a Document<'a>) -> Self {
        Self {
            document,
            errors: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn finding(&self, key: &str, message: impl Into<String>) -> Finding {
        Finding {
            place: self.document.place_of(key),
            key: key.to_owned(),
            message: message.into(),
        }
    }

    pub fn error(&mut self, key: &str, message: impl Into<String>) {
        self.errors.push(self.finding(key, message));
    }

    pub fn warn(&mut self, key: &str, message: impl Into<String>) {
        self.warnings.push(self.finding(key, message));
    }

    pub fn require(&mut self, holds: bool, key: &str, message: &str) {
        if !holds {
            self.error(key, message);
        }
    }

    /// The value, which must be above zero.
    pub fn positive(&mut self, key: &str, value: Real) -> Real {
        self.require(value > 0.0 && value.is_finite(), key, "must be above zero");
        value
    }

    /// The value, which must lie in the range.
    pub fn within(&mut self, key: &str, value: Real, range: RangeInclusive<Real>) -> Real {
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            self.error(
                key,
                format!("must lie between {low} and {high}, found {value}"),
            );
        }
        value
    }

    /// The direction with length 1.
    pub fn direction(&mut self, key: &str, direction: [Real; 3]) -> Vec3 {
        let direction = Vec3::from(direction);
        let unit = direction
            .try_normalize(1e-12)
            .filter(|u| u.iter().all(|c| c.is_finite()));
        self.require(
            unit.is_some(),
            key,
            "is no direction: its length must not be zero",
        );
        unit.unwrap_or(Vec3::z())
    }

    /// The box, which must not be empty.
    pub fn bounds(&mut self, key: &str, bounds: &BoxRecipe) -> Aabb {
        let bounds = Aabb {
            min: point(bounds.min),
            max: point(bounds.max),
        };
        let holds = (0..3).all(|axis| bounds.min[axis] < bounds.max[axis]);
        self.require(holds, key, "is empty: min must lie below max on every axis");
        bounds
    }

    /// The one key that is given out of several, and its number in the list.
    pub fn exactly_one(&mut self, key: &str, names: &[&str], given: &[bool]) -> Option<usize> {
        if given.iter().filter(|&&is| is).count() != 1 {
            self.error(key, format!("needs exactly one of {}", names.join(", ")));
            return None;
        }
        given.iter().position(|&is| is)
    }

    /// Names that tables and files will go by.
    pub fn distinct<'n>(&mut self, list: &str, names: impl Iterator<Item = &'n str>) {
        let mut seen: Vec<&str> = Vec::new();
        for (n, name) in names.enumerate() {
            let key = format!("{list}[{n}].name");
            let plain = |c: char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
            self.require(
                !name.trim().is_empty() && name.chars().all(plain) && name.len() <= 64,
                &key,
                "must be 1 to 64 letters, digits, spaces, - or _",
            );
            self.require(!seen.contains(&name), &key, "is used twice");
            seen.push(name);
        }
    }
}

/// A point in SI [m].
pub(super) fn point(lengths: [Length; 3]) -> Vec3 {
    Vec3::from(lengths.map(Length::si))
}
