//! The pressure operator P and its transpose, with walls.
//!
//! ```text
//! force     (P k)_i  = V_i [ Σ_j V_j (k_i + k_j) ∇W_ij + Σ_b V_b (k_i + k_b) ∇W_ib ]     k_b = Σ_j S_bj k_j
//! volume    (Pᵀv)_i  = V_i [ Σ_j V_j (v_i − v_j)·∇W_ij + Σ_b V_b v_i·∇W_ib ] + Σ_b S_bi V_b D_b
//!                                                                   D_b = −Σ_j V_j v_j·∇W_bj
//! ```
//!
//! The force on particle i is −(P k)_i. The pressure of a wall particle is the Shepard mean of the fluid's, and
//! the wall's own compression is given back to the fluid through the transpose, so that Pᵀ M⁻¹ P is symmetric
//! and positive semi-definite for any disorder and any masses.

use super::neighbourhood::Neighbourhood;
use super::pairs::{squared_over, vector};
use crate::math::{Real, Vec3};
use rayon::prelude::*;

const GRAIN: usize = 128;

/// What the pressure has to undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Compression left over at the end of the step: ψ − 1 + dt Dψ/Dt.
    Volume,
    /// Dψ/Dt alone, where the neighbourhood is full [DFSPH].
    Divergence,
}

/// P and Pᵀ for one set of positions.
pub struct PressureOperator<'a> {
    /// The positions' pairs.
    pub near: &'a Neighbourhood,
}

