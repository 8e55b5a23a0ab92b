//! Rows of unequal length, in blocks that are filled side by side and used again.

use rayon::prelude::*;

/// Rows of a block: what one task fills. A power of two; part of no result.
const BLOCK: usize = 256;

/// Row i, of as many entries as it has.
#[derive(Clone, Debug)]
pub struct Rows<T> {
    blocks: Vec<Block<T>>,
    len: usize,
    entries: usize,
}

/// Row r of a block is `data[first[r]..first[r + 1]]`.
#[derive(Clone, Debug)]
struct Block<T> {
    first: Vec<u32>,
    data: Vec<T>,
}

impl<T> Default for Block<T> {
    fn default() -> Self {
        Self {
            first: Vec::new(),
            data: Vec::new(),
        }
    }
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self {
            blocks: Vec::new(),
            len: 0,
            entries: 0,
        }
    }
}

impl<T: Copy + Send + Sync> Rows<T> {
    /// Fills `count` rows side by side, in the memory of the rows that were here; `fill` appends the entries of a row.
    pub fn rebuild(&mut self, count: usize, fill: impl Fn(usize, &mut Vec<T>) + Sync) {
        self.resize(count);
        self.blocks
            .par_iter_mut()
            .enumerate()
            .for_each(|(number, block)| {
                for i in number * BLOCK..count.min((number + 1) * BLOCK) {
                    fill(i, &mut block.data);
                    block.first.push(block.data.len() as u32);
                }
            });
        self.entries = self.blocks.iter().map(|block| block.data.len()).sum();
    }

    /// The same for two rows of equal length at once.
    pub fn rebuild_with<U: Copy + Send + Sync>(
        &mut self,
        other: &mut Rows<U>,
        count: usize,
        fill: impl Fn(usize, &mut Vec<T>, &mut Vec<U>) + Sync,
    ) {
        self.resize(count);
        other.resize(count);
        self.blocks
            .par_iter_mut()
            .zip(&mut other.blocks)
            .enumerate()
            .for_each(|(number, (block, other))| {
                for i in number * BLOCK..count.min((number + 1) * BLOCK) {
                    fill(i, &mut block.data, &mut other.data);
                    block.first.push(block.data.len() as u32);
                    other.first.push(other.data.len() as u32);
                }
            });
        self.entries = self.blocks.iter().map(|block| block.data.len()).sum();
        other.entries = other.blocks.iter().map(|block| block.data.len()).sum();
    }

    /// Empty blocks for `count` rows.
    fn resize(&mut self, count: usize) {
        self.blocks
            .resize_with(count.div_ceil(BLOCK), Block::default);
        for block in &mut self.blocks {
            block.data.clear();
            block.first.clear();
            block.first.push(0);
        }
        self.len = count;
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of entries in all rows.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// Row i.
    #[inline(always)]
    pub fn row(&self, i: usize) -> &[T] {
        let (block, r) = (&self.blocks[i / BLOCK], i % BLOCK);
        &block.data[block.first[r] as usize..block.first[r + 1] as usize]
    }

    /// Rewrites every entry in place together with that of `other` in the same place, given their row.
    pub fn for_each_mut_with<U: Send>(
        &mut self,
        other: &mut Rows<U>,
        change: impl Fn(usize, &mut T, &mut U) + Sync,
    ) {
        let blocks = self.blocks.par_iter_mut().zip(&mut other.blocks);
        blocks.enumerate().for_each(|(number, (block, others))| {
            for (r, ends) in block.first.windows(2).enumerate() {
                let own = &mut block.data[ends[0] as usize..ends[1] as usize];
                let their = &mut others.data[ends[0] as usize..ends[1] as usize];
                for (a, b) in own.iter_mut().zip(their) {
                    change(number * BLOCK + r, a, b);
                }
            }
        });
    }

    /// Rewrites every row in place.
    pub fn for_each_row_mut(&mut self, change: impl Fn(usize, &mut [T]) + Sync) {
        self.blocks
            .par_iter_mut()
            .enumerate()
            .for_each(|(number, block)| {
                for (r, ends) in block.first.windows(2).enumerate() {
                    let row = &mut block.data[ends[0] as usize..ends[1] as usize];
                    change(number * BLOCK + r, row);
                }
            });
    }

    /// Rewrites every entry in place, given its row.
    pub fn for_each_mut(&mut self, change: impl Fn(usize, &mut T) + Sync) {
        self.for_each_row_mut(|i, row| {
            for entry in row {
                change(i, entry);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_what_was_filled_in_also_when_they_are_filled_again() {
        let mut rows = Rows::default();
        for count in [1000, 3, 700, 0] {
            let length = |i: usize| (i * 7 + count) % 5;
            rows.rebuild(count, |i, row| row.extend((0..length(i)).map(|k| i + k)));
            rows.for_each_mut(|i, entry| *entry += i);
            assert_eq!(rows.len(), count);
            assert_eq!(rows.entries(), (0..count).map(length).sum::<usize>());
            for i in 0..count {
                let expected: Vec<usize> = (0..length(i)).map(|k| 2 * i + k).collect();
                assert_eq!(rows.row(i), expected);
            }
        }
    }
}
