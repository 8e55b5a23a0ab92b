//! Undoes on the pairs what a strained packing does to derivatives.
//!
//! Strain draws a lattice out: 1.6 spacings one way, 0.6 the other. A plain sum over neighbours then weighs one
//! direction more than another, by a third and more, and no refinement helps. With e = x_ij/|x_ij|:
//!
//! ```text
//! ∇W_ij → ½ (B_i + B_j) ∇W_ij        B_i⁻¹ = −Σ_j V_j x_ij ⊗ ∇W_ij                      [Bonet99], made antisymmetric
//! F_ij → ½ e·(S_i + S_j)e F_ij       Σ_j V_j F_ij r² (e·S_i e) e ⊗ e = I                [Fatehi11], made symmetric
//! ```
//!
//! Pairs stay equal and opposite, so momentum is kept, Pᵀ stays the transpose of P and K positive semi-definite. The
//! Laplacian is straightened everywhere but at one-sided neighbourhoods; gradients only in closed bodies: elsewhere the
//! rate of volume has to be that of ψ = Σ V W, which keeps the volume. Explicit Newtonian steps with a free surface go
//! without (`sim::stepper`).

use super::neighbourhood::Neighbourhood;
use super::pairs::{WallPair, vector};
use crate::math::{Mat3, Real, Sym3, Vec3};
use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// |Σ V ∇W| Δx from which neighbours are on one side: 0.3 to 0.6 at a plane surface, at most 0.12 in an array of
/// cylinders.
const ONE_SIDED: Real = 0.25;
/// A moment with a smaller determinant has no reliable inverse.
const LEAST_DETERMINANT: Real = 0.3;
/// e·S e is not taken below this, so that every pair still resists.
const LEAST_WEIGHT: Real = 0.1;

impl Neighbourhood {
    /// Finds B and S and brings them into the pairs, unless that was done; gradients only if the fluid is `closed`.
    pub fn straighten(&mut self, closed: bool) {
        if self.shape.len() == self.len() {
            return;
        }
        self.origin = None;
        let each = || (0..self.len()).into_par_iter().with_min_len(128);
        let moment: Vec<Mat3> = each().map(|i| self.moment_of(i)).collect();
        let inverse: Vec<Mat3> = moment.iter().map(inverse_of).collect();
        let shape: Vec<Sym3> = each().map(|i| self.shape_of(i, &moment[i])).collect();
        if closed {
            let straight: Vec<Mat3> = each().map(|i| self.straight_moment(i, &inverse)).collect();
            self.correction = straight.iter().map(inverse_of).collect();
            self.trace.fill(1.0);
        }
        self.shape = shape;
        let (shape, trace) = (&self.shape, &self.trace);
        self.fluid
            .for_each_mut_with(&mut self.bells, |i, link, bell| {
                let j = link.j as usize;
                let g = vector(link.gradient);
                let weight = 0.5 * (along(&shape[i], &g) + along(&shape[j], &g));
                let mean = 0.5 * (trace[i] + trace[j]);
                bell.steepness *= (mean * weight.max(LEAST_WEIGHT)) as f32;
                if closed {
                    link.gradient = rounded(&((inverse[i] + inverse[j]) * g * 0.5));
                }
            });
        if closed {
            let straight = |i: usize, g: [f32; 3]| rounded(&(inverse[i] * vector(g)));
            self.wall
                .for_each_mut(|i, pair| pair.gradient = straight(i, pair.gradient));
            self.of_wall
                .for_each_mut(|_, pair| pair.gradient = straight(pair.i as usize, pair.gradient));
            self.moment = moment;
        } else {
            self.correction = inverse;
        }
    }

    /// V_b ∇W_ib of the kernel itself [1/m].
    #[inline]
    pub(super) fn kernel_gradient(&self, i: usize, pair: &WallPair) -> Vec3 {
        let held = vector(pair.gradient);
        self.moment.get(i).map_or(held, |moment| moment * held)
    }

    /// Weight of a wall particle in the compact Laplacian, its field not carried on behind the surface [1/m²].
    #[inline]
    pub(super) fn wall_weight(&self, i: usize, pair: &WallPair) -> Real {
        let weight = match self.shape.get(i) {
            Some(shape) => along(shape, &self.kernel_gradient(i, pair)).max(LEAST_WEIGHT),
            None => 1.0 / self.trace[i],
        };
        2.0 * Real::from(pair.steepness) * weight
    }

