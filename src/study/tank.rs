//! The mixing tank of [IMM-CT] Fig. 7 to 9: liquid and polymer in two columns fall onto a fan, watched at every step.

use super::StudyError;
use super::scenes::{Place, newtonian, settings};
use super::watch::{Bounds, Collapse, Watch};
use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Aabb, Real, Vec3};
use crate::sim::{
    Body, BodyShape, Motion, MovingSolid, Path, Scheme, Simulation, StressStep, TimeStep,
};
use crate::solid::fan::{self, FanSettings};
use crate::solid::{Shape, Solid, mesh_grid, wall_particles};
use crate::sph::WallParticles;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A tank: 40 mm wide and high, columns of 14 mm by 24 mm, a fan of 30 mm that turns five times a second after half a
/// turn in which it gets up to that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tank {
    /// Which list of terms a step is.
    pub scheme: Scheme,
    /// How stress is stepped.
    pub stress: StressStep,
    /// Viscosity of the polymer; the liquid has 0.01 [Pa·s].
    pub viscosity: Real,
    /// λ [s].
    pub relaxation_time: Real,
    /// γ [1/s].
    pub thinning: Real,
    /// Distance between particles [m].
    pub spacing: Real,
    /// Fixed step [s], or as the limits allow.
    pub step: Option<Real>,
    /// Seed of the start's jitter.
    pub seed: u64,
    /// Simulated time [s].
    pub duration: Real,
    /// Steps after which it ends at the latest.
    pub most_steps: Option<u64>,
    /// Of the solvers, as [`crate::sim::SimSettings::tolerance`].
    pub tolerance: Real,
    /// Support radius, in spacings.
    pub support_ratio: Real,
}

/// Viscosity of the liquid [Pa·s].
pub const LIQUID: Real = 0.01;
/// Density of the liquid and of the polymer [kg/m³].
pub const DENSITIES: [Real; 2] = [940.0, 1180.0];
const RADIUS: Real = 0.02;
const HEIGHT: Real = 0.04;
const TURNS: Real = 5.0;
const RAMP: Real = 0.2;

/// What became of a tank.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fate {
    /// Time reached [s].
    pub time: Real,
    /// Steps made.
    pub steps: u64,
    /// Why it collapsed, if it did.
    pub collapse: Option<Collapse>,
    /// Time [s] and intensity of segregation, fifty times a second.
    pub segregation: Vec<[Real; 2]>,
    /// Wall-clock time per simulated time [1].
    pub cost: Real,
    /// Places [m], polymer fractions: the last moment.
    pub last: Vec<([f32; 3], f32)>,
}

/// Speed of the blades' tips [m/s].
pub fn tip_speed() -> Real {
    TAU * TURNS * 0.5 * FanSettings::default().diameter
}

/// A particle moves by 0.4 spacings [s].
pub fn cfl_step(spacing: Real) -> Real {
    0.4 * spacing / tip_speed()
}

/// The fan: the same for all tanks of one spacing.
pub struct Fan {
    solid: Solid,
    particles: WallParticles,
}

impl Fan {
    /// For tanks of this spacing and support radius, in spacings.
    pub fn new(spacing: Real, support_ratio: Real) -> Result<Self, StudyError> {
        let mut mesh = fan::make(&FanSettings::default()).map_err(StudyError::Scene)?;
        for x in &mut mesh.positions {
            x.z += 0.003;
        }
        let solid = Solid {
            shapes: Vec::new(),
            grids: vec![mesh_grid(&mesh, 0.5 * spacing, 3.2 * spacing)],
        };
        let depth = (support_ratio - 0.4) * spacing;
        let particles = wall_particles(&solid, &mesh.bounds().grown(spacing), spacing, depth);
        Ok(Self { solid, particles })
    }
}

impl Tank {
    /// Its fan.
    pub fn fan(&self) -> Result<Fan, StudyError> {
        Fan::new(self.spacing, self.support_ratio)
    }

