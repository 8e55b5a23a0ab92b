//! How a rigid wall moves: a closed formula of time, so that nothing of it has to be remembered across a stop.
//!
//! ```text
//! s(t) = t²/2T up to T, then t − T/2          T: ramp; speeds grow evenly from zero to full
//! turning      rotation by ω s about an axis
//! moving       shift by v s, at most `travel` far
//! oscillating  shift by a sin(2π f s)
//! ```

use crate::math::{Mat3, Real, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A law of motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Which way.
    pub path: Path,
    /// T: time in which the speed grows to its full value [s]; 0 for at once.
    pub ramp: Real,
}

/// Which way a wall moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// About an axis.
    Turning {
        /// A point on the axis [m].
        point: Vec3,
        /// Unit vector; anticlockwise around it.
        axis: Vec3,
        /// ω [rad/s].
        rate: Real,
    },
    /// Straight on.
    Moving {
        /// v [m/s].
        velocity: Vec3,
        /// It stops this far from its start [m]; infinite: never. (Kept as none in files, which know no infinity.)
        travel: Option<Real>,
    },
    /// To and fro about the start.
    Oscillating {
        /// a [m].
        amplitude: Vec3,
        /// f [1/s].
        frequency: Real,
    },
}

/// Where a rigid body is relative to its start: x = R x₀ + shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// R.
    pub rotation: Mat3,
    /// Shift [m].
    pub shift: Vec3,
}

/// Velocity field of a rigid body: v(x) = velocity + spin × (x − point).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// At `point` [m/s].
    pub velocity: Vec3,
    /// ω [rad/s].
    pub spin: Vec3,
    /// [m].
    pub point: Vec3,
}

impl Pose {
    /// Where a point of the body at its start is now.
    pub fn place(&self, start: &Vec3) -> Vec3 {
        self.rotation * start + self.shift
    }

    /// Where a point of the body that is at `x` now was at the start.
    pub fn start(&self, x: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(x - self.shift))
    }
}

impl Twist {
    /// Velocity at `x` [m/s].
    pub fn at(&self, x: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(&(x - self.point))
    }
}

impl Motion {
    /// s(t) [s].
    fn progress(&self, time: Real) -> Real {
        if time < self.ramp {
            0.5 * time * time / self.ramp
        } else {
            time - 0.5 * self.ramp
        }
    }

    /// ds/dt [1].
    fn speed_share(&self, time: Real) -> Real {
        if time < self.ramp {
            time / self.ramp
        } else {
            1.0
        }
    }

    /// Where the body is at a time [s].
    pub fn pose(&self, time: Real) -> Pose {
        let s = self.progress(time);
        let shifted = |shift| Pose {
            rotation: Mat3::identity(),
            shift,
        };
        match self.path {
            Path::Turning { point, axis, rate } => {
                let rotation = rotation(&axis, rate * s);
                Pose {
                    rotation,
                    shift: point - rotation * point,
                }
            }
            Path::Moving { velocity, travel } => {
                let far = velocity.norm() * s;
                let share = travel.map_or(1.0, |most| most / far.max(most));
                shifted(velocity * (s * share))
            }
            Path::Oscillating {
                amplitude,
                frequency,
            } => shifted(amplitude * libm::sin(TAU * frequency * s)),
        }
    }

    /// How the body moves at a time [s].
    pub fn twist(&self, time: Real) -> Twist {
        let share = self.speed_share(time);
        let straight = |velocity| Twist {
            velocity,
            spin: Vec3::zeros(),
            point: Vec3::zeros(),
        };
        match self.path {
            Path::Turning { point, axis, rate } => Twist {
                velocity: Vec3::zeros(),
                spin: axis * (rate * share),
                point,
            },
            Path::Moving { velocity, travel } => {
                let stopped =
                    travel.is_some_and(|most| velocity.norm() * self.progress(time) >= most);
                straight(if stopped {
                    Vec3::zeros()
                } else {
                    velocity * share
                })
            }
            Path::Oscillating {
                amplitude,
                frequency,
            } => {
                let phase = TAU * frequency * self.progress(time);
                straight(amplitude * (TAU * frequency * share * libm::cos(phase)))
            }
        }
    }

