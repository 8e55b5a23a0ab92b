//! Permeability of a porous cube, measured: creeping flow through it, driven by a body force.
//!
//! ```text
//! f_i(x + c_i, t + 1) = f_i − ω⁺ (f⁺ − e⁺) − ω⁻ (f⁻ − e⁻) + 3 w_i c_i·g,     e_i = w_i (ρ + 3 c_i·j)
//! k = ν U/g · voxel²,     ν = (1/ω⁺ − ½)/3,     (1/ω⁺ − ½)(1/ω⁻ − ½) = 3/16
//! ```
//!
//! Two-relaxation-time lattice Boltzmann without its inertial term, that is Stokes flow; with that product of rates,
//! walls lie halfway between nodes whatever the viscosity [Ginzburg08]. The cube repeats itself on all sides: where
//! its faces do not fit each other, some ways are closed that would go on. Nothing here knows particles.

use crate::math::{Real, Vec3, Wide, ordered_sum, widest};
use rayon::prelude::*;

/// Directions of D3Q19: after the first, each is followed by its opposite.
const C: [[i32; 3]; Q] = [
    [0, 0, 0],
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
    [1, 1, 0],
    [-1, -1, 0],
    [1, -1, 0],
    [-1, 1, 0],
    [1, 0, 1],
    [-1, 0, -1],
    [1, 0, -1],
    [-1, 0, 1],
    [0, 1, 1],
    [0, -1, -1],
    [0, 1, -1],
    [0, -1, 1],
];
const Q: usize = 19;
/// Voxels of a row that are handled at once.
const LANES: usize = 8;

/// 1/ω⁺: a viscosity of 1/3, with which flow settles fast.
const EVEN_TIME: f32 = 1.5;
/// 1/ω⁻.
const ODD_TIME: f32 = 0.5 + 3.0 / 16.0 / (EVEN_TIME - 0.5);
/// Driving force; the flow is linear in it.
const FORCE: f32 = 1e-4;
/// Steps between looks at the mean flow.
const PAUSE: usize = 50;
/// The flow has settled when it changes by less than this share between looks.
const SETTLED: Real = 2e-4;
/// Flow slower than this share of the force is none.
const STILL: Real = 1e-3;
/// More steps are not taken.
const MOST_STEPS: usize = 20_000;

fn weight(i: usize) -> f32 {
    match i {
        0 => 1.0 / 3.0,
        1..=6 => 1.0 / 18.0,
        _ => 1.0 / 36.0,
    }
}

/// A cube of voxels.
pub struct Sample {
    /// Voxels along an edge.
    pub edge: usize,
    /// Edge of a voxel [m].
    pub voxel: Real,
    /// Whether each is solid, z running fastest.
    pub solid: Vec<bool>,
}

impl Sample {
    /// The cube of `edge` voxels around `centre` [m], solid where φ is below zero.
    pub fn cut(
        centre: &Vec3,
        edge: usize,
        voxel: Real,
        phi: impl Fn(&Vec3) -> Real + Sync,
    ) -> Self {
        let first = centre.add_scalar(-0.5 * (edge as Real - 1.0) * voxel);
        let solid = (0..edge.pow(3)).into_par_iter().map(|n| {
            let place = [n / (edge * edge), n / edge % edge, n % edge];
            phi(&(first + Vec3::from(place.map(|p| p as Real)) * voxel)) < 0.0
        });
        Self {
            edge,
            voxel,
            solid: solid.collect(),
        }
    }

    /// Open share [1].
    pub fn porosity(&self) -> Real {
        let open = self.solid.iter().filter(|solid| !**solid).count();
        open as Real / self.solid.len().max(1) as Real
    }