    /// Runs with its fan, until the time is over or the tank collapses, or for `most_steps`.
    pub fn run(&self, name: &str, fan: &Fan) -> Result<Fate, StudyError> {
        let mut simulation = self.place(fan).start(name)?;
        let begun = std::time::Instant::now();
        let reach = 2.0 * self.spacing;
        let outside =
            |x: &Vec3| x.x.hypot(x.y) > RADIUS + reach || x.z < -reach || x.z > HEIGHT + reach;
        // What the fan does is at most to bring all to the speed of its tips.
        let bounds = Bounds {
            speed: tip_speed(),
            energy: 0.5 * tip_speed().powi(2) + 9.81 * HEIGHT,
            outside: &outside,
        };
        let mut watch = Watch::new(&mut simulation, bounds);
        let mut segregation = vec![[0.0, intensity(&simulation)]];
        let mut collapse = None;
        while simulation.time < self.duration
            && collapse.is_none()
            && self.most_steps.is_none_or(|most| simulation.steps < most)
        {
            let next = segregation.len() as Real * 0.02;
            let end = next.min(self.duration);
            collapse = match simulation.step_towards(end) {
                Ok(report) => watch.look(&mut simulation, report.converged),
                Err(error) => Some(Collapse::of(error).map_err(StudyError::run(name))?),
            };
            if simulation.time >= end && collapse.is_none() {
                segregation.push([simulation.time, intensity(&simulation)]);
            }
        }
        let fluid = &simulation.fluid;
        let last = fluid.position.iter().zip(&fluid.polymer_fraction);
        Ok(Fate {
            time: simulation.time,
            steps: simulation.steps,
            collapse,
            segregation,
            cost: begun.elapsed().as_secs_f64() / simulation.time.max(1e-9),
            last: last
                .map(|(x, &alpha)| ([x.x as f32, x.y as f32, x.z as f32], alpha as f32))
                .collect(),
        })
    }

    fn place(&self, fan: &Fan) -> Place {
        let dx = self.spacing;
        let domain = Aabb {
            min: Vec3::new(-RADIUS, -RADIUS, 0.0),
            max: Vec3::new(RADIUS, RADIUS, HEIGHT),
        }
        .grown(3.0 * dx);
        let mut s = settings(dx, domain);
        s.scheme = self.scheme;
        s.stress = self.stress;
        s.gravity = Vec3::new(0.0, 0.0, -9.81);
        s.duration = self.duration;
        s.seed = self.seed;
        s.tolerance = self.tolerance;
        s.support_ratio = self.support_ratio;
        s.jitter = 0.1;
        s.time_step = match self.step {
            Some(dt) => TimeStep::Fixed(dt),
            None => TimeStep::Adaptive {
                min: 1e-7,
                max: 4e-3,
                cfl: 0.4,
            },
        };
        s.cement = Cement {
            liquid: PhaseMaterial {
                density: DENSITIES[0],
                viscosity: LIQUID,
            },
            polymer: PhaseMaterial {
                density: DENSITIES[1],
                viscosity: self.viscosity,
            },
            relaxation_time: self.relaxation_time,
            thinning: self.thinning,
            diffusion: 1e-7,
            normalised_bonding: true,
            slip_relaxation: Some(1e-4),
            ..newtonian(DENSITIES[0], LIQUID)
        };
        s.bodies = [(-1.0, 0.0), (1.0, 1.0)]
            .map(|(side, polymer_fraction)| Body {
                shape: BodyShape::Cylinder {
                    base: Vec3::new(side * 0.009, 0.0, 0.012),
                    axis: Vec3::z(),
                    length: 0.024,
                    radius: 0.007,
                },
                polymer_fraction,
                velocity: Vec3::zeros(),
                saturated: false,
            })
            .to_vec();
        let tank = Solid {
            shapes: vec![Shape::Cylinder {
                base: Vec3::zeros(),
                axis: Vec3::z(),
                length: HEIGHT,
                radius: RADIUS,
                hollow: true,
            }],
            grids: Vec::new(),
        };
        let depth = (s.support_ratio - 0.4) * dx;
        let walls = wall_particles(&tank, &domain.grown(s.support_ratio * dx), dx, depth);
        Place {
            settings: s,
            solid: tank,
            walls,
            moving: vec![MovingSolid {
                motion: Motion {
                    path: Path::Turning {
                        point: Vec3::zeros(),
                        axis: Vec3::z(),
                        rate: TAU * TURNS,
                    },
                    ramp: RAMP,
                },
                solid: fan.solid.clone(),
                particles: fan.particles.clone(),
            }],
        }
    }
}

