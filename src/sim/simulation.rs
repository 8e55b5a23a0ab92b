//! A simulation from start to end: steps until a moment, and what there is to see then.

use super::energy::{self, Energy};
use super::health::SimError;
use super::inlet::InletState;
use super::ledger::{self, Ledger, Tally};
use super::mover::{Mover, MovingSolid, Surroundings};
use super::probe::Sample;
use super::settings::{SimSettings, TimeStep};
pub use super::stepper::StepReport;
use super::stepper::Stepper;
use super::time_step::Limit;
use super::{room, schemes, start};
use crate::fluid::{FluidParticles, MixtureFields, mixture};
use crate::math::{Real, Vec3};
use crate::solid::Solid;
use crate::sph::{Domain, Kernel, MovingWalls, Neighbourhood, WallParticles, Walls};

/// Neighbour rows are numbered with 32 bits.
const MOST_PARTICLES: usize = 20_000_000;

/// A step that fails is tried again this much smaller, this often; afterwards steps grow back by a third each.
const RETRY: Real = 0.4;
const MOST_RETRIES: u32 = 6;
const CAUTIOUS_GROWTH: Real = 4.0 / 3.0;

/// State and surroundings of a run.
pub struct Simulation {
    /// What it was told.
    pub settings: SimSettings,
    /// The cement.
    pub fluid: FluidParticles,
    /// Inlets in the course of time.
    pub inlets: Vec<InletState>,
    /// Simulated time [s].
    pub time: Real,
    /// Steps so far.
    pub steps: u64,
    /// Particles carved away at the start because a wall is there.
    pub carved: usize,
    /// V₀ [m³].
    pub rest_volume: Real,
    /// Largest step after one that failed [s], if one did lately.
    pub caution: Option<Real>,
    /// Speed at which compression is undone [m/s]; none before the first step.
    pub pace: Option<Real>,
    /// The last step [s]; 0 before the first.
    pub last_step: Real,
    kernel: Kernel,
    domain: Domain,
    solid: Solid,
    walls: Walls,
    movers: Vec<Mover>,
    pub(super) tally: Tally,
    /// Scratch: the pairs of the last step, whose memory the next one uses.
    near: Neighbourhood,
    /// Scratch: the cement before the step.
    before: FluidParticles,
}

impl Simulation {
    /// A run at its start, all walls at rest: bodies filled, first rows of the inlets in place.
    pub fn new(
        settings: SimSettings,
        solid: Solid,
        particles: WallParticles,
    ) -> Result<Self, SimError> {
        Self::with_movers(settings, solid, particles, Vec::new())
    }

    /// The same among walls some of which move.
    pub fn with_movers(
        settings: SimSettings,
        solid: Solid,
        particles: WallParticles,
        moving: Vec<MovingSolid>,
    ) -> Result<Self, SimError> {
        let kernel = Kernel::new(settings.spacing * settings.support_ratio);
        let domain = Domain {
            bounds: settings.domain,
            periodic: settings.periodic,
        };
        let walls = Walls::new(particles, &kernel, &domain, |x| -solid.distance(x).0);
        let movers: Vec<Mover> = moving
            .into_iter()
            .map(|given| Mover::new(given, &kernel, &domain))
            .collect();
        let around = Surroundings {
            solid: &solid,
            movers: &movers,
        };
        let (fluid, carved) = start::fill(&settings, &around.at(0.0));
        if fluid.len() > MOST_PARTICLES {
            return Err(SimError::TooMany(fluid.len(), MOST_PARTICLES));
        }
        room::require(&settings, &around.at(0.0), &fluid.position)?;
        let rest_volume = kernel.rest_volume(settings.spacing);
        let inlets = settings
            .inlets
            .iter()
            .map(|inlet| InletState::new(inlet.clone(), settings.spacing, rest_volume))
            .collect();
        let mut run = Self {
            settings,
            fluid,
            inlets,
            time: 0.0,
            steps: 0,
            carved,
            rest_volume,
            caution: None,
            pace: None,
            last_step: 0.0,
            kernel,
            domain,
            solid,
            walls,
            movers,
            tally: Tally::default(),
            near: Neighbourhood::default(),
            before: FluidParticles::default(),
        };
        run.start_inlets();
        Ok(run)
    }

