//! The flows that errors are measured in.

use super::setting::{Setting, Variant};
use crate::fluid::Cement;
use crate::math::{Real, Vec3};
use crate::sim::{ElasticWaves, Scheme, SimError, Simulation, StressStep};
use crate::solid::{Shape, Solid};
use crate::study::exact::{Fluid, SIMPLE_CUBIC, permeability, plane_poiseuille, sphere_radius};
use crate::study::scenes::{Lie, Norm, Place, around_with, channel_with, newtonian, viscoelastic};
use crate::study::tank::{Tank, cfl_step};
use crate::study::{Level, StudyError};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What a run came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Relative error [1]; none if the run fell over.
    pub error: Option<Real>,
    /// Wall clock of the simulation alone [s].
    pub seconds: Real,
    /// Steps.
    pub steps: u64,
    /// Particles.
    pub particles: u64,
}

/// Runs a setting and says its error.
pub type Measure = fn(&Setting) -> Result<Outcome, StudyError>;

/// A flow whose error can be said.
pub struct Flow {
    /// What it is called.
    pub name: &'static str,
    /// What the error is.
    pub measure: &'static str,
    /// Spacings across, coarse to fine; each other knob is tried at the second.
    pub across: fn(Level) -> &'static [u32],
    /// Whether a variant can run it.
    pub takes: fn(Variant) -> bool,
    /// Runs it; the tank has no error of its own and none of these.
    pub run: Option<Measure>,
}

/// All of them.
pub const FLOWS: [Flow; 4] = [
    Flow {
        name: "poiseuille",
        measure: "L2 of the start-up's profiles at four moments, by the exact ones",
        across: |level| level.pick(&[8, 16], &[8, 16, 32]),
        takes: |_| true,
        run: Some(poiseuille),
    },
    Flow {
        name: "waters-king",
        measure: "L2 over space and three relaxation times, by the exact flow",
        across: |level| level.pick(&[8, 16], &[8, 16, 32]),
        takes: |variant| variant.scheme == Scheme::ImmCt,
        run: Some(waters_king),
    },
    Flow {
        name: "spheres",
        measure: "permeability at a volume fraction of 0.125, by that of Zick and Homsy",
        across: |level| level.pick(&[8, 12], &[8, 12, 16, 24]),
        takes: |_| true,
        run: Some(spheres),
    },
    Flow {
        name: "tank",
        measure: "L2 of the intensity of mixing over time, by its own finest run",
        across: |level| level.pick(&[13, 20], &[13, 20, 27]),
        takes: |variant| variant.stress == StressStep::Explicit || variant.scheme == Scheme::ImmCt,
        run: None,
    },
];

/// A run as far as it gets: `work` returns the error.
fn watched(
    mut simulation: Simulation,
    name: &str,
    work: impl FnOnce(&mut Simulation) -> Result<Real, SimError>,
) -> Result<Outcome, StudyError> {
    let begun = Instant::now();
    let error = match work(&mut simulation) {
        Ok(error) => Some(error.abs()),
        Err(SimError::Diverged { .. } | SimError::Unconverged { .. }) => None,
        Err(other) => return Err(StudyError::run(name)(other)),
    };
    Ok(Outcome {
        error,
        seconds: begun.elapsed().as_secs_f64(),
        steps: simulation.steps,
        particles: simulation.fluid.len() as u64,
    })
}

/// Viscosity [Pa·s] and density [kg/m³] as asked for: IMM-CT with so short a memory that it is Newtonian.
fn thick(variant: Variant, density: Real, viscosity: Real, time: Real) -> Cement {
    if variant.scheme == Scheme::ImmCt {
        viscoelastic(
            density,
            0.01 * viscosity,
            0.99 * viscosity,
            1e-3 * time,
            0.0,
        )
    } else {
        newtonian(density, viscosity)
    }
}

const GAP: Real = 0.02;
const DENSITY: Real = 1000.0;

fn plates(setting: &Setting, seed: u64) -> Place {
    let lie = Lie {
        turned: false,
        seed,
    };
    channel_with(GAP, setting.across, lie, setting.support_ratio)
}

/// The middle comes to six spacings in h²/ν.
fn poiseuille(setting: &Setting) -> Result<Outcome, StudyError> {
    let name = setting.name();
    let fluid = Fluid {
        density: DENSITY,
        solvent: 1.0,
        polymer: 0.0,
        relaxation_time: 0.0,
    };
    let half = 0.5 * GAP;
    let unit = half * half * DENSITY / fluid.solvent;
    let mut place = plates(setting, 5);
    let speed = 6.0 * place.settings.spacing / unit;
    let force = 2.0 * fluid.solvent * speed / (half * half);
    place.settings.cement = thick(setting.variant, DENSITY, fluid.solvent, unit);
    place.settings.gravity = Vec3::x() * (force / DENSITY);
    setting.apply(&mut place.settings, speed);
    watched(place.start(&name)?, &name, |simulation| {
        let mut norm = Norm::default();
        for sample in [0.1, 0.2, 0.5, 1.0] {
            simulation.advance_to(sample * unit, |_| {})?;
            for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
                norm.add(
                    v.x,
                    plane_poiseuille(&fluid, force, half, x.y, simulation.time),
                );
            }
        }
        Ok(norm.relative())
    })
}