/// Cells in which segregation is counted [m].
const CELL: Real = 8e-3;

/// Intensity of segregation: variance of the polymer fraction over cells, of that of unmixed phases.
fn intensity(simulation: &Simulation) -> Real {
    let mut cells: BTreeMap<[i64; 3], (Real, Real)> = BTreeMap::new();
    let fluid = &simulation.fluid;
    for (x, alpha) in fluid.position.iter().zip(&fluid.polymer_fraction) {
        let key = [x.x, x.y, x.z].map(|c| (c / CELL).floor() as i64);
        let cell = cells.entry(key).or_default();
        cell.0 += 1.0;
        cell.1 += alpha;
    }
    let n: Real = cells.values().map(|c| c.0).sum();
    let mean = cells.values().map(|c| c.1).sum::<Real>() / n;
    let spread = cells.values().map(|(k, sum)| k * (sum / k - mean).powi(2));
    spread.sum::<Real>() / n / (mean * (1.0 - mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::scenes::SUPPORT;

    /// A tank at the CFL step.
    fn tank(scheme: Scheme, stress: StressStep, ratio: Real, duration: Real) -> Tank {
        Tank {
            scheme,
            stress,
            viscosity: ratio * LIQUID,
            relaxation_time: 0.05,
            thinning: 0.5,
            spacing: 2e-3,
            step: Some(cfl_step(2e-3)),
            seed: 1,
            duration,
            most_steps: None,
            tolerance: 1.0,
            support_ratio: SUPPORT,
        }
    }

    fn at_the_cfl_step(scheme: Scheme, stress: StressStep, ratio: Real, duration: Real) -> Fate {
        let tank = tank(scheme, stress, ratio, duration);
        let fan = tank.fan().expect("a scene");
        tank.run("tank", &fan).expect("a scene")
    }

    /// At a thousand times the liquid's viscosity and the step that a particle's motion allows.
    #[test]
    fn at_the_cfl_step_imm_falls_over_where_imm_ct_does_not() {
        let explicit = at_the_cfl_step(Scheme::Imm, StressStep::Explicit, 1000.0, 0.06);
        assert!(explicit.collapse.is_some() && explicit.time < 0.03);
        let coupled = at_the_cfl_step(Scheme::ImmCt, StressStep::Coupled, 1000.0, 0.06);
        assert_eq!(coupled.collapse, None);
        assert_eq!(coupled.time, 0.06);
        // Two columns that have not met are as they were.
        assert_eq!(coupled.segregation[0][1], 1.0);
        assert!(coupled.segregation.len() == 4);
    }

    /// Columns that touch nothing yet, at steps so small that what a start's jitter compresses is not to be undone in one.
    #[test]
    fn tiny_explicit_steps_do_not_fling_a_start_apart() {
        for scheme in [Scheme::Dfsph, Scheme::Imm] {
            let step = 0.006 * cfl_step(2e-3);
            let tank = Tank {
                step: Some(step),
                most_steps: Some(10),
                ..tank(scheme, StressStep::Explicit, 1e4, 1.0)
            };
            let fate = tank.run("tiny steps", &tank.fan().unwrap()).unwrap();
            assert_eq!((fate.collapse, fate.steps), (None, 10), "{scheme:?}");
        }
    }

    /// The fan presses particles into the corner below it, where the velocity gradient is steep.
    #[test]
    fn what_is_shifted_out_of_a_wall_again_and_again_gains_no_speed() {
        let fate = at_the_cfl_step(Scheme::ImmCt, StressStep::Coupled, 10.0, 0.56);
        assert_eq!(fate.collapse, None, "at {} s", fate.time);
    }
}
