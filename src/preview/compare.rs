//! Whether two pictures are the same, and how far apart if not.

use image::RgbImage;

/// What sets two pictures apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// Every byte is the same.
    Same,
    /// They have different sizes [pixels].
    Sizes {
        /// Width and height of the first.
        first: (u32, u32),
        /// Width and height of the second.
        second: (u32, u32),
    },
    /// The same size, but not the same picture.
    Different {
        /// Pixels that differ.
        pixels: u64,
        /// Largest difference of any channel, of 255.
        largest: u8,
    },
}

/// Compares byte by byte.
pub fn compare(first: &RgbImage, second: &RgbImage) -> Comparison {
    if first.dimensions() != second.dimensions() {
        return Comparison::Sizes {
            first: first.dimensions(),
            second: second.dimensions(),
        };
    }
    let (mut pixels, mut largest) = (0, 0);
    for (a, b) in first.pixels().zip(second.pixels()) {
        let apart = (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0);
        pixels += u64::from(apart > 0);
        largest = largest.max(apart);
    }
    if pixels == 0 {
        Comparison::Same
    } else {
        Comparison::Different { pixels, largest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_pixels_and_finds_the_largest_difference() {
        let first = RgbImage::from_pixel(4, 3, image::Rgb([10, 20, 30]));
        let mut second = first.clone();
        assert_eq!(compare(&first, &second), Comparison::Same);
        second.put_pixel(1, 2, image::Rgb([10, 27, 28]));
        second.put_pixel(3, 0, image::Rgb([11, 20, 30]));
        let different = Comparison::Different {
            pixels: 2,
            largest: 7,
        };
        assert_eq!(compare(&first, &second), different);
        assert!(matches!(
            compare(&first, &RgbImage::new(3, 4)),
            Comparison::Sizes { .. }
        ));
    }
}
