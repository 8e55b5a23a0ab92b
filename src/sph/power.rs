//! What moving walls and pistons give to the fluid through friction and stress [W]: their force on it times their own
//! velocity.

use super::neighbourhood::Neighbourhood;
use super::operators::wall_drag;
use super::pairs::vector;
use crate::math::{Mat3, Real, Vec3, ordered_sum};

/// Through friction at walls; `viscosity` [Pa·s].
pub fn of_friction(near: &Neighbourhood, viscosity: &[Real], velocity: &[Vec3]) -> Real {
    if near.wall_velocity.iter().all(|u| *u == Vec3::zeros()) {
        return 0.0;
    }
    near.rest_volume
        * ordered_sum(near.len(), |i| {
            let row = near.wall.row(i).iter();
            let of_one = row.map(|pair| {
                let u = near.surface_velocity(i, pair);
                wall_drag(near, i, pair) * u.dot(&(u - velocity[i]))
            });
            viscosity[i] * of_one.sum::<Real>()
        })
}

/// Through the stress [Pa] at walls.
pub fn of_stress(near: &Neighbourhood, stress: &[Mat3]) -> Real {
    near.rest_volume
        * ordered_sum(near.len(), |i| {
            let row = near.wall.row(i).iter();
            let of_one = row.map(|pair| {
                let force = stress[i] * vector(pair.gradient) * (2.0 / near.trace[i]);
                force.dot(&near.surface_velocity(i, pair))
            });
            of_one.sum::<Real>()
        })
}
