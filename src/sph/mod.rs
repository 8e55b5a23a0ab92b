//! Smoothed particle hydrodynamics that knows no phases: kernel, neighbour rows, walls, operators, solvers.

mod apgd;
mod cells;
mod coarse;
mod contact;
mod coupled;
mod kernel;
mod meeting;
mod minres;
mod mobility;
mod neighbourhood;
pub mod operators;
mod pairs;
pub mod power;
mod preconditioner;
mod pressure;
mod repeated;
mod rows;
mod saddle;
mod straighten;
mod walls;

pub use apgd::{ApgdGoal, PressureOutcome, solve_pressure};
pub use cells::{Cells, Domain};
pub use contact::Contact;
pub use coupled::{CoupledGoal, CoupledOutcome, CoupledProblem, CoupledSolver};
pub use kernel::Kernel;
pub use neighbourhood::{Neighbourhood, Standing};
pub use pairs::{FluidOfWall, Link, Pair, WallPair, vector};
pub use pressure::{PressureOperator, Source};
pub use repeated::RepeatedPressure;
pub use rows::Rows;
pub use walls::{MovingWalls, WallParticles, Walls};