    /// Permeability along axis 0, 1 or 2 [m²]; none if the flow has not settled.
    pub fn permeability(&self, axis: usize) -> Option<Real> {
        let rows = Rows::new(self);
        let mut now = vec![0.0_f32; self.edge * rows.plane()];
        let mut next = now.clone();
        let push = std::array::from_fn(|i| 3.0 * weight(i) * C[i][axis] as f32 * FORCE);
        let mut last = 0.0;
        for step in 1..=MOST_STEPS {
            next.par_chunks_mut(rows.plane())
                .enumerate()
                .for_each(|(x, plane)| {
                    widest(PlaneStep {
                        rows: &rows,
                        now: &now,
                        push: &push,
                        x,
                        plane,
                    });
                });
            std::mem::swap(&mut now, &mut next);
            if step % PAUSE == 0 {
                let mean = rows.mean_flow(&now, axis);
                let change = (mean - last).abs();
                if change <= SETTLED * mean.abs() || mean.abs() <= STILL * Real::from(FORCE) {
                    let viscosity = Real::from(EVEN_TIME - 0.5) / 3.0;
                    let per_force = mean.max(0.0) / Real::from(FORCE);
                    return Some(viscosity * per_force * self.voxel * self.voxel);
                }
                last = mean;
            }
        }
        None
    }
}

/// How a cube lies in memory: planes across x, in each the 19 directions, in each the rows along z. A row begins with
/// a copy of its last voxel; after its voxels comes a copy of the first, then solid to fill up the lanes.
struct Rows {
    edge: usize,
    /// Values from one row to the next.
    stride: usize,
    /// Rows of 1 where solid, 0 where open.
    solid: Vec<f32>,
}

impl Rows {
    fn new(sample: &Sample) -> Self {
        let edge = sample.edge;
        let stride = edge.next_multiple_of(LANES) + 2;
        let mut solid = vec![1.0; edge * edge * stride];
        for (row, of_row) in solid.chunks_mut(stride).zip(sample.solid.chunks(edge)) {
            for (to, from) in row[1..].iter_mut().zip(of_row) {
                *to = f32::from(u8::from(*from));
            }
            row[0] = row[edge];
            row[edge + 1] = row[1];
        }
        Self {
            edge,
            stride,
            solid,
        }
    }

    fn plane(&self) -> usize {
        Q * self.edge * self.stride
    }

    /// Where the row (x, y) of direction `i` begins.
    #[inline(always)]
    fn row(&self, x: usize, i: usize, y: usize) -> usize {
        ((x * Q + i) * self.edge + y) * self.stride
    }

    /// Mean velocity of all voxels along `axis`, halfway through the push of the collision.
    fn mean_flow(&self, now: &[f32], axis: usize) -> Real {
        let n = self.edge;
        let of_row = |row: usize| {
            let (x, y) = (row / n, row % n);
            let solid = &self.solid[row * self.stride + 1..][..n];
            let moved: Real = (1..Q)
                .filter(|&i| C[i][axis] != 0)
                .map(|i| {
                    let values = &now[self.row(x, i, y) + 1..][..n];
                    let sum: Real = values.iter().map(|&f| Real::from(f)).sum();
                    sum * Real::from(C[i][axis])
                })
                .sum();
            let open = solid.iter().filter(|s| **s == 0.0).count() as Real;
            moved - 0.5 * Real::from(FORCE) * open
        };
        ordered_sum(n * n, of_row) / (n * n * n) as Real
    }
}

/// One step of the voxels of a plane across x: what arrives is collided and pushed.
struct PlaneStep<'a> {
    rows: &'a Rows,
    now: &'a [f32],
    push: &'a [f32; Q],
    x: usize,
    plane: &'a mut [f32],
}

/// One value of eight voxels.
type Lane = [f32; LANES];

