//! MINRES with a positive definite preconditioner, for the symmetric indefinite velocity–pressure system [Paige75].
//!
//! The residual is carried along by its own recurrence, r ← s² r + φ c v̂, so that each block of it can be tested
//! in every iteration without another pass.

use super::coupled::VECTOR_BLOCK;
use crate::math::Real;
use rayon::prelude::*;

/// Velocity and pressure of one particle.
pub type Packed = [Real; 4];

/// A symmetric operator.
pub trait Operator {
    /// `out` = A x.
    fn apply(&self, x: &[Packed], out: &mut [Packed]);
}

/// A symmetric positive definite approximate inverse.
pub trait Preconditioner {
    /// `z` ≈ A⁻¹ r.
    fn precondition(&self, r: &[Packed], z: &mut [Packed]);
}

/// Improves `x` until `done(residual)`, which is also asked before the first iteration; returns the iterations.
pub fn solve<S: Operator + Preconditioner + Sync>(
    system: &S,
    b: &[Packed],
    x: &mut [Packed],
    most: usize,
    mut done: impl FnMut(&[Packed]) -> bool,
) -> usize {
    let n = b.len();
    let mut residual = vec![[0.0; 4]; n];
    system.apply(x, &mut residual);
    for i in 0..n {
        for c in 0..4 {
            residual[i][c] = b[i][c] - residual[i][c];
        }
    }
    if done(&residual) {
        return 0;
    }
    let mut v = residual.clone();
    let mut v_old = vec![[0.0; 4]; n];
    let mut z = vec![[0.0; 4]; n];
    system.precondition(&v, &mut z);
    let mut image = vec![[0.0; 4]; n];
    let (mut w, mut w_old) = (vec![[0.0; 4]; n], vec![[0.0; 4]; n]);
    let mut gamma = dot(&v, &z).max(0.0).sqrt();
    let mut gamma_old = 1.0;
    let mut phi = gamma;
    let (mut s_old, mut s, mut c_old, mut c) = (0.0, 0.0, 1.0, 1.0);
    for iteration in 1..=most {
        if gamma == 0.0 || !gamma.is_finite() {
            return iteration - 1;
        }
        for_each(&mut z, |_, q| *q = q.map(|e| e / gamma));
        system.apply(&z, &mut image);
        let delta = dot(&image, &z);
        // Lanczos: the new vector takes the place of the oldest.
        let (from_v, from_old) = (delta / gamma, gamma / gamma_old);
        for_each(&mut v_old, |i, q| {
            for a in 0..4 {
                q[a] = image[i][a] - from_v * v[i][a] - from_old * q[a];
            }
        });
        std::mem::swap(&mut v, &mut v_old);
        // `image` is free: it receives the preconditioned vector.
        system.precondition(&v, &mut image);
        let gamma_new = dot(&v, &image).max(0.0).sqrt();
        let alpha_0 = c * delta - c_old * s * gamma;
        let alpha_1 = alpha_0.hypot(gamma_new);
        let alpha_2 = s * delta + c_old * c * gamma;
        let alpha_3 = s_old * gamma;
        if alpha_1 == 0.0 {
            return iteration;
        }
        (c_old, s_old) = (c, s);
        c = alpha_0 / alpha_1;
        s = gamma_new / alpha_1;
        for_each(&mut w_old, |i, q| {
            for a in 0..4 {
                q[a] = (z[i][a] - alpha_3 * q[a] - alpha_2 * w[i][a]) / alpha_1;
            }
        });
        std::mem::swap(&mut w, &mut w_old);
        let along = c * phi;
        phi *= -s;
        let (keep, add) = (
            s * s,
            if gamma_new > 0.0 {
                phi * c / gamma_new
            } else {
                0.0
            },
        );
        for_each(x, |i, q| {
            for a in 0..4 {
                q[a] += along * w[i][a];
            }
        });
        for_each(&mut residual, |i, q| {
            for a in 0..4 {
                q[a] = keep * q[a] + add * v[i][a];
            }
        });
        std::mem::swap(&mut z, &mut image);
        (gamma_old, gamma) = (gamma, gamma_new);
        if done(&residual) {
            return iteration;
        }
    }
    most
}

fn for_each(x: &mut [Packed], change: impl Fn(usize, &mut Packed) + Sync) {
    if x.len() <= 16 * VECTOR_BLOCK {
        for (i, row) in x.iter_mut().enumerate() {
            change(i, row);
        }
        return;
    }
    x.par_chunks_mut(VECTOR_BLOCK)
        .enumerate()
        .for_each(|(block, rows)| {
            for (offset, row) in rows.iter_mut().enumerate() {
                change(block * VECTOR_BLOCK + offset, row);
            }
        });
}

fn dot(a: &[Packed], b: &[Packed]) -> Real {
    crate::math::ordered_sum(a.len(), |i| {
        a[i][0] * b[i][0] + a[i][1] * b[i][1] + a[i][2] * b[i][2] + a[i][3] * b[i][3]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small indefinite system: three damped velocities and a constraint on each block.
    struct Blocks;

    impl Operator for Blocks {
        fn apply(&self, x: &[Packed], out: &mut [Packed]) {
            let n = x.len();
            for i in 0..n {
                let (left, right) = (x[(i + n - 1) % n], x[(i + 1) % n]);
                for a in 0..3 {
                    out[i][a] = (3.0 + 0.1 * i as Real) * x[i][a] - left[a] - right[a];
                }
                out[i][0] += x[i][3];
                out[i][1] -= right[3];
                out[i][3] = x[i][0] - left[1];
            }
        }
    }

    impl Preconditioner for Blocks {
        fn precondition(&self, r: &[Packed], z: &mut [Packed]) {
            for i in 0..r.len() {
                let d = 3.0 + 0.1 * i as Real;
                z[i] = [r[i][0] / d, r[i][1] / d, r[i][2] / d, r[i][3] * d];
            }
        }
    }

    #[test]
    fn solves_an_indefinite_system_and_its_residual_recurrence_is_true() {
        let n = 30;
        let mut random = crate::math::Stream::new(9, "minres");
        let exact: Vec<Packed> = (0..n)
            .map(|_| std::array::from_fn(|_| random.between(-1.0, 1.0)))
            .collect();
        let mut b = vec![[0.0; 4]; n];
        Blocks.apply(&exact, &mut b);
        let mut x = vec![[0.0; 4]; n];
        let mut last = Vec::new();
        let iterations = solve(&Blocks, &b, &mut x, 400, |r| {
            last = r.to_vec();
            dot(r, r) < 1e-20
        });
        assert!(iterations < 150, "{iterations}");
        let mut image = vec![[0.0; 4]; n];
        Blocks.apply(&x, &mut image);
        for i in 0..n {
            for a in 0..4 {
                assert!((x[i][a] - exact[i][a]).abs() < 1e-8);
                assert!((b[i][a] - image[i][a] - last[i][a]).abs() < 1e-11);
            }
        }
    }
}
