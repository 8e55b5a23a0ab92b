//! The terms of a step, one method each; `schemes` says in which order.

use super::energy::{Books, Energy};
use super::health::{SimError, Symptom, first_symptom};
use super::inlet::InletState;
use super::mover::Surroundings;
use super::settings::{Scheme, SimSettings, StressStep, TimeStep};
use super::time_step::{self, FlowMeasures, Limit};
use crate::fluid::{FluidParticles, MixtureFields, bonding};
use crate::math::{Mat3, Real, Vec3, ordered_max};
use crate::sph::operators::velocity_gradient;
use crate::sph::{Domain, Kernel, MovingWalls, Neighbourhood, PressureOperator, Walls};
use serde::{Deserialize, Serialize};

/// Times the CFL limit that a particle may move in an adaptive step; more where smaller steps did not help or are not what
/// the solver is good at, as where a gap closes as fast as it likes.
const OVERSHOOT: [Real; 2] = [1.5, 2.5];
const PATIENCE: u32 = 2;

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// dt [s].
    pub dt: Real,
    /// What limited it.
    pub limit: Option<Limit>,
    /// Iterations of all solves.
    pub iterations: usize,
    /// Whether every solve met its goals.
    pub converged: bool,
    /// Volume strain left over in the step [1].
    pub strain: Real,
    /// Inflow left unbalanced, of the inflow [1]; 0 where nothing flows in.
    pub balance: Real,
    /// Velocity residual that a coupled solve left over [m/s].
    #[serde(default)]
    pub velocity: Real,
    /// How often the step was taken back and tried again smaller.
    pub retries: u32,
    /// Pairs of fluid particles.
    pub pairs: usize,
    /// Static wall particles that touch fluid.
    pub awake: usize,
    /// What came, went and was lost in the step, where that is kept account of.
    #[serde(default)]
    pub energy: Energy,
}

/// One step in progress.
pub struct Stepper<'a> {
    pub settings: &'a SimSettings,
    pub kernel: &'a Kernel,
    pub domain: &'a Domain,
    pub around: Surroundings<'a>,
    pub walls: &'a Walls,
    pub fluid: &'a mut FluidParticles,
    pub inlets: &'a mut [InletState],
    pub near: &'a mut Neighbourhood,
    pub moving: MovingWalls,
    pub mix: MixtureFields,
    pub gradient: Vec<Mat3>,
    /// v_θ − v of the end of the step [m/s], once they differ: forces act on v_θ, and particles move with it.
    pub lead: Vec<Vec3>,
    /// Whether the fluid has neither a free surface nor a way in or out.
    pub closed: bool,
    /// How this step's stress is stepped.
    pub stress: StressStep,
    /// Largest step after one that failed [s], if one did lately.
    pub caution: Option<Real>,
    /// Speed at which compression is undone [m/s]; none before the first step.
    pub pace: &'a mut Option<Real>,
    /// The step before this one [s]; 0 if none was.
    pub last_step: Real,
    pub dt: Real,
    pub time: Real,
    pub step: u64,
    /// How often it was tried before.
    pub retries: u32,
    /// The books of its energy, if they are kept.
    pub books: Option<Books>,
    pub report: StepReport,
}

