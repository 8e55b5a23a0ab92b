//! A picture of three slices through a bone: what is solid, and how far pores reach from their walls.

use super::FlowError;
use crate::grid::BrickGrid;
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{Lattice, TriMesh, inside_columns};
use image::{Rgb, RgbImage};

/// Pixels along the longest edge of the bone.
const LONGEST: Real = 560.0;
/// Pixels between panels and around them.
const GAP: u32 = 10;
const PAPER: [u8; 3] = [255, 255, 255];
const AROUND: [u8; 3] = [226, 226, 224];
const SOLID: [u8; 3] = [92, 74, 58];
/// Pores this far from their walls, in spacings, have the full colour.
const WIDE: Real = 1.5;
const PORE: [[u8; 3]; 2] = [[252, 238, 214], [24, 104, 178]];

/// Slices through `point` across x, y and z, side by side: solid brown, pores the bluer the farther their walls are.
/// Only the part of the bone within `built` is shown.
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
    let mut picture = RgbImage::from_pixel(width + GAP, height + 2 * GAP, Rgb(PAPER));
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
            let row = height - 1 - place(v).min(height - 1) + GAP;
            picture.put_pixel(
                left + place(u),
                row,
                Rgb(shade(solid, &x, *inside, spacing)),
            );
        }
        left += count[u] as u32 + GAP;
    }
    picture
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
