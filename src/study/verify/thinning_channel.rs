//! Steady flow of a thinning fluid between plates: flow rate and the flat profile of its middle.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{Scheme, TimeStep};
use crate::study::exact::{Thinning, giesekus_channel};
use crate::study::scenes::{Lie, Norm, channel, viscoelastic};

pub(super) const CASE: Case = Case {
    name: "giesekus",
    about: "steady flow of a thinning fluid between plates: flow rate and profile",
    measure,
};

/// Half the gap [m], and f [N/m³].
const HALF: Real = 1.0;
const FORCE: Real = 3.0;
const FLUID: Thinning = Thinning {
    solvent: 0.1,
    modulus: 1.8,
    relaxation_time: 1.0,
    thinning: 1.0,
};
/// The steady flow does not depend on ρ [kg/m³]; with this the start is over within λ.
const DENSITY: Real = 0.1;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![14, 28], vec![12, 24, 48]);
    let exact = giesekus_channel(&FLUID, FORCE, HALF, 401);
    let at = |y: Real| {
        let place = (y.abs() / HALF).min(1.0) * (exact.len() - 1) as Real;
        let k = (place as usize).min(exact.len() - 2);
        let t = place - k as Real;
        exact[k][1] * (1.0 - t) + exact[k + 1][1] * t
    };
    let (mut flow, mut shape) = (Refined::default(), Refined::default());
    let mut plot = Plot {
        title: "Thinning fluid between plates".into(),
        x: Axis::linear("place across / half gap"),
        y: Axis::linear("velocity [m/s]"),
        series: Vec::new(),
    };
    for &across in &sizes {
        let run = format!("giesekus-{across}");
        let (profile, seconds) =
            bench.run(&run, &(across, END, DENSITY), || steady(&run, across))?;
        let (mut sum, mut exact_sum, mut norm) = (0.0, 0.0, Norm::default());
        for [y, u] in &profile {
            sum += u;
            exact_sum += at(*y);
            norm.add(*u, at(*y));
        }
        flow.add(across, sum / exact_sum - 1.0, seconds);
        shape.add(across, norm.relative(), seconds);
        if Some(&across) == sizes.last() {
            let mirrored = exact.iter().rev().map(|p| [-p[0], p[1]]);
            let line = mirrored.chain(exact.iter().copied()).collect();
            plot.series.push(curve("exact", 0, line));
            let parabola = (-50..=50).map(|k| 0.02 * Real::from(k));
            let mean = parabola.map(|y| [y, exact[0][1] * (1.0 - y * y)]);
            plot.series.push(crate::report::Series {
                name: "parabola".into(),
                points: mean.collect(),
                look: crate::report::Look::Dashes,
                colour: 7,
            });
            plot.series.push(dots(1, thinned(profile, 80)));
        }
    }
    let mut figures = flow.figures("flow rate", "across", 0.02, None);
    figures.extend(shape.figures("profile, L2", "across", 0.02, None));
    Ok(Measured { figures, plot })
}

/// Ten linear relaxation times λ'.
const END: Real = 5.0;

/// y and u of every particle in the end.
fn steady(name: &str, across: u32) -> Result<Vec<[Real; 2]>, StudyError> {
    let lie = Lie {
        turned: false,
        seed: 11,
    };
    let mut place = channel(2.0 * HALF, across, lie);
    place.settings.scheme = Scheme::ImmCt;
    place.settings.cement = viscoelastic(
        DENSITY,
        FLUID.solvent,
        FLUID.modulus * FLUID.relaxation_time,
        FLUID.relaxation_time,
        FLUID.thinning,
    );
    place.settings.gravity = Vec3::x() * (FORCE / DENSITY);
    place.settings.time_step = TimeStep::Adaptive {
        min: 1e-6,
        max: 0.05,
        cfl: 0.4,
    };
    let mut simulation = place.start(name)?;
    simulation
        .advance_to(END, |_| {})
        .map_err(StudyError::run(name))?;
    let places = simulation.fluid.position.iter().zip(simulation.velocity());
    let mut profile: Vec<_> = places.map(|(x, v)| [x.y, v.x]).collect();
    profile.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(profile)
}
