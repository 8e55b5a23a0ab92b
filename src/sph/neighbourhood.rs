//! Who is near whom, and what every operator needs of a pair: built once a step, read by all.

use super::meeting::meet;
use super::pairs::{Bell, FluidOfWall, Link, Pair, WallPair, scaled, squared_over, vector};
use super::{Cells, Domain, Kernel, MovingWalls, Rows, WallParticles, Walls};
use crate::math::{Mat3, Real, Sym3, Vec3};
use rayon::prelude::*;

/// β is cut here: closer to the surface the wall would own the particle.
const MOST_BETA: Real = 8.0;
/// Distance to the surface is not taken below this, in spacings.
const LEAST_DISTANCE: Real = 0.1;
/// The trace of the moment matrix is 1 inside the fluid; at a free surface it is not taken below this.
const LEAST_TRACE: Real = 0.8;

/// Everything that the operators know about positions.
#[derive(Clone, Debug, Default)]
pub struct Neighbourhood {
    /// Spacing at rest [m].
    pub spacing: Real,
    /// V₀ [m³].
    pub rest_volume: Real,
    /// Fluid neighbours of each fluid particle, itself left out.
    pub fluid: Rows<Link>,
    pub(super) bells: Rows<Bell>,
    /// Wall neighbours of each fluid particle.
    pub wall: Rows<WallPair>,
    /// Fluid neighbours of each active wall particle.
    pub of_wall: Rows<FluidOfWall>,
    /// Velocity of each active wall particle [m/s].
    pub wall_velocity: Vec<Vec3>,
    /// The inlet whose piston each active wall particle is part of, if it is one.
    pub wall_inlet: Vec<Option<u16>>,
    /// ω of the body of each active wall particle [rad/s]; empty where nothing turns.
    pub wall_spin: Vec<Vec3>,
    /// Volume of each active wall particle [m³].
    pub wall_volume: Vec<Real>,
    /// ψ_b − 1 where a wall particle is over-full, else 0 [1].
    pub wall_excess: Vec<Real>,
    /// ψ_i = Σ V W, itself and walls included [1]: 1 at rest.
    pub compression: Vec<Real>,
    /// m_i = (1/3) Σ V_j (−W'/r) r² [1]: 1 in the continuum; floored at free surfaces.
    pub trace: Vec<Real>,
    /// B_i, with which a gradient in difference form is exact for linear fields; empty before
    /// [`Neighbourhood::straighten`].
    pub correction: Vec<Mat3>,
    /// S_i, which directions the Laplacian weighs more [1]: the identity on a lattice; empty before
    /// [`Neighbourhood::straighten`].
    pub(super) shape: Vec<Sym3>,
    /// What takes straightened gradients at walls back to those of the kernel; empty unless they were straightened.
    pub(super) moment: Vec<Mat3>,
    /// How many of the static walls are awake: the first of the active wall particles.
    pub awake: usize,
    /// Which of the moving wall particles the others are.
    moving: Vec<u32>,
    /// The walls near each fluid particle, static ones before moving ones, while the rest is built.
    found: Rows<u32>,
    /// What it was built of, as long as it is what was built.
    pub(super) origin: Option<Origin>,
}

/// What a neighbourhood follows from, but for walls at rest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Origin {
    position: Vec<Vec3>,
    spacing: Real,
    kernel: Kernel,
    moving: MovingWalls,
}

/// Where a particle stands before the solid: distance [m] to the true surface and unit normal into the open.
pub type Standing = (Real, Vec3);

impl Neighbourhood {
    /// Builds everything; `standing(i)` is asked only for particles with walls in reach.
    pub fn new(
        position: &[Vec3],
        spacing: Real,
        kernel: &Kernel,
        domain: &Domain,
        walls: &Walls,
        moving: &MovingWalls,
        standing: impl Fn(&Vec3) -> Standing + Sync,
    ) -> Self {
        let mut near = Self::default();
        near.rebuild(position, spacing, kernel, domain, walls, moving, standing);
        near
    }

    /// Fluid alone, with no walls anywhere.
    pub fn without_walls(
        position: &[Vec3],
        spacing: Real,
        kernel: &Kernel,
        domain: &Domain,
    ) -> Self {
        let walls = Walls::new(WallParticles::default(), kernel, domain, |_| 0.0);
        let moving = MovingWalls::default();
        Self::new(position, spacing, kernel, domain, &walls, &moving, |_| {
            (Real::INFINITY, Vec3::z())
        })
    }

