//! Single and double precision, for code that is written once for both and takes four lanes at a time.

use super::Real;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// `f32` or `f64`.
pub trait Scalar:
    Copy
    + Default
    + Send
    + Sync
    + From<f32>
    + Into<Real>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// Four of them: lanes do not touch each other, and nothing is fused.
    type Four: Copy
        + Default
        + From<[Self; 4]>
        + Into<[Self; 4]>
        + Add<Output = Self::Four>
        + Sub<Output = Self::Four>
        + Mul<Output = Self::Four>;

    /// The nearest that it can hold.
    fn of(value: Real) -> Self;

    /// Four at once.
    #[inline(always)]
    fn four(lanes: [Self; 4]) -> Self::Four {
        lanes.into()
    }

    /// The same in all lanes.
    #[inline(always)]
    fn splat(self) -> Self::Four {
        [self; 4].into()
    }

    /// The lanes.
    #[inline(always)]
    fn lanes(four: Self::Four) -> [Self; 4] {
        four.into()
    }
}

impl Scalar for f32 {
    type Four = wide::f32x4;

    #[inline(always)]
    fn of(value: Real) -> Self {
        value as Self
    }
}

impl Scalar for Real {
    type Four = wide::f64x4;

    #[inline(always)]
    fn of(value: Real) -> Self {
        value
    }
}
