//! From conformation to stress: modulus, wave speed, and what an implicit step needs of them.
//!
//! ```text
//! τ = G (U − I)                                                     [IMM-CT] (Eq. 13), G of `Cement::modulus`
//! ```
//!
//! On disordered particles the pair of first derivatives alone lets velocity noise cancel stress noise, and the
//! fluid comes out 14 to 155 % too runny at any resolution: a stabiliser that vanishes for smooth fields,
//! Lap[η_a] v − div(η_a L), is part of the scheme.

use super::Cement;
use crate::math::{Mat3, Real, Sym3};

/// τ = G (U − I) [Pa] (Eq. 13).
pub fn of_conformation(modulus: Real, u: &Sym3) -> Mat3 {
    (*u - Sym3::IDENTITY).to_matrix() * modulus
}

/// τ less its least principal value, G (U − λ_min I) [Pa]: none of it presses. Only the level of pressure differs.
///
/// Stretched fluid presses outwards across its stretch by G (1 − λ_min), and at a free surface a pressure below 0 has
/// to balance that. Of this stress it is 0 there, so a pressure that cannot pull does not let the fluid swell and tear.
pub fn above_least(modulus: Real, u: &Sym3) -> Mat3 {
    (*u - Sym3::IDENTITY * u.eigenvalues()[0]).to_matrix() * modulus
}

/// χ: more hides what bends sharply between particles, less lets noise through. Giesekus channel at 20 across: 5.0 %
/// with 1, 2.4 % with 0.5, 1.1 % with 0.3; first normal stress difference in the shear cell: 0.4, 2.7 and 7 %.
const STABILISER: Real = 0.6;

/// Spacings that a wave crosses at most in T where waves are resolved. An Oldroyd-B wave is 1.09, 0.93, 0.84 % off at 64
/// spacings with 8, 4, 2, start-up in a channel (E = 2) 0.82, 0.70, 0.66 %; the rest of that is the Laplacian's.
const CROSSING: Real = 4.0;

/// η_a = χ G T [Pa·s]: viscosity of the stabiliser, where the polymer is stretched by `stretch` = λ_max(U).
///
/// T = 1/(1/λ + γ λ_max) is the time in which the most stretched direction relaxes: right for flow that follows its
/// driving (creeping flow). It overdamps elastic waves; where they are to be `resolved`, T is cut to the time in
/// which a wave crosses a few spacings. T must not depend on dt, or the flow does: with steps in place of
/// spacings the pressure of a needle changed by 15 % over a factor 10 in dt, without by less than 1 %.
pub fn stabiliser_viscosity(
    cement: &Cement,
    modulus: Real,
    density: Real,
    stretch: Real,
    spacing: Real,
    resolved: bool,
) -> Real {
    let memory = 1.0 / (1.0 / cement.relaxation_time + cement.thinning * stretch);
    if modulus <= 0.0 {
        return 0.0;
    }
    let crossing = CROSSING * spacing * (density / modulus).sqrt();
    STABILISER
        * modulus
        * if resolved {
            memory.min(crossing)
        } else {
            memory
        }
}

/// Most of it in an explicit step, per ρ dx²/dt: viscous waves take 6.05 times that of the 2 ρ dx²/dt that are stable. With
/// 0.05, 0.1, 0.15, 0.2, 0.25 the mixing tank at 1 : 1000 (2 mm, λ = 50 ms) survives steps of 0.49, 0.59, 0.73, 0.55, 0.34 CFL
/// steps, the least of three starts: what little of the stabiliser is left lets noise through, what much takes the step.
const EXPLICIT_STABILISER: Real = 0.15;

/// Most viscosity of the stabiliser [Pa·s] that an explicit step of dt [s] bears.
pub fn most_explicit_stabiliser(density: Real, spacing: Real, dt: Real) -> Real {
    EXPLICIT_STABILISER * density * spacing * spacing / dt
}

/// Weight b of the new stress in a step: the exponential's own mean, from 1/2 (elastic) to 1 (viscous), and its
/// implicit viscosity per modulus [s], b λ' (1 − e^{−dt/λ'}) or what keeps the step stable.
///
/// With e = e^{−dt/λ'} a flow that strains the polymer keeps e − r (1 − e)(1 − b + b e) λ'/η of its stress, where r is how
/// much stronger the pair of gradient and divergence is than the Laplacian that stands for it: 1 in the continuum, more
/// at free surfaces, where gradients are made exact. [`MOST_EXCESS`] keeps that above −1.
pub fn implicit_weight(cement: &Cement, dt: Real) -> (Real, Real) {
    let memory = cement.linear_relaxation_time();
    let x = dt / memory;
    let fitted = if x < 1e-3 {
        0.5 + x / 12.0
    } else {
        1.0 / -libm::expm1(-x) - 1.0 / x
    };
    // With the velocity fully implicit, b = 1/2 would ring.
    let b = fitted.max(0.55);
    let lost = -libm::expm1(-x);
    let kept = 1.0 - b * lost;
    let stable = if x > LONG {
        MOST_EXCESS * lost * kept / (2.0 - lost)
    } else {
        0.0
    };
    (b, memory * (b * lost).max(stable))
}

/// r up to which steps longer than `LONG` memories are stable; the stabiliser is more in shorter ones. A drop of 100 Pa·s
/// that creeps on a floor runs away in the fifth step of two memories without, is compressed by 1.8 % with it, and by
/// 0.02 % with 3.
const MOST_EXCESS: Real = 2.2;
const LONG: Real = 0.5;

/// Power at which the elastic energy relaxes, G/2 [tr(U + U⁻¹ − 2I)/λ + γ tr (U − I)²] [W/m³]: what (Eq. 12) takes from
/// it without flow.
pub fn relaxation_power(cement: &Cement, modulus: Real, u: &Sym3) -> Real {
    let off = *u - Sym3::IDENTITY;
    let linear = u.trace() + u.inverse().trace() - 6.0;
    let square = (off.to_matrix() * off.to_matrix()).trace();
    0.5 * modulus * (linear / cement.relaxation_time + cement.thinning * square)
}

/// Elastic energy density (G/2)(tr U − ln det U − 3) [J/m³].
pub fn elastic_energy(modulus: Real, u: &Sym3) -> Real {
    let volume: Real = u.pivots().iter().map(|pivot| libm::log(*pivot)).sum();
    0.5 * modulus * (u.trace() - volume - 3.0)
}
