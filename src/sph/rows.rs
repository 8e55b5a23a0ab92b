//! Rows of unequal length, one after the other.

use rayon::prelude::*;

/// Row i is `data[first[i]..first[i + 1]]`.
#[derive(Clone, Debug)]
pub struct Rows<T> {
    first: Vec<u32>,
    data: Vec<T>,
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self {
            first: vec![0],
            data: Vec::new(),
        }
    }
}

/// Rows that one task fills; part of no result.
const ROWS_PER_TASK: usize = 256;

impl<T: Copy + Send + Sync> Rows<T> {
    /// Fills `count` rows side by side; `fill` appends the entries of a row.
    pub fn build(count: usize, fill: impl Fn(usize, &mut Vec<T>) + Sync) -> Self {
        let parts: Vec<(Vec<u32>, Vec<T>)> = (0..count.div_ceil(ROWS_PER_TASK))
            .into_par_iter()
            .map(|task| {
                let rows = task * ROWS_PER_TASK..count.min((task + 1) * ROWS_PER_TASK);
                let mut ends = Vec::with_capacity(rows.len());
                let mut data = Vec::with_capacity(rows.len() * 64);
                for i in rows {
                    fill(i, &mut data);
                    ends.push(data.len() as u32);
                }
                (ends, data)
            })
            .collect();
        let mut first = Vec::with_capacity(count + 1);
        first.push(0);
        let mut data = Vec::with_capacity(parts.iter().map(|p| p.1.len()).sum());
        for (ends, part) in parts {
            let base = data.len() as u32;
            first.extend(ends.iter().map(|end| base + end));
            data.extend_from_slice(&part);
        }
        Self { first, data }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.first.len() - 1
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of entries in all rows.
    pub fn entries(&self) -> usize {
        self.data.len()
    }

    /// Row i.
    #[inline(always)]
    pub fn row(&self, i: usize) -> &[T] {
        &self.data[self.first[i] as usize..self.first[i + 1] as usize]
    }

    /// Rewrites every entry in place, given its row.
    pub fn for_each_mut(&mut self, change: impl Fn(usize, &mut T) + Sync) {
        let first = &self.first;
        let mut rows: Vec<&mut [T]> = Vec::with_capacity(first.len() - 1);
        let mut rest = self.data.as_mut_slice();
        for i in 0..first.len() - 1 {
            let (row, tail) = rest.split_at_mut((first[i + 1] - first[i]) as usize);
            rows.push(row);
            rest = tail;
        }
        rows.par_iter_mut()
            .enumerate()
            .with_min_len(ROWS_PER_TASK)
            .for_each(|(i, row)| {
                for entry in row.iter_mut() {
                    change(i, entry);
                }
            });
    }
}
