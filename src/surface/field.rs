//! The colour field around the particles, less what is solid, on the bricks where it is not 0.
//!
//! ```text
//! φ(x) = Σ_j V_j W(x − x_j),   V_j = 1 / Σ_k W(x_j − x_k)
//! f(x) = min(φ(x) − threshold, s (d(x) + overlap))
//! ```
//!
//! φ is about 1 inside and falls to 0 outside. V_j is the volume that particle j stands for among its neighbours; with
//! the volume at rest instead, drops and filaments of a few particles would vanish. d is the distance from everything
//! solid, so f > 0 is cement: a smooth field between particles on both sides of a strut would bury it.

use super::SurfaceSettings;
use super::cubes::Brick;
use crate::cache::Frame;
use crate::grid::{BRICK, PointBricks};
use crate::math::{Real, Vec3};
use crate::solid::Solid;
use rayon::prelude::*;

/// Slope of f across the face of a solid [1/spacing]: that of φ across a free surface, so that they meet evenly.
const CONTACT_SLOPE: Real = 0.5;
/// Neighbours of a particle without a surface within reach, less one that may be missing beside it: 13.5 on a lattice at a
/// support of four particle radii. Where all have them, φ is above [`FULL`] for sure, and not computed.
const SURROUNDED: f32 = 12.25;
/// φ in the middle of such a gap.
const FULL: f32 = 0.67;
/// How steep φ is taken to be at most [1/spacing].
const STEEPEST: Real = 1.0;

/// Particles sorted for the field, and the field.
pub(super) struct Field {
    /// Edge of a cube [m].
    pub cube: Real,
    pub points: PointBricks,
    /// V_j of each sorted particle, up to a factor.
    pub volume: Vec<f32>,
    /// How many neighbours each sorted particle has: Σ (1 − q²)₊, the particle itself included.
    pub neighbours: Vec<f32>,
    /// Bricks where φ may be above 0, ascending.
    pub keys: Vec<[i32; 3]>,
    /// f on each of them.
    pub bricks: Vec<Brick>,
    /// f where there is no brick.
    pub outside: f32,
}

impl Field {
    pub fn new(frame: &Frame, solid: Option<&Solid>, settings: &SurfaceSettings) -> Self {
        let cube = settings.cube * frame.spacing;
        let points = PointBricks::new(&frame.position, cube, settings.smoothing * frame.spacing);
        let (volume, neighbours) = points
            .map_points(
                |_| (),
                |near, (), at, _| {
                    let [sum, neighbours] = near.crowding(at);
                    (1.0 / sum, neighbours)
                },
            )
            .into_iter()
            .unzip();
        let keys = points.touched();
        let mut field = Self {
            cube,
            points,
            volume,
            neighbours,
            keys,
            bricks: Vec::new(),
            outside: -settings.threshold as f32,
        };
        let least = field.points.brick_least(&field.neighbours);
        let limit = (settings.smoothing == 2.0 && settings.threshold as f32 <= FULL - 0.05)
            .then_some(SURROUNDED);
        let wall = solid.map(|solid| Wall {
            solid,
            slope: CONTACT_SLOPE / frame.spacing,
            overlap: settings.wall_overlap * frame.spacing,
            cube,
        });
        field.bricks = field
            .keys
            .par_iter()
            .map(|&key| {
                let wall = wall.as_ref().filter(|wall| wall.is_near(key));
                let full = |limit| field.points.all_around(key, &least, limit);
                if wall.is_none() && limit.is_some_and(full) {
                    return Brick::Uniform(1.0 + field.outside);
                }
                field.brick(key, wall, settings)
            })
            .collect();
        field
    }

    fn brick(&self, key: [i32; 3], wall: Option<&Wall>, settings: &SurfaceSettings) -> Brick {
        let near = self.points.near(key);
        let [mut values] = near.node_sums(|j| [self.volume[j]]);
        for value in values.iter_mut() {
            *value += self.outside;
        }
        if let Some(wall) = wall {
            wall.cut(key, &mut values);
        }
        let least = values.iter().copied().fold(f32::INFINITY, f32::min);
        let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        // Neighbouring nodes cannot lie on the other side, so no cut asks for the values.
        let certain = (STEEPEST * settings.cube) as f32;
        if least > certain {
            Brick::Uniform(least)
        } else if most < -certain || most <= self.outside {
            Brick::Uniform(most)
        } else {
            Brick::Nodes(values)
        }
    }
}

/// What is solid, seen from the lattice.
struct Wall<'a> {
    solid: &'a Solid,
    /// [1/m]
    slope: Real,
    /// How far into the solid the wall is taken to lie [m].
    overlap: Real,
    cube: Real,
}

impl Wall<'_> {
    /// Whether anything solid may cut the cubes of a brick.
    fn is_near(&self, key: [i32; 3]) -> bool {
        let half = 0.5 * Real::from(BRICK) * self.cube;
        let middle = Vec3::from(key.map(|k| Real::from(k * BRICK))) * self.cube;
        let farthest = libm::sqrt(3.0) * half * self.slope + 1.0;
        self.solid.phi(&middle.add_scalar(half)) * self.slope <= farthest
    }

    fn cut(&self, key: [i32; 3], values: &mut [f32; 512]) {
        let first = Vec3::from(key.map(|k| Real::from(k * BRICK))) * self.cube;
        for (node, value) in values.iter_mut().enumerate() {
            // What lies well outside the cement does so on the other side of a wall as well.
            if *value > -0.5 {
                let place = [node >> 6, node >> 3 & 7, node & 7].map(|n| n as Real);
                let x = first + Vec3::from(place) * self.cube;
                let distance = self.solid.phi(&x) + self.overlap;
                *value = value.min((distance * self.slope) as f32);
            }
        }
    }
}