/// Oldroyd-B with β = 1/9 and E = 1; at a CFL number of 0.4 there are twenty steps a relaxation time.
fn waters_king(setting: &Setting) -> Result<Outcome, StudyError> {
    let name = setting.name();
    let viscosity = 1.0;
    let half = 0.5 * GAP;
    let fluid = Fluid {
        density: DENSITY,
        solvent: viscosity / 9.0,
        polymer: viscosity * 8.0 / 9.0,
        relaxation_time: DENSITY * half * half / viscosity,
    };
    let mut place = plates(setting, 3);
    let speed = 8.0 * place.settings.spacing / fluid.relaxation_time;
    let force = 2.0 * viscosity * speed / (half * half);
    place.settings.elastic_waves = ElasticWaves::Resolved;
    place.settings.theta = ElasticWaves::Resolved.theta();
    place.settings.cement = viscoelastic(
        DENSITY,
        fluid.solvent,
        fluid.polymer,
        fluid.relaxation_time,
        0.0,
    );
    place.settings.gravity = Vec3::x() * (force / DENSITY);
    setting.apply(&mut place.settings, speed);
    watched(place.start(&name)?, &name, |simulation| {
        let mut norm = Norm::default();
        for k in 1..=30 {
            simulation.advance_to(0.1 * Real::from(k) * fluid.relaxation_time, |_| {})?;
            for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
                norm.add(
                    v.x,
                    plane_poiseuille(&fluid, force, half, x.y, simulation.time),
                );
            }
        }
        Ok(norm.relative())
    })
}

/// Six times the slowest decay L²/(4π² ν), in which the fastest fluid comes three spacings far.
fn spheres(setting: &Setting) -> Result<Outcome, StudyError> {
    let name = setting.name();
    let (cell, viscosity) = (0.01, 10.0);
    let (fraction, factor) = SIMPLE_CUBIC[1];
    let exact = permeability(fraction, factor);
    let dx = cell / Real::from(setting.across);
    let sphere = Shape::Sphere {
        centre: Vec3::repeat(0.5 * cell),
        radius: sphere_radius(fraction) * cell,
        hollow: false,
    };
    let solid = Solid {
        shapes: vec![sphere],
        grids: Vec::new(),
    };
    let mut place = around_with(Vec3::repeat(cell), dx, solid, setting.support_ratio);
    let end = 6.0 * cell * cell * DENSITY / viscosity / 39.5;
    let speed = 3.2 * dx / end;
    // The fastest fluid is about two and a half times as fast as the mean.
    let force = 0.4 * speed * viscosity / (exact * cell * cell);
    place.settings.cement = thick(setting.variant, DENSITY, viscosity, end);
    place.settings.gravity = Vec3::x() * (force / DENSITY);
    setting.apply(&mut place.settings, speed);
    watched(place.start_full(&name)?, &name, |simulation| {
        simulation.advance_to(end, |_| {})?;
        let sum: Real = simulation.velocity().iter().map(|v| v.x).sum();
        let superficial = sum * simulation.rest_volume / cell.powi(3);
        Ok(viscosity * superficial / force / (cell * cell) / exact - 1.0)
    })
}

/// Edge of the tank [m].
const TANK: Real = 0.04;

/// How mixed the tank is, fifty times a second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mixed {
    /// Time [s] and intensity of segregation; none if it fell over.
    pub segregation: Option<Vec<[Real; 2]>>,
    /// As of an outcome.
    pub seconds: Real,
    /// As of an outcome.
    pub steps: u64,
    /// As of an outcome.
    pub particles: u64,
}

/// Stirs the tank at 1 : 100.
pub fn stirred(setting: &Setting, level: Level) -> Result<Mixed, StudyError> {
    let spacing = TANK / Real::from(setting.across);
    let tank = Tank {
        scheme: setting.variant.scheme,
        stress: setting.variant.stress,
        viscosity: 1.0,
        relaxation_time: if setting.variant.scheme == Scheme::ImmCt {
            0.05
        } else {
            0.0
        },
        thinning: 0.5,
        spacing,
        step: Some(setting.cfl / 0.4 * cfl_step(spacing)),
        seed: 1,
        duration: level.pick(0.4, 1.0),
        most_steps: None,
        tolerance: setting.tolerance,
        support_ratio: setting.support_ratio,
    };
    let fate = tank.run(&setting.name(), &tank.fan()?)?;
    Ok(Mixed {
        segregation: fate.collapse.is_none().then_some(fate.segregation),
        seconds: fate.cost * fate.time,
        steps: fate.steps,
        particles: fate.last.len() as u64,
    })
}

/// The setting that the tank's others are held against.
pub fn finest(variant: Variant, level: Level) -> Setting {
    Setting {
        cfl: 0.1,
        ..Setting::usual(variant, level.pick(24, 32))
    }
}

/// L2 of what is mixed, 1 − intensity, by that of the finest run.
pub fn against(run: &Mixed, finest: &Mixed) -> Outcome {
    let error = run.segregation.as_ref().zip(finest.segregation.as_ref());
    let error = error.map(|(run, finest)| {
        let mut norm = Norm::default();
        for (got, exact) in run.iter().zip(finest) {
            norm.add(1.0 - got[1], 1.0 - exact[1]);
        }
        norm.relative()
    });
    Outcome {
        error,
        seconds: run.seconds,
        steps: run.steps,
        particles: run.particles,
    }
}