impl Wide for PlaneStep<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let (rows, n) = (self.rows, self.rows.edge);
        let lane = |of: &[f32], at: usize| -> Lane { *of[at..].first_chunk().expect("a full row") };
        let back = |place: usize, c: i32| (place as i32 + n as i32 - c) as usize % n;
        for y in 0..n {
            // Where each direction comes from, and whether that is solid.
            let from: [(usize, usize); Q] = std::array::from_fn(|i| {
                let [cx, cy, cz] = C[i];
                let (x, y) = (back(self.x, cx), back(y, cy));
                let z = (1 - cz) as usize;
                (rows.row(x, i, y) + z, (x * n + y) * rows.stride + z)
            });
            let here = (self.x * n + y) * rows.stride + 1;
            for z in (0..n).step_by(LANES) {
                let mut f = [[0.0_f32; LANES]; Q];
                f[0] = lane(self.now, from[0].0 + z);
                for i in 1..Q {
                    let opposite = ((i - 1) ^ 1) + 1;
                    let arrives = lane(self.now, from[i].0 + z);
                    let returns = lane(self.now, rows.row(self.x, opposite, y) + 1 + z);
                    let solid = lane(&rows.solid, from[i].1 + z);
                    f[i] = std::array::from_fn(|k| {
                        if solid[k] > 0.0 {
                            returns[k]
                        } else {
                            arrives[k]
                        }
                    });
                }
                collide(&mut f, self.push);
                let solid = lane(&rows.solid, here + z);
                for i in 0..Q {
                    let row = (i * n + y) * rows.stride + 1 + z;
                    for k in 0..LANES {
                        self.plane[row + k] = f[i][k] * (1.0 - solid[k]);
                    }
                }
            }
            for i in 0..Q {
                let row = &mut self.plane[(i * n + y) * rows.stride..][..rows.stride];
                row[0] = row[n];
                row[n + 1] = row[1];
            }
        }
    }
}

#[inline(always)]
fn collide(f: &mut [Lane; Q], push: &[f32; Q]) {
    let mut density = [0.0_f32; LANES];
    for of_direction in f.iter() {
        for k in 0..LANES {
            density[k] += of_direction[k];
        }
    }
    let mut flow = [[0.0_f32; LANES]; 3];
    for i in (1..Q).step_by(2) {
        for a in 0..3 {
            let c = C[i][a] as f32;
            for k in 0..LANES {
                flow[a][k] += c * (f[i][k] - f[i + 1][k]);
            }
        }
    }
    for k in 0..LANES {
        f[0][k] -= (f[0][k] - weight(0) * density[k]) / EVEN_TIME;
    }
    for i in (1..Q).step_by(2) {
        let c = C[i].map(|c| c as f32);
        for k in 0..LANES {
            let along = c[0] * flow[0][k] + c[1] * flow[1][k] + c[2] * flow[2][k];
            let even = 0.5 * (f[i][k] + f[i + 1][k]) - weight(i) * density[k];
            let odd = 0.5 * (f[i][k] - f[i + 1][k]) - 3.0 * weight(i) * along;
            let (even, odd) = (even / EVEN_TIME, odd / ODD_TIME);
            f[i][k] += push[i] - even - odd;
            f[i + 1][k] += push[i + 1] - even + odd;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Drag of spheres in a simple cubic lattice, in Stokes drags [Zick82] (Table 2).
    #[test]
    fn cubic_lattices_of_spheres_have_zick_and_homsys_drag() {
        for (solid, drag) in [(0.027, 2.008), (0.125, 4.292), (0.343, 15.4)] {
            let edge = 32;
            let radius = libm::cbrt(3.0 * solid / (4.0 * PI)) * edge as Real;
            let sample = Sample::cut(&Vec3::zeros(), edge, 1.0, |x| x.norm() - radius);
            let exact = (edge as Real).powi(3) / (6.0 * PI * radius * drag);
            let found = sample.permeability(2).unwrap();
            assert!(
                (found / exact - 1.0).abs() < 0.05,
                "{solid}: {}",
                found / exact
            );
        }
    }

    /// Between plates: k = (width²/12) · open share.
    #[test]
    fn a_slit_has_a_twelfth_of_its_square() {
        let sample = Sample::cut(&Vec3::zeros(), 16, 1e-3, |x| 5.0e-3 - x.x.abs());
        let found = sample.permeability(1).unwrap();
        let exact = 1e-4 / 12.0 * 10.0 / 16.0;
        assert!((found / exact - 1.0).abs() < 0.01, "{}", found / exact);
        let shut = Sample::cut(&Vec3::zeros(), 8, 1.0, |x| 2.0 - x.x.abs());
        assert!(shut.permeability(0).is_none_or(|k| k < 1e-3));
    }
}