    /// The first row of every inlet is fluid at the start.
    fn start_inlets(&mut self) {
        for number in 0..self.inlets.len() {
            let inlet = &mut self.inlets[number];
            while let Some(row) = inlet.emit(self.rest_volume) {
                let velocity = inlet.settings.direction * inlet.speed();
                for position in row {
                    let id = self.fluid.len() as u32;
                    self.fluid.push(
                        position,
                        velocity,
                        inlet.settings.polymer_fraction,
                        id,
                        number as u16 + 1,
                    );
                }
            }
        }
        self.count_injected();
    }

    fn count_injected(&mut self) {
        let share = |pick: fn(Real) -> Real| {
            self.inlets
                .iter()
                .map(|inlet| inlet.emitted * pick(inlet.settings.polymer_fraction))
                .sum()
        };
        self.tally.injected.polymer = share(|alpha| alpha);
        self.tally.injected.liquid = share(|alpha| 1.0 - alpha);
    }

    /// Steps until `end` [s] exactly; `each` sees every step.
    pub fn advance_to(
        &mut self,
        end: Real,
        mut each: impl FnMut(&StepReport),
    ) -> Result<(), SimError> {
        while self.time < end {
            each(&self.step_towards(end)?);
        }
        Ok(())
    }

    /// One step, which does not lead beyond `end` [s].
    pub fn step_towards(&mut self, end: Real) -> Result<StepReport, SimError> {
        let left = end - self.time;
        let report = self.step(left)?;
        // The last step of a frame lands on it exactly, whatever the sum of steps rounds to.
        self.time = if report.dt >= left {
            end
        } else {
            self.time + report.dt
        };
        Ok(report)
    }

    /// One step of at most `left` [s]. One that fails its health check or does not converge is taken back and tried
    /// again smaller, unless the step is fixed; what fails in the end leaves the state before it.
    fn step(&mut self, left: Real) -> Result<StepReport, SimError> {
        self.steps += 1;
        // A fixed step has no smaller one to fall back on, and goes on unconverged.
        let least = match self.settings.time_step {
            TimeStep::Adaptive { min, .. } => Some(min),
            TimeStep::Fixed(_) => None,
        };
        self.before.copy_from(&self.fluid);
        let (inlets, pace) = (self.inlets.clone(), self.pace);
        let mut retries = 0;
        loop {
            let (mut report, ended) = self.attempt(left, retries);
            report.retries = retries;
            let error = match ended {
                Ok(()) if report.converged || least.is_none() => {
                    // After a failure the step grows back slowly.
                    self.caution =
                        (report.limit == Some(Limit::Retry)).then_some(report.dt * CAUTIOUS_GROWTH);
                    return Ok(self.accept(report));
                }
                Ok(()) => SimError::Unconverged {
                    step: self.steps,
                    time: self.time,
                    dt: report.dt,
                    strain: report.strain,
                    balance: report.balance,
                    velocity: report.velocity,
                },
                Err(error) => error,
            };
            self.fluid.copy_from(&self.before);
            self.inlets.clone_from(&inlets);
            self.pace = pace;
            let Some(min) = least.filter(|&min| retries < MOST_RETRIES && report.dt > min) else {
                self.steps -= 1;
                return Err(error);
            };
            retries += 1;
            self.caution = Some((report.dt * RETRY).max(min));
        }
    }

    fn accept(&mut self, mut report: StepReport) -> StepReport {
        self.last_step = report.dt;
        self.count_injected();
        self.remove_escaped();
        if self.settings.energy_balance {
            let held = energy::held(&self.settings, &self.fluid, self.rest_volume);
            report.energy.carried = held - report.energy.carried;
            self.tally.energy = Some(Energy::followed_by(self.tally.energy, &report.energy));
        }
        self.tally.add(&report, &self.near.compression);
        report
    }

