//! One bit for every node of a lattice, in rows of whole words along z, and the place of each among those that are set.

use rayon::prelude::*;

/// Bits by node.
pub(super) struct BitRows {
    /// Nodes along each axis.
    pub(super) count: [usize; 3],
    /// Rows (x, y), y running faster.
    bits: Vec<u64>,
    /// How many are set before each word.
    before: Vec<u32>,
}

impl BitRows {
    /// The bits of the nodes, with how many nodes further along z the same holds: told by what `row` makes for (x, y).
    pub(super) fn new<S: Fn(usize) -> (bool, usize)>(
        count: [usize; 3],
        row: impl Fn([usize; 2]) -> S + Sync,
    ) -> Self {
        let words = count[2].div_ceil(64);
        let mut rows = Self {
            count,
            bits: vec![0; count[0] * count[1] * words],
            before: Vec::new(),
        };
        let each = rows.bits.par_chunks_mut(words.max(1)).enumerate();
        each.for_each(|(at, bits)| {
            let set = row([at / count[1], at % count[1]]);
            let mut z = 0;
            while z < count[2] {
                let (is_set, alike) = set(z);
                let next = (z + 1 + alike).min(count[2]);
                if is_set {
                    (z..next).for_each(|z| bits[z / 64] |= 1 << (z % 64));
                }
                z = next;
            }
        });
        rows
    }

    /// Takes back the nodes on the faces of the lattice.
    pub(super) fn clear_rim(&mut self) {
        let [nx, ny, nz] = self.count;
        let words = self.words();
        for (row, bits) in self.bits.chunks_mut(words.max(1)).enumerate() {
            let (x, y) = (row / ny, row % ny);
            if x == 0 || x + 1 == nx || y == 0 || y + 1 == ny {
                bits.fill(0);
            }
            bits[0] &= !1;
            bits[(nz - 1) / 64] &= !(1 << ((nz - 1) % 64));
        }
    }

    /// Words in a row.
    pub(super) fn words(&self) -> usize {
        self.count[2].div_ceil(64)
    }

    pub(super) fn rows(&self) -> usize {
        self.count[0] * self.count[1]
    }

    pub(super) fn place(&self, row: usize, z: usize) -> [usize; 3] {
        [row / self.count[1], row % self.count[1], z]
    }