impl PressureOperator<'_> {
    /// P k [N]: minus the force of a pressure k [Pa] on each particle.
    pub fn force(&self, pressure: &[Real]) -> Vec<Vec3> {
        self.force_where(pressure, |_| true)
    }

    /// The same on particles that touch walls, 0 on others.
    pub fn force_at_walls(&self, pressure: &[Real]) -> Vec<Vec3> {
        self.force_where(pressure, |i| !self.near.wall.row(i).is_empty())
    }

    fn force_where(&self, pressure: &[Real], asked: impl Fn(usize) -> bool + Sync) -> Vec<Vec3> {
        let near = self.near;
        let of_walls = self.of_walls(pressure);
        (0..near.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                if !asked(i) {
                    return Vec3::zeros();
                }
                let k = pressure[i];
                let fluid = near.fluid.row(i).iter();
                let fluid: Vec3 = fluid
                    .map(|pair| vector(pair.gradient) * (k + pressure[pair.j as usize]))
                    .sum();
                let wall = near.wall.row(i).iter();
                let wall: Vec3 = wall
                    .map(|pair| vector(pair.gradient) * (k + of_walls[pair.b as usize]))
                    .sum();
                (fluid + wall) * near.rest_volume
            })
            .collect()
    }

    /// P k [N] of a pressure that is the same everywhere [Pa], on a particle that is crowded so [1/m]: 2 V k ∇ψ_i, what the
    /// level of a pressure does to a packing. It is 0 on a lattice.
    pub fn force_of_level(&self, crowding: &Vec3, level: Real) -> Vec3 {
        crowding * (2.0 * self.near.rest_volume * level)
    }

    /// Pᵀ v [m³/s], walls at rest.
    pub fn volume_rate(&self, velocity: &[Vec3]) -> Vec<Real> {
        self.rate(velocity, false)
    }

    /// Pᵀ v [m³/s] with the walls' own velocities.
    pub fn volume_rate_with_walls(&self, velocity: &[Vec3]) -> Vec<Real> {
        self.rate(velocity, true)
    }

    fn rate(&self, velocity: &[Vec3], moving: bool) -> Vec<Real> {
        let near = self.near;
        let wall_velocity = |b: u32| {
            if moving {
                near.wall_velocity[b as usize]
            } else {
                Vec3::zeros()
            }
        };
        let of_walls: Vec<Real> = (0..near.of_wall.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let u_b = wall_velocity(b as u32);
                let closing = near.of_wall.row(b).iter();
                let sum: Real = closing
                    .map(|p| (u_b - velocity[p.i as usize]).dot(&vector(p.gradient)))
                    .sum();
                sum * near.wall_volume[b]
            })
            .collect();
        (0..near.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let (mut rate, mut given_back) = (0.0, 0.0);
                for pair in near.fluid.row(i) {
                    rate += (velocity[i] - velocity[pair.j as usize]).dot(&vector(pair.gradient));
                }
                for pair in near.wall.row(i) {
                    rate += (velocity[i] - wall_velocity(pair.b)).dot(&vector(pair.gradient));
                    given_back += Real::from(pair.share) * of_walls[pair.b as usize];
                }
                rate * near.rest_volume + given_back
            })
            .collect()
    }

    /// Mean normal stress of the pair forces [Pa], (1/6) Σ_j V_j (k_i + k_j) (−W'/r) r² [Irving50]: what a fluid with
    /// the multiplier k presses with, on walls and against weight. It is k where the trace of the moment matrix is 1; that
    /// is 0.98 on the cubic lattice at a support of 2.4 spacings, 1.02 at 2.0, and up to 1.03 in other packings with
    /// ψ = 1. For gradients that were not straightened.
    pub fn mean_stress(&self, multiplier: &[Real]) -> Vec<Real> {
        let near = self.near;
        let of_walls = self.of_walls(multiplier);
        (0..near.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let k = multiplier[i];
                let fluid = near.pairs(i).map(|pair| {
                    squared_over(pair.gradient, pair.steepness) * (k + multiplier[pair.j as usize])
                });
                let wall = near.wall.row(i).iter().map(|pair| {
                    squared_over(pair.gradient, pair.steepness) * (k + of_walls[pair.b as usize])
                });
                (fluid.sum::<Real>() + wall.sum::<Real>()) / 6.0
            })
            .collect()
    }

    /// The fluid's mean pressure at each wall particle [Pa].
    fn of_walls(&self, pressure: &[Real]) -> Vec<Real> {
        let near = self.near;
        (0..near.of_wall.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let row = near.of_wall.row(b).iter();
                row.map(|p| Real::from(p.share) * pressure[p.i as usize])
                    .sum()
            })
            .collect()
    }

    /// Power that the piston of an inlet spends against `pressure`, per volume rate that it pushes [Pa]:
    /// Σ_i k_i c_i / Σ_i c_i with the source c of its motion alone.
    pub fn piston_pressure(&self, inlet: u16, pressure: &[Real]) -> Real {
        let near = self.near;
        let (mut power, mut rate) = (0.0, 0.0);
        for b in 0..near.of_wall.len() {
            if near.wall_inlet[b] != Some(inlet) {
                continue;
            }
            let row = near.of_wall.row(b);
            let own: Real = row
                .iter()
                .map(|p| Real::from(p.share) * pressure[p.i as usize])
                .sum();
            for pair in row {
                let pushed =
                    near.wall_velocity[b].dot(&vector(pair.gradient)) * near.wall_volume[b];
                power += pushed * (pressure[pair.i as usize] + own);
                rate += 2.0 * pushed;
            }
        }
        if rate == 0.0 { 0.0 } else { power / rate }
    }

    /// V_i (ψ_i − 1) + Σ_b S_bi V_b (ψ_b − 1)⁺ [m³]: volume by which the particles are too dense.
    pub fn excess_volume(&self) -> Vec<Real> {
        let near = self.near;
        (0..near.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let of_walls: Real = near
                    .wall
                    .row(i)
                    .iter()
                    .map(|p| {
                        Real::from(p.share)
                            * near.wall_volume[p.b as usize]
                            * near.wall_excess[p.b as usize]
                    })
                    .sum();
                near.rest_volume * (near.compression[i] - 1.0) + of_walls
            })
            .collect()
    }

    /// Diagonal of Pᵀ M⁻¹ P [m⁶/(m² kg)], pairs that meet only through a wall left out.
    pub fn diagonal(&self, mass: &[Real]) -> Vec<Real> {
        let near = self.near;
        let v = near.rest_volume;
        (0..near.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let (mut own, mut others) = (Vec3::zeros(), 0.0);
                for pair in near.fluid.row(i) {
                    let g = vector(pair.gradient);
                    own += g;
                    others += g.norm_squared() / mass[pair.j as usize];
                }
                for pair in near.wall.row(i) {
                    own += vector(pair.gradient) * (1.0 + Real::from(pair.share));
                }
                v * v * (own.norm_squared() / mass[i] + others)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Stream};
    use crate::sph::{Domain, Kernel};

    /// A periodic box of `cells`³ particles, each up to `jitter` spacings off its place, all drawn out by `scale`.
    fn packed(cells: u32, jitter: Real, scale: Real, support: Real) -> Neighbourhood {
        let mut random = Stream::new(3, "packed");
        let side = Real::from(cells);
        let places = (0..cells).flat_map(|x| (0..cells).map(move |y| (x, y)));
        let position: Vec<Vec3> = places
            .flat_map(|(x, y)| (0..cells).map(move |z| Vec3::new(x.into(), y.into(), z.into())))
            .map(|x| (x + random.cube() * jitter) * scale)
            .collect();
        let kernel = Kernel::new(support);
        let domain = Domain {
            bounds: Aabb {
                min: Vec3::repeat(-0.5 * scale),
                max: Vec3::repeat((side - 0.5) * scale),
            },
            periodic: [true; 3],
        };
        Neighbourhood::without_walls(&position, 1.0, &kernel, &domain)
    }

    /// Virtual work: what Σ k V ψ gains when all is drawn out is −P dV, on any packing and of any k.
    #[test]
    fn mean_stress_is_the_work_of_a_change_of_volume() {
        let near = packed(9, 0.3, 1.0, 2.4);
        let mut random = Stream::new(4, "multiplier");
        let k: Vec<Real> = (0..near.len()).map(|_| 0.5 + random.unit()).collect();
        let small = 1e-4;
        let energy = |scale: Real| -> Real {
            let drawn = packed(9, 0.3, scale, 2.4);
            k.iter()
                .zip(&drawn.compression)
                .map(|(k, psi)| k * psi)
                .sum()
        };
        let gained = (energy(1.0 + small) - energy(1.0 - small)) / (2.0 * small);
        let stress = PressureOperator { near: &near }.mean_stress(&k);
        let work: Real = stress.iter().sum::<Real>() * -3.0;
        assert!((work / gained - 1.0).abs() < 1e-4, "{work} {gained}");
    }

    #[test]
    fn a_lattice_presses_with_its_trace() {
        for (support, trace) in [(2.0, 1.0201), (2.4, 0.9809)] {
            let near = packed(9, 0.0, 1.0, support);
            let stress = PressureOperator { near: &near }.mean_stress(&vec![7.0; near.len()]);
            for p in stress {
                assert!((p / 7.0 - trace).abs() < 1e-4, "{p}");
            }
        }
    }
}
