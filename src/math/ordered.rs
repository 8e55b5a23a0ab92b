//! Sums whose last digit does not depend on the number of threads.
//!
//! Fixed blocks are reduced side by side, then added in order: rayon decides only who computes a block.

use super::Real;
use rayon::prelude::*;

/// Elements per block: large enough to be worth a task, small enough to share out.
pub const BLOCK: usize = 512;

/// Up to this many blocks one thread is done sooner than two are woken; the order, and so the bits, are the same.
pub const FEW: usize = 16;

/// Σ `term(i)` for `i` in `0..count`, the same bits on any number of threads.
pub fn ordered_sum(count: usize, term: impl Fn(usize) -> Real + Sync) -> Real {
    reduce(count, 0.0, |sum, i| sum + term(i), |a, b| a + b)
}

/// The sums of several terms in one go.
pub fn ordered_sums<const N: usize>(
    count: usize,
    term: impl Fn(usize) -> [Real; N] + Sync,
) -> [Real; N] {
    let add = |mut a: [Real; N], b: [Real; N]| {
        for (a, b) in a.iter_mut().zip(b) {
            *a += b;
        }
        a
    };
    reduce(count, [0.0; N], |sum, i| add(sum, term(i)), add)
}

/// max `term(i)`, −∞ if there is none; NaN if any term is NaN, so that it cannot pass unseen.
pub fn ordered_max(count: usize, term: impl Fn(usize) -> Real + Sync) -> Real {
    let larger = |a: Real, b: Real| if a.is_nan() || a > b { a } else { b };
    reduce(
        count,
        Real::NEG_INFINITY,
        |max, i| larger(max, term(i)),
        larger,
    )
}

/// Σ a_i b_i over equally long slices.
pub fn ordered_dot(a: &[Real], b: &[Real]) -> Real {
    debug_assert_eq!(a.len(), b.len());
    ordered_sum(a.len(), |i| a[i] * b[i])
}

fn reduce<T: Copy + Send + Sync>(
    count: usize,
    start: T,
    fold: impl Fn(T, usize) -> T + Sync,
    join: impl Fn(T, T) -> T,
) -> T {
    let block = |b: usize| (b * BLOCK..count.min((b + 1) * BLOCK)).fold(start, &fold);
    let blocks = count.div_ceil(BLOCK);
    if blocks <= FEW {
        return (0..blocks).map(block).fold(start, join);
    }
    let partial: Vec<T> = (0..blocks).into_par_iter().map(block).collect();
    partial.into_iter().fold(start, join)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_on_any_number_of_threads() {
        let term = |i: usize| libm::sin(i as Real) * 1e10_f64.powi((i % 7) as i32 - 3);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("pool");
            pool.install(|| ordered_sum(100_003, term).to_bits())
        };
        assert_eq!(on(1), on(2));
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn maximum_does_not_hide_nan() {
        assert!(ordered_max(5000, |i| if i == 3000 { Real::NAN } else { i as Real }).is_nan());
        assert_eq!(ordered_max(0, |_| 1.0), Real::NEG_INFINITY);
    }
}
