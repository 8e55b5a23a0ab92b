//! An axis of a plot: from values to a place between 0 and 1, and where its ticks stand.

use crate::math::Real;

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it measures, with its unit.
    pub label: String,
    /// Whether equal steps are equal factors.
    pub log: bool,
    /// First and last value; `None`: as far as the data go, and a little.
    pub range: Option<[Real; 2]>,
}

/// A tick: where it stands (0 to 1), and what it says: a number, or a power of ten.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub at: Real,
    pub label: TickLabel,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TickLabel {
    Number(String),
    PowerOfTen(i32),
    /// Between two labelled ones.
    Minor,
}

impl Axis {
    /// An axis with equal steps.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            log: false,
            range: None,
        }
    }

    /// An axis with equal factors.
    pub fn log(label: &str) -> Self {
        Self {
            log: true,
            ..Self::linear(label)
        }
    }

    /// The same axis from `first` to `last`.
    #[must_use]
    pub fn between(self, first: Real, last: Real) -> Self {
        Self {
            range: Some([first, last]),
            ..self
        }
    }

    /// Fixes the range: what was asked for, else what holds all `values` that can be drawn.
    pub(super) fn fitted(&self, values: impl Iterator<Item = Real>) -> Scale {
        let (mut low, mut high) = (Real::INFINITY, Real::NEG_INFINITY);
        for v in values.filter(|v| v.is_finite() && (!self.log || *v > 0.0)) {
            (low, high) = (low.min(v), high.max(v));
        }
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        let [low, high] = if let Some([first, last]) = self.range {
            [self.place(first), self.place(last)]
        } else {
            let (low, high) = (self.place(low), self.place(high));
            let least = if self.log {
                0.3
            } else {
                1e-12 + 1e-6 * high.abs()
            };
            let margin = 0.04 * (high - low).max(least);
            [low - margin, high + margin]
        };
        Scale {
            log: self.log,
            low,
            high,
        }
    }

    fn place(&self, value: Real) -> Real {
        if self.log { libm::log10(value) } else { value }
    }
}

/// An axis with its range fixed; logarithms if it has equal factors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    log: bool,
    low: Real,
    high: Real,
}

impl Scale {
    /// Where a value stands: 0 at the first, 1 at the last; `None` if it cannot be drawn.
    pub fn at(&self, value: Real) -> Option<Real> {
        let place = if !self.log {
            value
        } else if value > 0.0 {
            libm::log10(value)
        } else {
            return None;
        };
        let at = (place - self.low) / (self.high - self.low);
        at.is_finite().then_some(at)
    }

    /// Ticks inside the range, ascending.
    pub fn ticks(&self) -> Vec<Tick> {
        if self.log && self.high - self.low >= 0.9 {
            self.decades()
        } else {
            self.steps()
        }
    }

    fn decades(&self) -> Vec<Tick> {
        let decades = self.high - self.low;
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for power in self.low.floor() as i32..=self.high.ceil() as i32 {
            for digit in 1..10 {
                let place = Real::from(power) + libm::log10(Real::from(digit));
                if place < self.low - 1e-9 || place > self.high + 1e-9 {
                    continue;
                }
                let label = if digit == 1 && power.rem_euclid(every) == 0 {
                    TickLabel::PowerOfTen(power)
                } else if every == 1 || digit == 1 {
                    TickLabel::Minor
                } else {
                    continue;
                };
                ticks.push(Tick {
                    at: (place - self.low) / (self.high - self.low),
                    label,
                });
            }
        }
        ticks
    }

    /// Five to ten round numbers; on a short logarithmic axis as well.
    fn steps(&self) -> Vec<Tick> {
        let value = |place: Real| {
            if self.log {
                libm::pow(10.0, place)
            } else {
                place
            }
        };
        let (first, last) = (value(self.low), value(self.high));
        let rough = (last - first) / 6.0;
        let power = libm::floor(libm::log10(rough));
        let unit = libm::pow(10.0, power);
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * unit)
            .into_iter()
            .find(|step| *step >= rough * (1.0 - 1e-9))
            .unwrap_or(10.0 * unit);
        let digits = (-libm::floor(libm::log10(step) + 1e-9)).max(0.0) as usize;
        let mut ticks = Vec::new();
        for k in 0..20 {
            let number = ((first / step - 1e-9).ceil() + Real::from(k)) * step;
            if number.is_nan() || number > last + 1e-9 * step {
                break;
            }
            if let Some(at) = self.at(number) {
                let text = if digits > 6 || step >= 1e6 {
                    format!("{number:.1e}")
                } else {
                    // No "-0".
                    format!(
                        "{:.digits$}",
                        if number.abs() < 1e-9 * step {
                            0.0
                        } else {
                            number
                        }
                    )
                };
                ticks.push(Tick {
                    at,
                    label: TickLabel::Number(text),
                });
            }
        }
        ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_has_its_ticks_at_powers_of_ten() {
        let scale = Axis::log("x").between(0.01, 1000.0).fitted([].into_iter());
        let labelled: Vec<_> = scale
            .ticks()
            .into_iter()
            .filter_map(|t| match t.label {
                TickLabel::PowerOfTen(p) => Some((p, t.at)),
                _ => None,
            })
            .collect();
        assert_eq!(labelled.len(), 6);
        for (power, at) in labelled {
            assert!((at - (f64::from(power) + 2.0) / 5.0).abs() < 1e-12);
        }
        assert_eq!(scale.at(-1.0), None);
        assert_eq!(scale.at(f64::NAN), None);
    }

    #[test]
    fn a_linear_axis_has_round_numbers() {
        let scale = Axis::linear("t").between(-0.2, 1.0).fitted([].into_iter());
        let labels: Vec<_> = scale.ticks().into_iter().map(|t| t.label).collect();
        let expected = ["-0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0"];
        assert_eq!(labels, expected.map(|s| TickLabel::Number(s.to_owned())));
    }

    #[test]
    fn data_without_extent_or_sense_still_give_an_axis() {
        for axis in [Axis::linear("a"), Axis::log("a")] {
            for values in [vec![], vec![3.0, 3.0], vec![f64::NAN, -1.0], vec![0.0]] {
                let scale = axis.fitted(values.into_iter());
                assert!(scale.ticks().len() < 60);
                assert!(scale.at(1.0).is_none_or(f64::is_finite));
            }
        }
    }
}
