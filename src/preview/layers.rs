//! From primitives to pixels: the nearest opaque surface of every sample, the glass before it, and their light.

use super::{
    Background, Colour, Material,
    colour::to_srgb,
    exposure::Exposures,
    geometry::{Geometry, NOTHING, Surface},
    panes::{PANES, Panes},
    primitive::Triangle,
    raster::{BAND_ROWS, Band, Samples, bin, cover},
    shade::Rig,
};
use crate::math::Real;
use rayon::prelude::*;

/// Set in a triangle's number where its inside faces the eye.
const INSIDE: u32 = 1 << 31;

/// What a sample sees first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Depth [m].
    pub depth: f32,
    /// Number of the primitive in [`Geometry`].
    pub number: u32,
}

impl Seen {
    pub const NOTHING: Self = Self {
        depth: f32::INFINITY,
        number: NOTHING,
    };

    /// Keeps the nearer; the first of equals.
    fn nearer(&mut self, other: Self) {
        if other.depth < self.depth {
            *self = other;
        }
    }
}

/// What is seen of everything opaque, sample by sample, pixel by pixel: of meshes from `first` on and spheres, before
/// what was seen already.
pub(super) fn opaque(
    geometry: &Geometry,
    first: usize,
    samples: &Samples,
    before: Option<&[Seen]>,
) -> Vec<Seen> {
    let view = &geometry.view;
    let meshes: Vec<_> = (first..geometry.meshes.len())
        .filter(|&m| matches!(geometry.meshes[m].layer.material, Material::Opaque { .. }))
        .map(|m| Binned::new(geometry, m))
        .collect();
    let ball_windows = geometry.ball_windows();
    let ball_bins = bin(&ball_windows, view);

    let mut visible = match before {
        Some(before) => before.to_vec(),
        None => vec![Seen::NOTHING; view.width * view.height * samples.count()],
    };
    visible
        .par_chunks_mut(BAND_ROWS * view.width * samples.count())
        .enumerate()
        .for_each(|(index, visible)| {
            let band = Band::new(index, view);
            for mesh in &meshes {
                mesh.opaque(geometry, &band, index, samples, visible);
            }
            for &i in &ball_bins[index] {
                if let (Some(ball), Some(window)) =
                    (geometry.ball(i as usize), &ball_windows[i as usize])
                {
                    cover(&ball, window, &band, samples, view.near, |at| {
                        visible[at.sample].nearer(Seen {
                            depth: at.depth as f32,
                            number: geometry.first_sphere + i,
                        });
                    });
                }
            }
        });
    visible
}

/// Lights what is seen, lays the glass over it and averages the samples of each pixel: three bytes each.
///
/// With `before`, only those pixels that it says; the others keep their bytes.
pub(super) fn shade(
    geometry: &Geometry,
    samples: &Samples,
    visible: &[Seen],
    exposures: &Exposures,
    panes: &Panes,
    background: Background,
    before: Option<(&[u8], &[bool])>,
) -> Vec<u8> {
    let (view, count) = (&geometry.view, samples.count());
    let (rig, wall) = (Rig::new(view), background.wall());
    let mut bytes = match before {
        Some((before, _)) => before.to_vec(),
        None => vec![0_u8; view.width * view.height * 3],
    };
    bytes
        .par_chunks_mut(BAND_ROWS * view.width * 3)
        .enumerate()
        .for_each(|(index, bytes)| {
            let band = Band::new(index, view);
            let first = band.top * band.width;
            for pixel in 0..band.pixels() {
                if before.is_some_and(|(_, redrawn)| !redrawn[first + pixel]) {
                    continue;
                }
                let (column, row) = (pixel % band.width, pixel / band.width + band.top);
                let corner = [column as Real, row as Real];
                let seen = &visible[(first + pixel) * count..(first + pixel + 1) * count];
                let behind = wall.at(
                    (2.0 * corner[0] + 1.0) / view.width as Real - 1.0,
                    1.0 - (2.0 * corner[1] + 1.0) / view.height as Real,
                );
                let mut colours = [behind; 16];
                for_each_surface(
                    geometry,
                    samples,
                    corner,
                    |s| seen[s].number,
                    |surface, members| {
                        let exposure = exposures.at(column, row, surface.position.z);
                        let lit = rig.light(surface, &exposure);
                        for s in members {
                            colours[s] = lit;
                        }
                    },
                );
                let mut before_it = [[NOTHING; 16]; PANES];
                let mut deepest = 0;
                for (s, seen) in seen.iter().enumerate() {
                    let all = panes.of(index, pixel * count + s).iter();
                    let in_front = all.take_while(|pane| pane.depth < seen.depth);
                    for (k, pane) in in_front.enumerate() {
                        before_it[k][s] = pane.number;
                        deepest = deepest.max(k + 1);
                    }
                }
                for pane in before_it[..deepest].iter().rev() {
                    for_each_surface(
                        geometry,
                        samples,
                        corner,
                        |s| pane[s],
                        |surface, members| {
                            let (lit, opacity) = rig.glass(surface);
                            for s in members {
                                colours[s] = colours[s] * (1.0 - opacity) + lit;
                            }
                        },
                    );
                }

                let sum: Colour = colours[..count].iter().sum();
                bytes[3 * pixel..3 * pixel + 3].copy_from_slice(&to_srgb(&(sum / count as Real)));
            }
        });
    bytes
}

