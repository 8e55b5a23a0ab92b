//! Flows that start: Newtonian and Oldroyd-B between plates, in a pipe, and as a decaying wave.
//!
//! Velocities are sums over modes of wave number q, each with the time factor
//! g = e^{−A T/2} [cosh(B T/2) + (C/B) sinh(B T/2)], T = t/λ, A = 1 + λ η_s q²/ρ, B = √(A² − 4 λ μ₀ q²/ρ)
//! [Waters70]; Newtonian: g = exp(−μ₀ q² t/ρ).

use super::bessel::{j0, j0_zeros, j1};
use crate::math::Real;
use std::f64::consts::PI;

/// A Newtonian or Oldroyd-B fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// ρ [kg/m³].
    pub density: Real,
    /// η_s [Pa·s].
    pub solvent: Real,
    /// η_p = G λ [Pa·s].
    pub polymer: Real,
    /// λ [s]; 0: Newtonian.
    pub relaxation_time: Real,
}

/// What sets a mode going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// A force per volume from t = 0 on; g says what is missing to the steady flow.
    Force,
    /// A wall, or the fluid itself, has its velocity at t = 0, without polymer stress.
    Velocity,
}

impl Fluid {
    /// μ₀ = η_s + η_p [Pa·s].
    pub fn viscosity(&self) -> Real {
        self.solvent + self.polymer
    }
}

/// g(t) of the mode with q² = `q_squared` [1/m²]: 1 at the start, 0 in the end.
pub fn mode(fluid: &Fluid, start: Start, q_squared: Real, t: Real) -> Real {
    let (rho, lambda, mu) = (fluid.density, fluid.relaxation_time, fluid.viscosity());
    if lambda == 0.0 || fluid.polymer == 0.0 {
        return libm::exp(-mu * q_squared * t / rho);
    }
    let a = 1.0 + lambda * fluid.solvent * q_squared / rho;
    let b_squared = a * a - 4.0 * lambda * mu * q_squared / rho;
    let c = a - 2.0 * lambda * q_squared / rho
        * match start {
            Start::Force => mu,
            Start::Velocity => fluid.solvent,
        };
    let half = 0.5 * t / lambda;
    let b = b_squared.abs().sqrt();
    if b * half < 1e-6 {
        // sinh(x)/x → 1, so that a double root divides by nothing.
        return libm::exp(-a * half) * (1.0 + c * half);
    }
    if b_squared < 0.0 {
        return libm::exp(-a * half) * (libm::cos(b * half) + c / b * libm::sin(b * half));
    }
    // Two exponentials: cosh would overflow where its product with e^{−A T/2} is small.
    let (slow, fast) = (libm::exp((b - a) * half), libm::exp((-a - b) * half));
    0.5 * (slow + fast) + 0.5 * c / b * (slow - fast)
}

/// u(y) [m/s] between plates at y = ±`half` [m] under the force `force` [N/m³] from t = 0 on.
pub fn plane_poiseuille(fluid: &Fluid, force: Real, half: Real, y: Real, t: Real) -> Real {
    let mu = fluid.viscosity();
    let steady = force * half * half / (2.0 * mu) * (1.0 - (y / half) * (y / half));
    let missing = (1..=400).map(|k| {
        let q = (2.0 * Real::from(k) - 1.0) * PI / (2.0 * half);
        let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
        2.0 * force * sign / (mu * half * q * q * q)
            * libm::cos(q * y)
            * mode(fluid, Start::Force, q * q, t)
    });
    steady - missing.sum::<Real>()
}

/// u(r) [m/s] in a pipe of radius `radius` [m] under the force `force` [N/m³] from t = 0 on.
pub fn pipe_poiseuille(fluid: &Fluid, force: Real, radius: Real, r: Real, t: Real) -> Real {
    let scale = force * radius * radius / fluid.viscosity();
    let steady = 0.25 * scale * (1.0 - (r / radius) * (r / radius));
    let missing = j0_zeros(200).into_iter().map(|j| {
        scale * 2.0 * j0(j * r / radius) / (j * j * j * j1(j))
            * mode(fluid, Start::Force, (j / radius) * (j / radius), t)
    });
    steady - missing.sum::<Real>()
}