    /// The same in the memory of the pairs that were here. If they are those of these positions they are kept; `walls` and
    /// `domain` are taken to be the same as before.
    pub fn rebuild(
        &mut self,
        position: &[Vec3],
        spacing: Real,
        kernel: &Kernel,
        domain: &Domain,
        walls: &Walls,
        moving: &MovingWalls,
        standing: impl Fn(&Vec3) -> Standing + Sync,
    ) {
        if let Some(origin) = &self.origin
            && origin.position == position
            && (origin.spacing, origin.kernel) == (spacing, *kernel)
            && origin.moving == *moving
        {
            return;
        }
        let n = position.len();
        let rest_volume = kernel.rest_volume(spacing);
        let h = kernel.support_radius;
        let cells = Cells::new(position, h, domain);
        let moving_cells = Cells::new(&moving.position, h, domain);

        let Self {
            fluid,
            bells,
            wall,
            of_wall,
            found,
            ..
        } = self;

        fluid.rebuild_with(bells, n, |i, row, bells| {
            meet(&cells, kernel, &position[i], |met| {
                if met.number != i {
                    let steepness = (rest_volume * met.steepness) as f32;
                    row.push(Link {
                        gradient: scaled(&met.apart, -steepness),
                        j: met.number as u32,
                    });
                    bells.push(Bell {
                        steepness,
                        weight: (rest_volume * met.w) as f32,
                    });
                }
            });
        });

        // Pairs with walls: static ones first, moving ones numbered after them.
        let static_count = walls.particles.position.len();
        found.rebuild(n, |i, row| {
            let x = &position[i];
            walls.cells.near(x, |b, _, _| row.push(b as u32));
            moving_cells.near(x, |b, _, _| row.push((static_count + b) as u32));
        });
        let mut place = vec![u32::MAX; static_count + moving.position.len()];
        for i in 0..n {
            for &b in found.row(i) {
                place[b as usize] = 0;
            }
        }
        let active: Vec<usize> = (0..place.len()).filter(|&b| place[b] == 0).collect();
        for (a, &b) in active.iter().enumerate() {
            place[b] = a as u32;
        }
        let at = |b: usize| {
            if b < static_count {
                walls.particles.position[b]
            } else {
                moving.position[b - static_count]
            }
        };
        let wall_volume: Vec<Real> = active
            .iter()
            .map(|&b| {
                if b < static_count {
                    walls.particles.volume[b]
                } else {
                    moving.volume[b - static_count]
                }
            })
            .collect();
        let wall_inlet = active
            .iter()
            .map(|&b| b.checked_sub(static_count).and_then(|b| moving.inlet[b]))
            .collect();
        let of_moving = |b: usize, values: &[Vec3]| match b.checked_sub(static_count) {
            Some(b) => values[b],
            None => Vec3::zeros(),
        };
        let each = |values: &[Vec3]| active.iter().map(|&b| of_moving(b, values)).collect();
        let wall_velocity = each(&moving.velocity);
        let turning = moving.spin.iter().any(|spin| *spin != Vec3::zeros());
        let wall_spin = if turning {
            each(&moving.spin)
        } else {
            Vec::new()
        };
        // Sum over its own walls and depth of a wall particle; none for a piston.
        let solid = |b: usize| match b.checked_sub(static_count) {
            None => Some((walls.own_sum[b], walls.depth[b])),
            Some(b) => moving.depth[b].map(|depth| (moving.own_sum[b], depth)),
        };

        of_wall.rebuild(active.len(), |a, row| {
            meet(&cells, kernel, &at(active[a]), |met| {
                let steepness = (rest_volume * met.steepness) as f32;
                row.push(FluidOfWall {
                    i: met.number as u32,
                    gradient: scaled(&met.apart, -steepness),
                    share: (rest_volume * met.w) as f32,
                });
            });
        });
        let weight_of_fluid: Vec<Real> = (0..active.len())
            .into_par_iter()
            .map(|a| {
                of_wall
                    .row(a)
                    .iter()
                    .map(|pair| Real::from(pair.share))
                    .sum()
            })
            .collect();
        let mean_of: Vec<f32> = weight_of_fluid
            .iter()
            .map(|&sum| (1.0 / sum.max(1e-30)) as f32)
            .collect();
        of_wall.for_each_mut(|a, pair| pair.share *= mean_of[a]);
        let wall_excess = (0..active.len())
            .map(|a| {
                // A wall particle with air behind it is never full: only an excess says something.
                solid(active[a]).map_or(0.0, |(of_walls, _)| {
                    (of_walls + weight_of_fluid[a] - 1.0).max(0.0)
                })
            })
            .collect();

        wall.rebuild(n, |i, row| {
            if found.row(i).is_empty() {
                return;
            }
            let x = position[i];
            let (distance, normal) = standing(&x);
            let distance = distance.max(LEAST_DISTANCE * spacing);
            for &b in found.row(i) {
                let b = b as usize;
                let a = place[b] as usize;
                let x_ib = domain.shortest(x - at(b));
                let r = x_ib.norm();
                let steepness = (wall_volume[a] * kernel.steepness(r)) as f32;
                let beta = solid(b).map_or(0.0, |(_, depth)| {
                    // The deeper of: below the surface, below the particle's own tangent plane (thin struts).
                    let depth = depth.max(normal.dot(&x_ib) - distance).max(0.0);
                    (depth / distance).min(MOST_BETA)
                });
                row.push(WallPair {
                    b: a as u32,
                    gradient: scaled(&x_ib, -steepness),
                    steepness,
                    share: (rest_volume * kernel.w(r)) as f32 * mean_of[a],
                    beta: beta as f32,
                });
            }
        });

        let own = rest_volume * kernel.w(0.0);
        (0..n)
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let (mut compression, mut trace) = (own, 0.0);
                for (link, bell) in fluid.row(i).iter().zip(bells.row(i)) {
                    compression += Real::from(bell.weight);
                    trace += squared_over(link.gradient, bell.steepness);
                }
                for pair in wall.row(i) {
                    compression += Real::from(pair.share) * weight_of_fluid[pair.b as usize]
                        / rest_volume
                        * wall_volume[pair.b as usize];
                    trace += squared_over(pair.gradient, pair.steepness);
                }
                (compression, (trace / 3.0).max(LEAST_TRACE))
            })
            .unzip_into_vecs(&mut self.compression, &mut self.trace);
        self.correction.clear();
        self.shape.clear();
        self.moment.clear();
        self.spacing = spacing;
        self.rest_volume = rest_volume;
        self.awake = active.iter().filter(|&&b| b < static_count).count();
        self.moving = active
            .iter()
            .filter_map(|b| Some(b.checked_sub(static_count)? as u32))
            .collect();
        self.wall_velocity = wall_velocity;
        self.wall_inlet = wall_inlet;
        self.wall_spin = wall_spin;
        self.wall_volume = wall_volume;
        self.wall_excess = wall_excess;
        self.origin = Some(Origin {
            position: position.to_vec(),
            spacing,
            kernel: *kernel,
            moving: moving.clone(),
        });
    }

    /// The fluid neighbours of particle i with all there is to know of them.
    #[inline(always)]
    pub fn pairs(&self, i: usize) -> impl Iterator<Item = Pair> + '_ {
        let bells = self.bells.row(i).iter();
        self.fluid
            .row(i)
            .iter()
            .zip(bells)
            .map(|(link, bell)| Pair {
                j: link.j,
                gradient: link.gradient,
                steepness: bell.steepness,
                weight: bell.weight,
            })
    }

    /// Gives the moving walls other velocities [m/s].
    pub fn set_moving_velocity(&mut self, velocity: &[Vec3]) {
        self.origin = None;
        for (active, &b) in self.wall_velocity[self.awake..]
            .iter_mut()
            .zip(&self.moving)
        {
            *active = velocity[b as usize];
        }
    }

    /// u_w [m/s] where the line from a fluid particle to a wall particle meets the wall's surface.
    ///
    /// With it a fluid that turns like the wall is not sheared by it: v_b = u_w − β (v_i − u_w) is then ω × x_b.
    #[inline]
    pub fn surface_velocity(&self, i: usize, pair: &WallPair) -> Vec3 {
        let b = pair.b as usize;
        let velocity = self.wall_velocity[b];
        match self.wall_spin.get(b) {
            Some(spin) if pair.steepness > 0.0 => {
                let beta = Real::from(pair.beta);
                let x_ib = -self.kernel_gradient(i, pair) / Real::from(pair.steepness);
                velocity + spin.cross(&x_ib) * (beta / (1.0 + beta))
            }
            _ => velocity,
        }
    }

    /// ∇ψ_i = Σ_j V ∇W_ij over fluid and walls [1/m]: which way a particle is crowded; 0 on a lattice.
    pub fn crowding(&self, i: usize) -> Vec3 {
        let fluid = self.fluid.row(i).iter().map(|pair| vector(pair.gradient));
        let wall = self.wall.row(i).iter().map(|pair| vector(pair.gradient));
        fluid.sum::<Vec3>() + wall.sum::<Vec3>()
    }

    /// Number of fluid particles.
    pub fn len(&self) -> usize {
        self.fluid.len()
    }

    /// Whether there is no fluid.
    pub fn is_empty(&self) -> bool {
        self.fluid.is_empty()
    }
}
