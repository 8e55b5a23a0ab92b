//! Writes text and draws lines: strokes with smooth edges, and a halo that keeps letters readable on anything.

use super::font::{BASELINE, CAPITAL, strokes};
use crate::math::Real;
use image::RgbImage;

/// Lettering of one size and colour.
#[derive(Clone, Copy, Debug)]
pub struct Pen {
    /// Height of a capital [pixels].
    pub size: Real,
    /// sRGB of the strokes.
    pub ink: [u8; 3],
    /// sRGB of the halo.
    pub halo: [u8; 3],
}

impl Pen {
    /// Width of `text` [pixels].
    pub fn width(&self, text: &str) -> Real {
        text.chars().map(|c| strokes(c).1).sum::<Real>() * self.size / CAPITAL
    }

    /// Writes `text` with its baseline starting at (x, y), y downwards [pixels].
    pub fn write(&self, image: &mut RgbImage, text: &str, x: Real, y: Real) {
        let scale = self.size / CAPITAL;
        let (mut pen, mut lines) = (x, Vec::new());
        for letter in text.chars() {
            let (polylines, advance) = strokes(letter);
            let place = |p: &[Real; 2]| [pen + p[0] * scale, y - (p[1] - BASELINE) * scale];
            lines.extend(
                polylines
                    .iter()
                    .map(|line| line.iter().map(place).collect()),
            );
            pen += advance * scale;
        }
        self.stroke(image, &lines);
    }

    /// Draws lines [pixels] with round ends and the width of the pen.
    pub fn stroke(&self, image: &mut RgbImage, lines: &[Vec<[Real; 2]>]) {
        let half_width = (0.062 * self.size).max(0.55);
        let halo_width = 0.16 * self.size + 1.0;
        let field = Field::around(lines, half_width + halo_width + 1.0, image);
        for (column, row, distance) in field.pixels() {
            let beyond = distance - half_width;
            let halo = 0.6 * ((halo_width + 0.5 - beyond) / halo_width).clamp(0.0, 1.0);
            blend(image, column, row, self.halo, halo);
            blend(image, column, row, self.ink, (0.5 - beyond).clamp(0.0, 1.0));
        }
    }
}

/// Draws lines [pixels] of a given width with round ends; a line of one point twice is a dot.
pub fn draw_lines(image: &mut RgbImage, lines: &[Vec<[Real; 2]>], width: Real, colour: [u8; 3]) {
    let field = Field::around(lines, 0.5 * width + 1.0, image);
    for (column, row, distance) in field.pixels() {
        let opacity = (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
        blend(image, column, row, colour, opacity);
    }
}

/// Distance of pixels from the nearest of some lines, as far as `reach`.
struct Field {
    left: u32,
    top: u32,
    width: u32,
    squared: Vec<Real>,
    reach: Real,
}

impl Field {
    fn around(lines: &[Vec<[Real; 2]>], reach: Real, image: &RgbImage) -> Self {
        let [left, top, right, bottom] = window(lines.iter().flatten(), reach, image);
        let (width, height) = (right.saturating_sub(left), bottom.saturating_sub(top));
        let mut squared = vec![Real::INFINITY; width as usize * height as usize];
        for ends in lines.iter().flat_map(|line| line.windows(2)) {
            let [x0, y0, x1, y1] = window(ends, reach, image);
            for row in y0..y1 {
                for column in x0..x1 {
                    let at = [Real::from(column) + 0.5, Real::from(row) + 0.5];
                    let here = &mut squared[((row - top) * width + column - left) as usize];
                    *here = here.min(distance_squared(at, ends[0], ends[1]));
                }
            }
        }
        Self {
            left,
            top,
            width,
            squared,
            reach,
        }
    }

    /// Column, row and distance.
    fn pixels(&self) -> impl Iterator<Item = (u32, u32, Real)> {
        let near = self.squared.iter().enumerate();
        near.filter(|(_, squared)| **squared < self.reach * self.reach)
            .map(|(i, squared)| {
                let (column, row) = (i as u32 % self.width, i as u32 / self.width);
                (self.left + column, self.top + row, squared.sqrt())
            })
    }
}

/// Left, top, right and bottom of the pixels within `reach` of the box around `points`.
fn window<'a>(
    points: impl IntoIterator<Item = &'a [Real; 2]>,
    reach: Real,
    image: &RgbImage,
) -> [u32; 4] {
    let (mut low, mut high) = ([Real::INFINITY; 2], [Real::NEG_INFINITY; 2]);
    for point in points {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let clamp = |v: Real, end: u32| v.clamp(0.0, Real::from(end)) as u32;
    [
        clamp((low[0] - reach).floor(), image.width()),
        clamp((low[1] - reach).floor(), image.height()),
        clamp((high[0] + reach).ceil(), image.width()),
        clamp((high[1] + reach).ceil(), image.height()),
    ]
}

/// Mixes sRGB `colour` into a pixel.
pub fn blend(image: &mut RgbImage, column: u32, row: u32, colour: [u8; 3], opacity: Real) {
    let pixel = image.get_pixel_mut(column, row);
    for k in 0..3 {
        let (old, new) = (Real::from(pixel[k]), Real::from(colour[k]));
        pixel[k] = (old + (new - old) * opacity).round() as u8;
    }
}

fn distance_squared(at: [Real; 2], from: [Real; 2], to: [Real; 2]) -> Real {
    let along = [to[0] - from[0], to[1] - from[1]];
    let offset = [at[0] - from[0], at[1] - from[1]];
    let length_squared = along[0] * along[0] + along[1] * along[1];
    let t = if length_squared > 0.0 {
        ((offset[0] * along[0] + offset[1] * along[1]) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (dx, dy) = (offset[0] - along[0] * t, offset[1] - along[1] * t);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn text_fills_its_width_and_height_and_nothing_else() {
        let paper = [250; 3];
        let pen = Pen {
            size: 18.0,
            ink: [0; 3],
            halo: paper,
        };
        let mut image = RgbImage::from_pixel(300, 60, Rgb(paper));
        pen.write(&mut image, "H 12.5 mm H", 20.0, 40.0);
        let inked: Vec<_> = image
            .enumerate_pixels()
            .filter(|(_, _, p)| p[0] < 120)
            .map(|(x, y, _)| (f64::from(x) + 0.5, f64::from(y) + 0.5))
            .collect();
        let edge = |f: fn(f64, f64) -> f64, start: f64, pick: fn(&(f64, f64)) -> f64| {
            inked.iter().map(pick).fold(start, f)
        };
        assert!((edge(f64::min, 1e9, |p| p.0) - 20.0).abs() <= 1.5);
        assert!(
            (edge(f64::max, 0.0, |p| p.0) - (20.0 + pen.width("H 12.5 mm H") - 5.2)).abs() <= 1.5
        );
        assert!((edge(f64::max, 0.0, |p| p.1) - 40.0).abs() <= 1.5);
        assert!((edge(f64::min, 1e9, |p| p.1) - 22.0).abs() <= 1.5);
    }

    #[test]
    fn writing_outside_the_picture_is_harmless() {
        let pen = Pen {
            size: 12.0,
            ink: [0; 3],
            halo: [255; 3],
        };
        let mut image = RgbImage::new(8, 8);
        for (x, y) in [
            (-500.0, 4.0),
            (500.0, 4.0),
            (0.0, -300.0),
            (2.0, 400.0),
            (-3.0, 9.0),
        ] {
            pen.write(&mut image, "osteoflow ∞", x, y);
        }
        pen.write(&mut RgbImage::new(0, 0), "none", 0.0, 0.0);
    }
}
