//! How easily a fluid moves: a uniform push on all of it, held back by viscosity and walls.

use super::coupled::GRAIN;
use super::rows::Rows;
use super::saddle::Drag;
use crate::math::{Real, ordered_sum};
use rayon::prelude::*;

/// Steps of CG: with 12 the solve takes 1 % fewer iterations, which cost less than these.
const STEPS: usize = 6;

/// Velocity per force [m/(s N)]: (M + dt K) u = M 1 by a few steps of Jacobi-CG, times dt/m. `drags` and `diagonal`
/// [kg/s] are those of M/dt + K.
pub(super) fn of_uniform_push(
    drags: &Rows<Drag>,
    diagonal: &[Real],
    mass: &[Real],
    dt: Real,
) -> Vec<Real> {
    let n = diagonal.len();
    let apply = |x: &[Real]| -> Vec<Real> {
        (0..n)
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let pull: Real = drags
                    .row(i)
                    .iter()
                    .map(|q| Real::from(q.drag) * x[q.j as usize])
                    .sum();
                diagonal[i] * x[i] - pull
            })
            .collect()
    };
    let mut u = vec![0.0; n];
    let mut r: Vec<Real> = (0..n).map(|i| mass[i] / dt).collect();
    let mut z: Vec<Real> = (0..n).map(|i| r[i] / diagonal[i]).collect();
    let mut d = z.clone();
    let mut rz = ordered_sum(n, |i| r[i] * z[i]);
    let start = rz;
    for _ in 0..STEPS {
        if rz <= 1e-8 * start {
            break;
        }
        let image = apply(&d);
        let step = rz / ordered_sum(n, |i| d[i] * image[i]);
        for i in 0..n {
            u[i] += step * d[i];
            r[i] -= step * image[i];
            z[i] = r[i] / diagonal[i];
        }
        let next = ordered_sum(n, |i| r[i] * z[i]);
        for i in 0..n {
            d[i] = z[i] + next / rz * d[i];
        }
        rz = next;
    }
    (0..n).map(|i| u[i].max(0.0) * dt / mass[i]).collect()
}
