//! Conformation tensor: how far, and which way, the polymer around a particle is stretched.
//!
//! ```text
//! DU/Dt = L U + U Lᵀ − (U − I)/λ − γ (U − I) U                      [IMM-CT] (Eqs 11, 12)
//! ```
//!
//! | symbol | name here | unit |
//! |--------|-----------|------|
//! | U | `u` | 1 |
//! | L_ab = ∂v_a/∂x_b | `gradient` | 1/s |
//! | λ, γ | `relaxation_time`, `thinning` | s, 1/s |
//!
//! The paper prints U ∇v + (∇v)ᵀ U with the Jacobian of its (Eq. 2), which turns U backwards; the upper-convected
//! derivative is meant. Based on: [IMM-CT], [Giesekus82]. Does not: limit the stretch (no FENE).

use crate::math::{Mat3, Real, Sym3};

/// U after `dt` [s] in the flow with gradient `gradient`: half a step of thinning, the linear flow, half a step.
///
/// Positive definite for any dt; exact in steady shear for γ = 0; the Newtonian limit is right for dt ≫ λ.
pub fn advance(u: &Sym3, gradient: &Mat3, relaxation_time: Real, thinning: Real, dt: Real) -> Sym3 {
    let half = thin(u, thinning, 0.5 * dt);
    thin(
        &flow(&half, gradient, relaxation_time, dt),
        thinning,
        0.5 * dt,
    )
}

/// Exact flow of dU/dt = −γ (U − I) U: U [ (1 − e) U + e I ]⁻¹ with e = exp(−γ dt).
pub fn thin(u: &Sym3, thinning: Real, dt: Real) -> Sym3 {
    if thinning == 0.0 {
        return *u;
    }
    let e = libm::exp(-thinning * dt);
    let inverse = (*u * (1.0 - e) + Sym3::IDENTITY * e).inverse();
    // Both factors commute, so the product is symmetric but for rounding.
    Sym3::symmetric_part(&(u.to_matrix() * inverse.to_matrix()))
}

