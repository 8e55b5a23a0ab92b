//! Giesekus' model in steady homogeneous flow.
//!
//! (Eq. 12) is Giesekus' model with relaxation time λ' = 1/(1/λ + γ) and mobility α' = γ λ'; closed forms of
//! [Giesekus82], written without cancellation.

use crate::math::Real;

/// Steady shear with the velocity along x, its gradient along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyShear {
    /// U_xy.
    pub xy: Real,
    /// N₁/G = U_xx − U_yy.
    pub first: Real,
    /// N₂/G = U_yy − U_zz.
    pub second: Real,
}

/// Conformation in steady shear at `rate` [1/s] for λ [s] and γ [1/s].
pub fn steady_shear(relaxation_time: Real, thinning: Real, rate: Real) -> SteadyShear {
    let memory = 1.0 / (1.0 / relaxation_time + thinning);
    let (wi, a) = (memory * rate, thinning * memory);
    if a < 1e-14 {
        return SteadyShear {
            xy: wi,
            first: 2.0 * wi * wi,
            second: 0.0,
        };
    }
    let q = 8.0 * a * (1.0 - a) * wi * wi;
    let root = (1.0 + 2.0 * q).sqrt();
    let chi = (2.0 / (root + 1.0)).sqrt();
    // 1 − χ = (√(1 + 2q) − 1)/((√(1 + 2q) + 1)(1 + χ)), and the numerator is 2q/(√(1 + 2q) + 1).
    let less = 2.0 * q / ((root + 1.0) * (root + 1.0) * (1.0 + chi));
    let f = less / (1.0 + (1.0 - 2.0 * a) * chi);
    let rest = 2.0 * (1.0 - a) * chi / (1.0 + (1.0 - 2.0 * a) * chi); // 1 − f
    SteadyShear {
        xy: wi * rest * rest / (1.0 + (1.0 - 2.0 * a) * f),
        first: 2.0 * f * (1.0 - a * f) / (a * rest),
        second: -f,
    }
}

/// Steady uniaxial extension at `rate` [1/s]: eigenvalues of U along and across. Each solves
/// γ u² + (s − γ − 2 e) u − s = 0 with s = 1/λ; without thinning it needs 2 λ e < 1.
pub fn extension(relaxation_time: Real, thinning: Real, rate: Real) -> [Real; 2] {
    let s = 1.0 / relaxation_time;
    [rate, -0.5 * rate].map(|e| {
        let b = s - thinning - 2.0 * e;
        let root = (b * b + 4.0 * thinning * s).sqrt();
        // The positive root, in the form that does not cancel.
        if b > 0.0 {
            2.0 * s / (b + root)
        } else {
            (root - b) / (2.0 * thinning)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation and of an ODE solver.
    #[test]
    fn steady_shear_has_the_published_values() {
        for (lambda, gamma, rate, xy, first, second) in [
            (
                0.5,
                0.5,
                4.0,
                0.949_696_796_589,
                2.219_872_675_71,
                -0.187_409_246_203,
            ),
            (
                0.1,
                1.0,
                50.0,
                1.790_596_546_041,
                9.155_940_489_08,
                -0.299_638_088_623,
            ),
            (
                0.9,
                0.2,
                2.0,
                0.989_452_733_801,
                2.311_477_001_73,
                -0.152_908_108_805,
            ),
        ] {
            let got = steady_shear(lambda, gamma, rate);
            assert!((got.xy - xy).abs() < 1e-11);
            assert!((got.first - first).abs() < 2e-11);
            assert!((got.second - second).abs() < 1e-11);
        }
        // η_p/(c η) of Fig. 6 at λ = 0.5 s.
        for (rate, gamma, ratio) in [
            (0.01, 0.1, 0.952_378),
            (1.0, 0.5, 0.743_713),
            (10.0, 1.0, 0.205_673),
            (1000.0, 0.25, 0.005_396),
            (100.0, 0.0, 1.0),
        ] {
            let got = steady_shear(0.5, gamma, rate).xy / (0.5 * rate);
            assert!((got - ratio).abs() < 6e-7, "{rate} {gamma}: {got} {ratio}");
        }
    }

    #[test]
    fn plateaus_are_right() {
        let far = steady_shear(0.5, 1.0, 1e9).xy;
        assert!((far - 1.0 / 0.5_f64.sqrt()).abs() < 1e-4);
        // η_E → 2 G/γ.
        let [along, across] = extension(0.5, 0.4, 1e6);
        assert!(((along - across) / 1e6 - 2.0 / 0.4).abs() < 1e-4);
        // Upper-convected Maxwell: u = s/(s − 2 e).
        let [along, across] = extension(0.5, 0.0, 0.3);
        assert!((along - 2.0 / 1.4).abs() < 1e-14 && (across - 2.0 / 2.3).abs() < 1e-14);
    }
}
