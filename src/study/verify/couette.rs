//! Plane Couette flow that starts: a plate that moves at once, walls anyhow on the voxels.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Measured, StudyError};
use crate::math::Real;
use crate::report::{Axis, Plot};
use crate::sim::TimeStep;
use crate::study::exact::{Fluid, couette};
use crate::study::scenes::{Lie, Norm, newtonian, shear_cell};

pub(super) const CASE: Case = Case {
    name: "couette",
    about: "start-up of Newtonian flow under a plate that moves",
    measure,
};

const GAP: Real = 0.02;
const FLUID: Fluid = Fluid {
    density: 1000.0,
    solvent: 1.0,
    polymer: 0.0,
    relaxation_time: 0.0,
};
/// ν t/H² of the samples.
const SAMPLES: [Real; 4] = [0.05, 0.1, 0.2, 0.5];

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![16, 32], vec![16, 32, 64]);
    let mut plot = Plot {
        title: "Start-up under a moving plate".into(),
        x: Axis::linear("place across / gap"),
        y: Axis::linear("velocity / velocity of the plate"),
        series: Vec::new(),
    };
    let lie = Lie {
        turned: true,
        seed: 8,
    };
    let mut refined = Refined::default();
    for &across in &sizes {
        let run = format!("couette-{across}");
        let settings = (GAP, across, steps(across), speed(across));
        let (profiles, seconds) = bench.run(&run, &settings, || start_up(&run, across, lie))?;
        let mut norm = Norm::default();
        for (sample, profile) in SAMPLES.iter().zip(&profiles) {
            for [y, u] in profile {
                norm.add(*u, exact(across, *y, *sample));
            }
        }
        refined.add(across, norm.relative(), seconds);
        if Some(&across) == sizes.last() {
            for (colour, (sample, profile)) in SAMPLES.into_iter().zip(profiles).enumerate() {
                let y = (0..=60).map(|k| GAP * (Real::from(k) / 60.0 - 0.5));
                let line = y.map(|y| [y / GAP, exact(across, y, sample) / speed(across)]);
                let name = format!("time {sample} H²/nu");
                plot.series.push(curve(&name, colour, line.collect()));
                let points = profile.into_iter();
                let points = points.map(|[y, u]| [y / GAP, u / speed(across)]);
                plot.series
                    .push(dots(colour, thinned(points.collect(), 50)));
            }
        }
    }
    let figures = refined.figures("Couette start-up, L2", "across", 0.01, None);
    Ok(Measured { figures, plot })
}

/// Steps to ν t/H² = 0.5; dt goes with dx².
fn steps(across: u32) -> Real {
    200.0 * (Real::from(across) / 32.0).powi(2)
}

/// The plate moves by six spacings in all [m/s].
fn speed(across: u32) -> Real {
    6.0 * GAP / Real::from(across) / time(SAMPLES[3])
}

fn time(sample: Real) -> Real {
    sample * GAP * GAP * FLUID.density / FLUID.solvent
}

/// The cell's middle is at y = 0.
fn exact(across: u32, y: Real, sample: Real) -> Real {
    couette(&FLUID, speed(across), GAP, y + 0.5 * GAP, time(sample))
}

/// y and u of every particle at each sample.
fn start_up(name: &str, across: u32, lie: Lie) -> Result<Vec<Vec<[Real; 2]>>, StudyError> {
    let mut place = shear_cell(GAP, across, lie, speed(across), 0.0);
    place.settings.cement = newtonian(FLUID.density, FLUID.solvent);
    place.settings.time_step = TimeStep::Fixed(time(SAMPLES[3]) / steps(across));
    let mut simulation = place.start(name)?;
    let mut profiles = Vec::new();
    for sample in SAMPLES {
        simulation
            .advance_to(time(sample), |_| {})
            .map_err(StudyError::run(name))?;
        let places = simulation.fluid.position.iter().zip(simulation.velocity());
        let mut profile: Vec<_> = places.map(|(x, v)| [x.y, v.x]).collect();
        profile.sort_by(|a, b| a[0].total_cmp(&b[0]));
        profiles.push(profile);
    }
    Ok(profiles)
}
