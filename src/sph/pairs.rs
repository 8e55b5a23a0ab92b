//! What operators need of a pair.
//!
//! It is kept in f32 relative to the pair, exactly antisymmetric, so that momentum is kept. Operators sum in f64, but for
//! corrections of the coupled solve (`saddle`) and iterations of the split one (`repeated`).

use crate::math::{Real, Vec3};

/// What most operators need of two fluid particles i, j: one load of four lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Link {
    /// V_j ∇_i W_ij [1/m].
    pub gradient: [f32; 3],
    /// The neighbour.
    pub j: u32,
}

/// What some operators need besides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bell {
    pub(super) steepness: f32,
    pub(super) weight: f32,
}

/// Two fluid particles i, j.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The neighbour.
    pub j: u32,
    /// V_j ∇_i W_ij [1/m].
    pub gradient: [f32; 3],
    /// −V_j W'(r)/r ≥ 0 [1/m²]: gradient = −steepness · x_ij.
    pub steepness: f32,
    /// V_j W_ij [1].
    pub weight: f32,
}

/// A fluid particle i and a wall particle b.
#[derive(Clone, Copy, Debug)]
pub struct WallPair {
    /// The wall particle, by its place among the active ones.
    pub b: u32,
    /// V_b ∇_i W_ib [1/m].
    pub gradient: [f32; 3],
    /// −V_b W'(r)/r [1/m²].
    pub steepness: f32,
    /// S_bi: share of i in the Shepard mean at b [1].
    pub share: f32,
    /// β: how far the velocity is carried on behind the true surface; v_b = u_w − β (v_i − u_w) [Morris97].
    pub beta: f32,
}

/// The same pair seen from the wall.
#[derive(Clone, Copy, Debug)]
pub struct FluidOfWall {
    /// The fluid particle.
    pub i: u32,
    /// V_i ∇_b W_bi [1/m].
    pub gradient: [f32; 3],
    /// S_bi [1].
    pub share: f32,
}

/// V (−W'/r) r²: the trace of what a pair adds to the moment matrix.
#[inline]
pub(super) fn squared_over(gradient: [f32; 3], steepness: f32) -> Real {
    if steepness > 0.0 {
        vector(gradient).norm_squared() / Real::from(steepness)
    } else {
        0.0
    }
}

/// −V W'/r x: a gradient as it is stored.
#[inline]
pub(super) fn scaled(x: &Vec3, factor: f32) -> [f32; 3] {
    [
        x.x as f32 * factor,
        x.y as f32 * factor,
        x.z as f32 * factor,
    ]
}

/// A stored gradient in full precision.
#[inline(always)]
pub fn vector(g: [f32; 3]) -> Vec3 {
    Vec3::new(g[0].into(), g[1].into(), g[2].into())
}