    /// Every neighbour of i by 1/(V F) and V ∇W = −V F x, and which fluid particle it is.
    fn each_neighbour(&self, i: usize, mut visit: impl FnMut(Real, Vec3, Option<usize>)) {
        let mut one = |gradient: [f32; 3], steepness: f32, j| {
            let g = vector(gradient);
            if steepness > 0.0 {
                visit(Real::from(steepness).recip(), g, j);
            }
        };
        for (link, bell) in self.fluid.row(i).iter().zip(self.bells.row(i)) {
            one(link.gradient, bell.steepness, Some(link.j as usize));
        }
        for pair in self.wall.row(i) {
            one(pair.gradient, pair.steepness, None);
        }
    }

    /// −Σ V x ⊗ ∇W.
    fn moment_of(&self, i: usize) -> Mat3 {
        let mut moment = Mat3::zeros();
        self.each_neighbour(i, |inverse_steepness, g, _| {
            moment += g * g.transpose() * inverse_steepness;
        });
        moment
    }

    /// The same with straightened gradients.
    fn straight_moment(&self, i: usize, inverse: &[Mat3]) -> Mat3 {
        let mut moment = Mat3::zeros();
        self.each_neighbour(i, |inverse_steepness, g, j| {
            let b = j.map_or(inverse[i], |j| (inverse[i] + inverse[j]) * 0.5);
            moment += g * (b * g).transpose() * inverse_steepness;
        });
        moment
    }

    /// S; the plain Laplacian stays where neighbours are on one side or too few for the `moment` to be sound: a drop that
    /// leaves a body and has but some at the rim of its kernel would be tied to them a dozen times too hard.
    fn shape_of(&self, i: usize, moment: &Mat3) -> Sym3 {
        let plain = Sym3::IDENTITY * (1.0 / self.trace[i]);
        if self.one_sided(i) || !is_sound(moment) {
            return plain;
        }
        let mut fourth = Matrix6::<Real>::zeros();
        self.each_neighbour(i, |inverse_steepness, g, _| {
            let q = Vector6::new(
                g.x * g.x,
                g.y * g.y,
                g.z * g.z,
                SQRT_2 * g.x * g.y,
                SQRT_2 * g.x * g.z,
                SQRT_2 * g.y * g.z,
            );
            fourth += q * q.transpose() * (inverse_steepness / g.norm_squared());
        });
        let identity = Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0);
        let Some(found) = fourth.cholesky() else {
            return plain;
        };
        let s = found.solve(&identity);
        Sym3 {
            xx: s[0],
            yy: s[1],
            zz: s[2],
            xy: FRAC_1_SQRT_2 * s[3],
            xz: FRAC_1_SQRT_2 * s[4],
            yz: FRAC_1_SQRT_2 * s[5],
        }
    }

    /// Whether i has neighbours on one side only; before gradients are straightened.
    pub fn one_sided(&self, i: usize) -> bool {
        self.is_one_sided(&self.crowding(i))
    }

    /// The same of what is crowded so [1/m].
    pub fn is_one_sided(&self, crowding: &Vec3) -> bool {
        crowding.norm() * self.spacing > ONE_SIDED
    }
}

/// The inverse of a moment, the identity where that is ill-conditioned: there the plain gradient stays.
fn inverse_of(moment: &Mat3) -> Mat3 {
    let inverse = is_sound(moment).then(|| moment.try_inverse()).flatten();
    inverse.unwrap_or_else(Mat3::identity)
}

fn is_sound(moment: &Mat3) -> bool {
    moment.determinant() > LEAST_DETERMINANT
}

/// e·S e with e along `g`.
#[inline]
fn along(shape: &Sym3, g: &Vec3) -> Real {
    let squared = g.norm_squared();
    if squared > 0.0 {
        shape.times(g).dot(g) / squared
    } else {
        1.0
    }
}

