//! MINRES with a positive definite preconditioner, for the symmetric indefinite velocity–pressure system [Paige75].
//!
//! In double or single precision; scalars are always double. The residual is carried along by its own recurrence,
//! r ← s² r + φ c v̂, so that each block of it can be tested in every iteration without another pass.

use crate::math::{BLOCK as VECTOR_BLOCK, FEW, Real, Scalar};
use rayon::prelude::*;

/// Velocity and pressure of one particle.
pub type Packed<T = Real> = [T; 4];

/// A symmetric operator.
pub trait Operator<T> {
    /// `out` = A x.
    fn apply(&self, x: &[Packed<T>], out: &mut [Packed<T>]);
}

/// A symmetric positive definite approximate inverse.
pub trait Preconditioner<T> {
    /// `z` ≈ A⁻¹ r.
    fn precondition(&self, r: &[Packed<T>], z: &mut [Packed<T>]);
}

/// x ≈ A⁻¹ b to where `done(b − A x)`, which is also asked before the first iteration; and the iterations.
pub fn solve<T: Scalar, S: Operator<T> + Preconditioner<T> + Sync>(
    system: &S,
    b: Vec<Packed<T>>,
    most: usize,
    mut done: impl FnMut(&[Packed<T>]) -> bool,
) -> (Vec<Packed<T>>, usize) {
    let n = b.len();
    let zero = || vec![[T::default(); 4]; n];
    let mut residual = b;
    let mut x = zero();
    if done(&residual) {
        return (x, 0);
    }
    let mut v = residual.clone();
    let mut v_old = zero();
    let mut z = zero();
    system.precondition(&v, &mut z);
    let mut image = zero();
    let (mut w, mut w_old) = (zero(), zero());
    let mut gamma = dot(&v, &z).max(0.0).sqrt();
    let mut gamma_old = 1.0;
    let mut phi = gamma;
    let (mut s_old, mut s, mut c_old, mut c) = (0.0, 0.0, 1.0, 1.0);
    let unit = T::of(1.0 / gamma);
    for_each([&mut z], |_, [z]| *z = z.map(|e| e * unit));
    for iteration in 1..=most {
        // Nothing is left, or less than can be divided by: what has been reached stands.
        let unit: Real = T::of(1.0 / gamma).into();
        if !unit.is_finite() || !gamma.is_finite() {
            return (x, iteration - 1);
        }
        system.apply(&z, &mut image);
        let delta = dot(&image, &z);
        // Lanczos: the new vector takes the place of the oldest.
        let (from_v, from_old) = (T::of(delta / gamma), T::of(gamma / gamma_old));
        for_each([&mut v_old], |i, [q]| {
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
            return (x, iteration);
        }
        (c_old, s_old) = (c, s);
        c = alpha_0 / alpha_1;
        s = gamma_new / alpha_1;
        let [own, of_old, of_w] =
            [1.0, alpha_3, alpha_2].map(|weight: Real| T::of(weight / alpha_1));
        let along = T::of(c * phi);
        phi *= -s;
        // What is left to do of a zero vector is nothing: the next iteration ends before it reads it.
        let (add, unit) = if gamma_new > 0.0 {
            (T::of(phi * c / gamma_new), T::of(1.0 / gamma_new))
        } else {
            (T::default(), T::default())
        };
        let keep = T::of(s * s);
        for_each(
            [&mut w_old, &mut x, &mut residual, &mut z],
            |i, [w_new, x, residual, z]| {
                for a in 0..4 {
                    w_new[a] = own * z[a] - of_old * w_new[a] - of_w * w[i][a];
                    x[a] += along * w_new[a];
                    residual[a] = keep * residual[a] + add * v[i][a];
                    z[a] = image[i][a] * unit;
                }
            },
        );
        std::mem::swap(&mut w, &mut w_old);
        (gamma_old, gamma) = (gamma, gamma_new);
        if done(&residual) {
            return (x, iteration);
        }
    }
    (x, most)
}

/// Changes the rows of several vectors together.
fn for_each<T: Scalar, const N: usize>(
    vectors: [&mut Vec<Packed<T>>; N],
    change: impl Fn(usize, [&mut Packed<T>; N]) + Sync,
) {
    // The same block of every vector.
    let count = vectors[0].len().div_ceil(VECTOR_BLOCK);
    let mut blocks: Vec<[&mut [Packed<T>]; N]> = Vec::with_capacity(count);
    let mut chunks = vectors.map(|vector| vector.chunks_mut(VECTOR_BLOCK));
    for _ in 0..count {
        blocks.push(
            chunks
                .each_mut()
                .map(|chunk| chunk.next().unwrap_or_default()),
        );
    }
    let fill = |(number, mut rows): (usize, [&mut [Packed<T>]; N])| {
        for r in 0..rows[0].len() {
            change(
                number * VECTOR_BLOCK + r,
                rows.each_mut().map(|rows| &mut rows[r]),
            );
        }
    };
    if count <= FEW / N {
        blocks.into_iter().enumerate().for_each(fill);
    } else {
        blocks.into_par_iter().enumerate().for_each(fill);
    }
}

fn dot<T: Scalar>(a: &[Packed<T>], b: &[Packed<T>]) -> Real {
    crate::math::ordered_sum(a.len(), |i| {
        let (a, b): ([Real; 4], [Real; 4]) = (a[i].map(Into::into), b[i].map(Into::into));
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small indefinite system: three damped velocities and a constraint on each block.
    struct Blocks;

    impl<T: Scalar> Operator<T> for Blocks {
        fn apply(&self, x: &[Packed<T>], out: &mut [Packed<T>]) {
            let n = x.len();
            for i in 0..n {
                let (left, right) = (x[(i + n - 1) % n], x[(i + 1) % n]);
                for a in 0..3 {
                    out[i][a] = T::of(3.0 + 0.1 * i as Real) * x[i][a] - left[a] - right[a];
                }
                out[i][0] += x[i][3];
                out[i][1] += -right[3];
                out[i][3] = x[i][0] - left[1];
            }
        }
    }

    impl<T: Scalar> Preconditioner<T> for Blocks {
        fn precondition(&self, r: &[Packed<T>], z: &mut [Packed<T>]) {
            for i in 0..r.len() {
                let d = T::of(3.0 + 0.1 * i as Real);
                z[i] = [r[i][0] / d, r[i][1] / d, r[i][2] / d, r[i][3] * d];
            }
        }
    }

    /// Solves to where the residual has fallen by `factor`: farthest from the exact solution, and of the carried residual
    /// from the true one.
    fn errors<T: Scalar>(factor: Real) -> (Real, Real) {
        let n = 30;
        let mut random = crate::math::Stream::new(9, "minres");
        let exact: Vec<Packed<T>> = (0..n)
            .map(|_| std::array::from_fn(|_| T::of(random.between(-1.0, 1.0))))
            .collect();
        let mut b = vec![[T::default(); 4]; n];
        Blocks.apply(&exact, &mut b);
        let goal = factor * factor * dot(&b, &b);
        let mut last = Vec::new();
        let (x, iterations) = solve(&Blocks, b.clone(), 400, |r| {
            last = r.to_vec();
            dot(r, r) < goal
        });
        assert!(iterations < 150, "{iterations}");
        let mut image = vec![[T::default(); 4]; n];
        Blocks.apply(&x, &mut image);
        let (mut of_x, mut of_residual) = (0.0, 0.0);
        for i in 0..n {
            for a in 0..4 {
                let [x, exact, b, image, last] =
                    [x[i][a], exact[i][a], b[i][a], image[i][a], last[i][a]].map(Into::into);
                of_x = Real::max(of_x, Real::abs(x - exact));
                of_residual = Real::max(of_residual, Real::abs(b - image - last));
            }
        }
        (of_x, of_residual)
    }

    #[test]
    fn what_is_too_small_to_divide_by_is_left_alone() {
        let mut b = vec![[0.0_f32; 4]; 30];
        b[3] = [1e-42; 4];
        let (x, iterations) = solve(&Blocks, b, 400, |_| false);
        assert!(iterations < 3 && x.iter().flatten().all(|e| e.is_finite()));
    }

    #[test]
    fn solves_an_indefinite_system_and_its_residual_recurrence_is_true() {
        let (of_x, of_residual) = errors::<Real>(1e-11);
        assert!(of_x < 1e-8 && of_residual < 1e-11, "{of_x} {of_residual}");
        let (of_x, of_residual) = errors::<f32>(1e-4);
        assert!(of_x < 1e-2 && of_residual < 3e-5, "{of_x} {of_residual}");
    }
}
