//! Contact: fluid that lies against a wall is carried by it within the solve.
//!
//! Pressure keeps fluid off a wall by what fills the neighbourhood; one layer of particles fills so little of it that
//! fluid comes to lie in the layer itself, where the layer's force has no direction. A particle that would end the step
//! deeper than it may is therefore held: n·v is what the wall allows. Walls push and do not pull, which a second active
//! set decides.

use super::minres::Packed;
use crate::math::{Real, Scalar, Vec3};

/// A particle near a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Which.
    pub particle: u32,
    /// Out of the wall, unit length.
    pub normal: Vec3,
    /// Slowest velocity along the normal with which it ends no deeper than it may [m/s].
    pub least: Real,
}

impl Contact {
    fn along<T: Scalar>(&self, rows: &[Packed<T>]) -> Real {
        let [x, y, z, _] = rows[self.particle as usize].map(Into::into);
        self.normal.x * x + self.normal.y * y + self.normal.z * z
    }

    fn add<T: Scalar>(&self, rows: &mut [Packed<T>], along: Real) {
        let row = &mut rows[self.particle as usize];
        for axis in 0..3 {
            row[axis] = T::of(row[axis].into() + self.normal[axis] * along);
        }
    }
}

/// Those that may touch.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    near: Vec<Contact>,
    /// Which of them are held.
    held: Vec<bool>,
    /// Velocity by which a hold may be missed before it is one [m/s].
    slack: Real,
}

impl Contacts {
    /// Begins with those whose guessed velocity needs it.
    pub(super) fn new(near: Vec<Contact>, slack: Real, guess: &[Packed]) -> Self {
        let held = near
            .iter()
            .map(|contact| contact.along(guess) < contact.least + slack)
            .collect();
        Self { near, held, slack }
    }

    fn held(&self) -> impl Iterator<Item = &Contact> {
        let all = self.near.iter().zip(&self.held);
        all.filter_map(|(contact, &held)| held.then_some(contact))
    }

    /// Takes what lies along the normals out.
    pub(super) fn take_out<T: Scalar>(&self, rows: &mut [Packed<T>]) {
        for contact in self.held() {
            let along = contact.along(rows);
            contact.add(rows, -along);
        }
    }

    /// Adds the velocities that walls impose.
    pub(super) fn impose(&self, rows: &mut [Packed]) {
        for contact in self.held() {
            contact.add(rows, contact.least);
        }
    }

    /// Lets go whom the wall would have to pull, and holds who is still too fast; whether anything changed. `surplus`:
    /// H v + P k less the forces [N], what the walls push with.
    pub(super) fn decide(&mut self, velocity: &[Packed], surplus: &[Packed]) -> bool {
        let mut changed = false;
        for (contact, held) in self.near.iter().zip(&mut self.held) {
            let goal = if *held {
                contact.along(surplus) >= 0.0
            } else {
                contact.along(velocity) < contact.least - self.slack
            };
            changed |= goal != *held;
            *held = goal;
        }
        changed
    }
}
