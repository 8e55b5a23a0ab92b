//! A = Pᵀ (dt M⁻¹) P of `pressure` for being applied again and again: in wide registers of single precision.
//!
//! A k is then right to 1e-6 of itself, far below what is asked of a solve; what the pressure that comes out does to the
//! velocity is to be taken from [`PressureOperator::force`](super::PressureOperator::force), which keeps momentum.

use super::neighbourhood::Neighbourhood;
use super::pairs::Link;
use crate::math::{Real, WideRows, widest_rows};
use rayon::prelude::*;

const GRAIN: usize = 128;

/// A for one set of positions.
pub struct RepeatedPressure<'a> {
    near: &'a Neighbourhood,
    /// dt/m_i [s/kg].
    mobility: &'a [Real],
    /// k [Pa].
    pressure: Vec<f32>,
    /// dt M⁻¹ P k [m/s].
    velocity: Vec<[f32; 4]>,
}

impl<'a> RepeatedPressure<'a> {
    /// `mobility` is the velocity per force [s/kg] of each particle.
    pub fn new(near: &'a Neighbourhood, mobility: &'a [Real]) -> Self {
        Self {
            near,
            mobility,
            pressure: vec![0.0; near.len()],
            velocity: vec![[0.0; 4]; near.len()],
        }
    }

    /// V₀ [m³].
    pub fn rest_volume(&self) -> Real {
        self.near.rest_volume
    }

    /// A k [m³/s] of a pressure [Pa].
    pub fn apply(&mut self, pressure: &[Real], image: &mut [Real]) {
        for (single, k) in self.pressure.iter_mut().zip(pressure) {
            *single = *k as f32;
        }
        let of_walls = self.of_walls(|i, share, _| share * self.pressure[i]);
        let mut velocity = std::mem::take(&mut self.velocity);
        let push = Push {
            operator: self,
            of_walls: &of_walls,
        };
        widest_rows(&push, &mut velocity);
        self.velocity = velocity;

        let mut of_walls = self.of_walls(|i, _, gradient| {
            let v = &self.velocity[i];
            -(v[0] * gradient[0] + v[1] * gradient[1] + v[2] * gradient[2])
        });
        for (rate, volume) in of_walls.iter_mut().zip(&self.near.wall_volume) {
            *rate *= *volume as f32;
        }
        let close = Close {
            operator: self,
            of_walls: &of_walls,
        };
        widest_rows(&close, image);
    }

    /// Sum over the fluid near each wall particle of what `term(i, share, gradient)` says.
    fn of_walls(&self, term: impl Fn(usize, f32, &[f32; 3]) -> f32 + Sync) -> Vec<f32> {
        let rows = &self.near.of_wall;
        (0..rows.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let pairs = rows.row(b).iter();
                pairs
                    .map(|p| term(p.i as usize, p.share, &p.gradient))
                    .sum()
            })
            .collect()
    }
}

/// dt M⁻¹ P k.
struct Push<'a> {
    operator: &'a RepeatedPressure<'a>,
    of_walls: &'a [f32],
}

impl WideRows<[f32; 4]> for Push<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [[f32; 4]]) {
        let (near, pressure) = (self.operator.near, &self.operator.pressure[..]);
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = pressure[i];
            let push = two_sums(near.fluid.row(i), |link| {
                let both = own + pressure[link.j as usize];
                lanes(link).map(|g| g * both)
            });
            let mut wall = [0.0; 3];
            for pair in near.wall.row(i) {
                let both = own + self.of_walls[pair.b as usize];
                for axis in 0..3 {
                    wall[axis] += pair.gradient[axis] * both;
                }
            }
            let scale = (near.rest_volume * self.operator.mobility[i]) as f32;
            for axis in 0..3 {
                row[axis] = (push[axis] + wall[axis]) * scale;
            }
        }
    }
}

/// Pᵀ v, walls at rest.
struct Close<'a> {
    operator: &'a RepeatedPressure<'a>,
    of_walls: &'a [f32],
}

impl WideRows<Real> for Close<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [Real]) {
        let (near, velocity) = (self.operator.near, &self.operator.velocity[..]);
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = velocity[i];
            let rate = two_sums(near.fluid.row(i), |link| {
                let (g, v) = (lanes(link), velocity[link.j as usize]);
                std::array::from_fn(|lane| (own[lane] - v[lane]) * g[lane])
            });
            let (mut wall, mut given_back) = (0.0, 0.0);
            for pair in near.wall.row(i) {
                for axis in 0..3 {
                    wall += own[axis] * pair.gradient[axis];
                }
                given_back += pair.share * self.of_walls[pair.b as usize];
            }
            let rate = Real::from(rate[0] + rate[1] + rate[2] + wall);
            *row = rate * near.rest_volume + Real::from(given_back);
        }
    }
}

