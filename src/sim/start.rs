//! Fluid that is there at the start: bodies filled on a lattice, carved where a wall or an earlier body is.

use super::mover::Scenery;
use super::settings::{BodyShape, Inside, SimSettings};
use crate::fluid::FluidParticles;
use crate::math::{Aabb, Real, Stream, Vec3, lattice};

/// Particles closer to a wall than this are carved away, or moved off it where they saturate pores, in spacings.
const CLEARANCE: Real = 0.25;

/// Fills the bodies; returns the particles and how many were carved away because a wall or an earlier body is there.
pub fn fill(settings: &SimSettings, around: &Scenery<'_>) -> (FluidParticles, usize) {
    let mut fluid = FluidParticles::default();
    let mut carved = 0;
    let mut random = Stream::new(settings.seed, "start");
    for (number, body) in settings.bodies.iter().enumerate() {
        let earlier = &settings.bodies[..number];
        let bounds = bounds(&body.shape);
        if bounds.is_empty() {
            continue;
        }
        // Half a spacing in from each face.
        let mut count = cells(&bounds.extent(), settings.spacing);
        if body.saturated {
            let free = |x: &Vec3| {
                holds(&body.shape, x)
                    && !earlier.iter().any(|other| holds(&other.shape, x))
                    && around.distance(x).0 >= 0.0
            };
            let mut random = Stream::new(settings.seed, "room");
            fit(&mut count, &bounds, settings.spacing, free, &mut random);
        }
        let step = bounds.extent().component_div(&count);
        for corner in lattice(&count) {
            let mut position = bounds.min + corner.add_scalar(0.5).component_mul(&step);
            if !holds(&body.shape, &position) {
                continue;
            }
            if earlier.iter().any(|other| holds(&other.shape, &position)) {
                carved += 1;
                continue;
            }
            if settings.jitter > 0.0 {
                position += random.cube() * (settings.jitter * settings.spacing);
            }
            let clearance = CLEARANCE * settings.spacing;
            let (phi, away) = around.distance(&position);
            // A lattice cut at the walls themselves has on average as many points as there is room for.
            if phi < if body.saturated { 0.0 } else { clearance } {
                carved += 1;
                continue;
            }
            if phi < clearance {
                position += away * (clearance - phi);
            }
            let id = fluid.len() as u32;
            fluid.push(position, body.velocity, body.polymer_fraction, id, 0);
        }
    }
    (fluid, carved)
}

/// How many cells, one a particle, fill a body from face to face along each axis.
///
/// The longest side makes up for what the others were rounded by, so that a cell is as large as a particle: a narrow
/// column would start a tenth denser or thinner than it is at rest.
fn cells(extent: &Vec3, spacing: Real) -> Vec3 {
    let mut count = extent.map(|e| (e / spacing).round().max(1.0));
    let longest = extent.imax();
    count[longest] = 1.0;
    let layers = extent.product() / (count.product() * spacing.powi(3));
    count[longest] = layers.round().max(1.0);
    count
}

/// Random points in each cell by which the room in a body is measured.
const PROBES: usize = 4;

/// Changes the layers across the longest side to as many as there is room for where `free`. A lattice that is cut at walls
/// has on average as many points as there is room for, but in a narrow pipe along it, cut alike in every layer, some per cent
/// more or fewer, and if it is deep many layers too many.
fn fit(
    count: &mut Vec3,
    bounds: &Aabb,
    spacing: Real,
    free: impl Fn(&Vec3) -> bool,
    random: &mut Stream,
) {
    let step = bounds.extent().component_div(count);
    let (mut held, mut room) = (0.0, 0.0);
    for corner in lattice(count) {
        let place = |within: Vec3| bounds.min + (corner + within).component_mul(&step);
        held += Real::from(u8::from(free(&place(Vec3::repeat(0.5)))));
        for _ in 0..PROBES {
            let within = random.cube().add_scalar(1.0) * 0.5;
            room += Real::from(u8::from(free(&place(within)))) / PROBES as Real;
        }
    }
    if held > 0.0 {
        let longest = bounds.extent().imax();
        let share = step.product() / spacing.powi(3);
        let layers = count[longest] * share * room / held;
        count[longest] = layers.round().max(1.0);
    }
}

fn bounds(shape: &BodyShape) -> Aabb {
    match shape {
        BodyShape::Box(bounds) => *bounds,
        BodyShape::Sphere { centre, radius } => Aabb {
            min: *centre,
            max: *centre,
        }
        .grown(*radius),
        BodyShape::Cylinder {
            base,
            axis,
            length,
            radius,
        } => {
            // A disc of radius r across the axis reaches r √(1 − a²) along a coordinate.
            let reach = axis.map(|a| radius * (1.0 - a * a).max(0.0).sqrt());
            let top = base + axis * *length;
            Aabb {
                min: base.inf(&top) - reach,
                max: base.sup(&top) + reach,
            }
        }
        BodyShape::Mesh(Inside(read)) => read.as_ref().map_or(Aabb::around([]), |read| read.0),
    }
}

fn holds(shape: &BodyShape, x: &Vec3) -> bool {
    match shape {
        BodyShape::Box(bounds) => bounds.contains(x),
        BodyShape::Sphere { centre, radius } => (x - centre).norm() <= *radius,
        BodyShape::Cylinder {
            base,
            axis,
            length,
            radius,
        } => {
            let along = (x - base).dot(axis);
            (0.0..=*length).contains(&along) && (x - base - axis * along).norm() <= *radius
        }
        BodyShape::Mesh(Inside(read)) => read.as_ref().is_some_and(|read| read.1.phi(x) < 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice has 52 points across a pipe of radius 4, which has room for 50.3; 16 across one of 2.5, with room for 19.6.
    #[test]
    fn what_saturates_a_narrow_pipe_is_as_much_as_it_has_room_for() {
        for (radius, across, deep) in [(4.0, 52.0, 100.0), (2.5, 16.0, 300.0)] {
            let bounds = Aabb {
                min: Vec3::new(-8.0, -8.0, 0.0),
                max: Vec3::new(8.0, 8.0, deep),
            };
            let free = |x: &Vec3| x.xy().norm() < radius;
            let mut count = cells(&bounds.extent(), 1.0);
            fit(&mut count, &bounds, 1.0, free, &mut Stream::new(3, "room"));
            let room = std::f64::consts::PI * radius * radius * deep;
            assert!((across * count.z / room - 1.0).abs() < 0.007, "{count}");
        }
    }

    #[test]
    fn a_box_of_any_size_holds_as_many_cells_as_particles_have_room_in_it() {
        let mut random = Stream::new(4, "cells");
        for _ in 0..1000 {
            let extent = random.cube().map(|c| 6.5 + 3.5 * c) * 0.5;
            let count = cells(&extent, 0.5);
            let volume = extent.product() / 0.125;
            // Half a layer across the longest side is the most that is too many or missing.
            let layer = count.product() / count[extent.imax()];
            assert!(
                (count.product() - volume).abs() <= 0.5 * layer + 1e-9,
                "{extent}: {count}"
            );
        }
        // Whole numbers stay as they are.
        assert_eq!(
            cells(&Vec3::new(2.0, 2.0, 4.0), 0.5),
            Vec3::new(4.0, 4.0, 8.0)
        );
        // A resting column a third coarser than it was made for: 592.6 particles have room.
        let coarse = cells(&Vec3::new(40.0, 40.0, 80.0), 6.0);
        assert_eq!(coarse, Vec3::new(7.0, 7.0, 12.0));
    }
}
