//! How much sky and key lamp reaches what each pixel sees, free of noise.
//!
//! Sky and lamp are asked at a spiral of points. The spirals of 4 × 4 pixels are turned against each other, and averaging
//! over just as many pixels of the same surface removes the pattern.

use super::{
    camera::View,
    changes::Changes,
    geometry::{Geometry, NOTHING, Surface},
    layers::Seen,
    occlusion::{self, Neighbourhood},
    raster::Samples,
    shade::Exposure,
    shadow::Shadow,
};
use crate::math::Real;
use rayon::prelude::*;

/// Points of a spiral.
const TAPS: usize = 16;
/// Side of the pattern of turned spirals [pixels].
const TILE: usize = 4;
/// Farthest pixel, along a row or column, that an exposure is averaged with.
pub(super) const SPREAD: i64 = TILE as i64 - 2;
/// Pixels belong to the same surface if their depths differ by less, in reaches of the occlusion.
const SAME: Real = 0.3;

/// Exposure pixel by pixel, and how far away the surface is that it belongs to.
pub(super) struct Exposures {
    /// Shares of sky and key lamp, as each pixel's own spiral found them.
    raw: Vec<[f32; 2]>,
    /// The same, averaged.
    shares: Vec<[f32; 2]>,
    depth: Vec<f32>,
    width: usize,
    /// Largest difference of depth on one surface, in depths.
    same: Real,
}

/// Measures it for what the first sample of every pixel sees.
pub(super) fn measure(
    geometry: &Geometry,
    samples: &Samples,
    visible: &[Seen],
    shadow: Option<&Shadow>,
) -> Exposures {
    let view = &geometry.view;
    let everywhere = Exposures {
        raw: vec![[1.0; 2]; view.width * view.height],
        shares: vec![[1.0; 2]; view.width * view.height],
        width: view.width,
        same: SAME * occlusion::reach(view) / view.focal,
        depth: Vec::new(),
    };
    let all = vec![true; view.width * view.height];
    everywhere.again(&all, geometry, samples, visible, shadow)
}

/// What the first sample of a pixel sees.
fn first_surface(
    geometry: &Geometry,
    samples: &Samples,
    visible: &[Seen],
    pixel: usize,
) -> Option<Surface> {
    let number = visible[pixel * samples.count()].number;
    let (column, row) = (pixel % geometry.view.width, pixel / geometry.view.width);
    let [x, y] = samples.offset[0];
    (number != NOTHING)
        .then(|| geometry.surface(number, column as Real + x, row as Real + y))
        .flatten()
}

/// Where in the lamp's view each pixel's surface is; not finite if the lamp does not see there.
pub(super) fn lamp_places(
    geometry: &Geometry,
    samples: &Samples,
    visible: &[Seen],
    shadow: Option<&Shadow>,
) -> Vec<[f32; 2]> {
    (0..geometry.view.width * geometry.view.height)
        .into_par_iter()
        .map(|pixel| {
            shadow
                .zip(first_surface(geometry, samples, visible, pixel))
                .map_or([f32::NAN; 2], |(shadow, surface)| shadow.place(&surface))
        })
        .collect()
}

/// How many pixels away something may hide sky.
pub(super) fn sky_reach(view: &View) -> i64 {
    occlusion::reach(view).ceil() as i64 + 2
}

impl Exposures {
    /// With those pixels measured anew that are `touched`, after something has moved.
    pub fn again(
        &self,
        touched: &[bool],
        geometry: &Geometry,
        samples: &Samples,
        visible: &[Seen],
        shadow: Option<&Shadow>,
    ) -> Self {
        let (view, count) = (&geometry.view, samples.count());
        let depth: Vec<f32> = visible.iter().step_by(count).map(|s| s.depth).collect();
        let spirals = spirals();
        let around = Neighbourhood::new(view, samples.offset[0], &depth, &spirals);
        let raw: Vec<[f32; 2]> = (0..touched.len())
            .into_par_iter()
            .map(|pixel| {
                if !touched[pixel] {
                    return self.raw[pixel];
                }
                let surface = first_surface(geometry, samples, visible, pixel);
                surface.map_or([1.0; 2], |surface| {
                    let (column, row) = (pixel % view.width, pixel / view.width);
                    let pattern = column % TILE + TILE * (row % TILE);
                    let sky = around.open(pixel, &surface.normal, pattern);
                    let lit = |shadow: &Shadow| shadow.lit(&surface, &spirals[pattern]);
                    let key = shadow.map_or(1.0, lit);
                    [sky as f32, key as f32]
                })
            })
            .collect();

        let near = Changes::new(view.width, touched);
        let mut again = Self {
            raw,
            shares: Vec::new(),
            depth,
            ..*self
        };
        again.shares = (0..touched.len())
            .into_par_iter()
            .map(|pixel| {
                if near.near(pixel, SPREAD) {
                    again.tile_mean(pixel)
                } else {
                    self.shares[pixel]
                }
            })
            .collect();
        again
    }

