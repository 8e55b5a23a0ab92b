//! What moves: volume between phases, particles with the mixture, past walls that may move themselves, pistons,
//! and rows that become fluid.

use super::mover::{Placed, Scenery};
use super::stepper::Stepper;
use crate::fluid::transfer;
use crate::math::{Real, Vec3};
use crate::solid::Solid;
use crate::sph::PressureOperator;
use rayon::prelude::*;

impl Stepper<'_> {
    /// Eqs 8, 9: volume and momentum move between the phases of neighbours.
    pub fn transfer_phases(&mut self) {
        if self.mixes() {
            transfer::advance(&self.settings.cement, self.fluid, self.near, self.dt);
        } else {
            transfer::unite_vanished_phases(&self.settings.cement, self.fluid);
        }
        self.mix.refresh_velocity(self.fluid);
    }

    /// x ← x + dt v_mix, and who meets a wall keeps no velocity into it; pistons advance and their rows become fluid.
    pub fn move_particles(&mut self) {
        let dt = self.dt;
        let shift = self.shift();
        let velocity = self.carrying_velocity();
        let (near, domain) = (&self.near, self.domain);
        let before = self.around.at(self.time);
        let after = self.around.at(self.time + dt);
        let most_depth = MOST_DEPTH * self.settings.spacing;
        let mixed = &self.mix.velocity;
        self.fluid
            .position
            .par_iter_mut()
            .zip(&mut self.fluid.phase_velocity)
            .enumerate()
            .with_min_len(128)
            .for_each(|(i, (x, phases))| {
                let aim = *x + velocity[i] * dt + shift[i];
                if near.wall.row(i).is_empty() {
                    *x = domain.wrapped(aim);
                    return;
                }
                let (kept, wall) = beside_all(&before, &after, x, aim, most_depth);
                let way = kept - aim;
                if let Some(outward) = way.try_normalize(0.0) {
                    let into = (wall / dt - mixed[i]).dot(&outward);
                    let stopped = outward * into.clamp(0.0, way.norm() / dt);
                    phases.liquid += stopped;
                    phases.polymer += stopped;
                }
                *x = domain.wrapped(kept);
            });
        self.book_shift();
        self.measure_inlet_pressure();
        let rest_volume = self.near.rest_volume;
        let mut next_id = self.fluid.id.iter().max().map_or(0, |id| id + 1);
        for (number, inlet) in self.inlets.iter_mut().enumerate() {
            inlet.advance(dt);
            while let Some(row) = inlet.emit(rest_volume) {
                let velocity = inlet.settings.direction * inlet.speed();
                for position in row {
                    self.fluid.push(
                        position,
                        velocity,
                        inlet.settings.polymer_fraction,
                        next_id,
                        number as u16 + 1,
                    );
                    if let Some(pressure) = self.fluid.pressure.last_mut() {
                        pressure[0] = inlet.pressure;
                    }
                    next_id += 1;
                }
            }
        }
    }

    /// What the fluid presses against each piston with.
    fn measure_inlet_pressure(&mut self) {
        let operator = PressureOperator { near: self.near };
        let pressure: Vec<Real> = self.fluid.pressure.iter().map(|p| p[0]).collect();
        for (number, inlet) in self.inlets.iter_mut().enumerate() {
            inlet.pressure = operator.piston_pressure(number as u16, &pressure);
        }
    }
}

/// How far a particle's centre may lie inside the solid, in spacings: the true surface of a rough wall is only
/// known that well to the particles, and holding them off it costs flow and stability.
const MOST_DEPTH: Real = 0.3;

/// Past every wall in turn, each in its own frame, where it stands still: what a blade catches goes with the blade.
/// Walls at rest come last, so that nothing is pushed through them. Also how far the wall that was met went itself.
fn beside_all(
    before: &Scenery<'_>,
    after: &Scenery<'_>,
    from: &Vec3,
    aim: Vec3,
    most_depth: Real,
) -> (Vec3, Vec3) {
    let (mut x, mut gone) = (aim, Vec3::zeros());
    for (Placed { solid, pose }, then) in after.movers.iter().zip(&before.movers) {
        let goal = pose.start(&x);
        let kept = beside(solid, &then.pose.start(from), goal, most_depth);
        if kept != goal {
            x = pose.place(&kept);
            gone = x - then.pose.place(&kept);
        }
    }
    let kept = beside(after.solid, from, x, most_depth);
    if kept != x {
        gone = Vec3::zeros();
    }
    (kept, gone)
}

/// Where a particle comes to rest that aims at a point too deep inside the solid, or behind it: as deep as allowed, on
/// the side it came from. Without it slow creep takes one particle in a thousand through a strut.
fn beside(solid: &Solid, from: &Vec3, aim: Vec3, most_depth: Real) -> Vec3 {
    let (phi, normal) = solid.distance(&aim);
    // A path that meets the solid ends no farther from it than it is long.
    if phi >= (aim - from).norm() {
        return aim;
    }
    let (start, outward) = solid.distance(from);
    let (mut x, mut phi, mut normal) = if normal.dot(&outward) < 0.0 {
        before_the_middle(solid, from, &outward, aim, most_depth)
    } else {
        (aim, phi, normal)
    };
    if phi >= -most_depth {
        return x;
    }
    for _ in 0..4 {
        if normal.dot(&outward) < 0.0 {
            // Behind the middle of a thin wall: the near way out is the wrong one.
            return *from;
        }
        x -= normal * (phi + most_depth);
        (phi, normal) = solid.distance(&x);
        if phi >= -most_depth - 1e-9 {
            return x;
        }
    }
    if phi > start { x } else { *from }
}

/// The last point of a path that is still on the near side of a wall, with its distance and normal: where the way out
/// turns over inside the solid is the wall's middle (in the fluid it is the middle of a gap, which may be passed).
/// A wall thinner than twice the depth allowed holds nothing otherwise.
fn before_the_middle(
    solid: &Solid,
    from: &Vec3,
    outward: &Vec3,
    aim: Vec3,
    most_depth: Real,
) -> (Vec3, Real, Vec3) {
    let path = aim - from;
    let pieces = (path.norm() / (PIECE * most_depth)).ceil().max(1.0);
    let (mut near, mut facing) = (*from, *outward);
    let mut at_near = solid.distance(from).0;
    for piece in 1..=pieces as usize {
        let x = from + path * (piece as Real / pieces);
        let (phi, normal) = solid.distance(&x);
        if phi < 0.0 && normal.dot(&facing) < 0.0 {
            break;
        }
        (near, at_near, facing) = (x, phi, normal);
    }
    (near, at_near, facing)
}

/// How finely a path is looked at, in depths allowed.
const PIECE: Real = 0.25;
