//! Viscosity and first normal stress difference in a cell of particles, over three decades of shear rate.

use super::series::{curve, dots};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::math::Real;
use crate::report::{Axis, Plot};
use crate::study::exact::steady_shear;
use crate::study::shear_cell;

pub(super) const CASE: Case = Case {
    name: "shear-cell",
    about: "viscosity and normal stress in a cell of particles, over three decades of shear rate",
    measure,
};

const RELAXATION: Real = 0.5;
const THINNING: Real = 0.5;
/// γ [1/s] and rate [1/s] of fluid that is stretched most: N₁ is 17 times the shear stress.
const STRETCHED: (Real, Real) = (0.25, 100.0);

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let rates = bench.level.pick(
        vec![0.1, 1.0, 10.0],
        vec![0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0],
    );
    let read = |thinning: Real, rate: Real| {
        let run = format!("shear-cell-{thinning}-{rate}");
        bench.run(&run, &(RELAXATION, thinning, rate), || {
            shear_cell::read(&run, RELAXATION, thinning, rate)
        })
    };
    let (little, fast) = STRETCHED;
    let (stretched, stretched_took) = read(little, fast)?;
    let of_stretched = steady_shear(RELAXATION, little, fast);
    let mut plot = Plot {
        title: "A cell of particles as a rheometer".into(),
        x: Axis::log("shear rate [1/s]"),
        y: Axis::log("U_xy and U_xx − U_yy"),
        series: Vec::new(),
    };
    let line = |pick: fn(Real) -> Real| {
        let rates = (-22..=42).map(|k| libm::pow(10.0, 0.05 * Real::from(k)));
        rates.map(|rate| [rate, pick(rate)]).collect()
    };
    let exact = |rate: Real| steady_shear(RELAXATION, THINNING, rate);
    plot.series.push(curve(
        "U_xy",
        0,
        line(|r| steady_shear(RELAXATION, THINNING, r).xy),
    ));
    plot.series.push(curve(
        "U_xx − U_yy",
        1,
        line(|r| steady_shear(RELAXATION, THINNING, r).first),
    ));
    let off = |reached: Real, exact: Real| (reached / exact - 1.0).abs();
    let (mut shear, mut normal) = (Vec::new(), Vec::new());
    let (mut worst_shear, mut worst_normal, mut seconds): (Real, Real, Real) = (0.0, 0.0, 0.0);
    for rate in rates {
        let (reading, took) = read(THINNING, rate)?;
        seconds += took;
        shear.push([rate, reading.xy]);
        normal.push([rate, reading.first]);
        worst_shear = worst_shear.max(off(reading.xy, exact(rate).xy));
        worst_normal = worst_normal.max(off(reading.first, exact(rate).first));
    }
    plot.series.push(dots(0, shear));
    plot.series.push(dots(1, normal));
    let figure = |what: &str, reached: Real, seconds: Real| Figure {
        what: what.into(),
        resolution: "10 across".into(),
        reached,
        goal: Goal::AtMost(0.02),
        seconds,
    };
    Ok(Measured {
        figures: vec![
            figure("viscosity, largest error", worst_shear, seconds),
            figure(
                "first normal stress difference, largest error",
                worst_normal,
                seconds,
            ),
            figure(
                "stretched fluid, viscosity",
                off(stretched.xy, of_stretched.xy),
                stretched_took,
            ),
            figure(
                "stretched fluid, first normal stress difference",
                off(stretched.first, of_stretched.first),
                stretched_took,
            ),
        ],
        plot,
    })
}
