//! The widest registers of the machine, with the same bits: code that is compiled a second time for AVX2.
//!
//! Lanes of an array are independent, and nothing is fused or approximated, so the result does not depend on how many
//! of them the machine takes at once. This is the only unsafe code of the program.

use rayon::prelude::*;

/// Work that is worth wide registers: loops over arrays such as `[f32; 8]`.
pub trait Wide {
    /// What it gives.
    type Out;
    /// Does it. Has to be `#[inline(always)]`, and so has all that it calls: only what is inlined is compiled again.
    fn run(self) -> Self::Out;
}

/// Runs `work` in the widest registers there are.
#[inline]
pub fn widest<W: Wide>(work: W) -> W::Out {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn with_avx2<W: Wide>(work: W) -> W::Out {
            work.run()
        }
        #[allow(unsafe_code)]
        // SAFETY: the processor has AVX2, which is all that `with_avx2` asks for.
        return unsafe { with_avx2(work) };
    }
    work.run()
}

/// Work of that kind on rows that do not depend on each other.
pub trait WideRows<T>: Sync {
    /// Fills `rows`, of which the first is row `first` of all. Has to be `#[inline(always)]`, as [`Wide::run`].
    fn fill(&self, first: usize, rows: &mut [T]);
}

/// Rows that one task fills; part of no result.
const GRAIN: usize = 128;

/// Fills all `rows` side by side, in the widest registers there are.
pub fn widest_rows<T: Send>(work: &impl WideRows<T>, rows: &mut [T]) {
    rows.par_chunks_mut(GRAIN)
        .enumerate()
        .for_each(|(block, rows)| {
            widest(Block {
                work,
                first: block * GRAIN,
                rows,
            });
        });
}

struct Block<'a, T, W> {
    work: &'a W,
    first: usize,
    rows: &'a mut [T],
}

impl<T, W: WideRows<T>> Wide for Block<'_, T, W> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        self.work.fill(self.first, self.rows);
    }
}
