//! When a run has collapsed: what is looked for after every step of a stability study.

use crate::math::{Real, Vec3};
use crate::sim::{SimError, Simulation, Symptom};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why a run counts as collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Collapse {
    /// A particle is where none may be.
    Escaped,
    /// Ten times as fast as anything that drives.
    Runaway,
    /// Twice the kinetic energy that can have been given.
    Energy,
    /// Compressed by 5 % on average.
    Compressed,
    /// A conformation tensor that is not positive definite.
    NotPositive,
    /// A polymer fraction outside 0…1.
    Fraction,
    /// A value that is not a number.
    NonFinite,
    /// A phase lost or won a thousandth of the volume.
    Volume,
    /// The solver missed its goals too often in a row.
    Unconverged,
}

impl Collapse {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Escaped,
        Self::Runaway,
        Self::Energy,
        Self::Compressed,
        Self::NotPositive,
        Self::Fraction,
        Self::NonFinite,
        Self::Volume,
        Self::Unconverged,
    ];

    /// What a step that failed for good says; errors that are none of physics are handed back.
    pub fn of(error: SimError) -> Result<Self, SimError> {
        match error {
            SimError::Diverged { what, .. } => Ok(match what {
                Symptom::NonFinite => Self::NonFinite,
                Symptom::NotPositive => Self::NotPositive,
                Symptom::Fraction => Self::Fraction,
                Symptom::Runaway => Self::Runaway,
            }),
            SimError::Unconverged { .. } => Ok(Self::Unconverged),
            other => Err(other),
        }
    }
}

impl fmt::Display for Collapse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Escaped => "a particle escaped",
            Self::Runaway => "a runaway velocity",
            Self::Energy => "energy from nowhere",
            Self::Compressed => "compressed by 5 % on average",
            Self::NotPositive => "conformation not positive",
            Self::Fraction => "a fraction outside 0 to 1",
            Self::NonFinite => "not a number",
            Self::Volume => "a phase lost volume",
            Self::Unconverged => "the solver does not converge",
        })
    }
}

/// What drives a run, and where its particles may be.
pub struct Bounds<'a> {
    /// Speed of whatever drives [m/s].
    pub speed: Real,
    /// Energy that drivers and gravity can give to a mass [J/kg].
    pub energy: Real,
    /// Whether a place is beyond the walls.
    pub outside: &'a dyn Fn(&Vec3) -> bool,
}

/// What was seen so far.
pub struct Watch<'a> {
    bounds: Bounds<'a>,
    /// Volume of each phase that is accounted for at the start [m³], and the kinetic energy then [J].
    volume: [Real; 2],
    kinetic: Real,
    first_compression: Option<Real>,
    unconverged: u32,
    /// Largest change of a phase's volume so far, of all volume [1].
    pub drift: Real,
    /// Particles beyond the walls at the last look.
    pub escaped: u64,
    /// Most particles deeper than half a spacing inside a wall.
    pub in_walls: u64,
}

/// Steps in a row that may end unconverged.
const MOST_UNCONVERGED: u32 = 20;
/// Mean compression from which a run has collapsed.
const MOST_COMPRESSION: Real = 0.05;

impl<'a> Watch<'a> {
    /// Starts to watch a run.
    pub fn new(simulation: &mut Simulation, bounds: Bounds<'a>) -> Self {
        let ledger = simulation.ledger();
        let kept = |k: usize| account(&ledger)[k];
        Self {
            bounds,
            volume: [kept(0), kept(1)],
            kinetic: ledger.kinetic,
            first_compression: None,
            unconverged: 0,
            drift: 0.0,
            escaped: 0,
            in_walls: 0,
        }
    }

    /// Why the run has collapsed, if it has, after a step that `converged` or not.
    pub fn look(&mut self, simulation: &mut Simulation, converged: bool) -> Option<Collapse> {
        self.unconverged = if converged { 0 } else { self.unconverged + 1 };
        let ledger = simulation.ledger();
        let fluid = &simulation.fluid;
        let fled = fluid.position.iter().filter(|x| (self.bounds.outside)(x));
        let gone = (ledger.escaped.liquid + ledger.escaped.polymer) / simulation.rest_volume;
        self.escaped = fled.count() as u64 + gone.round() as u64;
        self.in_walls = self.in_walls.max(ledger.in_walls as u64);
        let phases = fluid.phase_velocity.iter();
        let fastest = phases
            .map(|v| v.liquid.norm().max(v.polymer.norm()))
            .fold(0.0, Real::max);
        let volume = account(&ledger);
        let inside = ledger.inside.liquid + ledger.inside.polymer;
        let drift = (0..2).map(|k| (volume[k] - self.volume[k]).abs());
        let drift = drift.fold(0.0, Real::max) / inside.max(simulation.rest_volume);
        self.drift = self.drift.max(drift);
        let cement = &simulation.settings.cement;
        let mass = ledger.inside.liquid * cement.liquid.density
            + ledger.inside.polymer * cement.polymer.density;
        let given = self.kinetic + mass * self.bounds.energy;
        // Fluid that starts compressed is not to blame for that.
        let first = *self.first_compression.get_or_insert(ledger.compression[0]);
        Some(if self.escaped > 0 {
            Collapse::Escaped
        } else if fastest > 10.0 * self.bounds.speed {
            Collapse::Runaway
        } else if ledger.kinetic > 2.0 * given {
            Collapse::Energy
        } else if ledger.compression[0] > MOST_COMPRESSION.max(1.01 * first) {
            Collapse::Compressed
        } else if ledger.stretch[0] <= 0.0 {
            Collapse::NotPositive
        } else if drift > 1e-3 {
            Collapse::Volume
        } else if self.unconverged > MOST_UNCONVERGED {
            Collapse::Unconverged
        } else {
            return None;
        })
    }
}

/// Volume of liquid and polymer that a closed account keeps [m³].
fn account(ledger: &crate::sim::Ledger) -> [Real; 2] {
    let kept = |inside: Real, escaped: Real, injected: Real| inside + escaped - injected;
    let (inside, escaped, injected) = (&ledger.inside, &ledger.escaped, &ledger.injected);
    [
        kept(inside.liquid, escaped.liquid, injected.liquid),
        kept(inside.polymer, escaped.polymer, injected.polymer),
    ]
}
