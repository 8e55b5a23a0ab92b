//! The numerics of a run: what a user may turn to trade time for accuracy.

use crate::math::Real;
use crate::sim::{Scheme, SimSettings, StressStep, TimeStep};
use crate::study::scenes::SUPPORT;
use serde::Serialize;

/// A scheme as compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Variant {
    /// Which list of terms a step is.
    pub scheme: Scheme,
    /// How stress is stepped.
    pub stress: StressStep,
}

impl Variant {
    /// All that are compared.
    pub const ALL: [Self; 6] = [
        Self::of(Scheme::Dfsph, StressStep::Explicit),
        Self::of(Scheme::Dfsph, StressStep::Coupled),
        Self::of(Scheme::Imm, StressStep::Explicit),
        Self::of(Scheme::Imm, StressStep::Coupled),
        Self::of(Scheme::ImmCt, StressStep::Explicit),
        Self::of(Scheme::ImmCt, StressStep::Coupled),
    ];

    const fn of(scheme: Scheme, stress: StressStep) -> Self {
        Self { scheme, stress }
    }

    /// What the tables call it.
    pub fn name(self) -> String {
        format!("{} {}", self.scheme.name(), self.stress.name())
    }
}

/// The numerics of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Scheme and stress.
    pub variant: Variant,
    /// Spacings across what flows.
    pub across: u32,
    /// Share of a spacing that the fastest fluid moves in a step.
    pub cfl: Real,
    /// Of the solvers, by the usual one.
    pub tolerance: Real,
    /// Support radius, in spacings.
    pub support_ratio: Real,
}

impl Setting {
    /// The usual ones: as a recipe that says nothing.
    pub fn usual(variant: Variant, across: u32) -> Self {
        Self {
            variant,
            across,
            cfl: 0.4,
            tolerance: 1.0,
            support_ratio: SUPPORT,
        }
    }

    /// A name for files.
    pub fn name(&self) -> String {
        format!(
            "{}-{}-{}-{}-{}",
            self.variant.name().replace(' ', "_"),
            self.across,
            self.cfl,
            self.tolerance,
            self.support_ratio
        )
    }

    /// Puts them in place for a flow whose fastest fluid comes to `speed` [m/s].
    pub fn apply(&self, s: &mut SimSettings, speed: Real) {
        s.scheme = self.variant.scheme;
        s.stress = self.variant.stress;
        s.tolerance = self.tolerance;
        s.time_step = TimeStep::Adaptive {
            min: 1e-9,
            // From the start, when nothing moves yet.
            max: self.cfl * s.spacing / speed,
            cfl: self.cfl,
        };
    }
}

/// What is tried of a variant: every spacing with every step, then each other knob by itself at `knobs` spacings
/// across. Explicit steps are bounded by viscosity and not by the CFL number, and cost most: they are tried at the
/// usual one, and with looser solvers.
pub fn tried(variant: Variant, across: &[u32], steps: &[Real], knobs: u32) -> Vec<Setting> {
    let explicit = variant.stress == StressStep::Explicit;
    let mut settings = Vec::new();
    for &across in across {
        for &cfl in if explicit { &[0.4] } else { steps } {
            settings.push(Setting {
                cfl,
                ..Setting::usual(variant, across)
            });
        }
    }
    let usual = Setting::usual(variant, knobs);
    settings.push(Setting {
        tolerance: 10.0,
        ..usual
    });
    if !explicit {
        settings.push(Setting {
            tolerance: 0.1,
            ..usual
        });
        for support_ratio in [2.0, 3.0] {
            settings.push(Setting {
                support_ratio,
                ..usual
            });
        }
    }
    settings
}
