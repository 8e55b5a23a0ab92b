//! Which samples a primitive covers: bands of rows side by side, each walking its primitives in order.

use super::{
    camera::View,
    primitive::{Primitive, Window},
};
use crate::math::Real;

/// Rows of pixels a band: small enough to share out, large enough that few primitives fall into two.
pub(super) const BAND_ROWS: usize = 16;

/// Where in a pixel the samples are: k² of them, no two in the same row or column (a rotated grid).
#[derive(Clone, Debug)]
pub(super) struct Samples {
    /// Offsets from the pixel's corner [pixels].
    pub offset: Vec<[Real; 2]>,
}

impl Samples {
    pub fn new(asked: u32) -> Self {
        let side = (1..=4).rev().find(|k| k * k <= asked).unwrap_or(1);
        let k = Real::from(side);
        let offset = (0..side * side)
            .map(|n| (Real::from(n % side), Real::from(n / side)))
            .map(|(i, j)| [(i + (j + 0.5) / k) / k, (j + 1.0 - (i + 0.5) / k) / k])
            .collect();
        Self { offset }
    }

    pub fn count(&self) -> usize {
        self.offset.len()
    }
}

/// Some rows of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// First row.
    pub top: usize,
    /// Number of rows.
    pub rows: usize,
    /// Pixels a row.
    pub width: usize,
}

impl Band {
    /// The band `index` of the picture.
    pub fn new(index: usize, view: &View) -> Self {
        let top = index * BAND_ROWS;
        Self {
            top,
            rows: BAND_ROWS.min(view.height - top),
            width: view.width,
        }
    }

    pub fn pixels(&self) -> usize {
        self.rows * self.width
    }
}

/// Sorts primitives into the bands that they touch, keeping their order.
pub(super) fn bin(windows: &[Option<Window>], view: &View) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); view.height.div_ceil(BAND_ROWS)];
    for (i, window) in windows.iter().enumerate() {
        if let Some(window) = window {
            let [first, end] = window.y.map(|y| y as usize);
            for band in &mut bands[first / BAND_ROWS..end.div_ceil(BAND_ROWS)] {
                band.push(i as u32);
            }
        }
    }
    bands
}

/// A sample that a primitive covers.
pub(super) struct Covered {
    /// Index of the sample in its band: pixel × samples a pixel + sample.
    pub sample: usize,
    /// Position in the picture [pixels].
    pub x: Real,
    /// Position in the picture, downwards [pixels].
    pub y: Real,
    /// Depth [m].
    pub depth: Real,
}

/// Calls `visit` for every sample of `band` that `primitive` covers beyond the near plane.
pub(super) fn cover(
    primitive: &impl Primitive,
    window: &Window,
    band: &Band,
    samples: &Samples,
    near: Real,
    mut visit: impl FnMut(&Covered),
) {
    let top = (window.y[0] as usize).max(band.top);
    let bottom = (window.y[1] as usize).min(band.top + band.rows);
    for row in top..bottom {
        for column in window.x[0] as usize..window.x[1] as usize {
            let pixel = (row - band.top) * band.width + column;
            for (s, offset) in samples.offset.iter().enumerate() {
                let (x, y) = (column as Real + offset[0], row as Real + offset[1]);
                if let Some(depth) = primitive.depth(x, y)
                    && depth >= near
                {
                    let sample = pixel * samples.count() + s;
                    visit(&Covered {
                        sample,
                        x,
                        y,
                        depth,
                    });
                }
            }
        }
    }
}