/// Flow of dU/dt = L U + U Lᵀ − s (U − I), s = 1/λ, for frozen L:
/// U' = e^{−s dt} F U Fᵀ + s ∫ e^{−s r} (I + r L)(I + r L)ᵀ dr, a sum of positive terms.
pub fn flow(u: &Sym3, gradient: &Mat3, relaxation_time: Real, dt: Real) -> Sym3 {
    let s = 1.0 / relaxation_time;
    // Incompressible: the trace of L is discretisation error, and would change det U.
    let l = gradient - Mat3::identity() * (gradient.trace() / 3.0);
    let x = s * dt;
    let e = libm::exp(-x);
    let (c_0, c_1, c_2) = if x < 1e-2 {
        (
            -libm::expm1(-x),
            dt * (x / 2.0 - x * x / 3.0 + x * x * x / 8.0),
            dt * dt * (x / 3.0 - x * x / 4.0 + x * x * x / 10.0),
        )
    } else {
        (
            1.0 - e,
            (1.0 - e * (1.0 + x)) / s,
            2.0 * (1.0 - e * (1.0 + x + 0.5 * x * x)) / (s * s),
        )
    };
    let f = Mat3::identity() + l * dt + l * l * (0.5 * dt * dt);
    u.congruence(&f) * e
        + Sym3::IDENTITY * c_0
        + Sym3::symmetric_part(&l) * (2.0 * c_1)
        + Sym3::IDENTITY.congruence(&l) * c_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    fn shear(rate: Real) -> Mat3 {
        Mat3::new(0.0, rate, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    }

    fn steady(lambda: Real, gamma: Real, rate: Real, dt: Real) -> Sym3 {
        let mut u = Sym3::IDENTITY;
        for _ in 0..(40.0 * lambda / dt) as usize + 200 {
            u = advance(&u, &shear(rate), lambda, gamma, dt);
        }
        u
    }

    /// Oldroyd-B in steady shear: U_xy = λγ̇, U_xx = 1 + 2(λγ̇)², exact at any step; N₁ > 0 catches a transposed L.
    #[test]
    fn steady_shear_without_thinning_is_exact_at_any_step() {
        for dt_over_lambda in [0.01, 0.5, 5.0, 20.0] {
            let u = steady(0.3, 0.0, 2.0, 0.3 * dt_over_lambda);
            assert!((u.xy - 0.6).abs() < 1e-9, "{u:?}");
            assert!((u.xx - 1.72).abs() < 1e-9, "{u:?}");
            assert!((u.yy - 1.0).abs() < 1e-9);
        }
    }

    /// Giesekus' closed form, three published points (λ, γ, γ̇ → U_xy, N₁/G, N₂/G).
    #[test]
    fn steady_shear_with_thinning_matches_giesekus() {
        for (lambda, gamma, rate, xy, n_1, n_2) in [
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
            // Strang's error is second order in the step: extrapolate two steps to none.
            let (coarse, fine) = (
                steady(lambda, gamma, rate, lambda / 500.0),
                steady(lambda, gamma, rate, lambda / 1000.0),
            );
            let u = fine + (fine - coarse) * (1.0 / 3.0);
            assert!((u.xy - xy).abs() < 2e-7 * xy, "{} {xy}", u.xy);
            assert!(
                (u.xx - u.yy - n_1).abs() < 2e-6 * n_1,
                "{} {n_1}",
                u.xx - u.yy
            );
            assert!((u.yy - u.zz - n_2).abs() < 2e-6, "{} {n_2}", u.yy - u.zz);
        }
    }

    /// Start-up: U_xy = λγ̇(1 − e^{−t/λ}), N₁ = 2(λγ̇)²[1 − e^{−t/λ}(1 + t/λ)].
    #[test]
    fn startup_of_shear_follows_the_closed_form() {
        let (lambda, rate, dt) = (0.2, 3.0, 0.001);
        let mut u = Sym3::IDENTITY;
        for step in 1..=400 {
            u = advance(&u, &shear(rate), lambda, 0.0, dt);
            let t = Real::from(step) * dt / lambda;
            let wi = lambda * rate;
            assert!((u.xy - wi * (1.0 - libm::exp(-t))).abs() < 1e-10);
            assert!((u.xx - u.yy - 2.0 * wi * wi * (1.0 - libm::exp(-t) * (1.0 + t))).abs() < 1e-9);
        }
    }

    #[test]
    fn rigid_rotation_turns_the_tensor_forwards() {
        let omega = 1.0;
        let spin = Mat3::new(0.0, -omega, 0.0, omega, 0.0, 0.0, 0.0, 0.0, 0.0);
        let mut u = Sym3 {
            xx: 2.0,
            ..Sym3::IDENTITY
        };
        let (steps, angle) = (20_000, 0.5);
        for _ in 0..steps {
            u = flow(&u, &spin, 1e12, angle / Real::from(steps));
        }
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        assert!((u.xx - (2.0 * c * c + s * s)).abs() < 1e-6);
        assert!((u.xy - s * c).abs() < 1e-6, "turned backwards: {}", u.xy);
    }

    #[test]
    fn stays_positive_definite_in_ten_thousand_violent_steps() {
        let mut random = Stream::new(8, "violent");
        let mut u = Sym3::IDENTITY;
        for step in 0..10_000 {
            let size = 10.0_f64.powf(random.between(-1.0, 2.0));
            let l = Mat3::from_fn(|_, _| random.between(-1.0, 1.0)) * size;
            u = advance(
                &u,
                &l,
                10.0_f64.powf(random.between(-3.0, 0.0)),
                random.unit(),
                random.between(0.0, 1.0),
            );
            if u.trace() > 1e8 {
                u = Sym3::IDENTITY;
            }
            assert!(
                u.to_matrix().symmetric_eigenvalues().min() > 0.0,
                "step {step}: {u:?}"
            );
        }
    }

    #[test]
    fn order_is_two_with_the_midpoint_gradient() {
        let gradient = |t: Real| {
            shear(2.0 * libm::sin(3.0 * t))
                + Mat3::new(0.3, 0.0, 0.1, 0.2, -0.1, 0.0, 0.0, 0.0, -0.2)
        };
        let run = |steps: u32| {
            let dt = 1.0 / Real::from(steps);
            let mut u = Sym3::IDENTITY;
            for n in 0..steps {
                u = advance(&u, &gradient((Real::from(n) + 0.5) * dt), 0.3, 0.4, dt);
            }
            u
        };
        let exact = run(20_000);
        let error = |n| (run(n) - exact).to_matrix().norm();
        let order = libm::log2(error(50) / error(100));
        assert!((order - 2.0).abs() < 0.15, "{order}");
    }
}