impl Stepper<'_> {
    /// Neighbours, moving walls and all that follows from positions.
    pub fn find_neighbours(&mut self) {
        self.meet_neighbours();
        // An explicit Newtonian step with a free surface goes without: a fifth of its time for a figure that does not
        // show there.
        let explicit = self.settings.stress == StressStep::Explicit;
        if self.closed || self.settings.scheme == Scheme::ImmCt || !explicit {
            self.near.straighten(self.closed);
        }
        self.report.converged = true;
    }

    /// Neighbours and moving walls, with the kernel's own gradients.
    fn meet_neighbours(&mut self) {
        let mut moving = MovingWalls::default();
        let volume = self.kernel.rest_volume(self.settings.spacing);
        for (number, inlet) in self.inlets.iter().enumerate() {
            inlet.stand(
                number as u16,
                self.kernel.support_radius,
                volume,
                &mut moving,
            );
        }
        for mover in self.around.movers {
            mover.stand(self.time, self.domain, &mut moving);
        }
        let scenery = self.around.at(self.time);
        self.near.rebuild(
            &self.fluid.position,
            self.settings.spacing,
            self.kernel,
            self.domain,
            self.walls,
            &moving,
            |x| scenery.distance(x),
        );
        self.moving = moving;
        self.report.pairs = self.near.fluid.entries();
        self.report.awake = self.near.awake;
        self.closed = self.find_closed();
    }

    /// What each particle presses with [Pa] (`PressureOperator::mean_stress`). In a closed body gradients are straightened
    /// and the multiplier is that already.
    pub(super) fn pressure(&mut self) -> Vec<Real> {
        self.meet_neighbours();
        let multiplier = self.fluid.multiplier(0);
        if self.closed {
            return multiplier;
        }
        PressureOperator { near: self.near }.mean_stress(&multiplier)
    }

    /// Whether mixture work has anything to do: with a single pure phase it only copies (same bits).
    pub(super) fn mixes(&self) -> bool {
        let first = self.fluid.polymer_fraction.first().copied().unwrap_or(0.0);
        let pure = (first == 0.0 || first == 1.0)
            && self.fluid.polymer_fraction.iter().all(|&a| a == first);
        !(pure && self.settings.skip_unneeded)
    }

    /// Eqs 4, 5 and the effective mass; C_d of (Eq. 10) if `bonds`, C_d⁰ everywhere if not.
    pub fn refresh_mixture(&mut self, bonds: bool) {
        let cement = &self.settings.cement;
        let drag = if bonds && self.mixes() {
            bonding::drag(cement, self.fluid, self.near, self.kernel, self.domain)
        } else if self.settings.scheme == Scheme::Dfsph {
            vec![1.0; self.fluid.len()]
        } else {
            vec![cement.rest_drag; self.fluid.len()]
        };
        self.mix
            .refresh(cement, self.fluid, self.near.rest_volume, drag);
    }

    /// L from v_mix (Eq. 2).
    pub fn refresh_gradient(&mut self) {
        self.near.straighten(self.closed);
        self.gradient = velocity_gradient(self.near, &self.carrying_velocity());
    }

    /// v_θ of the mixture [m/s]: what strains the polymer and moves particles.
    pub(super) fn carrying_velocity(&self) -> Vec<Vec3> {
        let mut velocity = self.mix.velocity.clone();
        for (v, lead) in velocity.iter_mut().zip(&self.lead) {
            *v += lead;
        }
        velocity
    }

    /// Chooses dt; `left` [s] remain to the end of the frame.
    pub fn choose_step(&mut self, left: Real) {
        let cement = &self.settings.cement;
        let fluid = &*self.fluid;
        let n = fluid.len();
        let fluid_speed = ordered_max(n, |i| {
            let v = &fluid.phase_velocity[i];
            self.mix.velocity[i].norm().max(match self.settings.scheme {
                Scheme::Dfsph => 0.0,
                _ => v.liquid.norm().max(v.polymer.norm()),
            })
        });
        let flow = FlowMeasures {
            speed: fluid_speed.max(self.driven_speed()),
            strain_rate: ordered_max(self.gradient.len(), |i| self.gradient[i].norm()).max(0.0),
            stiffness: match self.settings.scheme {
                Scheme::ImmCt if cement.relaxation_time > 0.0 => ordered_max(n, |i| {
                    let u = &fluid.conformation[i];
                    cement.modulus(fluid.polymer_fraction[i]) * u.eigenvalues()[2]
                }),
                _ => 0.0,
            },
            viscosity: ordered_max(n, |i| cement.mixture_viscosity(fluid.polymer_fraction[i])),
            density: -ordered_max(n, |i| -self.mix.density[i]),
            pressure: ordered_max(n, |i| fluid.pressure[i][0]),
        };
        let (mut dt, mut limit, stress) = time_step::choose(self.settings, &flow);
        self.stress = stress;
        if let TimeStep::Adaptive { cfl, .. } = self.settings.time_step {
            for mover in self.around.movers {
                let most = mover.most_step(self.time, cfl * self.settings.spacing, dt);
                if most < dt {
                    (dt, limit) = (most, Limit::Cfl);
                }
            }
        }
        for inlet in &*self.inlets {
            if inlet.most_step() < dt {
                (dt, limit) = (inlet.most_step(), Limit::Dose);
            }
        }
        if let Some(caution) = self.caution.filter(|&c| limit != Limit::Fixed && c < dt) {
            (dt, limit) = (caution, Limit::Retry);
        }
        if limit == Limit::Fixed {
            if left < dt * (1.0 + 1e-9) {
                dt = left;
            }
        } else if left < dt * (1.0 + 1e-9) {
            (dt, limit) = (left, Limit::Frame);
        } else if left < 2.0 * dt {
            // Two equal steps rather than a full one and a sliver.
            dt = 0.5 * left;
        }
        self.dt = dt;
        if stress == StressStep::Explicit {
            self.fluid.change.fill(Vec3::zeros());
        }
        self.drive_walls();
        self.keep_pace();
        self.report.dt = dt;
        self.report.limit = Some(limit);
    }

    /// Moving walls have the velocity of the middle of the step: it takes them where they will be at its end.
    fn drive_walls(&mut self) {
        let middle = self.time + 0.5 * self.dt;
        let pistons = self.moving.velocity.iter().copied();
        let pistons = pistons.zip(&self.moving.depth).filter(|b| b.1.is_none());
        let movers = self.around.movers.iter().flat_map(|m| m.velocities(middle));
        let velocity: Vec<Vec3> = pistons.map(|b| b.0).chain(movers).collect();
        self.near.set_moving_velocity(&velocity);
    }

    /// Fastest piston or moving wall [m/s].
    pub(super) fn driven_speed(&self) -> Real {
        let pistons = self.inlets.iter().map(InletState::speed);
        let movers = self
            .around
            .movers
            .iter()
            .map(|mover| mover.speed(self.time));
        pistons.chain(movers).fold(0.0, Real::max)
    }

    /// How far a particle may move in a step [m]. A step that was chosen for the speed before it and ends far beyond the
    /// CFL limit, as from rest under a great force, is to be tried again smaller.
    fn reach(&self) -> Real {
        let most = self.kernel.support_radius;
        match self.settings.time_step {
            TimeStep::Adaptive { cfl, .. } => {
                let patient = self.retries < PATIENCE && self.stress != StressStep::Explicit;
                let overshoot = OVERSHOOT[usize::from(!patient)];
                most.min(overshoot * cfl * self.settings.spacing)
            }
            TimeStep::Fixed(_) => most,
        }
    }

    /// Stops the run if a particle is ill after `term`: it need not be moved, which for a speed beyond all measure has no end.
    pub fn check(&self, term: &'static str) -> Result<(), SimError> {
        self.stop_if(first_symptom(self.fluid, self.reach(), self.dt), term)
    }

    /// The same after a term that the pressure is still to tame: any speed will do.
    pub fn check_untamed(&self, term: &'static str) -> Result<(), SimError> {
        self.stop_if(first_symptom(self.fluid, Real::INFINITY, self.dt), term)
    }

    fn stop_if(
        &self,
        symptom: Option<(usize, Symptom)>,
        term: &'static str,
    ) -> Result<(), SimError> {
        let Some((i, what)) = symptom else {
            return Ok(());
        };
        Err(SimError::Diverged {
            step: self.step,
            time: self.time,
            particle: self.fluid.id[i],
            position: self.fluid.position[i],
            term,
            what,
        })
    }
}
