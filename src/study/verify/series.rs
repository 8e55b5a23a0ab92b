//! A quantity on refinement: errors at several resolutions, their order, and their plot.

use super::{Figure, Goal};
use crate::math::Real;
use crate::report::{Look, Series};

/// An error at each of several resolutions, coarse to fine.
#[derive(Clone, Debug, Default)]
pub(super) struct Refined {
    /// Spacings across, relative error, seconds.
    pub rows: Vec<(u32, Real, Real)>,
}

impl Refined {
    pub fn add(&mut self, across: u32, error: Real, seconds: Real) {
        self.rows.push((across, error, seconds));
    }

    /// log(e₁/e₂)/log(n₂/n₁) of the coarsest and the finest.
    pub fn order(&self) -> Option<Real> {
        let (first, last) = (self.rows.first()?, self.rows.last()?);
        (first.0 != last.0).then(|| {
            libm::log(first.1.abs() / last.1.abs())
                / libm::log(Real::from(last.0) / Real::from(first.0))
        })
    }

    /// The finest error against its target, and the order against its own.
    pub fn figures(&self, what: &str, unit: &str, most: Real, order: Option<Real>) -> Vec<Figure> {
        let seconds = self.rows.iter().map(|row| row.2).sum();
        let mut figures = Vec::new();
        if let Some(&(across, error, seconds)) = self.rows.last() {
            figures.push(Figure {
                what: what.to_owned(),
                resolution: format!("{across} {unit}"),
                reached: error.abs(),
                goal: Goal::AtMost(most),
                seconds,
            });
        }
        if let (Some(least), Some(reached)) = (order, self.order()) {
            let across: Vec<String> = self.rows.iter().map(|row| row.0.to_string()).collect();
            figures.push(Figure {
                what: format!("{what}, order"),
                resolution: across.join(", "),
                reached,
                goal: Goal::AtLeast(least),
                seconds,
            });
        }
        figures
    }
}

/// An exact curve.
pub(super) fn curve(name: &str, colour: usize, points: Vec<[Real; 2]>) -> Series {
    Series {
        name: name.to_owned(),
        points,
        look: Look::Curve,
        colour,
    }
}

/// Computed points; named by the curve of their colour.
pub(super) fn dots(colour: usize, points: Vec<[Real; 2]>) -> Series {
    Series {
        name: String::new(),
        points,
        look: Look::Dots,
        colour,
    }
}

/// At most `most` of the points, evenly.
pub(super) fn thinned(points: Vec<[Real; 2]>, most: usize) -> Vec<[Real; 2]> {
    let every = points.len().div_ceil(most).max(1);
    points.into_iter().step_by(every).collect()
}
