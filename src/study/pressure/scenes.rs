//! Scenes of deep and confined flow: a pipe, a needle whose end opens into pores with closed ends, an array of struts.

use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Aabb, Real, Vec3};
use crate::sim::{Body, BodyShape, Inlet, Scheme, TimeStep};
use crate::solid::{Shape, Solid, wall_particles};
use crate::study::scenes::{Place, body, newtonian, settings};
use serde::Serialize;
use std::f64::consts::PI;

/// Distance between particles [m].
pub const SPACING: Real = 0.5e-3;
/// Mean speed where fluid comes in [m/s].
pub const SPEED: Real = 0.02;
/// Share of a spacing that the fastest particle may move in a step.
const CFL: Real = 0.4;
const DENSITY: Real = 1070.0;
/// How far walls stand above the fluid at the start, in spacings. What comes out there goes on freely: a column that rose
/// between walls would press back the more, the more has come.
const ABOVE: Real = 1.0;
/// Room above that for what comes out, in spacings on top of how far it comes in.
const ROOM: Real = 16.0;

/// Where fluid is pressed through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Vessel {
    /// A pipe of this radius, full to this depth, in spacings.
    Pipe { radius: Real, depth: u32 },
    /// A needle five spacings wide that opens into a pore with three annular side pores, whose ends are closed.
    Pores,
    /// A vessel twelve spacings wide, crossed by struts.
    Array,
}

impl Vessel {
    /// What the tables call it.
    pub fn name(self) -> String {
        match self {
            Self::Pipe { depth, .. } => format!("pipe {depth} deep"),
            Self::Pores => "needle into closed pores".into(),
            Self::Array => "array of struts".into(),
        }
    }

    /// Radius where fluid comes in, and its depth, in spacings.
    fn size(self) -> (Real, Real) {
        match self {
            Self::Pipe { radius, depth } => (radius, Real::from(depth)),
            Self::Pores => (2.5, 26.0),
            Self::Array => (6.0, 20.0),
        }
    }

    fn walls(self) -> Vec<Shape> {
        let dx = SPACING;
        let tube = |from: Real, to: Real, inner: Real, outer: Real| Shape::Tube {
            base: Vec3::z() * from * dx,
            axis: Vec3::z(),
            length: (to - from) * dx,
            inner: inner * dx,
            outer: outer * dx,
        };
        let (radius, depth) = self.size();
        let top = depth + ABOVE;
        match self {
            Self::Pipe { .. } => vec![tube(-4.0, top, radius, radius + 4.0)],
            Self::Pores => {
                let mut walls = vec![
                    tube(-4.0, 10.0, radius, 11.0),
                    // What is left open between rings are pores without a way out.
                    tube(10.0, depth + 0.5, 7.5, 11.0),
                ];
                for ring in 0..3 {
                    let from = 13.0 + 4.5 * Real::from(ring);
                    walls.push(tube(from, from + 1.5, 3.5, 8.0));
                }
                walls.push(tube(25.0, top, 3.5, 8.0));
                walls
            }
            Self::Array => {
                let mut walls = vec![tube(-4.0, top, radius, radius + 4.0)];
                for layer in 0..4 {
                    let z = 5.0 + 3.6 * Real::from(layer);
                    let (along, across) = if layer % 2 == 0 {
                        (Vec3::x(), Vec3::y())
                    } else {
                        (Vec3::y(), Vec3::x())
                    };
                    for side in [-1.0, 1.0] {
                        let place = across * (2.7 * side) + Vec3::z() * z;
                        walls.push(Shape::Cylinder {
                            base: (place - along * 8.0) * dx,
                            axis: along,
                            length: 16.0 * dx,
                            radius: 1.2 * dx,
                            hollow: false,
                        });
                    }
                }
                walls
            }
        }
    }
}

/// A run: what flows where, how it is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pressed {
    /// Where.
    pub vessel: Vessel,
    /// Viscosity [Pa·s]; of the polymer where the fluid has a memory.
    pub viscosity: Real,
    /// λ [s]; 0: Newtonian.
    pub relaxation_time: Real,
    /// CFL steps.
    pub step: Real,
    /// How far the inflow comes until the end, in spacings.
    pub travel: Real,
    /// Seed of the start's jitter; 0: a lattice.
    pub seed: u64,
}

/// As large as the CFL limit allows what comes in [s].
fn cfl_step() -> Real {
    CFL * SPACING / SPEED
}

impl Pressed {
    fn cement(&self) -> Cement {
        if self.relaxation_time == 0.0 {
            return newtonian(DENSITY, self.viscosity);
        }
        Cement {
            polymer: PhaseMaterial {
                density: DENSITY,
                viscosity: self.viscosity,
            },
            relaxation_time: self.relaxation_time,
            thinning: 0.5,
            ..newtonian(DENSITY, 0.01)
        }
    }

    /// Height above which fluid counts as let through [m].
    pub fn level(&self) -> Real {
        (self.vessel.size().1 - 4.0) * SPACING
    }

    /// Simulated time [s].
    pub fn duration(&self) -> Real {
        self.travel * SPACING / SPEED
    }

    /// The scene, full of fluid to its depth, with a piston below.
    pub fn place(&self) -> Place {
        let dx = SPACING;
        let (radius, depth) = self.vessel.size();
        let domain = Aabb {
            min: Vec3::new(-14.0, -14.0, -4.0) * dx,
            max: Vec3::new(14.0, 14.0, depth + self.travel + ROOM) * dx,
        };
        let mut s = settings(dx, domain);
        s.scheme = if self.relaxation_time > 0.0 {
            Scheme::ImmCt
        } else {
            Scheme::Dfsph
        };
        s.cement = self.cement();
        s.duration = self.duration();
        s.seed = self.seed;
        s.jitter = if self.seed == 0 { 0.0 } else { 0.1 };
        // Full to the walls: gaps there would take up all that flows in before anything comes out.
        s.bodies = vec![Body {
            saturated: true,
            ..body(
                BodyShape::Cylinder {
                    base: Vec3::z() * 0.5 * dx,
                    axis: Vec3::z(),
                    length: (depth - 0.5) * dx,
                    radius: 8.0 * dx,
                },
                1.0,
            )
        }];
        let flow_rate = SPEED * PI * (radius * dx).powi(2);
        s.inlets = vec![Inlet {
            name: "piston".into(),
            position: Vec3::zeros(),
            direction: Vec3::z(),
            diameter: 2.0 * radius * dx,
            flow_rate,
            polymer_fraction: 1.0,
            dose: 1.001 * flow_rate * s.duration,
        }];
        // The CFL limit of the fastest particle, wherever that is.
        s.time_step = TimeStep::Adaptive {
            min: 1e-9,
            max: self.step * cfl_step(),
            cfl: self.step * CFL,
        };
        let solid = Solid {
            shapes: self.vessel.walls(),
            grids: Vec::new(),
        };
        let region = Aabb {
            min: Vec3::new(-12.0, -12.0, -4.0) * dx,
            max: Vec3::new(12.0, 12.0, depth + ABOVE) * dx,
        };
        let walls = wall_particles(&solid, &region, dx, (s.support_ratio - 0.4) * dx);
        Place {
            settings: s,
            solid,
            walls,
            moving: Vec::new(),
        }
    }
}
