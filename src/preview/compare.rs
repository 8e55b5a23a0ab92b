//! Whether two pictures are the same, or look the same; and a picture of where they do not.
//!
//! ```text
//! SSIM = (2 μ_a μ_b + c₁)(2 σ_ab + c₂) / ((μ_a² + μ_b² + c₁)(σ_a² + σ_b² + c₂))     [Wang04]
//! ```
//!
//! is 1 for equal windows. It is taken in every window on its own, of luminance, and beside it the mean difference of each
//! colour channel: a drop that is missing changes a few windows of thousands, and a tint changes no structure.

use image::{Rgb, RgbImage};
use rayon::prelude::*;

/// Side of a window [pixels].
const WINDOW: u32 = 8;
/// Least structural similarity of any window of pictures that look the same [1].
const LEAST_SIMILARITY: f64 = 0.97;
/// Largest mean difference of a channel in any window of pictures that look the same [1/255].
const LARGEST_TINT: f64 = 1.5;

/// What sets two pictures apart.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        /// Least structural similarity of any window [1].
        similarity: f64,
        /// Largest mean difference of a channel in any window, of 255.
        tint: f64,
    },
}

impl Comparison {
    /// Whether nobody would see a difference: what rounding changes, not what a change of the scene does.
    pub fn looks_same(&self) -> bool {
        match self {
            Self::Same => true,
            Self::Sizes { .. } => false,
            Self::Different {
                similarity, tint, ..
            } => *similarity >= LEAST_SIMILARITY && *tint <= LARGEST_TINT,
        }
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Same => write!(f, "the same"),
            Self::Sizes { first, second } => {
                let ([a, b], [c, d]) = ([first.0, first.1], [second.0, second.1]);
                write!(f, "{c} x {d} pixels instead of {a} x {b}")
            }
            Self::Different {
                pixels,
                largest,
                similarity,
                tint,
            } => write!(
                f,
                "{pixels} pixels differ by up to {largest} of 255, similarity {similarity:.3}, tint {tint:.1}"
            ),
        }
    }
}

/// Compares byte by byte and window by window.
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
        return Comparison::Same;
    }
    let step = (WINDOW / 2) as usize;
    let (width, height) = first.dimensions();
    let (similarity, tint) = (0..height)
        .into_par_iter()
        .step_by(step)
        .map(|y| {
            let windows = (0..width)
                .step_by(step)
                .map(|x| window(first, second, x, y));
            windows.fold((1.0, 0.0), worse)
        })
        .reduce(|| (1.0, 0.0), worse);
    Comparison::Different {
        pixels,
        largest,
        similarity,
        tint,
    }
}

fn worse(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Similarity and tint of the window at a corner.
fn window(first: &RgbImage, second: &RgbImage, x: u32, y: u32) -> (f64, f64) {
    const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
    const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);
    let luminance = |p: &Rgb<u8>| {
        let [r, g, b] = p.0.map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (mut n, mut sums, mut tint) = (0.0, [0.0; 5], [0.0; 3]);
    for row in y..(y + WINDOW).min(first.height()) {
        for column in x..(x + WINDOW).min(first.width()) {
            let (p, q) = (first.get_pixel(column, row), second.get_pixel(column, row));
            let (a, b) = (luminance(p), luminance(q));
            n += 1.0;
            for (sum, term) in sums.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                *sum += term;
            }
            for k in 0..3 {
                tint[k] += f64::from(p[k]) - f64::from(q[k]);
            }
        }
    }
    let [a, b, aa, bb, ab] = sums.map(|sum| sum / n);
    let (var_a, var_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    let similarity = (2.0 * a * b + C1) * (2.0 * covariance + C2)
        / ((a * a + b * b + C1) * (var_a + var_b + C2));
    (
        similarity,
        tint.map(|t| f64::abs(t / n))
            .into_iter()
            .fold(0.0, f64::max),
    )
}

/// The first, the second and eight times their difference, side by side.
pub fn side_by_side(first: &RgbImage, second: &RgbImage) -> RgbImage {
    let size = |pick: fn(&RgbImage) -> u32| pick(first).max(pick(second));
    let (width, height) = (size(RgbImage::width), size(RgbImage::height));
    let at = |image: &RgbImage, x, y| {
        image
            .get_pixel_checked(x, y)
            .copied()
            .unwrap_or(Rgb([255; 3]))
    };
    RgbImage::from_fn(3 * width, height, |x, y| {
        let (a, b) = (at(first, x % width, y), at(second, x % width, y));
        match x / width {
            0 => a,
            1 => b,
            _ => Rgb(std::array::from_fn(|k| {
                a[k].abs_diff(b[k]).saturating_mul(8)
            })),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_pixels_and_finds_the_largest_difference() {
        let first = RgbImage::from_pixel(4, 3, Rgb([10, 20, 30]));
        let mut second = first.clone();
        assert_eq!(compare(&first, &second), Comparison::Same);
        second.put_pixel(1, 2, Rgb([10, 27, 28]));
        second.put_pixel(3, 0, Rgb([11, 20, 30]));
        let Comparison::Different {
            pixels, largest, ..
        } = compare(&first, &second)
        else {
            panic!("they differ")
        };
        assert_eq!((pixels, largest), (2, 7));
        assert!(!compare(&first, &RgbImage::new(3, 4)).looks_same());
        let shown = side_by_side(&first, &second);
        assert_eq!(shown.dimensions(), (12, 3));
        assert_eq!(shown.get_pixel(9, 2), &Rgb([0, 56, 16]));
    }

    #[test]
    fn rounding_looks_the_same_and_a_tint_does_not() {
        let first = RgbImage::from_fn(64, 48, |x, y| Rgb([(3 * x) as u8, (5 * y) as u8, 90]));
        let changed = |change: fn(u8) -> u8| {
            RgbImage::from_fn(64, 48, |x, y| Rgb(first.get_pixel(x, y).0.map(change)))
        };
        assert!(compare(&first, &changed(|v| v ^ 1)).looks_same());
        assert!(!compare(&first, &changed(|v| (f64::from(v) * 0.95) as u8)).looks_same());
    }
}
