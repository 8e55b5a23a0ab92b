//! Where the flow is going: what a coupled step will likely change.
//!
//! Viscosity that resists only what changes in a step (the lag), the stabiliser's gradient and the predicted U need a
//! velocity before the solve has found it. With v^n they are a step late, and pressure knows of the step; with v^n plus the
//! change of the step before they are of second order. Pressure at the piston of an array of struts [Pa], mean of three
//! starts at the CFL step and at 0.3 of it (now one of 4.4 Pa·s), of one at 0.1 (each good to 0.3 %; `study pressure`):
//!
//! | counted from | v^n | the likely v |
//! |---|---|---|
//! | 4.4 Pa·s | 7317, 7260, 7260: 0.8 % | 7271, 7264, 7262: 0.1 % |
//! | 8 Pa·s, memory 50 ms | 9640, 9440, 9394: 2.6 % | 9493, 9433, 9437: 0.6 % |
//!
//! The vertebra takes as many iterations (64 574 for 63 297) and no step back. Tried on the way, with the change of the
//! array with a memory: no limit 1.0 % (and 1.12 times the vertebra's iterations, with steps back), either limit alone 1.4 to
//! 2.4 %, the mean over neighbours 1.7 %, four fifths of it 1.1 %, the stabiliser alone 1.3 % (it rings), all but the lag
//! 2.1 %. U advanced with the mean gradient of the step rings. As the solver's guess it costs iterations (45 for 39).
//!
//! Over half the way (12 spacings, where a start is good to 0.5 %) the CFL step gives 7256 and 9446 Pa (three starts), a tenth
//! of it 7262 and 9334 (two), a hundredth 7312 and 9355 (one): 0.8 and 1.2 %.
//!
//! Its gradient is taken beside walls that go on as they do: that of a plate which moves off in steps of six CFL steps
//! would be that of the plate's new velocity and the fluid's old one, and the flow runs away.

use super::stepper::Stepper;
use crate::math::{Real, Vec3};

/// Most of |v| that a step is expected to change: the rest is noise.
const MOST_CHANGE: Real = 0.2;
/// Most of |L| dx that it is: what tells neighbours apart. (0.3: 1.0 % for the array.)
const MOST_NOISE: Real = 0.5;
/// Most of a longer step that the one before speaks for, in steps like that.
const MOST_GROWTH: Real = 1.5;

impl Stepper<'_> {
    /// What this step will likely change the carrying velocity by [m/s]: what the one before did, in as much of its time.
    pub(super) fn likely_change(&self) -> Vec<Vec3> {
        // What is left of a sliver of a step, by rounding and tolerance, must not be blown up.
        let ratio = (self.dt / self.last_step.max(1e-300)).min(MOST_GROWTH);
        let share = self.settings.theta * ratio;
        let velocity = self.carrying_velocity();
        let flow = velocity.iter().zip(&self.gradient);
        let limited = flow.zip(&self.fluid.change).map(|((v, l), change)| {
            let change = change * share;
            let most = (MOST_CHANGE * v.norm()).min(MOST_NOISE * self.settings.spacing * l.norm());
            let size = change.norm();
            if size > most {
                change * (most / size)
            } else {
                change
            }
        });
        limited.collect()
    }

    /// Keeps what the step changed the mixture's velocity to [m/s] for the next one's outlook.
    pub(super) fn keep_change(&mut self, velocity: &[Vec3]) {
        let ends = velocity.iter().zip(&self.mix.velocity);
        for (change, (after, before)) in self.fluid.change.iter_mut().zip(ends) {
            *change = after - before;
        }
    }
}
