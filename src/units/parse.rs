//! From text to a checked number in SI.

use super::NAMED;
use super::dimension::{Dimension, Unit};
use crate::math::Real;

/// Why a text is not the quantity that belongs there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// Nothing like a number with a unit.
    #[error("{expected}, found {found}")]
    NotAQuantity {
        /// What belongs here, with an example.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// A unit that is in no table.
    #[error("\"{text}\": unknown unit `{unit}`")]
    UnknownUnit {
        /// The quantity as written.
        text: String,
        /// The part that is not understood.
        unit: String,
    },
    /// A number with a unit of something else.
    #[error("\"{text}\" {is}, {wanted} belongs here")]
    WrongDimension {
        /// The quantity as written.
        text: String,
        /// What it is instead.
        is: String,
        /// What belongs here.
        wanted: &'static str,
    },
    /// Beyond what the numbers can hold.
    #[error("\"{0}\" is too large a number")]
    TooLarge(String),
}

pub(super) fn quantity(
    text: &str,
    dimension: Dimension,
    noun: &'static str,
    expected: &'static str,
) -> Result<Real, UnitError> {
    let text = text.trim();
    let (mantissa, exponent, rest) = split_number(text);
    let unit = rest.trim();
    let number = mantissa.parse::<Real>().is_ok();
    if !number || unit.is_empty() {
        let found = if number {
            text.to_owned()
        } else {
            format!("{text:?}")
        };
        return Err(UnitError::NotAQuantity { expected, found });
    }
    let unit = Unit::parse(unit).map_err(|part| UnitError::UnknownUnit {
        text: text.to_owned(),
        unit: if part.is_empty() {
            unit.to_owned()
        } else {
            part
        },
    })?;
    if unit.dimension != dimension {
        return Err(UnitError::WrongDimension {
            text: text.to_owned(),
            is: describe(unit.dimension),
            wanted: noun,
        });
    }
    let too_large = || UnitError::TooLarge(text.to_owned());
    let exponent = exponent.ok_or_else(too_large)? + unit.decimal;
    let decimal: Real = format!("{mantissa}e{exponent}")
        .parse()
        .map_err(|_| too_large())?;
    // Dividing by 60 is exact more often than multiplying by 1/60.
    let value = if unit.factor < 1.0 && (1.0 / unit.factor).fract() == 0.0 {
        decimal / (1.0 / unit.factor)
    } else {
        decimal * unit.factor
    };
    if value.is_finite() {
        Ok(value)
    } else {
        Err(too_large())
    }
}

/// Mantissa, decimal exponent (`None` if it does not fit), and what follows the number.
fn split_number(text: &str) -> (&str, Option<i32>, &str) {
    let end = |from: usize, accept: fn(char) -> bool| {
        text[from..]
            .find(|c| !accept(c))
            .map_or(text.len(), |n| from + n)
    };
    let signed = usize::from(text.starts_with(['+', '-']));
    let mantissa = end(signed, |c| c.is_ascii_digit() || c == '.');
    let rest = &text[mantissa..];
    if rest.starts_with(['e', 'E']) {
        let sign = usize::from(rest[1..].starts_with(['+', '-']));
        let digits = mantissa + 1 + sign;
        let stop = end(digits, |c| c.is_ascii_digit());
        if stop > digits {
            // Small enough to add a unit's power of ten to it without overflow.
            let exponent = text[mantissa + 1..stop]
                .parse()
                .ok()
                .filter(|e: &i32| e.abs() < 100_000);
            return (&text[..mantissa], exponent, &text[stop..]);
        }
    }
    (&text[..mantissa], Some(0), rest)
}

fn describe(dimension: Dimension) -> String {
    match NAMED.iter().find(|(named, _)| *named == dimension) {
        Some((_, noun)) => format!("is {noun}"),
        None if dimension == Dimension([0; 4]) => "is a bare number".to_owned(),
        None => format!("has the unit {dimension}"),
    }
}