    /// Bound on the speed of any point within `reach` [m] of the axis, up to a time [m/s].
    pub fn most_speed(&self, time: Real, reach: Real) -> Real {
        self.speed_share(time)
            * match self.path {
                Path::Turning { rate, .. } => rate.abs() * reach,
                Path::Moving { velocity, .. } => velocity.norm(),
                Path::Oscillating {
                    amplitude,
                    frequency,
                } => TAU * frequency * amplitude.norm(),
            }
    }

    /// Farthest that it shifts from its start within a time [m]; turning does not shift.
    pub fn most_shift(&self, time: Real) -> Real {
        match self.path {
            Path::Turning { .. } => 0.0,
            Path::Moving { velocity, travel } => {
                let far = velocity.norm() * self.progress(time);
                travel.map_or(far, |most| far.min(most))
            }
            Path::Oscillating { amplitude, .. } => amplitude.norm(),
        }
    }
}

/// Rotation about a unit axis (Rodrigues); the identity at angle 0 to the last bit.
fn rotation(axis: &Vec3, angle: Real) -> Mat3 {
    let cross = axis.cross_matrix();
    // 1 − cos from the half angle keeps its digits when the angle is small.
    let half = libm::sin(0.5 * angle);
    Mat3::identity() + cross * libm::sin(angle) + cross * cross * (2.0 * half * half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motions() -> Vec<Motion> {
        let paths = [
            Path::Turning {
                point: Vec3::new(0.1, -0.2, 0.3),
                axis: Vec3::new(1.0, 2.0, -2.0) / 3.0,
                rate: -7.0,
            },
            Path::Moving {
                velocity: Vec3::new(0.3, 0.4, 0.0),
                travel: Some(0.2),
            },
            Path::Moving {
                velocity: Vec3::new(0.3, 0.4, 0.0),
                travel: None,
            },
            Path::Oscillating {
                amplitude: Vec3::new(0.0, 0.1, 0.2),
                frequency: 3.0,
            },
        ];
        let ramps = [0.0, 0.25];
        let with = |ramp| paths.map(|path| Motion { path, ramp });
        ramps.into_iter().flat_map(with).collect()
    }

    /// The twist is the time derivative of the pose, and the bounds hold.
    #[test]
    fn velocity_is_the_change_of_place() {
        for motion in motions() {
            let x0 = Vec3::new(0.4, 0.5, -0.6);
            let still = motion.pose(0.0);
            assert_eq!(still.rotation, Mat3::identity());
            assert!((still.place(&x0) - x0).norm() < 1e-15);
            for step in 1..80 {
                // Off the ends of the ramp and of the travel, where speeds have a kink.
                let t = 0.01 * f64::from(step) + 1.3e-3;
                let d = 1e-6;
                let slope =
                    (motion.pose(t + d).place(&x0) - motion.pose(t - d).place(&x0)) / (2.0 * d);
                let x = motion.pose(t).place(&x0);
                let v = motion.twist(t).at(&x);
                assert!((slope - v).norm() < 1e-8, "{motion:?} at {t}: {slope} {v}");
                assert!((motion.pose(t).start(&x) - x0).norm() < 1e-14);
                let reach = 2.0;
                assert!(v.norm() <= motion.most_speed(t, reach) * (1.0 + 1e-12));
                let shift = motion.pose(t).shift.norm();
                if !matches!(motion.path, Path::Turning { .. }) {
                    assert!(shift <= motion.most_shift(t) * (1.0 + 1e-12));
                }
            }
        }
    }

    #[test]
    fn half_a_turn_of_ramp_is_one_period_long() {
        let rate = TAU * 5.0;
        let motion = Motion {
            path: Path::Turning {
                point: Vec3::zeros(),
                axis: Vec3::z(),
                rate,
            },
            ramp: 0.2,
        };
        assert!((motion.pose(0.2).place(&Vec3::x()) + Vec3::x()).norm() < 1e-14);
        assert!((motion.twist(0.1).spin.z - 0.5 * rate).abs() < 1e-14);
    }

    #[test]
    fn a_stroke_ends_where_it_should() {
        let motion = motions()[1];
        assert!((motion.pose(10.0).shift.norm() - 0.2).abs() < 1e-15);
        assert_eq!(motion.twist(10.0).velocity, Vec3::zeros());
    }
}
