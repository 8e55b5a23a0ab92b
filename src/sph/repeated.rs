//! A = Pᵀ (dt M⁻¹) P of `pressure` for being applied again and again: in wide registers.

use super::neighbourhood::{Link, Neighbourhood, vector};
use crate::math::{Real, Vec3, WideRows, widest_rows};
use rayon::prelude::*;

const GRAIN: usize = 128;

/// A for one set of positions.
pub struct RepeatedPressure<'a> {
    near: &'a Neighbourhood,
    /// dt/m_i [s/kg].
    mobility: &'a [Real],
    /// What Pᵀ is applied to [m/s].
    velocity: Vec<[Real; 4]>,
}

impl<'a> RepeatedPressure<'a> {
    /// `mobility` is the velocity per force [s/kg] of each particle.
    pub fn new(near: &'a Neighbourhood, mobility: &'a [Real]) -> Self {
        Self {
            near,
            mobility,
            velocity: vec![[0.0; 4]; near.len()],
        }
    }

    /// V₀ [m³].
    pub fn rest_volume(&self) -> Real {
        self.near.rest_volume
    }

    /// dt M⁻¹ P k of the pressure that A was applied to last [m/s]: what it takes off the velocity.
    pub fn velocity(&self, i: usize) -> Vec3 {
        let [x, y, z, _] = self.velocity[i];
        Vec3::new(x, y, z)
    }

    /// A k [m³/s] of a pressure [Pa].
    pub fn apply(&mut self, pressure: &[Real], image: &mut [Real]) {
        let mut velocity = std::mem::take(&mut self.velocity);
        let of_walls = self.of_walls(|_, i, share, _| share * pressure[i]);
        let push = Push {
            operator: self,
            pressure,
            of_walls: &of_walls,
        };
        widest_rows(&push, &mut velocity);
        self.velocity = velocity;
        self.close(None, image);
    }

    /// Pᵀ v [m³/s] of a velocity [m/s], with the walls' own.
    pub fn volume_rate(&mut self, velocity: &[Vec3]) -> Vec<Real> {
        for (row, v) in self.velocity.iter_mut().zip(velocity) {
            *row = [v.x, v.y, v.z, 0.0];
        }
        let mut rate = vec![0.0; velocity.len()];
        self.close(Some(&self.near.wall_velocity), &mut rate);
        rate
    }

    /// Pᵀ of `self.velocity` [m³/s] among walls at rest or not.
    fn close(&self, wall_velocity: Option<&[Vec3]>, rate: &mut [Real]) {
        let walls = Drift(wall_velocity);
        let mut of_walls = self.of_walls(|b, i, _, gradient| {
            let (u, v) = (walls.of(b), &self.velocity[i]);
            (u[0] - v[0]) * gradient.x + (u[1] - v[1]) * gradient.y + (u[2] - v[2]) * gradient.z
        });
        for (rate, volume) in of_walls.iter_mut().zip(&self.near.wall_volume) {
            *rate *= volume;
        }
        let close = Close {
            operator: self,
            walls,
            of_walls: &of_walls,
        };
        widest_rows(&close, rate);
    }

    /// Sum over the fluid near each wall particle b of what `term(b, i, share, gradient)` says.
    fn of_walls(&self, term: impl Fn(usize, usize, Real, Vec3) -> Real + Sync) -> Vec<Real> {
        let rows = &self.near.of_wall;
        (0..rows.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let pairs = rows.row(b).iter();
                pairs
                    .map(|p| term(b, p.i as usize, p.share.into(), vector(p.gradient)))
                    .sum()
            })
            .collect()
    }
}

/// Velocities of the walls [m/s], or walls at rest.
#[derive(Clone, Copy)]
struct Drift<'a>(Option<&'a [Vec3]>);

impl Drift<'_> {
    #[inline(always)]
    fn of(&self, b: usize) -> [Real; 3] {
        self.0.map_or([0.0; 3], |velocity| velocity[b].into())
    }
}

/// dt M⁻¹ P k.
struct Push<'a> {
    operator: &'a RepeatedPressure<'a>,
    pressure: &'a [Real],
    of_walls: &'a [Real],
}

impl WideRows<[Real; 4]> for Push<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [[Real; 4]]) {
        let near = self.operator.near;
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = self.pressure[i];
            let push = two_sums(self.operator.near.fluid.row(i), |link| {
                let both = own + self.pressure[link.j as usize];
                lanes(link).map(|g| g * both)
            });
            let mut wall = [0.0; 3];
            for pair in near.wall.row(i) {
                let both = own + self.of_walls[pair.b as usize];
                for axis in 0..3 {
                    wall[axis] += Real::from(pair.gradient[axis]) * both;
                }
            }
            let scale = near.rest_volume * self.operator.mobility[i];
            for axis in 0..3 {
                row[axis] = (push[axis] + wall[axis]) * scale;
            }
        }
    }
}

/// Pᵀ v.
struct Close<'a> {
    operator: &'a RepeatedPressure<'a>,
    walls: Drift<'a>,
    of_walls: &'a [Real],
}

impl WideRows<Real> for Close<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [Real]) {
        let near = self.operator.near;
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = self.operator.velocity[i];
            let rate = two_sums(self.operator.near.fluid.row(i), |link| {
                let (g, v) = (lanes(link), self.operator.velocity[link.j as usize]);
                std::array::from_fn(|lane| (own[lane] - v[lane]) * g[lane])
            });
            let (mut wall, mut given_back) = (0.0, 0.0);
            for pair in near.wall.row(i) {
                let u = self.walls.of(pair.b as usize);
                for axis in 0..3 {
                    wall += (own[axis] - u[axis]) * Real::from(pair.gradient[axis]);
                }
                given_back += Real::from(pair.share) * self.of_walls[pair.b as usize];
            }
            *row = (rate[0] + rate[1] + rate[2] + wall) * near.rest_volume + given_back;
        }
    }
}

#[inline(always)]
fn lanes(link: &Link) -> [Real; 4] {
    let [x, y, z] = link.gradient;
    [x.into(), y.into(), z.into(), 0.0]
}

/// Σ term, even and odd links apart: neither sum waits for the other.
#[inline(always)]
fn two_sums(links: &[Link], term: impl Fn(&Link) -> [Real; 4]) -> [Real; 4] {
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
    use crate::math::{Aabb, Stream};
    use crate::sph::{Domain, Kernel, MovingWalls, PressureOperator, WallParticles, Walls};

    /// On disordered particles above a floor: the same as the plain operator, one thread or two.
    #[test]
    fn agrees_with_the_operator_and_its_transpose() {
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
        let velocity: Vec<Vec3> = (0..n).map(|i| operator.velocity(i)).collect();
        let plain = PressureOperator { near: &near }.volume_rate(&velocity);
        for (packed, plain) in of_b.iter().zip(&plain) {
            assert!((packed - plain).abs() < 1e-12 * (1.0 + plain.abs()));
        }
    }
}
