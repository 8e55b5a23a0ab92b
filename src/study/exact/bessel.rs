//! Zeros of the Bessel function J₀, which pipes ring with.

use crate::math::Real;
use std::f64::consts::PI;

pub(super) use libm::{j0, j1};

/// The first `count` zeros of J₀: McMahon's expansion, then Newton with J₀' = −J₁.
pub(super) fn j0_zeros(count: usize) -> Vec<Real> {
    (1..=count)
        .map(|k| {
            let b = (k as Real - 0.25) * PI;
            let mut z = b + 1.0 / (8.0 * b) - 31.0 / (384.0 * b * b * b);
            for _ in 0..3 {
                z += j0(z) / j1(z);
            }
            z
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_those_of_the_tables() {
        let zeros = j0_zeros(200);
        let known = [
            2.404_825_557_695_773,
            5.520_078_110_286_311,
            8.653_727_912_911_013,
        ];
        for (got, want) in zeros.iter().zip(known) {
            assert!((got - want).abs() < 1e-13);
        }
        assert!(zeros.iter().all(|&z| j0(z).abs() < 1e-13));
        assert!(zeros.windows(2).all(|w| (w[1] - w[0] - PI).abs() < 0.03));
    }
}
