//! Which pixels of a picture differ from an earlier one, and whether any in a box do.

/// Counts of differing pixels above and left of every corner of a pixel: a box is asked in four look-ups.
pub(super) struct Changes {
    width: usize,
    height: usize,
    counts: Vec<u32>,
}

impl Changes {
    /// Of a picture `width` wide, pixel by pixel.
    pub fn new(width: usize, changed: &[bool]) -> Self {
        let height = changed.len().checked_div(width).unwrap_or(0);
        let mut counts = vec![0; (width + 1) * (height + 1)];
        for row in 0..height {
            let mut along = 0;
            for column in 0..width {
                along += u32::from(changed[row * width + column]);
                counts[(row + 1) * (width + 1) + column + 1] =
                    along + counts[row * (width + 1) + column + 1];
            }
        }
        Self {
            width,
            height,
            counts,
        }
    }

    /// Whether any pixel differs whose column and row are within the ends, both included; what lies outside of the
    /// picture does not differ.
    pub fn any(&self, columns: [i64; 2], rows: [i64; 2]) -> bool {
        let clamp = |[first, last]: [i64; 2], end: usize| {
            [first, last + 1].map(|v| v.clamp(0, end as i64) as usize)
        };
        let ([left, right], [top, bottom]) = (clamp(columns, self.width), clamp(rows, self.height));
        let count = |row: usize, column: usize| self.counts[row * (self.width + 1) + column];
        left < right
            && top < bottom
            && count(bottom, right) + count(top, left) > count(bottom, left) + count(top, right)
    }

    /// Whether any pixel differs that is at most `reach` columns and rows away from `pixel`.
    pub fn near(&self, pixel: usize, reach: i64) -> bool {
        let (column, row) = ((pixel % self.width) as i64, (pixel / self.width) as i64);
        self.any([column - reach, column + reach], [row - reach, row + reach])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_find_what_a_search_finds() {
        let (width, height) = (7, 5);
        let mut changed = vec![false; width * height];
        changed[width + 2] = true;
        changed[4 * width + 6] = true;
        let changes = Changes::new(width, &changed);
        for [left, right, top, bottom] in [
            [-3, 9, -3, 9],
            [2, 2, 1, 1],
            [3, 5, 0, 4],
            [6, 40, 4, 4],
            [7, 9, 0, 9],
            [3, 2, 0, 4],
        ] {
            let inside = |(i, _): &(usize, &bool)| {
                let (column, row) = ((i % width) as i64, (i / width) as i64);
                (left..=right).contains(&column) && (top..=bottom).contains(&row)
            };
            let found = changed.iter().enumerate().filter(inside).any(|(_, c)| *c);
            assert_eq!(
                changes.any([left, right], [top, bottom]),
                found,
                "{left} {right} {top} {bottom}"
            );
        }
        assert!(changes.near(0, 2) && !changes.near(0, 1));
    }
}