    /// The exposure of a surface `depth` [m] away in a pixel: that of the neighbour that is most like it.
    pub fn at(&self, column: usize, row: usize, depth: Real) -> Exposure {
        let here = row * self.width + column;
        let misfit = |pixel: usize| (Real::from(self.depth[pixel]) - depth).abs();
        let mut best = here;
        if misfit(here) > self.same * depth {
            let beside = [
                (column > 0).then(|| here - 1),
                (column + 1 < self.width).then_some(here + 1),
                here.checked_sub(self.width),
                Some(here + self.width).filter(|&p| p < self.depth.len()),
            ];
            for pixel in beside.into_iter().flatten() {
                if misfit(pixel) < misfit(best) {
                    best = pixel;
                }
            }
        }
        let [sky, key] = self.shares[best].map(Real::from);
        Exposure { sky, key }
    }

    /// Mean over the pixels around, as many as the pattern has, that see the same surface.
    fn tile_mean(&self, pixel: usize) -> [f32; 2] {
        let (width, height) = (self.width, self.raw.len() / self.width);
        let (column, row) = (pixel % width, pixel / width);
        let here = self.depth[pixel];
        if !here.is_finite() {
            return [1.0; 2];
        }
        let limit = self.same as f32 * here;
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for r in row.saturating_sub(1)..(row + TILE - 1).min(height) {
            for c in column.saturating_sub(1)..(column + TILE - 1).min(width) {
                let other = r * width + c;
                if (self.depth[other] - here).abs() <= limit {
                    sum[0] += self.raw[other][0];
                    sum[1] += self.raw[other][1];
                    count += 1.0;
                }
            }
        }
        sum.map(|s| s / count)
    }
}

/// Points of the unit disc, denser towards its middle, for every place in the pattern.
fn spirals() -> Vec<[[Real; 2]; TAPS]> {
    // An ordered dither matrix, so that close pixels are turned far apart.
    const ORDER: [usize; TILE * TILE] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    const GOLDEN_ANGLE: Real = 2.399_963_229_728_653;
    ORDER
        .iter()
        .map(|&order| {
            let shift = order as Real / ORDER.len() as Real;
            core::array::from_fn(|tap| {
                let radius = (tap as Real + shift) / TAPS as Real;
                let angle = GOLDEN_ANGLE * tap as Real + core::f64::consts::TAU * shift;
                [radius * libm::cos(angle), radius * libm::sin(angle)]
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::preview::{Camera, Colour, Colours, Material, MeshLayer, layers};

    #[test]
    fn a_plain_floor_is_open_and_a_corner_darkens_towards_its_edge() {
        let corner = |x: Real, y: Real, z: Real| Vec3::new(x, y, z);
        let floor = [
            corner(-1.0, -1.0, 0.0),
            corner(1.0, -1.0, 0.0),
            corner(1.0, 0.0, 0.0),
            corner(-1.0, 0.0, 0.0),
        ];
        let wall = [
            floor[3],
            floor[2],
            corner(1.0, 0.0, 1.0),
            corner(-1.0, 0.0, 1.0),
        ];
        let positions = [floor, wall].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let open = |triangles: &[[u32; 3]]| {
            let meshes = [MeshLayer {
                positions: &positions,
                triangles,
                normals: None,
                colours: Colours::Uniform(Colour::repeat(0.5)),
                material: Material::BONE,
                cut: None,
            }];
            let camera = Camera {
                position: corner(0.0, -2.0, 2.0),
                target: Vec3::zeros(),
                up: Vec3::z(),
                field_of_view: 0.5,
            };
            let geometry = Geometry::new(&meshes, &[], camera.view(160, 160));
            let samples = Samples::new(4);
            let visible = layers::opaque(&geometry, 0, &samples, None);
            let exposures = measure(&geometry, &samples, &visible, None);
            // The edge is in the middle row; rows below it look at the floor.
            [81, 84, 87, 120].map(|row| {
                let seen = visible[(row * 160 + 80) * 4];
                assert!(seen.number < 2);
                exposures.at(80, row, Real::from(seen.depth)).sky
            })
        };
        assert_eq!(open(&triangles[..2]), [1.0; 4]);
        let [edge, near, far, away] = open(&triangles);
        assert!(
            edge < near && near < far && far < away,
            "{edge} {near} {far} {away}"
        );
        assert!(edge < 0.85 && away == 1.0, "{edge} {near} {far} {away}");
    }
}
