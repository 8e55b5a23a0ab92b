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

use crate::math::{Real, Vec3, ordered_sum};
use rayon::prelude::*;

/// Directions of D3Q19; each even one is followed by its opposite.
const C: [[i32; 3]; 19] = [
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

/// 1/ω⁺: a viscosity of 1/3, with which flow settles fast.
const EVEN_TIME: Real = 1.5;
/// 1/ω⁻.
const ODD_TIME: Real = 0.5 + 3.0 / 16.0 / (EVEN_TIME - 0.5);
/// Driving force; the flow is linear in it.
const FORCE: Real = 1e-4;
/// Steps between looks at the mean flow.
const PAUSE: usize = 50;
/// The flow has settled when it changes by less than this share between looks.
const SETTLED: Real = 2e-4;
/// More steps are not taken.
const MOST_STEPS: usize = 20_000;

fn weight(i: usize) -> Real {
    match i {
        0 => 1.0 / 3.0,
        1..=6 => 1.0 / 18.0,
        _ => 1.0 / 36.0,
    }
}

fn opposite(i: usize) -> usize {
    if i == 0 { 0 } else { ((i - 1) ^ 1) + 1 }
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
        let n = self.edge;
        let mut now = vec![[0.0_f32; 19]; self.solid.len()];
        let mut next = now.clone();
        let mut last = 0.0;
        for step in 1..=MOST_STEPS {
            next.par_chunks_mut(n * n)
                .enumerate()
                .for_each(|(x, plane)| {
                    for (yz, cell) in plane.iter_mut().enumerate() {
                        let at = x * n * n + yz;
                        if !self.solid[at] {
                            *cell = self.collided(&now, [x, yz / n, yz % n], axis);
                        }
                    }
                });
            std::mem::swap(&mut now, &mut next);
            if step % PAUSE == 0 {
                let flow = |at: usize| {
                    let moved = (0..19).map(|i| Real::from(now[at][i]) * Real::from(C[i][axis]));
                    // The flow is that halfway through the push of the collision.
                    if self.solid[at] {
                        0.0
                    } else {
                        moved.sum::<Real>() - 0.5 * FORCE
                    }
                };
                let mean = ordered_sum(now.len(), flow) / now.len() as Real;
                if (mean - last).abs() <= SETTLED * mean.abs() {
                    let viscosity = (EVEN_TIME - 0.5) / 3.0;
                    return Some(viscosity * mean / FORCE * self.voxel * self.voxel);
                }
                last = mean;
            }
        }
        None
    }

    /// What arrives at an open cell, collided and pushed.
    fn collided(&self, now: &[[f32; 19]], place: [usize; 3], axis: usize) -> [f32; 19] {
        let n = self.edge;
        let index = |p: [usize; 3]| (p[0] * n + p[1]) * n + p[2];
        let here = index(place);
        let mut f = [0.0; 19];
        for i in 0..19 {
            let from = std::array::from_fn(|a| match C[i][a] {
                1 => (place[a] + n - 1) % n,
                -1 => (place[a] + 1) % n,
                _ => place[a],
            });
            let from = index(from);
            f[i] = Real::from(if self.solid[from] {
                now[here][opposite(i)]
            } else {
                now[from][i]
            });
        }
        let density: Real = f.iter().sum();
        let mut flow = [0.0; 3];
        for i in 1..19 {
            for a in 0..3 {
                flow[a] += Real::from(C[i][a]) * f[i];
            }
        }
        let mut out = [0.0_f32; 19];
        for i in 0..19 {
            let o = opposite(i);
            let along: Real = (0..3).map(|a| Real::from(C[i][a]) * flow[a]).sum();
            let even = 0.5 * (f[i] + f[o]) - weight(i) * density;
            let odd = 0.5 * (f[i] - f[o]) - 3.0 * weight(i) * along;
            let push = 3.0 * weight(i) * Real::from(C[i][axis]) * FORCE;
            out[i] = (f[i] - even / EVEN_TIME - odd / ODD_TIME + push) as f32;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Drag of spheres in a simple cubic lattice, in Stokes drags [Zick82] (Table 2).
    #[test]
    fn cubic_lattices_of_spheres_have_zick_and_homsys_drag() {
        for (solid, drag) in [(0.125, 4.292), (0.343, 15.4)] {
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
