//! How fast compression and gaps are undone: slower than a step, or the pressure that it takes would know of the step.

use super::stepper::Stepper;
use crate::math::{Real, ordered_sum, ordered_sums};
use crate::sph::PressureOperator;

/// Share of a spacing that the flow covers while compression is undone: about three steps at the CFL limit. What pressure
/// knows of the step hangs on it (`study pressure`: needle, 4.4 Pa·s, mean of six starts [Pa] at the CFL step and 0.3 of it,
/// particles moved by v alone): 2783 and 2807 with 0.8, 2754 and 2749 with 1.2. With 0.4 the vertebra takes 14 % more
/// iterations than with 0.8, and steps back. With 1.6 and 4 the gradient of a pipe eight across was 5 and 9 % low once; later
/// 1.6, 0.7, 1.4 % with 0.8, 1.2, 1.6 (1 Pa·s, one run each).
const CORRECTION: Real = 1.2;
/// The same of a split solve in an open body: a fifth of the CFL step, which undoes 99 % of it. Undone within a
/// smaller step, a stirred tank's start flew apart below a hundredth of the CFL step, and pressure mixed what the flow
/// did not: 0.45, 0.42, 0.28 were left of its segregation at 1, 1/4, 1/16 of the CFL step, now 0.45, 0.46, 0.42 (imm, 0.1 Pa·s,
/// 0.2 s, one run each).
const SPLIT_CORRECTION: Real = 0.08;
/// Share of the way to the fastest particle that the pace makes in the time in which compression is undone. With 1 a body
/// that is over-full by ten times what its flow undoes would still be flung apart, with 0.25 it swells a few times as fast
/// as it flows.
const PURSUIT: Real = 0.25;
/// Most that a vessel into which something is pushed gives back of what it is over-full by as a whole, of what is pushed in:
/// its flow stays that of what drives it, however deep it is. What disorder adds to the volume of a lattice that starts to
/// flow is 2 %: six spacings of a pipe 320 deep. Given back while the flow covers a spacing, it was flung apart.
const SWELLING: Real = 1.0;
/// In a closed body gaps and compression are disorder, which shifting evens better than pressure: share that pressure takes
/// among walls, which it has to press particles into line with, and where there are none, in [`CLOSED_TIME`]. With 0.1, 0.05,
/// 0.025, 0.01, 0 everywhere Taylor-Green is 1.92, 1.46, 1.24, 1.13, 1.06 % off at 32 spacings (order 1.4 to 2.0), and the
/// profile in a slit of 16 spacings 2.1, 2.7, 3.0, 3.3, 3.4 %. A little is left to it, so that nothing drifts for ever.
const CLOSED_SHARE: Real = 0.1;
const UNWALLED_SHARE: Real = 0.01;
/// Of the time over which compression is undone elsewhere: that in which a closed body evens out this share.
const CLOSED_TIME: Real = 0.5;

impl Stepper<'_> {
    /// Time over which compression is undone [s]: that in which the flow, at its [`Stepper::pace`], covers a share of a
    /// spacing. Undone in whatever a step is, the pressure that it takes would grow as 1/dt and swamp that of the flow.
    /// (Gaps in fluid without pressure may close as fast as they like.)
    pub(super) fn correction_time(&self) -> Real {
        self.time_over(CORRECTION)
    }

    /// Time in which the flow, at its [`Stepper::pace`], covers that many spacings [s].
    pub(super) fn time_over(&self, spacings: Real) -> Real {
        let pace = self.pace.unwrap_or_default();
        spacings * self.settings.spacing / pace.max(Real::MIN_POSITIVE)
    }

    /// The same of a solve apart from viscosity [s], see [`SPLIT_CORRECTION`].
    pub(super) fn split_correction_time(&self) -> Real {
        self.time_over(if self.closed {
            CORRECTION
        } else {
            SPLIT_CORRECTION
        })
    }

    /// Brings the pace up to date, once dt is known.
    ///
    /// It follows the fastest particle, but slowly: undoing compression is itself a flow, and where a deep body is
    /// over-full a faster one than that which set its pace. Followed at once, each step would undo the same share faster
    /// than the one before, without end.
    pub(super) fn keep_pace(&mut self) {
        let dx = self.settings.spacing;
        let fall = (self.settings.gravity.norm() * dx).sqrt();
        let fastest = self.fastest().max(fall);
        let driven = self.driven_speed();
        let next = match *self.pace {
            Some(pace) => {
                let covered = pace * self.dt / (CORRECTION * dx);
                let next = pace + (fastest - pace) * (PURSUIT * covered).min(1.0);
                next.max(fall).max(driven)
            }
            None => fastest,
        };
        *self.pace = Some(next);
    }

    /// Rate at which pressure has to push volume away, so that compression fades in `correction` [s] [m³/s].
    pub(super) fn correction_rate(
        &self,
        operator: &PressureOperator,
        correction: Real,
    ) -> Vec<Real> {
        let excess = operator.excess_volume();
        if self.closed {
            self.even_out(excess, correction)
        } else {
            self.give_back(excess, correction)
        }
    }

    /// The same of a closed body: it can only even out what it has, and does it slowly.
    fn even_out(&self, mut excess: Vec<Real>, correction: Real) -> Vec<Real> {
        let share = if self.near.wall.entries() > 0 {
            CLOSED_SHARE
        } else {
            UNWALLED_SHARE
        };
        let rate = share / self.dt.max(CLOSED_TIME * correction);
        let n = excess.len();
        let mean = ordered_sum(n, |i| excess[i]) / n.max(1) as Real;
        for e in &mut excess {
            *e = rate * (*e - mean);
        }
        excess
    }

    /// The same of an open one. Gaps in fluid under pressure are treated like compression: closed at once, those that noise
    /// opens would suck in as much as an inlet gives. Other gaps may close by the end of the step.
    ///
    /// What is undone fades as e^{−t/T}, whatever the step is. (With a share of dt/T in each, two steps of T/2 leave a quarter
    /// where small ones leave 0.37, and the pressure of an array of struts is 1.2 % higher at the CFL step than at 0.3 of it,
    /// for 0.8 %.)
    fn give_back(&self, mut excess: Vec<Real>, correction: Real) -> Vec<Real> {
        let time = self.dt / -libm::expm1(-self.dt / correction);
        let pressed: Vec<bool> = (excess.iter().zip(&self.fluid.pressure))
            .map(|(e, pressure)| *e > 0.0 || pressure[0] > 0.0)
            .collect();
        let [surplus, count] = ordered_sums(excess.len(), |i| {
            if pressed[i] {
                [excess[i], 1.0]
            } else {
                [0.0; 2]
            }
        });
        let inflow = self.inflow();
        // What each of them is over-full by because the whole is, and how fast that goes out.
        let (mean, swelling) = if surplus > 0.0 && inflow > 0.0 {
            let mean = surplus / count;
            (mean, mean / time.max(surplus / (SWELLING * inflow)))
        } else {
            (0.0, 0.0)
        };
        for (e, pressed) in excess.iter_mut().zip(pressed) {
            *e = if pressed {
                (*e - mean) / time + swelling
            } else {
                *e / self.dt
            };
        }
        excess
    }
}
