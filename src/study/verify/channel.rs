//! Plane Poiseuille flow that starts: Newtonian, walls at a random offset and turned on the voxels.

use super::series::{Refined, curve, dots, thinned};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::TimeStep;
use crate::study::exact::{Fluid, plane_poiseuille};
use crate::study::scenes::{Lie, Norm, channel, newtonian};

pub(super) const CASE: Case = Case {
    name: "channel",
    about: "start-up of Newtonian flow between plates that lie anyhow on the voxels",
    measure,
};

const GAP: Real = 0.02;
const FLUID: Fluid = Fluid {
    density: 1000.0,
    solvent: 1.0,
    polymer: 0.0,
    relaxation_time: 0.0,
};
/// ν t/h² of the samples.
const SAMPLES: [Real; 4] = [0.1, 0.2, 0.5, 1.0];

/// u [m/s] at y [m] at each sample.
type Profiles = Vec<Vec<[Real; 2]>>;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![16, 32], vec![16, 32, 64]);
    let mut plot = Plot {
        title: "Start-up between plates, turned on the voxels".into(),
        x: Axis::linear("place across / gap"),
        y: Axis::linear("velocity / steady velocity in the middle"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (what, lie) in [
        (
            "offset",
            Lie {
                turned: false,
                seed: 5,
            },
        ),
        (
            "offset and turned",
            Lie {
                turned: true,
                seed: 6,
            },
        ),
    ] {
        let mut refined = Refined::default();
        for &across in &sizes {
            let run = format!(
                "channel-{}-{across}",
                if lie.turned { "turned" } else { "offset" }
            );
            let settings = (
                GAP,
                across,
                lie.turned,
                lie.seed,
                steps(across),
                force(across),
            );
            let (profiles, seconds) = bench.run(&run, &settings, || start_up(&run, across, lie))?;
            let mut norm = Norm::default();
            for (sample, profile) in SAMPLES.iter().zip(&profiles) {
                for [y, u] in profile {
                    norm.add(*u, exact(across, *y, *sample));
                }
            }
            refined.add(across, norm.relative(), seconds);
            if lie.turned && Some(&across) == sizes.last() {
                draw(&mut plot, across, profiles);
            }
        }
        figures.extend(refined.figures(
            &format!("Poiseuille start-up, {what}, L2"),
            "across",
            0.01,
            None,
        ));
    }
    Ok(Measured { figures, plot })
}

fn draw(plot: &mut Plot, across: u32, profiles: Profiles) {
    let top = force(across) * 0.25 * GAP * GAP / (2.0 * FLUID.solvent);
    for (colour, (sample, profile)) in SAMPLES.into_iter().zip(profiles).enumerate() {
        let y = (0..=60).map(|k| GAP * (Real::from(k) / 60.0 - 0.5));
        let line = y.map(|y| [y / GAP, exact(across, y, sample) / top]);
        plot.series.push(curve(
            &format!("time {sample} h²/nu"),
            colour,
            line.collect(),
        ));
        let points = profile.into_iter().map(|[y, u]| [y / GAP, u / top]);
        plot.series
            .push(dots(colour, thinned(points.collect(), 50)));
    }
}

/// Steps to ν t/h² = 1; dt goes with dx².
fn steps(across: u32) -> Real {
    100.0 * (Real::from(across) / 32.0).powi(2)
}

/// Force [N/m³] under which the middle would move by six spacings in h²/ν at its steady speed.
fn force(across: u32) -> Real {
    let half = 0.5 * GAP;
    let nu = FLUID.solvent / FLUID.density;
    let speed = 6.0 * GAP / Real::from(across) * nu / (half * half);
    2.0 * FLUID.solvent * speed / (half * half)
}

fn exact(across: u32, y: Real, sample: Real) -> Real {
    plane_poiseuille(&FLUID, force(across), 0.5 * GAP, y, time(sample))
}

fn time(sample: Real) -> Real {
    sample * 0.25 * GAP * GAP * FLUID.density / FLUID.solvent
}

fn start_up(name: &str, across: u32, lie: Lie) -> Result<Profiles, StudyError> {
    let mut place = channel(GAP, across, lie);
    place.settings.cement = newtonian(FLUID.density, FLUID.solvent);
    place.settings.gravity = Vec3::x() * (force(across) / FLUID.density);
    place.settings.time_step = TimeStep::Fixed(time(1.0) / steps(across));
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
