//! One measured figure and what it should be.

use crate::math::Real;
use std::fmt;

/// A number that a case came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What was measured.
    pub what: String,
    /// How finely.
    pub resolution: String,
    /// What came out.
    pub reached: Real,
    /// What should.
    pub goal: Goal,
    /// Wall-clock time of the runs behind it [s].
    pub seconds: Real,
}

/// What a figure should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// An error.
    AtMost(Real),
    /// An order of convergence.
    AtLeast(Real),
}

impl Goal {
    /// Whether the target is met; NaN never is.
    pub fn is_met(self, reached: Real) -> bool {
        match self {
            Self::AtMost(target) => reached <= target,
            Self::AtLeast(target) => reached >= target,
        }
    }

    /// Whether `reached` is worse than what is recorded; NaN always is.
    pub fn is_worse(self, reached: Real, recorded: Real) -> bool {
        match self {
            Self::AtMost(_) => reached.is_nan() || reached > recorded,
            Self::AtLeast(_) => reached.is_nan() || reached < recorded,
        }
    }

    /// To two digits, away from the target: what to record.
    pub fn rounded(self, reached: Real) -> Real {
        if reached == 0.0 || !reached.is_finite() {
            return reached;
        }
        let power = libm::floor(libm::log10(reached.abs())) as i32;
        // Through text, so that 0.023 is written as 0.023.
        let digits = reached / libm::pow(10.0, Real::from(power - 1));
        let digits = match self {
            Self::AtMost(_) => (digits - 1e-9).ceil(),
            Self::AtLeast(_) => (digits + 1e-9).floor(),
        };
        format!("{digits}e{}", power - 1).parse().unwrap_or(reached)
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(target) => write!(f, "<= {target}"),
            Self::AtLeast(target) => write!(f, ">= {target}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_rounded_to_the_bad_side_and_nan_is_worse_than_anything() {
        let most = Goal::AtMost(0.01);
        assert_eq!(most.rounded(0.023_41), 0.024);
        assert_eq!(most.rounded(0.024), 0.024);
        assert_eq!(most.rounded(3.17e-11), 3.2e-11);
        assert_eq!(Goal::AtLeast(1.5).rounded(1.99), 1.9);
        assert_eq!(most.rounded(0.0), 0.0);
        assert!(!most.is_worse(0.024, 0.024) && most.is_worse(0.025, 0.024));
        assert!(Goal::AtLeast(1.5).is_worse(1.8, 1.9));
        for goal in [most, Goal::AtLeast(1.5)] {
            assert!(goal.is_worse(Real::NAN, 1.0) && !goal.is_met(Real::NAN));
        }
    }
}
