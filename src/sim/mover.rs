//! Walls that move: rigid solids, each known in its own frame, and what they and the walls at rest are together.

use super::motion_law::{Motion, Pose};
use crate::math::{Real, Vec3};
use crate::solid::Solid;
use crate::sph::{Domain, Kernel, MovingWalls, WallParticles, Walls};

/// A rigid wall and its law of motion, as given.
#[derive(Clone, Debug)]
pub struct MovingSolid {
    /// How it moves.
    pub motion: Motion,
    /// Where it is at the start.
    pub solid: Solid,
    /// Its particles at the start.
    pub particles: WallParticles,
}

/// The same, ready to be felt by fluid. What changes with time is a function of time: no state.
#[derive(Clone, Debug)]
pub struct Mover {
    motion: Motion,
    solid: Solid,
    walls: Walls,
    /// Largest distance of a particle from the axis [m].
    reach: Real,
}

impl Mover {
    /// Depths and sums over its own particles, which no motion changes.
    pub fn new(given: MovingSolid, kernel: &Kernel, domain: &Domain) -> Self {
        let MovingSolid {
            motion,
            solid,
            particles,
        } = given;
        let point = motion.twist(0.0).point;
        let reach = particles.position.iter().map(|x| (x - point).norm());
        let reach = reach.fold(0.0, Real::max);
        let walls = Walls::new(particles, kernel, domain, |x| -solid.distance(x).0);
        Self {
            motion,
            solid,
            walls,
            reach,
        }
    }

    /// Adds its particles as they are at `time` [s].
    pub fn stand(&self, time: Real, domain: &Domain, walls: &mut MovingWalls) {
        let (pose, twist) = (self.motion.pose(time), self.motion.twist(time));
        let particles = &self.walls.particles;
        for (b, start) in particles.position.iter().enumerate() {
            let x = pose.place(start);
            walls.position.push(domain.wrapped(x));
            walls.velocity.push(twist.at(&x));
            walls.spin.push(twist.spin);
            walls.volume.push(particles.volume[b]);
            walls.depth.push(Some(self.walls.depth[b]));
            walls.own_sum.push(self.walls.own_sum[b]);
            walls.inlet.push(None);
        }
    }

    /// Velocities of its particles at `time` [m/s].
    pub fn velocities(&self, time: Real) -> impl Iterator<Item = Vec3> {
        let (pose, twist) = (self.motion.pose(time), self.motion.twist(time));
        let particles = self.walls.particles.position.iter();
        particles.map(move |start| twist.at(&pose.place(start)))
    }

    /// Speed of its fastest point at `time` [m/s].
    pub fn speed(&self, time: Real) -> Real {
        self.motion.most_speed(time, self.reach)
    }

    /// Largest step from `time` in which no point of it moves further than `most` [m], up to `longest` [s].
    pub fn most_step(&self, time: Real, most: Real, longest: Real) -> Real {
        // Speeds only grow along a ramp, so that the speed at the end of a step bounds it.
        let holds = |dt: Real| dt * self.speed(time + dt) <= most;
        let (mut low, mut high) = (0.0, longest);
        if holds(longest) {
            return longest;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if holds(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// How many particles it has.
    pub fn len(&self) -> usize {
        self.walls.particles.position.len()
    }
}

/// Everything solid: walls at rest and walls that move.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// At rest.
    pub solid: &'a Solid,
    /// Moving.
    pub movers: &'a [Mover],
}

impl<'a> Surroundings<'a> {
    /// As it is at `time` [s].
    pub fn at(&self, time: Real) -> Scenery<'a> {
        let placed = self.movers.iter().map(|mover| Placed {
            solid: &mover.solid,
            pose: mover.motion.pose(time),
        });
        Scenery {
            solid: self.solid,
            movers: placed.collect(),
        }
    }
}

/// Everything solid at one time.
pub struct Scenery<'a> {
    /// Walls at rest.
    pub solid: &'a Solid,
    /// Walls that move, each in its place.
    pub movers: Vec<Placed<'a>>,
}

/// A solid that is not where it was at the start.
pub struct Placed<'a> {
    /// In its place at the start.
    pub solid: &'a Solid,
    /// Where that is now.
    pub pose: Pose,
}

impl Scenery<'_> {
    /// φ at `x` [m] and its unit gradient.
    pub fn distance(&self, x: &Vec3) -> (Real, Vec3) {
        let mut nearest = self.solid.distance(x);
        for Placed { solid, pose } in &self.movers {
            let (phi, normal) = solid.distance(&pose.start(x));
            if phi < nearest.0 {
                nearest = (phi, pose.rotation * normal);
            }
        }
        nearest
    }
}
