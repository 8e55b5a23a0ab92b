//! All that a restart has to keep: from it and the same settings and walls a run goes on with the same bits.
//!
//! Walls that move are not in it: where they are follows from the time.

use super::inlet::InletState;
use super::ledger::Tally;
use super::simulation::Simulation;
use crate::fluid::FluidParticles;
use crate::math::Real;
use serde::{Deserialize, Serialize};

/// The state of a run between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The cement, with the warm starts of its solvers.
    pub fluid: FluidParticles,
    /// Everything else.
    pub progress: Progress,
}

/// How far a run has come, apart from its particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Simulated time [s].
    pub time: Real,
    /// Steps so far.
    pub steps: u64,
    /// Particles carved away at the start.
    pub carved: usize,
    /// Largest step after one that failed [s], if one did lately.
    #[serde(default)]
    pub caution: Option<Real>,
    /// Speed at which compression is undone [m/s].
    #[serde(default)]
    pub pace: Option<Real>,
    /// The last step [s]; 0 before the first.
    #[serde(default)]
    pub last_step: Real,
    /// Of each inlet.
    pub inlets: Vec<InletProgress>,
    /// What adds up for the tables.
    pub tally: Tally,
}

/// How far an inlet has come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InletProgress {
    /// How far the piston has come since the last row became fluid [m].
    pub travelled: Real,
    /// Volume that the piston has pushed [m³].
    pub pushed: Real,
    /// Volume that has become fluid [m³].
    pub emitted: Real,
    /// Pressure at the opening [Pa].
    pub pressure: Real,
}

impl Simulation {
    /// The state as it is now.
    pub fn state(&self) -> State {
        State {
            fluid: self.fluid.clone(),
            progress: self.progress(),
        }
    }

    /// The state apart from the particles.
    pub fn progress(&self) -> Progress {
        let inlet = |inlet: &InletState| InletProgress {
            travelled: inlet.travelled,
            pushed: inlet.pushed,
            emitted: inlet.emitted,
            pressure: inlet.pressure,
        };
        Progress {
            time: self.time,
            steps: self.steps,
            carved: self.carved,
            caution: self.caution,
            pace: self.pace,
            last_step: self.last_step,
            inlets: self.inlets.iter().map(inlet).collect(),
            tally: self.tally.clone(),
        }
    }

    /// Goes on from a state of a run with the same settings and walls; false if it belongs to another.
    #[must_use]
    pub fn restore(&mut self, state: State) -> bool {
        let State { fluid, progress } = state;
        if progress.inlets.len() != self.inlets.len() {
            return false;
        }
        self.fluid = fluid;
        self.time = progress.time;
        self.steps = progress.steps;
        self.carved = progress.carved;
        self.caution = progress.caution;
        self.pace = progress.pace;
        self.last_step = progress.last_step;
        self.tally = progress.tally;
        for (inlet, then) in self.inlets.iter_mut().zip(progress.inlets) {
            inlet.travelled = then.travelled;
            inlet.pushed = then.pushed;
            inlet.emitted = then.emitted;
            inlet.pressure = then.pressure;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fluid::Cement;
    use crate::math::{Aabb, Vec3};
    use crate::sim::{
        Body, BodyShape, ElasticWaves, Inlet, Motion, MovingSolid, Path, PhaseMaterial, Scheme,
        SimSettings, StressStep, TimeStep,
    };
    use crate::solid::{Shape, Solid, wall_particles};

    const DX: Real = 1e-3;

    /// A box with a body of fluid, an inlet and a moving plate.
    fn run(scheme: Scheme, stress: StressStep) -> Simulation {
        let phase = |density, viscosity| PhaseMaterial { density, viscosity };
        let inside = Aabb {
            min: Vec3::zeros(),
            max: Vec3::repeat(10.0 * DX),
        };
        let domain = inside.grown(3.0 * DX);
        let settings = SimSettings {
            scheme,
            stress,
            elastic_waves: ElasticWaves::Damped,
            theta: 1.0,
            spacing: DX,
            support_ratio: 2.4,
            duration: 1.0,
            frames_per_second: 100.0,
            gravity: Vec3::z() * -9.81,
            periodic: [false; 3],
            domain,
            time_step: TimeStep::Adaptive {
                min: 1e-6,
                max: 1e-3,
                cfl: 0.4,
            },
            tolerance: 1.0,
            cement: Cement {
                liquid: phase(940.0, 0.01),
                polymer: phase(1180.0, 1.0),
                relaxation_time: 0.05,
                thinning: 0.5,
                rest_drag: 0.5,
                diffusion: 1e-7,
                normalised_bonding: true,
                literal_modulus: false,
                slip_relaxation: Some(1e-4),
            },
            bodies: vec![Body {
                shape: BodyShape::Box(Aabb {
                    min: Vec3::zeros(),
                    max: Vec3::new(10.0, 10.0, 4.0) * DX,
                }),
                polymer_fraction: 0.5,
                velocity: Vec3::zeros(),
                saturated: false,
            }],
            inlets: vec![Inlet {
                name: "needle".into(),
                position: Vec3::new(5.0, 5.0, 8.0) * DX,
                direction: -Vec3::z(),
                diameter: 3.0 * DX,
                flow_rate: 1e-6,
                polymer_fraction: 0.8,
                dose: 0.4e-6,
            }],
            seed: 1,
            jitter: 0.1,
            energy_balance: false,
            skip_unneeded: true,
        };
        let walls = |shape| {
            let solid = Solid {
                shapes: vec![shape],
                grids: Vec::new(),
            };
            let particles = wall_particles(&solid, &domain, DX, 2.0 * DX);
            (solid, particles)
        };
        let (solid, particles) = walls(Shape::Box {
            min: inside.min,
            max: inside.max,
            hollow: true,
        });
        let (blade, blade_particles) = walls(Shape::Box {
            min: Vec3::new(1.0, 1.0, 1.0) * DX,
            max: Vec3::new(3.0, 9.0, 3.0) * DX,
            hollow: false,
        });
        let mover = MovingSolid {
            motion: Motion {
                path: Path::Turning {
                    point: Vec3::new(5.0, 5.0, 2.0) * DX,
                    axis: Vec3::z(),
                    rate: 20.0,
                },
                ramp: 0.01,
            },
            solid: blade,
            particles: blade_particles,
        };
        Simulation::with_movers(settings, solid, particles, vec![mover]).unwrap()
    }

    #[test]
    fn a_run_goes_on_from_its_state_with_the_same_bits() {
        for (scheme, stress) in [
            (Scheme::ImmCt, StressStep::Coupled),
            (Scheme::ImmCt, StressStep::Explicit),
            (Scheme::Dfsph, StressStep::Explicit),
        ] {
            let mut whole = run(scheme, stress);
            let mut other = run(scheme, stress);
            let end = 8e-3;
            // Stopped in the middle of a window of the ledger, at no round time.
            for _ in 0..3 {
                whole.step_towards(end).unwrap();
            }
            let state = whole.state();
            whole.advance_to(end, |_| {}).unwrap();
            assert!(other.restore(state));
            other.advance_to(end, |_| {}).unwrap();
            assert!(whole.state() == other.state(), "{scheme:?} {stress:?}");
            assert!(whole.steps > 6, "{}", whole.steps);
            assert_eq!(whole.ledger().row(), other.ledger().row());
        }
    }
}