    fn word_of(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.count[1] + y) * self.words() + z / 64
    }

    pub(super) fn get(&self, place: [usize; 3]) -> bool {
        self.bits[self.word_of(place)] >> (place[2] % 64) & 1 == 1
    }

    pub(super) fn set(&mut self, place: [usize; 3]) {
        let word = self.word_of(place);
        self.bits[word] |= 1 << (place[2] % 64);
    }

    /// How many bits are set before that of `place`.
    pub(super) fn rank(&self, place: [usize; 3]) -> usize {
        let word = self.word_of(place);
        let lower = self.bits[word] & ((1 << (place[2] % 64)) - 1);
        self.before[word] as usize + lower.count_ones() as usize
    }

    /// Something for each bit that is set, in their order.
    pub(super) fn map<T: Send>(&self, make: impl Fn([usize; 3]) -> T + Sync) -> Vec<T> {
        self.map_by_row(|_| &make)
    }

    /// The same, by what `row` makes for (x, y).
    pub(super) fn map_by_row<T: Send, M: Fn([usize; 3]) -> T>(
        &self,
        row: impl Fn([usize; 2]) -> M + Sync,
    ) -> Vec<T> {
        let of_row = |at: usize| -> Vec<T> {
            let [x, y, _] = self.place(at, 0);
            self.row(at).map(row([x, y])).collect()
        };
        let rows = (0..self.rows()).into_par_iter();
        rows.map(of_row).flatten_iter().collect()
    }

    /// The places in a row that are set.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = [usize; 3]> {
        let words = &self.bits[row * self.words()..][..self.words()];
        let set = words.iter().enumerate();
        let set = set.flat_map(|(w, bits)| bits_of(*bits).map(move |bit| w * 64 + bit));
        set.map(move |z| self.place(row, z))
    }

    /// The cells above the nodes of a word of which some corners are set and some are not.
    pub(super) fn mixed_word(&self, row: usize, word: usize) -> u64 {
        let [nx, ny, nz] = self.count;
        let (x, y) = (row / ny, row % ny);
        if x + 1 == nx || y + 1 == ny {
            return 0;
        }
        let words = self.words();
        let (mut some, mut all) = ([0, 0], [!0, !0]);
        for row in [row, row + 1, row + ny, row + ny + 1] {
            let at = row * words + word;
            let here = self.bits[at];
            let next = if word + 1 < words {
                self.bits[at + 1]
            } else {
                0
            };
            let above = here >> 1 | next << 63;
            some = [some[0] | here, some[1] | above];
            all = [all[0] & here, all[1] & above];
        }
        // No cell begins at the last node of a row.
        let last = (nz - 1) / 64 == word;
        let cells = if last { (1 << ((nz - 1) % 64)) - 1 } else { !0 };
        (some[0] | some[1]) & !(all[0] & all[1]) & cells
    }

    /// The cells, by their lowest corner, of which some corners are set and some are not.
    pub(super) fn mixed(&self) -> Self {
        let words = self.words();
        let word = |at: usize| self.mixed_word(at / words, at % words);
        self.with((0..self.bits.len()).into_par_iter().map(word).collect())
    }

    /// The corners of the cells that are set.
    pub(super) fn corners(&self) -> Self {
        let (words, ny) = (self.words(), self.count[1]);
        let word = |at: usize| {
            let (row, word) = (at / words, at % words);
            let back = |step: usize, from: usize| (from >= step).then(|| row - step);
            let (x, y) = (row / ny, row % ny);
            let rows = [
                Some(row),
                back(1, y),
                back(ny, x * ny),
                back(ny, x * ny).and_then(|row| (y > 0).then(|| row - 1)),
            ];
            let mut bits = 0;
            for row in rows.into_iter().flatten() {
                let at = row * words + word;
                let below = if word > 0 { self.bits[at - 1] } else { 0 };
                bits |= self.bits[at] | self.bits[at] << 1 | below >> 63;
            }
            bits
        };
        self.with((0..self.bits.len()).into_par_iter().map(word).collect())
    }

    fn with(&self, bits: Vec<u64>) -> Self {
        let mut sum = 0;
        let before = bits.iter().map(|word: &u64| {
            sum += word.count_ones();
            sum - word.count_ones()
        });
        Self {
            count: self.count,
            before: before.collect(),
            bits,
        }
    }
}

/// The places of the bits that are set, ascending.
pub(super) fn bits_of(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros() as usize;
        (word != 0).then(|| {
            word &= word - 1;
            bit
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_corners_and_ranks_agree_with_plain_loops() {
        let count = [4, 5, 131];
        let mut random = crate::math::Stream::new(2, "bits");
        let plain: Vec<bool> = (0..4 * 5 * 131).map(|_| random.unit() < 0.02).collect();
        let plain = plain.as_slice();
        let index = |[x, y, z]: [usize; 3]| (x * 5 + y) * 131 + z;
        let rows = BitRows::new(count, |[x, y]| move |z| (plain[index([x, y, z])], 0));
        let cells = rows.mixed();
        let near = cells.corners();
        let mut expected = Vec::new();
        let mut corners = vec![false; plain.len()];
        for x in 0..3 {
            for y in 0..4 {
                for z in 0..130 {
                    let of_cell = (0..8).map(|c| [x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)]);
                    let set = of_cell.clone().filter(|p| plain[index(*p)]).count();
                    if (1..8).contains(&set) {
                        expected.push([x, y, z]);
                        of_cell.for_each(|p| corners[index(p)] = true);
                    }
                }
            }
        }
        assert!(expected.len() > 20);
        assert_eq!(cells.map(|place| place), expected);
        for (n, place) in expected.iter().enumerate() {
            assert_eq!(cells.rank(*place), n);
        }
        let found = near.map(index);
        let wanted: Vec<usize> = (0..plain.len()).filter(|i| corners[*i]).collect();
        assert_eq!(found, wanted);
        let share = wanted.len() as f64 / plain.len() as f64;
        assert!(share < 0.9, "{share}");
    }
}