/// u(y) [m/s] between a plate at rest at y = 0 and one at y = `gap` [m] that moves with `speed` from t = 0 on.
pub fn couette(fluid: &Fluid, speed: Real, gap: Real, y: Real, t: Real) -> Real {
    let missing = (1..=2000).map(|n| {
        let q = Real::from(n) * PI / gap;
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        2.0 * speed * sign / (Real::from(n) * PI)
            * libm::sin(q * y)
            * mode(fluid, Start::Velocity, q * q, t)
    });
    speed * y / gap + missing.sum::<Real>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEWTONIAN: Fluid = Fluid {
        density: 1.0,
        solvent: 1.0,
        polymer: 0.0,
        relaxation_time: 0.0,
    };

    /// Values of the reference implementation, which finite differences agreed with.
    #[test]
    fn start_up_has_the_published_values() {
        for (t, ratio) in [
            (0.05, 0.099_956),
            (0.1, 0.197_746),
            (0.2, 0.370_386),
            (1.0, 0.912_477),
        ] {
            assert!((plane_poiseuille(&NEWTONIAN, 2.0, 1.0, 0.0, t) - ratio).abs() < 1e-6);
        }
        for (t, ratio) in [
            (0.05, 0.199_617),
            (0.1, 0.385_190),
            (0.2, 0.651_796),
            (0.5, 0.938_518),
        ] {
            assert!((pipe_poiseuille(&NEWTONIAN, 4.0, 1.0, 0.0, t) - ratio).abs() < 1e-6);
        }
        for (t, ratio) in [
            (0.01, 0.000_407),
            (0.05, 0.113_844),
            (0.1, 0.262_756),
            (0.5, 0.495_422),
        ] {
            assert!((couette(&NEWTONIAN, 1.0, 1.0, 0.5, t) - ratio).abs() < 1e-6);
        }
        let oldroyd = Fluid {
            solvent: 0.1,
            polymer: 0.9,
            relaxation_time: 1.0,
            ..NEWTONIAN
        };
        for (t, ratio) in [
            (0.1, 0.00084),
            (0.3, 0.15495),
            (0.7, 0.66320),
            (1.5, 0.53480),
            (5.0, 0.50306),
        ] {
            assert!((couette(&oldroyd, 1.0, 1.0, 0.5, t) - ratio).abs() < 1e-5);
        }
    }

    /// Waters and King: β = 1/9, E = 1, centre line in units of f h²/(3 μ₀).
    #[test]
    fn oldroyd_b_overshoots_as_published() {
        let fluid = Fluid {
            solvent: 1.0 / 9.0,
            polymer: 8.0 / 9.0,
            relaxation_time: 1.0,
            ..NEWTONIAN
        };
        for (t, u) in [
            (0.2, 0.6),
            (0.4, 1.19829),
            (1.0, 2.46619),
            (2.0, 2.05795),
            (4.0, 1.31706),
            (10.0, 1.50387),
        ] {
            let got = plane_poiseuille(&fluid, 3.0, 1.0, 0.0, t);
            assert!((got - u).abs() < 1e-5, "{t}: {got} {u}");
        }
    }

    #[test]
    fn waves_have_the_published_values() {
        let fluid = Fluid {
            density: 1000.0,
            solvent: 0.01,
            polymer: 8.0,
            relaxation_time: 0.05,
        };
        let q = 2.0 * PI / 0.05;
        for (t, g) in [
            (0.01, 0.882_670),
            (0.02, 0.588_755),
            (0.05, -0.394_344),
            (0.1, 0.006_181),
            (0.2, -0.132_251),
        ] {
            assert!((mode(&fluid, Start::Velocity, q * q, t) - g).abs() < 1e-6);
        }
        // A double root: A² = 4 λ μ₀ q²/ρ with η_s = 0 at λ μ₀ q²/ρ = 1/4; g = e^{−T/2}(1 + T/2).
        let double = Fluid {
            density: 1.0,
            solvent: 0.0,
            polymer: 1.0,
            relaxation_time: 1.0,
        };
        let (g, near) = (
            mode(&double, Start::Velocity, 0.25, 2.0),
            mode(&double, Start::Velocity, 0.25 + 1e-9, 2.0),
        );
        assert!((g - 2.0 * (-1.0_f64).exp()).abs() < 1e-12 && (g - near).abs() < 1e-7);
    }
}
