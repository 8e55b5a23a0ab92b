//! A trial: one small scene that asks for trouble, run for some dozen steps and watched at each.

use super::scenes::Arena;
use crate::math::Real;
use crate::sim::{StressStep, TimeStep};
use crate::study::StudyError;
use crate::study::watch::{Bounds, Collapse, Watch};
use serde::{Deserialize, Serialize};

/// What is done to the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A blade turns at full speed from the first step on, two phases side by side.
    Stirred,
    /// The same where the blade sweeps through the wall of the pot.
    Overlapping,
    /// The same with a polymer ten times as dense.
    Dense,
    /// Fluid started wherever walls, blade and struts are, on a lattice that is shaken by half a spacing.
    InWalls,
    /// Two bodies of fluid at the same place.
    Doubled,
    /// Pressed between struts by a needle at ten times a sane speed.
    Squeezed,
    /// The same, until a closed space is full.
    Filled,
    /// The same, more than a closed space has room for.
    Overfilled,
    /// A single particle falls.
    Single,
    /// A single particle falls down a wall into a corner.
    Cornered,
    /// Stands on a plate of this many spacings, and presses with 3 MPa.
    Plate(Real),
}

impl Family {
    /// What the tables call it.
    pub fn name(self) -> String {
        match self {
            Self::Stirred => "stirred".into(),
            Self::Overlapping => "overlapping fan".into(),
            Self::Dense => "density ratio 10".into(),
            Self::InWalls => "started inside walls".into(),
            Self::Doubled => "two bodies in one place".into(),
            Self::Squeezed => "squeezed between struts".into(),
            Self::Filled => "squeezed until full".into(),
            Self::Overfilled => "squeezed beyond full".into(),
            Self::Single => "one particle".into(),
            Self::Cornered => "one particle in a corner".into(),
            Self::Plate(thickness) => format!("plate of {thickness} spacings"),
        }
    }
}

/// How time is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// As large as the limits allow, between the bounds that a recipe has by default.
    Adaptive(StressStep),
    /// Always this many CFL steps.
    Fixed(StressStep, Real),
}

impl Mode {
    /// All that are compared.
    pub const ALL: [Self; 6] = [
        Self::Adaptive(StressStep::Coupled),
        Self::Adaptive(StressStep::Auto),
        Self::Fixed(StressStep::Coupled, 1.0),
        Self::Fixed(StressStep::Coupled, 4.0),
        Self::Fixed(StressStep::Explicit, 0.1),
        Self::Fixed(StressStep::Explicit, 1.0),
    ];

    /// What the tables call it.
    pub fn name(self) -> String {
        match self {
            Self::Adaptive(stress) => format!("adaptive {}", stress.name()),
            Self::Fixed(stress, steps) => format!("fixed {} {steps} cfl", stress.name()),
        }
    }

    /// Whether the step is the program's own choice.
    pub fn is_adaptive(self) -> bool {
        matches!(self, Self::Adaptive(_))
    }
}

/// A run of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// What is done.
    pub family: Family,
    /// Viscosity of the polymer by that of the liquid, which is 0.01 Pa·s [1].
    pub ratio: Real,
    /// Speed of what drives [m/s].
    pub speed: Real,
    /// λ [s].
    pub relaxation_time: Real,
    /// γ [1/s].
    pub thinning: Real,
    /// Distance between particles [m].
    pub spacing: Real,
    /// Of the jitter; even ones have no friction between the phases.
    pub seed: u64,
    /// How time is stepped.
    pub mode: Mode,
}

/// How a trial ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// Nothing to complain of.
    Stable,
    /// Not begun, for this reason.
    Refused(String),
    /// Fell over.
    Collapsed(Collapse),
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fate {
    /// How it ended.
    pub end: End,
    /// Particles at the end.
    pub particles: u64,
    /// Steps made.
    pub steps: u64,
    /// Time reached, of the time asked for [1].
    pub reached: Real,
    /// Least step but for those that end a frame, by the CFL step [1].
    pub least_step: Real,
    /// Steps that were taken back.
    pub retries: u64,
    /// Steps that missed their goals and were kept.
    pub unconverged: u64,
    /// Particles beyond the walls.
    pub escaped: u64,
    /// Most particles deeper than half a spacing in a wall.
    pub in_walls: u64,
    /// Largest change of a phase's volume, of all volume [1].
    pub drift: Real,
    /// What the energy's books do not account for, and what the method lost or gave, of all energy turned over; none where
    /// a run ended in numbers that are none.
    pub imbalance: Option<[Real; 2]>,
}

