//! Creeping flow through a simple cubic array of spheres [Zick82].

use crate::math::Real;

/// Volume fraction of the spheres and drag factor K; F = 6π μ a K U with U the superficial velocity.
pub const SIMPLE_CUBIC: [(Real, Real); 3] = [(0.027, 2.008), (0.125, 4.292), (0.343, 15.4)];

/// Radius of the spheres by the edge of the cell, a/L.
pub fn radius(fraction: Real) -> Real {
    libm::cbrt(3.0 * fraction / (4.0 * std::f64::consts::PI))
}

/// Permeability by the square of the cell's edge, k/L² = 1/(6π (a/L) K).
pub fn permeability(fraction: Real, drag_factor: Real) -> Real {
    1.0 / (6.0 * std::f64::consts::PI * radius(fraction) * drag_factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permeabilities_are_the_published_ones() {
        for ((fraction, factor), k) in SIMPLE_CUBIC
            .into_iter()
            .zip([1.4196e-1, 3.9850e-2, 7.9331e-3])
        {
            assert!((permeability(fraction, factor) / k - 1.0).abs() < 1e-4);
        }
        // The dilute series, good to a fraction of 0.2.
        let series = |p: Real| {
            1.0 / (1.0 - 1.7601 * libm::cbrt(p) + p - 1.5593 * p * p
                + 3.9799 * libm::pow(p, 8.0 / 3.0)
                - 3.0734 * libm::pow(p, 10.0 / 3.0))
        };
        assert!((series(0.027) / 2.008 - 1.0).abs() < 1e-3);
        assert!((series(0.125) / 4.292 - 1.0).abs() < 1e-3);
    }
}
