//! The cubic spline kernel with compact support.
//!
//! ```text
//! W(r) = σ (6q³ − 6q² + 1)  for q ≤ 1/2,   2σ (1 − q)³  for q ≤ 1,   q = r/h,  σ = 8/(π h³)
//! ```
//!
//! h is the support radius: W vanishes at r = h.

use crate::math::{Real, Vec3};

/// W and its slope for one support radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Support radius h [m].
    pub support_radius: Real,
    sigma: Real,
}

impl Kernel {
    /// The kernel with support radius `h` [m].
    pub fn new(support_radius: Real) -> Self {
        Self {
            support_radius,
            sigma: 8.0 / (core::f64::consts::PI * support_radius.powi(3)),
        }
    }

    /// W(r) [1/m³].
    #[inline(always)]
    pub fn w(&self, r: Real) -> Real {
        // Both pieces are taken and one is chosen, so that several r fit into one register.
        let q = r / self.support_radius;
        let rest = 1.0 - q;
        let inner = self.sigma * (6.0 * q * q * (q - 1.0) + 1.0);
        let outer = 2.0 * self.sigma * rest * rest * rest;
        choose(q, inner, outer)
    }

    /// −W'(r)/r ≥ 0 [1/m⁵], finite at r = 0; ∇W_ij = −(this) x_ij.
    #[inline(always)]
    pub fn steepness(&self, r: Real) -> Real {
        let h = self.support_radius;
        let q = r / h;
        let inner = self.sigma * (12.0 - 18.0 * q) / (h * h);
        let outer = 6.0 * self.sigma * (1.0 - q) * (1.0 - q) / (h * h * q);
        choose(q, inner, outer)
    }

    /// ∇_i W(x_ij) [1/m⁴].
    pub fn gradient(&self, x_ij: &Vec3) -> Vec3 {
        x_ij * -self.steepness(x_ij.norm())
    }

    /// V₀ = 1/Σ W over the cubic lattice [m³], so that ψ = 1 on it exactly (method: trap of the dense start).
    pub fn rest_volume(&self, spacing: Real) -> Real {
        let reach = (self.support_radius / spacing).ceil() as i32;
        let mut sum = 0.0;
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -reach..=reach {
                    sum += self.w(Real::from(x * x + y * y + z * z).sqrt() * spacing);
                }
            }
        }
        1.0 / sum
    }
}

/// The piece that holds at q.
#[inline(always)]
fn choose(q: Real, inner: Real, outer: Real) -> Real {
    let outer = if q < 1.0 { outer } else { 0.0 };
    if q <= 0.5 { inner } else { outer }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_to_one_and_slope_matches_differences() {
        let kernel = Kernel::new(2.4);
        let n = 2000;
        let step = 2.4 / Real::from(n);
        let shell = |i: i32| {
            let r = (Real::from(i) + 0.5) * step;
            4.0 * core::f64::consts::PI * r * r * kernel.w(r) * step
        };
        let integral: Real = (0..n).map(shell).sum();
        assert!((integral - 1.0).abs() < 1e-6, "{integral}");
        for r in [0.1, 0.7, 1.19, 1.21, 2.0, 2.39] {
            let slope = (kernel.w(r + 1e-6) - kernel.w(r - 1e-6)) / 2e-6;
            assert!((kernel.steepness(r) * r + slope).abs() < 1e-7);
        }
        assert_eq!(kernel.w(2.4), 0.0);
    }

    /// Figures of the kernel table: ψ of a cubic lattice with V = spacing³.
    #[test]
    fn lattice_sums_match_the_published_table() {
        for (ratio, psi) in [(2.0, 1.0000), (2.4, 1.0008), (3.0, 1.0018)] {
            assert!(
                (1.0 / Kernel::new(ratio).rest_volume(1.0) - psi).abs() < 6e-5,
                "{ratio}"
            );
        }
    }
}