fn rounded(g: &Vec3) -> [f32; 3] {
    [g.x as f32, g.y as f32, g.z as f32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::sph::operators::{Mean, laplacian_weight, velocity_gradient, viscous_force};
    use crate::sph::{Domain, Kernel, PressureOperator};

    const STRAIN: [Real; 3] = [1.4, 0.7, 1.0 / (1.4 * 0.7)];

    /// A lattice of spacing 1, drawn out by `STRAIN` and a little disordered; its box is periodic.
    fn strained(disorder: Real) -> (Vec<Vec3>, Domain, Kernel) {
        let cells = [10, 20, 14];
        let size = Vec3::from_fn(|a, _| Real::from(cells[a]) * STRAIN[a]);
        let mut position = Vec::new();
        for x in 0..cells[0] {
            for y in 0..cells[1] {
                for z in 0..cells[2] {
                    let at = Vec3::new(x.into(), y.into(), z.into()).add_scalar(0.5);
                    let wobble = at.map(|c: Real| disorder * libm::sin(17.0 * c + 5.0 * at.sum()));
                    position.push((at + wobble).component_mul(&Vec3::from(STRAIN)));
                }
            }
        }
        let bounds = Aabb {
            min: Vec3::zeros(),
            max: size,
        };
        (
            position,
            Domain {
                bounds,
                periodic: [true; 3],
            },
            Kernel::new(2.4),
        )
    }

    /// Particles more than a support radius from the seam, where a linear field jumps.
    fn inner(position: &[Vec3], domain: &Domain) -> Vec<usize> {
        let inside = |x: &Vec3| (0..3).all(|a| x[a] > 2.5 && x[a] < domain.bounds.max[a] - 2.5);
        (0..position.len())
            .filter(|&i| inside(&position[i]))
            .collect()
    }

    #[test]
    fn strained_lattices_neither_see_a_divergence_that_is_not_there_nor_miss_a_gradient() {
        let (position, domain, kernel) = strained(0.05);
        let velocity: Vec<Vec3> = position.iter().map(|x| Vec3::new(x.x, -x.y, 0.0)).collect();
        let worst = |near: &Neighbourhood| {
            let rate = PressureOperator { near }.volume_rate(&velocity);
            let inner = inner(&position, &domain);
            assert!(!inner.is_empty());
            inner
                .iter()
                .map(|&i| (rate[i] / near.rest_volume).abs())
                .fold(0.0, Real::max)
        };
        let mut near = Neighbourhood::without_walls(&position, 1.0, &kernel, &domain);
        let plain = worst(&near);
        near.straighten(true);
        assert!(
            plain > 0.05 && worst(&near) < 0.01,
            "{plain} {}",
            worst(&near)
        );
        let gradient = velocity_gradient(&near, &velocity);
        for i in inner(&position, &domain) {
            let error = gradient[i] - Mat3::from_diagonal(&Vec3::new(1.0, -1.0, 0.0));
            assert!(error.norm() < 1e-5, "{error}");
        }
    }

    #[test]
    fn strained_lattices_resist_alike_in_every_direction() {
        let (position, domain, kernel) = strained(0.0);
        for closed in [false, true] {
            for axis in 0..3 {
                let curved: Vec<Vec3> = position
                    .iter()
                    .map(|x| Vec3::x() * (x[axis] * x[axis]))
                    .collect();
                let mut near = Neighbourhood::without_walls(&position, 1.0, &kernel, &domain);
                let eta = vec![1.0; position.len()];
                let of = |near: &Neighbourhood| {
                    let force = viscous_force(near, &eta, Mean::Arithmetic, &curved, false);
                    force[inner(&position, &domain)[0]].x / near.rest_volume
                };
                let plain = of(&near);
                near.straighten(closed);
                assert!(
                    (of(&near) - 2.0).abs() < 0.01,
                    "axis {axis}: {plain} {}",
                    of(&near)
                );
            }
        }
    }

    #[test]
    fn pairs_stay_equal_and_opposite() {
        let (position, domain, kernel) = strained(0.1);
        let mut near = Neighbourhood::without_walls(&position, 1.0, &kernel, &domain);
        near.straighten(true);
        for i in 0..near.len() {
            for pair in near.pairs(i) {
                let back = near.pairs(pair.j as usize).find(|p| p.j as usize == i);
                let back = back.expect("neighbours know each other");
                assert_eq!(pair.gradient, back.gradient.map(|g| -g));
                assert_eq!(pair.steepness, back.steepness);
            }
        }
    }

    /// Nine neighbours far out, all round: their sum has no direction, and what it says of directions is next to nothing.
    #[test]
    fn a_drop_with_some_neighbours_at_the_rim_is_not_tied_to_them() {
        let mut position = vec![Vec3::zeros()];
        for k in 0..9 {
            let z = (Real::from(k) - 4.0) / 4.5;
            let (sin, cos) = libm::sincos(2.4 * Real::from(k));
            let across = (1.0 - z * z).sqrt();
            let far = 1.75 + 0.05 * Real::from(k);
            position.push(Vec3::new(cos * across, sin * across, z) * far);
        }
        let bounds = Aabb {
            min: Vec3::repeat(-5.0),
            max: Vec3::repeat(5.0),
        };
        let domain = Domain {
            bounds,
            periodic: [false; 3],
        };
        let mut near = Neighbourhood::without_walls(&position, 1.0, &Kernel::new(2.4), &domain);
        assert!(!near.one_sided(0) && near.compression[0] < 0.5);
        let tie = |near: &Neighbourhood| -> Real {
            let pairs = near.pairs(0);
            pairs.map(|pair| laplacian_weight(near, 0, &pair)).sum()
        };
        let plain = tie(&near);
        near.straighten(false);
        assert!(
            (tie(&near) / plain - 1.0).abs() < 1e-3,
            "{plain} {}",
            tie(&near)
        );
    }
}
