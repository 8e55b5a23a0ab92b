//! A picture of three slices through a bone: what is solid, and how far pores reach from their walls.

use super::FlowError;
use crate::grid::BrickGrid;
use crate::ink::Pen;
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{Lattice, TriMesh, inside_columns};
use image::{Rgb, RgbImage};

/// Pixels along the longest edge of the bone.
const LONGEST: Real = 560.0;
/// Pixels between panels and around them.
const GAP: u32 = 10;
/// Pixels above the panels for their titles, and below them for what the colours mean.
const LINE: u32 = 26;
const TEXT: Pen = Pen {
    size: 9.0,
    ink: [40, 40, 40],
    halo: PAPER,
};
/// Length of the bar by which sizes are read [m].
const BAR: Real = 10e-3;
const PAPER: [u8; 3] = [255, 255, 255];
const AROUND: [u8; 3] = [226, 226, 224];
const SOLID: [u8; 3] = [92, 74, 58];
/// Pores this far from their walls, in spacings, have the full colour.
const WIDE: Real = 1.5;
/// Pixels that the line below the panels is long at most.
const MOST_WORDS: u32 = 900;
const AXES: [char; 3] = ['x', 'y', 'z'];
const PORE: [[u8; 3]; 2] = [[252, 238, 214], [24, 104, 178]];

/// Slices through `point` across x, y and z, side by side: solid brown, pores the bluer the farther their walls are.
/// Only the part of the bone within `built` is shown. Titles say where, a bar how large, and a line below what is what.
pub(super) fn draw(
    solid: &BrickGrid,
    bone: &TriMesh,
    built: &Aabb,
    point: &Vec3,
    spacing: Real,
) -> RgbImage {
    let mut bounds = bone.bounds();
    bounds.min = bounds.min.sup(&built.min);
    bounds.max = bounds.max.inf(&built.max);
    if bounds.is_empty() {
        return RgbImage::from_pixel(1, 1, Rgb(PAPER));
    }
    let pixel = bounds.extent().max() / LONGEST;
    let count = bounds
        .extent()
        .map(|e| (e / pixel).ceil().max(1.0) as usize);
    // Horizontal and vertical axis of each panel.
    let panels = [[1, 2], [0, 2], [0, 1]];
    let width: u32 = panels.iter().map(|[u, _]| count[*u] as u32 + GAP).sum();
    let height = panels
        .iter()
        .map(|[_, v]| count[*v] as u32)
        .max()
        .unwrap_or(1);
    // Narrow slices need room for the words below them.
    let width = (width + GAP).max(MOST_WORDS);
    let top = GAP + LINE;
    let mut picture = RgbImage::from_pixel(width, top + height + GAP + LINE, Rgb(PAPER));
    let mut left = GAP;
    for (across, [u, v]) in panels.into_iter().enumerate() {
        let mut lattice = Lattice {
            origin: bounds.min.add_scalar(0.5 * pixel),
            step: pixel,
            count: [count.x, count.y, count.z],
        };
        lattice.origin[across] = point[across];
        lattice.count[across] = 1;
        let inside = inside_columns(bone, &lattice);
        for (index, inside) in inside.iter().enumerate() {
            let x = lattice.position(index);
            let place = |axis: usize| ((x[axis] - bounds.min[axis]) / pixel) as u32;
            let row = height - 1 - place(v).min(height - 1) + top;
            picture.put_pixel(
                left + place(u),
                row,
                Rgb(shade(solid, &x, *inside, spacing)),
            );
        }
        let title = format!(
            "{}–{} plane at {} = {:.1} mm",
            AXES[u],
            AXES[v],
            AXES[across],
            point[across] * 1e3
        );
        let above = top + height - count[v] as u32;
        TEXT.write(&mut picture, &title, left.into(), Real::from(above) - 9.0);
        left += count[u] as u32 + GAP;
    }
    key(
        &mut picture,
        Real::from(top + height + LINE),
        spacing,
        pixel,
    );
    picture
}

/// What the colours mean, and how long a centimetre is, on the line that ends at `below` [pixels].
fn key(picture: &mut RgbImage, below: Real, spacing: Real, pixel: Real) {
    let mut x = Real::from(GAP);
    let bar = BAR / pixel;
    let middle = below - 5.0;
    TEXT.stroke(picture, &[vec![[x, middle], [x + bar, middle]]]);
    let words = format!("{:.0} mm", BAR * 1e3);
    TEXT.write(picture, &words, x + bar + 8.0, below);
    x += bar + TEXT.width(&words) + 32.0;
    let wide = format!("pore, {:.2} mm from bone or more", WIDE * spacing * 1e3);
    for (colour, words) in [
        (SOLID, "bone"),
        (PORE[0], "pore at bone"),
        (PORE[1], wide.as_str()),
        (AROUND, "outside"),
    ] {
        for (column, row) in (0..144).map(|n| (n % 12, n / 12)) {
            let at = [x as u32 + column, below as u32 - 11 + row];
            if at[0] < picture.width() && at[1] < picture.height() {
                picture.put_pixel(at[0], at[1], Rgb(colour));
            }
        }
        TEXT.write(picture, words, x + 18.0, below);
        x += TEXT.width(words) + 42.0;
    }
}

fn shade(solid: &BrickGrid, x: &Vec3, inside: bool, spacing: Real) -> [u8; 3] {
    let phi = solid.value(x);
    if phi < 0.0 {
        return SOLID;
    }
    if !inside {
        return AROUND;
    }
    let t = (phi / (WIDE * spacing)).min(1.0);
    std::array::from_fn(|k| {
        let [near, far] = [PORE[0][k], PORE[1][k]].map(Real::from);
        (near + (far - near) * t).round() as u8
    })
}

/// The picture as a PNG file.
pub(super) fn write(path: &std::path::Path, picture: &RgbImage) -> Result<(), FlowError> {
    let bytes = super::preview::png(path, picture)?;
    Ok(crate::cache::write(path, &bytes)?)
}
