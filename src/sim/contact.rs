//! Contact with walls: how deep a particle may lie in one, what holds it there within a solve, and where it ends that
//! aims deeper.

use super::mover::{Placed, Scenery};
use super::stepper::Stepper;
use crate::math::{Mat3, Real, Vec3};
use crate::solid::Solid;
use crate::sph::Contact;
use rayon::prelude::*;

impl Stepper<'_> {
    /// Particles that a thin wall may have to hold in this step: those less than a spacing from the nearest wall, where
    /// that is thin. (Thick ones push well enough.)
    pub(super) fn contacts(&self) -> Vec<Contact> {
        let dt = self.dt;
        let spacing = self.settings.spacing;
        let before = self.around.at(self.time);
        let after = self.around.at(self.time + dt);
        (0..self.fluid.len())
            .into_par_iter()
            .with_min_len(128)
            .filter(|&i| !self.near.wall.row(i).is_empty())
            .filter_map(|i| {
                let x = self.fluid.position[i];
                let (mut solid, mut at) = (before.solid, x);
                let (mut phi, mut normal) = solid.distance(&x);
                let (mut turned, mut carried) = (Mat3::identity(), Vec3::zeros());
                for (placed, then) in before.movers.iter().zip(&after.movers) {
                    let start = placed.pose.start(&x);
                    let (other, outward) = placed.solid.distance(&start);
                    if other < phi {
                        (solid, at, phi, normal) = (placed.solid, start, other, outward);
                        turned = placed.pose.rotation;
                        carried = (then.pose.place(&start) - x) / dt;
                    }
                }
                if phi >= spacing || !thin(solid, &at, phi, &normal, MOST_DEPTH * spacing) {
                    return None;
                }
                let normal = turned * normal;
                Some(Contact {
                    particle: i as u32,
                    normal,
                    least: carried.dot(&normal) - phi.max(0.0) / dt,
                })
            })
            .collect()
    }
}

/// How far a particle's centre may lie inside the solid, in spacings: the true surface of a rough wall is only
/// known that well to the particles, and holding them off it costs flow and stability.
pub(super) const MOST_DEPTH: Real = 0.3;

/// Past every wall in turn, each in its own frame, where it stands still: what a blade catches goes with the blade.
/// Walls at rest come last, so that nothing is pushed through them. Also how far the wall that was met went itself.
pub(super) fn beside_all(
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
    // Nor does one that goes through: it has both ends outside. (The aim's normal need not tell: next to the far side of a
    // plate there may be another wall.)
    let (mut x, mut phi, mut normal) = if start.max(0.0) + phi.max(0.0) < (aim - from).norm() {
        before_the_middle(solid, (*from, start, outward), aim, most_depth)
    } else {
        (aim, phi, normal)
    };
    if phi >= 0.0 {
        return x;
    }
    let most_depth = if thin(solid, &x, phi, &normal, most_depth) {
        0.0
    } else {
        most_depth
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

/// Whether the wall next to or around `x` turns over within twice the depth allowed. Its one layer of particles pushes
/// ever less as one comes near, so nothing may sink into it.
fn thin(solid: &Solid, x: &Vec3, phi: Real, normal: &Vec3, most_depth: Real) -> bool {
    let deep = x - normal * (phi + 2.0 * most_depth);
    solid.distance(&deep).1.dot(normal) < 0.0
}

/// The last point of a path that is still on the near side of a wall, with its distance and normal, as given for the
/// point that it comes `from`: where the way out turns over inside the solid is the wall's middle (in the fluid it is the
/// middle of a gap, which may be passed). A wall thinner than twice the depth allowed holds nothing otherwise.
fn before_the_middle(
    solid: &Solid,
    from: (Vec3, Real, Vec3),
    aim: Vec3,
    most_depth: Real,
) -> (Vec3, Real, Vec3) {
    let path = aim - from.0;
    let pieces = (path.norm() / (PIECE * most_depth)).ceil().max(1.0);
    let mut near = from;
    for piece in 1..=pieces as usize {
        let x = from.0 + path * (piece as Real / pieces);
        let (phi, normal) = solid.distance(&x);
        if phi < 0.0 && normal.dot(&near.2) < 0.0 {
            break;
        }
        near = (x, phi, normal);
    }
    near
}

/// How finely a path is looked at, in depths allowed.
const PIECE: Real = 0.25;
