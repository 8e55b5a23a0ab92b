//! Pressure by projected gradients with Nesterov's momentum: p ≥ 0, no set logic, always converges.
//!
//! ```text
//! min ½ kᵀ A k − bᵀ k,  k ≥ 0,   A = Pᵀ (dt M⁻¹) P,   residual s = b − A k  (volume left over [m³/s])
//! k' = max(0, y + s(y)/(L diag)),   y' = k' + w (k' − k),   s(y') = b − A k' − w (A k' − A k)
//! ```
//!
//! A is applied once an iteration, to k'. L is found on the way: where the step from y turns out longer than
//! (k' − y)ᵀ A (k' − y) ≤ L (k' − y)ᵀ D (k' − y) allows, L grows and the step is done again. Momentum is dropped where
//! the step turns against the gradient.

use super::repeated::RepeatedPressure;
use crate::math::{Real, ordered_sums};
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

/// L at first: what lattices and flows of the recipes need; and what it grows by beyond the need.
const FIRST_L: Real = 1.5;
const MARGIN: Real = 1.1;
const GRAIN: usize = 2048;

/// Solves for the pressure `k` [Pa], which comes in as the guess. `source` is the volume rate [m³/s] that it has
/// to undo, `diagonal` that of A; particles that are `free` keep k = 0.
pub fn solve_pressure(
    operator: &mut RepeatedPressure,
    diagonal: &[Real],
    source: &[Real],
    free: &[bool],
    goal: &ApgdGoal,
    k: &mut Vec<Real>,
) -> PressureOutcome {
    let n = source.len();
    let mut outcome = PressureOutcome::default();
    if n == 0 {
        outcome.converged = true;
        return outcome;
    }
    let volume = operator.rest_volume();
    // Isolated particles have next to no diagonal; without a floor they divide by zero.
    let median = *diagonal
        .to_vec()
        .select_nth_unstable_by(n / 2, Real::total_cmp)
        .1;
    let floor = 1e-3 * median.max(Real::MIN_POSITIVE);
    let weight = |i: usize| diagonal[i].max(floor);

    for i in 0..n {
        k[i] = if free[i] { 0.0 } else { k[i].max(0.0) };
    }
    let mut image = vec![0.0; n];
    operator.apply(k, &mut image);
    outcome.iterations = 1;
    let (mut next, mut next_image) = (vec![0.0; n], vec![0.0; n]);
    let mut y = k.clone();
    let mut s: Vec<Real> = (0..n).map(|i| source[i] - image[i]).collect();
    let mut momentum: Real = 1.0;
    let mut l = FIRST_L;
    let reached = |k: &[Real], image: &[Real], outcome: &mut PressureOutcome| {
        let [square, sum] = ordered_sums(n, |i| {
            let s = source[i] - image[i];
            let left = match (free[i], k[i] > 0.0) {
                (true, _) => 0.0,
                (_, true) => s,
                _ => s.max(0.0),
            };
            [left * left, left]
        });
        outcome.strain_rate = (square / n as Real).sqrt() / volume;
        outcome.balance = sum.abs();
        outcome.converged =
            outcome.strain_rate <= goal.strain_rate && outcome.balance <= goal.balance;
        outcome.converged
    };
    if reached(k, &image, &mut outcome) {
        return outcome;
    }
    while outcome.iterations < goal.most_iterations {
        next.par_iter_mut()
            .enumerate()
            .with_min_len(GRAIN)
            .for_each(|(i, next)| {
                *next = if free[i] {
                    0.0
                } else {
                    (y[i] + s[i] / (l * weight(i))).max(0.0)
                };
            });
        operator.apply(&next, &mut next_image);
        outcome.iterations += 1;
        let [bent, length, along] = ordered_sums(n, |i| {
            let d = next[i] - y[i];
            [
                d * (next_image[i] - (source[i] - s[i])),
                d * d * weight(i),
                (next[i] - k[i]) * s[i],
            ]
        });
        if bent > l * length {
            l = MARGIN * bent / length;
            continue;
        }
        if reached(&next, &next_image, &mut outcome) {
            *k = next;
            return outcome;
        }
        let turned = along < 0.0;
        let ahead = if turned {
            1.0
        } else {
            0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt())
        };
        let w = if turned {
            0.0
        } else {
            (momentum - 1.0) / ahead
        };
        (&mut y, &mut s)
            .into_par_iter()
            .enumerate()
            .with_min_len(GRAIN)
            .for_each(|(i, (y, s))| {
                *y = next[i] + w * (next[i] - k[i]);
                *s = source[i] - next_image[i] - w * (next_image[i] - image[i]);
            });
        std::mem::swap(k, &mut next);
        std::mem::swap(&mut image, &mut next_image);
        momentum = ahead;
    }
    outcome
}