#[inline(always)]
fn lanes(link: &Link) -> [f32; 4] {
    let [x, y, z] = link.gradient;
    [x, y, z, 0.0]
}

/// Σ term, even and odd links apart: neither sum waits for the other.
#[inline(always)]
fn two_sums(links: &[Link], term: impl Fn(&Link) -> [f32; 4]) -> [f32; 4] {
    let (mut even, mut odd) = ([0.0; 4], [0.0; 4]);
    let (twos, rest) = links.as_chunks::<2>();
    for [a, b] in twos {
        let (a, b) = (term(a), term(b));
        for lane in 0..4 {
            even[lane] += a[lane];
            odd[lane] += b[lane];
        }
    }
    for link in rest {
        let a = term(link);
        for lane in 0..4 {
            even[lane] += a[lane];
        }
    }
    std::array::from_fn(|lane| even[lane] + odd[lane])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Stream, Vec3};
    use crate::sph::{Domain, Kernel, MovingWalls, PressureOperator, WallParticles, Walls};

    /// Disordered particles above a floor.
    fn above_a_floor() -> Neighbourhood {
        let mut random = Stream::new(5, "packed");
        let kernel = Kernel::new(2.4);
        let domain = Domain {
            bounds: Aabb {
                min: Vec3::repeat(-5.0),
                max: Vec3::repeat(15.0),
            },
            periodic: [false; 3],
        };
        let lattice = |low: i32| {
            let cells = (0..9).flat_map(|x| (0..9).map(move |y| (x, y)));
            let columns = cells.flat_map(move |(x, y)| (low..low + 5).map(move |z| (x, y, z)));
            columns.map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()))
        };
        let position: Vec<Vec3> = lattice(0).map(|x| x + random.cube() * 0.3).collect();
        let floor: Vec<Vec3> = lattice(-5).collect();
        let particles = WallParticles {
            volume: vec![1.0; floor.len()],
            position: floor,
        };
        let walls = Walls::new(particles, &kernel, &domain, |x| -0.5 - x.z);
        let near = Neighbourhood::new(
            &position,
            1.0,
            &kernel,
            &domain,
            &walls,
            &MovingWalls::default(),
            |x| (x.z + 0.5, Vec3::z()),
        );
        assert!(near.of_wall.len() > 100);
        near
    }

    /// The pressure of a wall is a mean of the fluid's, so a level is felt there as anywhere.
    #[test]
    fn a_level_of_pressure_pushes_the_crowded_alone() {
        let near = above_a_floor();
        let operator = PressureOperator { near: &near };
        for (i, force) in operator.force(&vec![1.0; near.len()]).iter().enumerate() {
            let level = operator.force_of_level(&near.crowding(i), 1.0);
            assert!(
                (force - level).norm() < 1e-5 * (1.0 + level.norm()),
                "{force} {level}"
            );
        }
    }

    /// The same as the plain operator, and symmetric.
    #[test]
    fn agrees_with_the_operator_and_its_transpose() {
        let near = above_a_floor();
        let mut random = Stream::new(6, "pressures");
        let n = near.len();
        let mobility: Vec<Real> = (0..n).map(|_| 0.5 + random.unit()).collect();
        let [a, b] = [0, 1].map(|_| -> Vec<Real> { (0..n).map(|_| random.unit()).collect() });
        let mut operator = RepeatedPressure::new(&near, &mobility);
        let (mut of_a, mut of_b) = (vec![0.0; n], vec![0.0; n]);
        operator.apply(&a, &mut of_a);
        operator.apply(&b, &mut of_b);
        let dot = |a: &[Real], b: &[Real]| -> Real { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        assert!((dot(&a, &of_b) / dot(&b, &of_a) - 1.0).abs() < 1e-6);
        assert!(dot(&b, &of_b) > 0.0);
        let plain = PressureOperator { near: &near };
        let mut velocity = plain.force(&b);
        for (v, mobility) in velocity.iter_mut().zip(&mobility) {
            *v *= *mobility;
        }
        let plain = plain.volume_rate(&velocity);
        for (single, plain) in of_b.iter().zip(&plain) {
            assert!((single - plain).abs() < 3e-6 * (1.0 + plain.abs()));
        }
    }
}