    /// The step itself: what it did, and whether it went well.
    fn attempt(&mut self, left: Real, retries: u32) -> (StepReport, Result<(), SimError>) {
        let mut stepper = self.stepper(retries);
        let ended = schemes::step(&mut stepper, left);
        (stepper.report, ended)
    }

    fn stepper(&mut self, retries: u32) -> Stepper<'_> {
        Stepper {
            settings: &self.settings,
            kernel: &self.kernel,
            domain: &self.domain,
            around: Surroundings {
                solid: &self.solid,
                movers: &self.movers,
            },
            walls: &self.walls,
            fluid: &mut self.fluid,
            inlets: &mut self.inlets,
            near: &mut self.near,
            moving: MovingWalls::default(),
            mix: MixtureFields::default(),
            gradient: Vec::new(),
            lead: Vec::new(),
            closed: false,
            stress: self.settings.stress,
            caution: self.caution,
            pace: &mut self.pace,
            last_step: self.last_step,
            dt: 0.0,
            time: self.time,
            step: self.steps,
            retries,
            books: None,
            report: StepReport::default(),
        }
    }

    /// Particles that leave the domain are gone, and counted.
    fn remove_escaped(&mut self) {
        let bounds = self.domain.bounds;
        let periodic = self.domain.periodic;
        let inside = |x: &Vec3| {
            (0..3).all(|a| periodic[a] || (bounds.min[a] <= x[a] && x[a] <= bounds.max[a]))
        };
        if self.fluid.position.iter().all(inside) {
            return;
        }
        let stays: Vec<bool> = self.fluid.position.iter().map(inside).collect();
        for (alpha, _) in self
            .fluid
            .polymer_fraction
            .iter()
            .zip(&stays)
            .filter(|(_, stays)| !**stays)
        {
            self.tally.escaped.polymer += self.rest_volume * alpha;
            self.tally.escaped.liquid += self.rest_volume * (1.0 - alpha);
        }
        self.fluid.retain(|i| stays[i]);
    }

    /// The ledger's entry for now; starts a new window.
    pub fn ledger(&mut self) -> Ledger {
        let depth = -0.5 * self.settings.spacing;
        let scenery = self.around().at(self.time);
        let in_walls = self
            .fluid
            .position
            .iter()
            .filter(|x| scenery.distance(x).0 < depth)
            .count();
        let entry = ledger::enter(
            &self.settings,
            &self.fluid,
            &self.inlets,
            &self.tally,
            self.rest_volume,
            self.time,
            self.steps,
            in_walls,
        );
        self.tally.reset_window();
        entry
    }

    /// v_mix of every particle [m/s] (Eq. 4).
    pub fn velocity(&self) -> Vec<Vec3> {
        let phases = self
            .fluid
            .phase_velocity
            .iter()
            .zip(&self.fluid.polymer_fraction);
        phases
            .map(|(v, &alpha)| mixture::mixture_velocity(v, alpha))
            .collect()
    }

    /// What every particle presses with [Pa]: the mean normal stress of its pairs. The multiplier that the solver finds
    /// (`fluid.pressure`) is that only up to how the packing stands: at a support of 2.4 spacings 2 % more on the cubic
    /// lattice, up to 3 % less in other packings.
    pub fn pressure(&mut self) -> Vec<Real> {
        self.stepper(0).pressure()
    }

    /// What probes look at; `velocity` and `pressure` as [`Simulation::velocity`] and [`Simulation::pressure`] give them.
    pub fn sample<'a>(&'a self, velocity: &'a [Vec3], pressure: &'a [Real]) -> Sample<'a> {
        Sample {
            position: &self.fluid.position,
            velocity,
            pressure,
            rest_volume: self.rest_volume,
            spacing: self.settings.spacing,
        }
    }

    /// Support radius [m].
    pub fn support_radius(&self) -> Real {
        self.kernel.support_radius
    }

    /// Number of wall particles, at rest and moving.
    pub fn wall_count(&self) -> usize {
        let moving: usize = self.movers.iter().map(Mover::len).sum();
        self.walls.particles.position.len() + moving
    }

    fn around(&self) -> Surroundings<'_> {
        Surroundings {
            solid: &self.solid,
            movers: &self.movers,
        }
    }
}
