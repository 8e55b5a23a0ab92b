//! Derivatives of fields on particles: velocity gradient, force of a stress, viscous force, and their walls.

use super::neighbourhood::Neighbourhood;
use super::pairs::{Pair, WallPair, vector};
use crate::math::{Mat3, Real, Vec3};
use rayon::prelude::*;

/// Rows that one task works on at least.
const GRAIN: usize = 128;

/// L_ab = ∂v_a/∂x_b [1/s] (Eq. 2, as a Jacobian), in difference form with the moment correction; behind a wall
/// the velocity is carried on linearly, zero slip at the true surface.
///
/// Exact for a linear field, also beside a plane wall and on disordered particles. Needs
/// [`Neighbourhood::straighten`].
pub fn velocity_gradient(near: &Neighbourhood, velocity: &[Vec3]) -> Vec<Mat3> {
    gradient(near, velocity, |i, pair| near.surface_velocity(i, pair))
}

/// What a change of the velocity [m/s] adds to it, beside walls that go on as they do.
pub fn gradient_of_change(near: &Neighbourhood, change: &[Vec3]) -> Vec<Mat3> {
    gradient(near, change, |_, _| Vec3::zeros())
}

fn gradient(
    near: &Neighbourhood,
    velocity: &[Vec3],
    of_surface: impl Fn(usize, &WallPair) -> Vec3 + Send + Sync,
) -> Vec<Mat3> {
    per_particle(near, |i| {
        let v_i = velocity[i];
        let mut sum = Mat3::zeros();
        for pair in near.fluid.row(i) {
            sum += (velocity[pair.j as usize] - v_i) * vector(pair.gradient).transpose();
        }
        for pair in near.wall.row(i) {
            let slip = v_i - of_surface(i, pair);
            sum -= slip * (1.0 + Real::from(pair.beta)) * vector(pair.gradient).transpose();
        }
        sum * near.correction[i]
    })
}

fn per_particle<T: Send>(near: &Neighbourhood, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    let all = (0..near.len()).into_par_iter().with_min_len(GRAIN);
    all.map(of).collect()
}

/// Force V_i div τ [N] of a (not necessarily symmetric) stress [Pa]:
/// f_i = V_i Σ_j V_j (τ_i + τ_j) ∇W_ij, at walls τ_b = τ_i; gradients divided by the local trace, which is the
/// lattice constant of the kernel on a lattice (Eq. 14 in volume form, with the missing m_j).
///
/// Where not `summed(i)`, with τ_j − τ_i, of which a uniform stress is exactly without force: for particles that have
/// neighbours all round. It is not equal and opposite, so it does not keep momentum.
pub fn stress_force(
    near: &Neighbourhood,
    stress: &[Mat3],
    summed: impl Fn(usize) -> bool + Send + Sync,
) -> Vec<Vec3> {
    per_particle(near, |i| {
        let (summed, m_i) = (summed(i), near.trace[i]);
        let own = stress[i] * if summed { 1.0 } else { -1.0 };
        let mut force = Vec3::zeros();
        for pair in near.fluid.row(i) {
            let j = pair.j as usize;
            force += (own + stress[j]) * vector(pair.gradient) * (2.0 / (m_i + near.trace[j]));
        }
        if summed {
            for pair in near.wall.row(i) {
                force += own * vector(pair.gradient) * (2.0 / m_i);
            }
        }
        force * near.rest_volume
    })
}

/// c_ij of the compact Laplacian Σ_j c_ij (A_j − A_i) [1/m²]: Brookshaw's form, divided by the local trace.
#[inline(always)]
pub fn laplacian_weight(near: &Neighbourhood, i: usize, pair: &Pair) -> Real {
    4.0 * Real::from(pair.steepness) / (near.trace[i] + near.trace[pair.j as usize])
}

/// Weight of a wall particle in the compact Laplacian [1/m²].
#[inline(always)]
pub(super) fn wall_drag(near: &Neighbourhood, i: usize, pair: &WallPair) -> Real {
    near.wall_weight(i, pair) * (1.0 + Real::from(pair.beta))
}

/// What a wall does to the compact Laplacian of particle i: K_i [1/m²] and K_i u_w [1/(m s)].
pub fn wall_friction(near: &Neighbourhood, i: usize) -> (Real, Vec3) {
    let (mut friction, mut carried) = (0.0, Vec3::zeros());
    for pair in near.wall.row(i) {
        let k = wall_drag(near, i, pair);
        friction += k;
        carried += near.surface_velocity(i, pair) * k;
    }
    (friction, carried)
}

/// How a pair of different viscosities resists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mean {
    /// (η_i + η_j)/2: matches the stress, which is averaged so.
    Arithmetic,
    /// 2 η_i η_j/(η_i + η_j): exact for layers of two Newtonian fluids.
    Harmonic,
}

impl Mean {
    /// The mean of two viscosities [Pa·s].
    #[inline(always)]
    pub fn of(self, a: Real, b: Real) -> Real {
        match self {
            Self::Arithmetic => 0.5 * (a + b),
            Self::Harmonic if a + b > 0.0 => 2.0 * a * b / (a + b),
            Self::Harmonic => 0.0,
        }
    }
}

/// Force V_i div(η grad v) [N] by the compact Laplacian; the walls' part is −V_i η_i (K_i v_i − K_i u_w) and comes
/// with `with_walls`.
pub fn viscous_force(
    near: &Neighbourhood,
    viscosity: &[Real],
    mean: Mean,
    velocity: &[Vec3],
    with_walls: bool,
) -> Vec<Vec3> {
    per_particle(near, |i| {
        let mut force = Vec3::zeros();
        for pair in near.pairs(i) {
            let j = pair.j as usize;
            let eta = mean.of(viscosity[i], viscosity[j]);
            force += (velocity[j] - velocity[i]) * (eta * laplacian_weight(near, i, &pair));
        }
        if with_walls {
            let (friction, carried) = wall_friction(near, i);
            force -= (velocity[i] * friction - carried) * viscosity[i];
        }
        force * near.rest_volume
    })
}
