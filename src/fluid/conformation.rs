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
//! derivative is meant. Based on: [IMM-CT], [Giesekus82], [Anderson78]. Does not: limit the stretch (no FENE).

use crate::math::{Mat3, Real, Sym3};

/// λ' = 1/(1/λ + γ) [s]: the relaxation time of small deformations (Eq. 12 is Giesekus' model with mobility γ λ')
/// [Giesekus82].
pub fn linear_relaxation_time(relaxation_time: Real, thinning: Real) -> Real {
    1.0 / (1.0 / relaxation_time + thinning)
}

/// U after `dt` [s] in the flow with gradient `gradient`: exact for a frozen gradient (to 1e-11), positive definite
/// for any dt.
///
/// (Eq. 12) is a matrix Riccati equation, U' = A U + U Aᵀ + s I − γ U² with A = L + (γ − s)/2 and s = 1/λ. What a
/// time t does to any U is P + E (U⁻¹ + Q)⁻¹ Eᵀ with P, Q ≥ 0 that do not depend on U: a short time from the series
/// of the exponential of [A, s; γ, −Aᵀ], then doubled, where nothing is ever subtracted [Anderson78].
pub fn advance(u: &Sym3, gradient: &Mat3, relaxation_time: Real, thinning: Real, dt: Real) -> Sym3 {
    let s = 1.0 / relaxation_time;
    // Incompressible: the trace of L is discretisation error, and would change det U.
    let a = gradient + Mat3::identity() * (0.5 * (thinning - s) - gradient.trace() / 3.0);
    let size = (a.norm() + s.max(thinning)) * dt;
    let doublings = libm::log2(size / SHORT).ceil().clamp(0.0, 60.0) as i32;
    let mut map = Flow::short(&a, s, thinning, libm::ldexp(dt, -doublings));
    for _ in 0..doublings {
        map = map.doubled();
    }
    let kept = bounded(&u.to_matrix(), &map.q);
    Sym3::symmetric_part(&(map.p + map.e * kept * map.e.transpose()))
}

/// Length of the first step, in units of the largest rate, and order of its series: 0.25⁹/9! = 1e-11.
const SHORT: Real = 0.25;
const ORDER: i32 = 8;

/// U → P + E (U⁻¹ + Q)⁻¹ Eᵀ.
struct Flow {
    p: Mat3,
    q: Mat3,
    e: Mat3,
}

impl Flow {
    fn short(a: &Mat3, s: Real, thinning: Real, dt: Real) -> Self {
        // The right column of the exponential: what becomes of [0; I] and, in `below`, the lower left block.
        let (mut upper, mut lower) = (Mat3::zeros(), Mat3::identity());
        let (mut sum_upper, mut sum_lower) = (upper, lower);
        let (mut left_upper, mut left_lower) = (Mat3::identity(), Mat3::zeros());
        let mut below = Mat3::zeros();
        let transposed = a.transpose();
        for k in 1..=ORDER {
            let h = dt / Real::from(k);
            (upper, lower) = (
                (a * upper + lower * s) * h,
                (upper * thinning - transposed * lower) * h,
            );
            sum_upper += upper;
            sum_lower += lower;
            if thinning > 0.0 {
                (left_upper, left_lower) = (
                    (a * left_upper + left_lower * s) * h,
                    (left_upper * thinning - transposed * left_lower) * h,
                );
                below += left_lower;
            }
        }
        let inverse = inverse(&sum_lower);
        Self {
            p: sum_upper * inverse,
            q: inverse * below,
            e: inverse.transpose(),
        }
    }

    fn doubled(&self) -> Self {
        let (p, q, e) = (&self.p, &self.q, &self.e);
        // (I + Q P)⁻¹; its transpose is (I + P Q)⁻¹.
        let middle = inverse(&(Mat3::identity() + q * p));
        Self {
            p: symmetric(&(p + e * (p * middle) * e.transpose())),
            q: symmetric(&(q + e.transpose() * (middle * q) * e)),
            e: e * middle.transpose() * e,
        }
    }
}

/// (U⁻¹ + Q)⁻¹ = U (I + Q U)⁻¹ ≤ U.
fn bounded(u: &Mat3, q: &Mat3) -> Mat3 {
    u * inverse(&(Mat3::identity() + q * u))
}

fn symmetric(m: &Mat3) -> Mat3 {
    (m + m.transpose()) * 0.5
}

/// Inverse by the adjugate; not finite if there is none.
fn inverse(m: &Mat3) -> Mat3 {
    let (x, y, z) = (m.column(0), m.column(1), m.column(2));
    let adjugate = Mat3::from_rows(&[
        y.cross(&z).transpose(),
        z.cross(&x).transpose(),
        x.cross(&y).transpose(),
    ]);
    adjugate / x.dot(&y.cross(&z))
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
            let u = steady(lambda, gamma, rate, 0.1 / (1.0 / lambda + gamma));
            assert!((u.xy - xy).abs() < 1e-11 * xy, "{} {xy}", u.xy);
            assert!((u.xx - u.yy - n_1).abs() < 1e-11 * n_1);
            assert!((u.yy - u.zz - n_2).abs() < 1e-11);
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
        let angle = 7.0;
        u = advance(&u, &spin, 1e12, 0.0, angle / omega);
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        assert!((u.xx - (2.0 * c * c + s * s)).abs() < 1e-10);
        assert!((u.xy - s * c).abs() < 1e-10, "turned backwards: {}", u.xy);
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
            assert!(u.is_positive_definite(), "step {step}: {u:?}");
            assert!(
                u.to_matrix().symmetric_eigenvalues().min() > 0.0,
                "step {step}: {u:?}"
            );
        }
    }

    /// What a physicist would call exact: two steps are one, whatever the step.
    #[test]
    fn steps_of_a_frozen_gradient_add_up() {
        let mut random = Stream::new(3, "add up");
        for _ in 0..300 {
            let l = Mat3::from_fn(|_, _| random.between(-1.0, 1.0)) * 3.0;
            let (lambda, gamma) = (10.0_f64.powf(random.between(-4.0, 1.0)), random.unit());
            let f = Mat3::from_fn(|_, _| random.between(-1.0, 1.0));
            let u = Sym3::IDENTITY.congruence(&f) + Sym3::IDENTITY * 0.1;
            let dt = 10.0_f64.powf(random.between(-3.0, 0.3));
            let once = advance(&u, &l, lambda, gamma, dt);
            let half = advance(&u, &l, lambda, gamma, 0.37 * dt);
            let twice = advance(&half, &l, lambda, gamma, 0.63 * dt);
            let apart = (once - twice).to_matrix().norm() / once.to_matrix().norm();
            assert!(apart < 3e-11, "{apart} λ {lambda} γ {gamma} dt {dt}");
        }
    }

    /// dt ≫ λ is a Newtonian fluid: U − I = λ (L + Lᵀ), without noise from the stiffness.
    #[test]
    fn stiff_relaxation_leaves_the_newtonian_limit() {
        let l = Mat3::new(0.3, 1.0, 0.0, -0.2, -0.1, 0.5, 0.0, 0.0, -0.2);
        let lambda = 1e-7;
        let u = advance(&Sym3::IDENTITY, &l, lambda, 0.5, 1.0);
        let strain = (u - Sym3::IDENTITY).to_matrix() / lambda;
        assert!((strain - l - l.transpose()).norm() < 1e-6, "{strain}");
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
