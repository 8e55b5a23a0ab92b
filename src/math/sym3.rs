//! Symmetric 3×3 tensors, six numbers each.

use super::{Mat3, Real, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul, Sub};

/// A symmetric tensor by its upper triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sym3 {
    /// xx component.
    pub xx: Real,
    /// yy component.
    pub yy: Real,
    /// zz component.
    pub zz: Real,
    /// xy = yx component.
    pub xy: Real,
    /// xz = zx component.
    pub xz: Real,
    /// yz = zy component.
    pub yz: Real,
}

impl Sym3 {
    /// I.
    pub const IDENTITY: Self = Self {
        xx: 1.0,
        yy: 1.0,
        zz: 1.0,
        xy: 0.0,
        xz: 0.0,
        yz: 0.0,
    };
    /// 0.
    pub const ZERO: Self = Self {
        xx: 0.0,
        yy: 0.0,
        zz: 0.0,
        xy: 0.0,
        xz: 0.0,
        yz: 0.0,
    };

    /// (A + Aᵀ)/2.
    pub fn symmetric_part(a: &Mat3) -> Self {
        Self {
            xx: a[(0, 0)],
            yy: a[(1, 1)],
            zz: a[(2, 2)],
            xy: 0.5 * (a[(0, 1)] + a[(1, 0)]),
            xz: 0.5 * (a[(0, 2)] + a[(2, 0)]),
            yz: 0.5 * (a[(1, 2)] + a[(2, 1)]),
        }
    }

    /// The tensor as a full matrix.
    pub fn to_matrix(self) -> Mat3 {
        Mat3::new(
            self.xx, self.xy, self.xz, self.xy, self.yy, self.yz, self.xz, self.yz, self.zz,
        )
    }

    /// F S Fᵀ.
    #[must_use]
    pub fn congruence(self, f: &Mat3) -> Self {
        Self::symmetric_part(&(f * self.to_matrix() * f.transpose()))
    }

    /// Product with a vector.
    #[inline(always)]
    pub fn times(&self, v: &Vec3) -> Vec3 {
        Vec3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// Sum of the diagonal.
    pub fn trace(&self) -> Real {
        self.xx + self.yy + self.zz
    }

    /// Determinant.
    pub fn determinant(&self) -> Real {
        self.xx * (self.yy * self.zz - self.yz * self.yz)
            - self.xy * (self.xy * self.zz - self.yz * self.xz)
            + self.xz * (self.xy * self.yz - self.yy * self.xz)
    }

    /// The inverse; not finite if the determinant is 0.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let d = 1.0 / self.determinant();
        Self {
            xx: (self.yy * self.zz - self.yz * self.yz) * d,
            yy: (self.xx * self.zz - self.xz * self.xz) * d,
            zz: (self.xx * self.yy - self.xy * self.xy) * d,
            xy: (self.xz * self.yz - self.xy * self.zz) * d,
            xz: (self.xy * self.yz - self.xz * self.yy) * d,
            yz: (self.xy * self.xz - self.xx * self.yz) * d,
        }
    }

    /// The diagonal of L D Lᵀ. Their product is the determinant, and stays right where the least eigenvalue is 1e-15 of the
    /// largest; the sum of products loses it from 1e-8 on.
    pub fn pivots(&self) -> [Real; 3] {
        let (below, far) = (self.xy / self.xx, self.xz / self.xx);
        let second = self.yy - below * self.xy;
        let cross = self.yz - below * self.xz;
        [
            self.xx,
            second,
            self.zz - far * self.xz - cross * (cross / second),
        ]
    }

    /// Whether every pivot is positive, which is cheaper than eigenvalues.
    pub fn is_positive_definite(&self) -> bool {
        self.pivots().iter().all(|pivot| *pivot > 0.0)
    }

    /// Eigenvalues in ascending order, by the trigonometric formula.
    pub fn eigenvalues(&self) -> [Real; 3] {
        let mean = self.trace() / 3.0;
        let off = self.xy * self.xy + self.xz * self.xz + self.yz * self.yz;
        let (a, b, c) = (self.xx - mean, self.yy - mean, self.zz - mean);
        let spread = libm::sqrt((a * a + b * b + c * c + 2.0 * off) / 6.0);
        if spread <= Real::EPSILON * mean.abs() {
            return [mean; 3];
        }
        let half_determinant =
            (*self - Self::IDENTITY * mean).determinant() / (2.0 * spread.powi(3));
        let angle = libm::acos(half_determinant.clamp(-1.0, 1.0)) / 3.0;
        let largest = mean + 2.0 * spread * libm::cos(angle);
        let third_turn = 2.0 * core::f64::consts::FRAC_PI_3;
        let smallest = mean + 2.0 * spread * libm::cos(angle + third_turn);
        [smallest, 3.0 * mean - largest - smallest, largest]
    }
}

impl Add for Sym3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
}

impl Sub for Sym3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self + o * -1.0
    }
}

impl Mul<Real> for Sym3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: Real) -> Self {
        Self {
            xx: self.xx * s,
            yy: self.yy * s,
            zz: self.zz * s,
            xy: self.xy * s,
            xz: self.xz * s,
            yz: self.yz * s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_and_inverse_agree_with_nalgebra() {
        let mut random = crate::math::Stream::new(1, "sym3");
        for _ in 0..1000 {
            let f = Mat3::from_fn(|_, _| random.between(-2.0, 2.0));
            let s = Sym3::IDENTITY.congruence(&f) + Sym3::IDENTITY * 0.1;
            let mut exact: Vec<Real> = s
                .to_matrix()
                .symmetric_eigenvalues()
                .iter()
                .copied()
                .collect();
            exact.sort_by(Real::total_cmp);
            for (got, want) in s.eigenvalues().iter().zip(&exact) {
                assert!((got - want).abs() < 1e-9 * exact[2], "{got} {want}");
            }
            assert!((s.inverse().to_matrix() * s.to_matrix() - Mat3::identity()).norm() < 1e-9);
            assert!(s.is_positive_definite());
        }
        assert!(!(Sym3::IDENTITY * -1.0).is_positive_definite());
    }
}
