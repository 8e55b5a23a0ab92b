//! Numbers and small algebra that every room shares; knows no physics.

mod bounds;
mod noise;
mod ordered;
mod scalar;
mod sym3;
mod wide;

pub use bounds::{Aabb, lattice};
pub use noise::{Stream, hash_unit};
pub use ordered::{BLOCK, FEW, ordered_dot, ordered_max, ordered_sum, ordered_sums};
pub use scalar::Scalar;
pub use sym3::Sym3;
pub use wide::{Wide, WideRows, widest, widest_rows};

/// The one floating-point type of state and algebra.
pub type Real = f64;
/// A point, velocity or force.
pub type Vec3 = nalgebra::Vector3<Real>;
/// A 3×3 matrix, for example a velocity gradient.
pub type Mat3 = nalgebra::Matrix3<Real>;
