//! Pressure by projected gradients with Nesterov's momentum: p ≥ 0, no set logic, always converges.
//!
//! ```text
//! min ½ kᵀ A k − bᵀ k,  k ≥ 0,   A = Pᵀ (dt M⁻¹) P,   residual s = b − A k  (volume left over [m³/s])
//! k' = max(0, y + s(y)/(L diag)),   restart where the step turns against the gradient
//! ```
//!
//! How the force moves the fluid (dt M⁻¹, or a viscous solve) is a parameter.

use super::pressure::PressureOperator;
use crate::math::{Real, Vec3, ordered_dot, ordered_sum};
use rayon::prelude::*;

/// When the pressure is good enough.
#[derive(Clone, Copy, Debug)]
pub struct ApgdGoal {
    /// Root mean square of the volume strain left over [1/s].
    pub strain_rate: Real,
    /// |Σ s| over the particles under pressure [m³/s].
    pub balance: Real,
    /// Give up after so many applications of A.
    pub most_iterations: usize,
}

/// What became of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PressureOutcome {
    /// Applications of A.
    pub iterations: usize,
    /// Whether both goals were met.
    pub converged: bool,
    /// Root mean square volume strain left over [1/s].
    pub strain_rate: Real,
    /// |Σ s| over the particles under pressure [m³/s].
    pub balance: Real,
}

/// Solves for the pressure `k` [Pa], which comes in as the guess. `source` is the volume rate [m³/s] that it has
/// to undo, `mobility(f)` the velocity [m/s] that forces f [N] cause in the step, `diagonal` that of A;
/// particles that are `free` keep k = 0.
pub fn solve_pressure(
    operator: &PressureOperator,
    mobility: impl Fn(&[Vec3]) -> Vec<Vec3>,
    diagonal: &[Real],
    source: &[Real],
    free: &[bool],
    goal: &ApgdGoal,
    k: &mut Vec<Real>,
) -> PressureOutcome {
    let n = source.len();
    let volume = operator.near.rest_volume;
    let apply = |k: &[Real]| operator.volume_rate(&mobility(&operator.force(k)));
    // Isolated particles have next to no diagonal; without a floor they divide by zero.
    let mut sorted = diagonal.to_vec();
    sorted.sort_by(Real::total_cmp);
    let floor = 1e-3
        * sorted
            .get(n / 2)
            .copied()
            .unwrap_or(1.0)
            .max(Real::MIN_POSITIVE);
    let scale: Vec<Real> = diagonal.iter().map(|d| 1.0 / d.max(floor)).collect();

    // Largest eigenvalue of D⁻¹A by power iteration from a rough vector.
    let mut probe: Vec<Real> = (0..n)
        .map(|i| if i % 2 == 0 { 1.0 } else { -0.7 })
        .collect();
    let mut largest: Real = 1.0;
    for _ in 0..8 {
        let norm = ordered_dot(&probe, &probe).sqrt();
        if norm == 0.0 {
            break;
        }
        let image = apply(&probe);
        probe = (0..n).map(|i| image[i] * scale[i]).collect();
        largest = largest.max(ordered_dot(&probe, &probe).sqrt() / norm);
    }
    let step = 1.0 / (1.15 * largest);

    for i in 0..n {
        k[i] = if free[i] { 0.0 } else { k[i].max(0.0) };
    }
    let mut outcome = PressureOutcome::default();
    let mut y = k.clone();
    let mut momentum: Real = 1.0;
    loop {
        let image = apply(&y);
        outcome.iterations += 1;
        let s: Vec<Real> = (0..n).map(|i| source[i] - image[i]).collect();
        let next: Vec<Real> = (0..n)
            .into_par_iter()
            .map(|i| {
                if free[i] {
                    0.0
                } else {
                    (y[i] + s[i] * step * scale[i]).max(0.0)
                }
            })
            .collect();
        // The test is on y, where the residual is known; y and k meet at the solution.
        let left = |i: usize| match (free[i], y[i] > 0.0) {
            (true, _) => 0.0,
            (_, true) => s[i],
            _ => s[i].max(0.0),
        };
        outcome.strain_rate =
            (ordered_sum(n, |i| left(i) * left(i)) / n.max(1) as Real).sqrt() / volume;
        outcome.balance = ordered_sum(n, left).abs();
        if outcome.strain_rate <= goal.strain_rate && outcome.balance <= goal.balance {
            outcome.converged = true;
            *k = y;
            return outcome;
        }
        if outcome.iterations >= goal.most_iterations {
            *k = next;
            return outcome;
        }
        let turned = ordered_sum(n, |i| (next[i] - k[i]) * s[i]) < 0.0;
        let ahead = if turned {
            1.0
        } else {
            0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt())
        };
        let weight = if turned {
            0.0
        } else {
            (momentum - 1.0) / ahead
        };
        y = (0..n)
            .map(|i| (next[i] + weight * (next[i] - k[i])).max(0.0))
            .collect();
        *k = next;
        momentum = ahead;
    }
}