/// CFL steps of a trial.
const STEPS: Real = 60.0;
/// Moments that steps land on.
const FRAMES: u32 = 12;
/// Steps after which a trial ends, wherever it is.
const MOST_STEPS: u64 = 60;
/// A step as the share of a spacing that what drives moves in it.
const CFL: Real = 0.4;

impl Trial {
    /// A name for files.
    pub fn name(&self) -> String {
        let text = format!(
            "{}-{}-{}-{}-{}-{}-{}",
            self.family.name(),
            self.ratio,
            self.speed,
            self.relaxation_time,
            self.thinning,
            self.seed,
            self.mode.name()
        );
        text.replace(' ', "_")
    }

    /// Runs it.
    pub fn run(&self) -> Result<Fate, StudyError> {
        let mut arena = Arena::of(self);
        let cfl = CFL * self.spacing / arena.speed;
        let duration = STEPS * cfl;
        let s = &mut arena.place.settings;
        s.duration = duration;
        let stress;
        (stress, s.time_step) = match self.mode {
            Mode::Adaptive(stress) => (
                stress,
                TimeStep::Adaptive {
                    min: 1e-6,
                    max: 0.02,
                    cfl: CFL,
                },
            ),
            Mode::Fixed(stress, steps) => (stress, TimeStep::Fixed(steps * cfl)),
        };
        s.stress = stress;
        s.energy_balance = true;
        for inlet in &mut s.inlets {
            inlet.dose = inlet.flow_rate * duration * 1.0001;
        }
        let mut fate = Fate {
            end: End::Stable,
            particles: 0,
            steps: 0,
            reached: 0.0,
            least_step: Real::INFINITY,
            retries: 0,
            unconverged: 0,
            escaped: 0,
            in_walls: 0,
            drift: 0.0,
            imbalance: None,
        };
        let mut simulation = match arena.place.start(&self.name()) {
            Ok(simulation) => simulation,
            Err(StudyError::Run { source, .. }) => {
                fate.least_step = 0.0;
                fate.end = End::Refused(source.to_string());
                return Ok(fate);
            }
            Err(other) => return Err(other),
        };
        let bounds = Bounds {
            speed: arena.speed.max((2.0 * arena.fall).sqrt()),
            energy: 0.5 * arena.speed * arena.speed + arena.fall,
            outside: &*arena.outside,
        };
        let mut watch = Watch::new(&mut simulation, bounds);
        while simulation.time < duration && fate.steps < MOST_STEPS && fate.end == End::Stable {
            let frame = (simulation.time / duration * Real::from(FRAMES) + 1e-9).floor() + 1.0;
            let end = (frame * duration / Real::from(FRAMES)).min(duration);
            let why = match simulation.step_towards(end) {
                Ok(report) => {
                    fate.steps += 1;
                    fate.retries += u64::from(report.retries);
                    fate.unconverged += u64::from(!report.converged);
                    if simulation.time < end {
                        fate.least_step = fate.least_step.min(report.dt / cfl);
                    }
                    watch.look(&mut simulation, report.converged)
                }
                Err(error) => Some(Collapse::of(error).map_err(StudyError::run(&self.name()))?),
            };
            fate.end = why.map_or(End::Stable, End::Collapsed);
        }
        if !fate.least_step.is_finite() {
            fate.least_step = duration / Real::from(FRAMES) / cfl;
        }
        fate.particles = simulation.fluid.len() as u64;
        fate.reached = simulation.time / duration;
        (fate.escaped, fate.in_walls, fate.drift) = (watch.escaped, watch.in_walls, watch.drift);
        let ledger = simulation.ledger();
        fate.imbalance = ledger.energy.and_then(|energy| {
            let residual = energy.residual(ledger.kinetic + ledger.elastic);
            let shares = [residual, energy.numerical()].map(|joule| joule / energy.scale());
            shares
                .iter()
                .all(|share| share.is_finite())
                .then_some(shares)
        });
        Ok(fate)
    }
}
