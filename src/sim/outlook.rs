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
//! The vertebra took as many iterations (64 574 for 63 297; 72 895 with what particles' ways, `compression` and the solver's C
//! are now) and no step back. Tried on the way, with the change of the
//! array with a memory: no limit 1.0 % (and 1.12 times the vertebra's iterations, with steps back), either limit alone 1.4 to
//! 2.4 %, the mean over neighbours 1.7 %, four fifths of it 1.1 %, the stabiliser alone 1.3 % (it rings), all but the lag
//! 2.1 %. U advanced with the mean gradient of the step rings. As the solver's guess it costs iterations (45 for 39).
//!
//! Particles have a way of second order by it as well: without, the last is 9503 and 9354 Pa at 1 and 0.1 (1.6 %, with what
//! `compression` and the solver's C are now), with it 9328 and 9352 (0.3 %); Newtonian 7232 and 7207, 7209 and 7207.
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
/// Spacings over which friction has to outdo inertia within a step for the velocity to be that of its places.
const BEND: Real = 2.0;

impl Stepper<'_> {
    /// What this step will likely change the carrying velocity by [m/s]: what the one before did, in as much of its time.
    pub(super) fn likely_change(&self) -> Vec<Vec3> {
        // What is left of a sliver of a step, by rounding and tolerance, must not be blown up.
        let ratio = (self.dt / self.last_step.max(1e-300)).min(MOST_GROWTH);
        let share = self.settings.theta * ratio;
        let velocity = self.carrying_velocity();
        let flow = velocity.iter().enumerate();
        flow.map(|(i, v)| self.without_noise(i, v, self.fluid.change[i] * share))
            .collect()
    }

    /// What bends the way of a particle within the step, on top of its velocity [m/s]: half of what the next step will
    /// likely change.
    ///
    /// Where friction sets the velocity, that of the end of a step is the one that belongs to the places of its start, and
    /// a way along it is of first order. Where inertia does, it belongs to the places of the end, and nothing is added.
    pub(super) fn bend(&self, i: usize) -> Vec3 {
        if self.settings.theta < 1.0 {
            return Vec3::zeros();
        }
        let alpha = self.fluid.polymer_fraction[i];
        let scale = BEND * self.settings.spacing;
        let friction = self.settings.cement.mixture_viscosity(alpha) * self.dt;
        let inertia = self.mix.density[i] * scale * scale;
        let share = 0.5 * friction / (friction + inertia);
        self.without_noise(i, &self.mix.velocity[i], self.fluid.change[i]) * share
    }

    /// A change of the velocity v of particle i [m/s], no more than flow can be told from noise by.
    fn without_noise(&self, i: usize, v: &Vec3, change: Vec3) -> Vec3 {
        let spread = self.settings.spacing * self.gradient[i].norm();
        let most = (MOST_CHANGE * v.norm()).min(MOST_NOISE * spread);
        let size = change.norm();
        if size > most {
            change * (most / size)
        } else {
            change
        }
    }

    /// Keeps what the step changed the mixture's velocity to [m/s] for the next one's outlook.
    pub(super) fn keep_change(&mut self, velocity: &[Vec3]) {
        let ends = velocity.iter().zip(&self.mix.velocity);
        for (change, (after, before)) in self.fluid.change.iter_mut().zip(ends) {
            *change = after - before;
        }
    }
}