/// Calls `visit` once for every primitive that the samples of a pixel see, at the middle of those that see it.
fn for_each_surface(
    geometry: &Geometry,
    samples: &Samples,
    corner: [Real; 2],
    number: impl Fn(usize) -> u32,
    mut visit: impl FnMut(&Surface, &mut dyn Iterator<Item = usize>),
) {
    let count = samples.count();
    let mut done = 0_u32;
    for s in 0..count {
        let this = number(s);
        if done >> s & 1 == 1 || this == NOTHING {
            continue;
        }
        let (mut members, mut size, mut sum) = (0_u32, 0.0, [0.0; 2]);
        for other in s..count {
            if number(other) == this {
                members |= 1 << other;
                size += 1.0;
                sum[0] += samples.offset[other][0];
                sum[1] += samples.offset[other][1];
            }
        }
        done |= members;
        let (x, y) = (corner[0] + sum[0] / size, corner[1] + sum[1] / size);
        if let Some(surface) = geometry.surface(this, x, y) {
            visit(&surface, &mut (s..count).filter(|m| members >> m & 1 == 1));
        }
    }
}

/// A mesh with its triangles sorted into bands.
pub(super) struct Binned {
    mesh: usize,
    windows: Vec<Option<super::primitive::Window>>,
    bins: Vec<Vec<u32>>,
}

impl Binned {
    pub fn new(geometry: &Geometry, mesh: usize) -> Self {
        let windows = geometry.meshes[mesh].windows(&geometry.view);
        let bins = bin(&windows, &geometry.view);
        Self {
            mesh,
            windows,
            bins,
        }
    }

    /// Whether it does not reach into a band.
    pub fn is_empty_in(&self, band: usize) -> bool {
        self.bins[band].is_empty()
    }

    /// Calls `visit` with triangle number, whether it is a front, and sample, for all that `cut` leaves.
    fn cover(
        &self,
        geometry: &Geometry,
        band: &Band,
        index: usize,
        samples: &Samples,
        mut visit: impl FnMut(u32, bool, usize, f32),
    ) {
        let (mesh, view) = (&geometry.meshes[self.mesh], &geometry.view);
        for &i in &self.bins[index] {
            let shape = mesh.corners(i).and_then(|c| Triangle::new(&c, view));
            if let (Some(shape), Some(window)) = (shape, &self.windows[i as usize]) {
                cover(&shape, window, band, samples, view.near, |at| {
                    let kept = mesh
                        .cut
                        .is_none_or(|cut| !cut.removes(&view.ray(at.x, at.y), at.depth));
                    if kept {
                        visit(i, shape.front, at.sample, at.depth as f32);
                    }
                });
            }
        }
    }

    fn opaque(
        &self,
        geometry: &Geometry,
        band: &Band,
        index: usize,
        samples: &Samples,
        visible: &mut [Seen],
    ) {
        let (mesh, view) = (&geometry.meshes[self.mesh], &geometry.view);
        let Some(cut) = mesh.cut else {
            self.cover(geometry, band, index, samples, |i, _, sample, depth| {
                let number = mesh.first + i;
                visible[sample].nearer(Seen { depth, number });
            });
            return;
        };

        let mut alone = vec![Seen::NOTHING; visible.len()];
        self.cover(geometry, band, index, samples, |i, front, sample, depth| {
            let number = if front { i } else { i | INSIDE };
            alone[sample].nearer(Seen { depth, number });
        });
        for (sample, seen) in alone.into_iter().enumerate() {
            if seen.number == NOTHING {
                continue;
            }
            let inside = seen.number & INSIDE != 0;
            let mut number = mesh.first + (seen.number & !INSIDE);
            let mut depth = seen.depth;
            // Beyond the plane the inside comes first: the plane lies within the solid there, and caps it.
            let (pixel, offset) = (
                sample / samples.count(),
                samples.offset[sample % samples.count()],
            );
            let x = (pixel % band.width) as Real + offset[0];
            let y = (pixel / band.width + band.top) as Real + offset[1];
            if inside
                && let Some(entry) = cut.entry(&view.ray(x, y))
                && entry >= view.near
            {
                depth = entry as f32;
                number = mesh.cap;
            }
            visible[sample].nearer(Seen { depth, number });
        }
    }

    /// Keeps the nearest panes in order.
    pub fn glass(
        &self,
        geometry: &Geometry,
        band: &Band,
        index: usize,
        samples: &Samples,
        panes: &mut [[Seen; PANES]],
    ) {
        let first = geometry.meshes[self.mesh].first;
        self.cover(geometry, band, index, samples, |i, front, sample, depth| {
            if front {
                let mut moving = Seen {
                    depth,
                    number: first + i,
                };
                for pane in &mut panes[sample] {
                    if moving.depth < pane.depth {
                        std::mem::swap(pane, &mut moving);
                    }
                }
            }
        });
    }
}
