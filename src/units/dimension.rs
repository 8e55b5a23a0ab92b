//! Unit expressions, `ml/min` or `Pa.s`: what they measure, and how many SI units they are.

use crate::math::Real;
use std::f64::consts::PI;
use std::fmt;

/// Exponents of metre, kilogram, second and radian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dimension(pub [i32; 4]);

/// How many SI units one unit is: `10^decimal · factor`. The decimal part is kept apart so that it can move the
/// decimal point of the number as written, which rounds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub dimension: Dimension,
    pub decimal: i32,
    pub factor: Real,
}

/// Symbol, exponents, power of ten, factor, whether it takes prefixes.
type Symbol = (&'static str, [i32; 4], i32, Real, bool);

const SYMBOLS: &[Symbol] = &[
    ("m", [1, 0, 0, 0], 0, 1.0, true),
    ("g", [0, 1, 0, 0], -3, 1.0, true),
    ("s", [0, 0, 1, 0], 0, 1.0, true),
    ("min", [0, 0, 1, 0], 0, 60.0, false),
    ("h", [0, 0, 1, 0], 0, 3600.0, false),
    ("l", [3, 0, 0, 0], -3, 1.0, true),
    ("L", [3, 0, 0, 0], -3, 1.0, true),
    ("N", [1, 1, -2, 0], 0, 1.0, true),
    ("Pa", [-1, 1, -2, 0], 0, 1.0, true),
    ("bar", [-1, 1, -2, 0], 5, 1.0, true),
    ("P", [-1, 1, -1, 0], -1, 1.0, true),
    ("St", [2, 0, -1, 0], -4, 1.0, true),
    ("Hz", [0, 0, -1, 0], 0, 1.0, true),
    ("rad", [0, 0, 0, 1], 0, 1.0, true),
    ("deg", [0, 0, 0, 1], 0, PI / 180.0, false),
    ("°", [0, 0, 0, 1], 0, PI / 180.0, false),
];

const PREFIXES: &[(char, i32)] = &[
    ('n', -9),
    ('u', -6),
    ('µ', -6),
    ('μ', -6),
    ('m', -3),
    ('c', -2),
    ('d', -1),
    ('k', 3),
    ('M', 6),
    ('G', 9),
];

/// No physical unit needs more, and it keeps the arithmetic small.
const LARGEST_EXPONENT: i32 = 9;

impl Unit {
    /// Reads factors joined by `.`, `·`, `*` or a space, and divided by `/`, each with an optional exponent.
    /// The error is the part that is not understood.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut unit = Self {
            dimension: Dimension([0; 4]),
            decimal: 0,
            factor: 1.0,
        };
        for (nth, side) in text.split('/').enumerate() {
            let sign = if nth == 0 { 1 } else { -1 };
            let side = side.trim();
            if nth == 0 && (side.is_empty() || side == "1") {
                continue;
            }
            for part in side.split(['.', '·', '⋅', '*', ' ']) {
                unit.multiply(part, sign)?;
            }
        }
        Ok(unit)
    }

    fn multiply(&mut self, part: &str, sign: i32) -> Result<(), String> {
        let not_understood = || part.to_owned();
        let (name, exponent) = split_exponent(part).ok_or_else(not_understood)?;
        let exponent = sign * exponent;
        let (decimal, symbol) = lookup(name).ok_or_else(not_understood)?;
        for (sum, e) in self.dimension.0.iter_mut().zip(symbol.1) {
            *sum += e * exponent;
        }
        self.decimal += (symbol.2 + decimal) * exponent;
        self.factor *= symbol.3.powi(exponent);
        Ok(())
    }
}

fn lookup(name: &str) -> Option<(i32, &'static Symbol)> {
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| symbol.0 == name) {
        return Some((0, symbol));
    }
    let first = name.chars().next()?;
    let (_, decimal) = PREFIXES.iter().find(|prefix| prefix.0 == first)?;
    let rest = &name[first.len_utf8()..];
    let symbol = SYMBOLS.iter().find(|symbol| symbol.4 && symbol.0 == rest)?;
    Some((*decimal, symbol))
}

/// `s2`, `s^2`, `s²`, `s-2` → (`s`, ±2).
fn split_exponent(part: &str) -> Option<(&str, i32)> {
    for (superscript, exponent) in [('²', 2), ('³', 3)] {
        if let Some(name) = part.strip_suffix(superscript) {
            return Some((name, exponent));
        }
    }
    let start = part.find(|c: char| c.is_ascii_digit() || c == '-' || c == '^');
    let Some(start) = start else {
        return Some((part, 1));
    };
    let digits = &part[start..];
    let exponent: i32 = digits.strip_prefix('^').unwrap_or(digits).parse().ok()?;
    let reasonable = exponent != 0 && exponent.abs() <= LARGEST_EXPONENT;
    reasonable.then_some((&part[..start], exponent))
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (name, exponent) in ["m", "kg", "s", "rad"].iter().zip(self.0) {
            if exponent == 0 {
                continue;
            }
            write!(f, "{separator}{name}")?;
            if exponent != 1 {
                write!(f, "{exponent}")?;
            }
            separator = ".";
        }
        Ok(())
    }
}
