//! Velocity and pressure in one implicit solve, with p ≥ 0.
//!
//! ```text
//! [ H   P ] [v]   [ b ]      H = M/dt + K        K: compact Laplacian with no-slip walls
//! [ Pᵀ −C ] [k] = [−c ]      k ≥ 0,  s = c + Pᵀv − C k ≤ 0,  k s = 0
//! ```
//!
//! An outer active set F = {k > 0} ∪ {s > 0} around block MINRES (`minres`), which finds the correction to what the last
//! round left over: that in double precision, the correction in single. C is a graph Laplacian over F that damps pressure
//! modes which the velocity cannot see; it is zero on constants, so no inflow is lost, and does not know dt: what it lets
//! through is part of the answer. Particles that a wall has to hold lose their velocity along its normal as an unknown
//! (`contact`).
//! Preconditioner: two Chebyshev–Jacobi steps for H; for the pressure block viscosity and inertia by
//! particle, and a coarse level that knows the mobility of the fluid.

use super::coarse::Coarse;
use super::contact::{Contact, Contacts};
use super::minres::{self, Packed};
use super::mobility;
use super::neighbourhood::Neighbourhood;
use super::operators::{Mean, laplacian_weight, wall_friction};
use super::pressure::PressureOperator;
use super::rows::Rows;
use super::saddle::{Coupling, Drag};
use crate::math::{Real, Vec3, ordered_sum, ordered_sums};
use rayon::prelude::*;

/// Strength of the pressure stabilisation C.
const STABILISATION: Real = 0.1;
/// Steps over which inertia counts in C at most: what rests without weight would do it for ever.
const MOST_SETTLING: Real = 1e3;
/// A round whose set is not final anyway reduces its residual by this factor.
const LOOSE: Real = 0.3;
/// Share of the particles that may have entered or left the set in the last round if this one is to end the solve.
const SETTLED: Real = 0.01;
/// Where a body comes loose from what it pressed on the set shrinks a little at each; one round more than that ends it.
const MOST_OUTERS: usize = 40;
const MOST_INNER: usize = 300;
pub(super) const GRAIN: usize = 128;

/// One step's system.
pub struct CoupledProblem<'a> {
    /// Pairs.
    pub near: &'a Neighbourhood,
    /// Positions [m].
    pub position: &'a [Vec3],
    /// Effective masses [kg].
    pub mass: &'a [Real],
    /// Viscosity of K on each particle [Pa·s].
    pub viscosity: &'a [Real],
    /// How pairs of different viscosity resist.
    pub mean: Mean,
    /// Viscosity on top that resists only what changes in the step [Pa·s].
    pub lag: &'a [Real],
    /// Velocities from which the lag counts [m/s].
    pub likely: &'a [Vec3],
    /// Time step [s].
    pub dt: Real,
    /// Time over which inertia resists what C lets through [s]: not that of the step, or pressure would know of it.
    pub settling: Real,
    /// b without the parts of the walls and of the lag: M/dt v* plus explicit forces [N].
    pub force: &'a [Vec3],
    /// c without the walls' motion: excess volume / dt [m³/s].
    pub excess: &'a [Real],
    /// Whether the fluid has neither a free surface nor a way in or out. Then only differences of pressure mean
    /// anything, of either sign. On a disordered lattice its level is felt a little all the same (P 1 ≠ 0), enough for
    /// a solve that is free to choose it to hold particles in place with it, so it stays that of the guess.
    pub closed: bool,
    /// Particles that walls may have to hold, each at most once.
    pub contacts: Vec<Contact>,
}

/// Share of a spacing by which a particle may end the step too deep before it counts as held.
const SLACK: Real = 0.01;
/// After that many rounds whom walls hold stays as it is.
const MOST_CHANGES: usize = 10;

/// When the solve is good enough.
#[derive(Clone, Copy, Debug)]
pub struct CoupledGoal {
    /// Root mean square volume strain left over [1/s].
    pub strain_rate: Real,
    /// |Σ s| over the particles under pressure [m³/s].
    pub balance: Real,
    /// Σ |Σ s| over the coarse level's cells [m³/s]: what a long vessel may swallow in one place and give back in another.
    /// Infinite: anything.
    pub spread: Real,
    /// Root mean square velocity residual r_v/H_ii [m/s].
    pub velocity: Real,
    /// Share of the velocity residual of the guess that may be left where the step's change is smaller than that [1].
    pub reduction: Real,
}

/// What became of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoupledOutcome {
    /// MINRES iterations in all.
    pub iterations: usize,
    /// Rounds of the active set.
    pub outers: usize,
    /// Whether all goals were met.
    pub converged: bool,
    /// Volume strain left over [1/s].
    pub strain_rate: Real,
    /// Inflow left unbalanced [m³/s].
    pub balance: Real,
    /// Velocity residual [m/s].
    pub velocity: Real,
}

/// The assembled system.
pub struct CoupledSolver<'a> {
    pub(super) problem: CoupledProblem<'a>,
    pub(super) drags: Rows<Drag>,
    pub(super) couplings: Rows<Coupling>,
    /// H_ii [kg/s].
    pub(super) diagonal: Vec<Real>,
    /// Its inverse [s/kg].
    pub(super) inverse: Vec<Real>,
    /// b [N].
    force: Vec<Vec3>,
    /// c with the walls' part [m³/s].
    source: Vec<Real>,
    /// How hard the fluid round a particle is to push away, by its viscosity and inertia [Pa s/m³].
    pub(super) fine: Vec<Real>,
    /// The same of what does not hang on the step [Pa s/m³].
    firm: Vec<Real>,
    /// Mobility: velocity per force of a uniform push [m/(s N)].
    mobility: Vec<Real>,
    pub(super) active: Vec<bool>,
    pub(super) contacts: Contacts,
    pub(super) coarse: Coarse,
}

impl<'a> CoupledSolver<'a> {
    /// Assembles the system.
    pub fn new(problem: CoupledProblem<'a>) -> Self {
        let near = problem.near;
        let n = near.len();
        let volume = near.rest_volume;
        let (mut drags, mut couplings) = (Rows::default(), Rows::default());
        drags.rebuild_with(&mut couplings, n, |i, drags: &mut Vec<Drag>, couplings| {
            for pair in near.pairs(i) {
                let j = pair.j as usize;
                let eta = problem.mean.of(problem.viscosity[i], problem.viscosity[j])
                    + Mean::Arithmetic.of(problem.lag[i], problem.lag[j]);
                drags.push(Drag {
                    j: pair.j,
                    drag: (volume * eta * laplacian_weight(near, i, &pair)) as f32,
                });
                let [g_x, g_y, g_z] = pair.gradient;
                couplings.push([g_x, g_y, g_z, 0.0]);
            }
        });
        let lags = problem.lag.iter().any(|&lag| lag > 0.0);
        let rows: Vec<(Real, Vec3)> = (0..n)
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let (friction, carried) = wall_friction(near, i);
                let (viscosity, lag) = (problem.viscosity[i], problem.lag[i]);
                let own = problem.likely[i];
                let mut lagging = own * (lag * friction);
                if lags {
                    for pair in near.pairs(i) {
                        let j = pair.j as usize;
                        let lag = Mean::Arithmetic.of(lag, problem.lag[j]);
                        let weight = lag * laplacian_weight(near, i, &pair);
                        lagging += (own - problem.likely[j]) * weight;
                    }
                }
                let drags: Real = drags.row(i).iter().map(|p| Real::from(p.drag)).sum();
                (
                    problem.mass[i] / problem.dt + drags + volume * (viscosity + lag) * friction,
                    problem.force[i] + (carried * viscosity + lagging) * volume,
                )
            })
            .collect();
        let operator = PressureOperator { near };
        let carried = operator.volume_rate_with_walls(&vec![Vec3::zeros(); n]);
        let inertial = operator.diagonal(problem.mass);
        let mut solver = Self {
            drags,
            couplings,
            diagonal: rows.iter().map(|r| r.0).collect(),
            inverse: rows.iter().map(|r| 1.0 / r.0).collect(),
            force: rows.iter().map(|r| r.1).collect(),
            source: (0..n).map(|i| problem.excess[i] + carried[i]).collect(),
            fine: Vec::new(),
            firm: Vec::new(),
            mobility: Vec::new(),
            active: vec![false; n],
            contacts: Contacts::default(),
            coarse: Coarse::new(near, problem.position, &vec![false; n], &[]),
            problem,
        };
        let p = &solver.problem;
        // A particle without neighbours has no diagonal of its own.
        let least = 1e-3 * (volume / near.spacing).powi(2);
        let resistance = |i: usize, viscosity: Real, time: Real| {
            let inertial = inertial[i].max(least / p.mass[i]);
            viscosity / volume + 1.0 / (time * inertial)
        };
        let settling = p.settling.min(MOST_SETTLING * p.dt);
        (solver.fine, solver.firm) = (0..n)
            .map(|i| {
                (
                    resistance(i, p.viscosity[i] + p.lag[i], p.dt),
                    resistance(i, p.viscosity[i], settling),
                )
            })
            .unzip();
        solver.mobility = mobility::of_uniform_push(
            &solver.drags,
            &solver.diagonal,
            solver.problem.mass,
            solver.problem.dt,
        );
        solver
    }

    /// Solves, with `velocity` [m/s] and `pressure` [Pa] as the guess; `full(i)`: the neighbourhood has no gap.
    pub fn solve(
        &mut self,
        velocity: &mut [Vec3],
        pressure: &mut [Real],
        full: impl Fn(usize) -> bool,
        goal: &CoupledGoal,
    ) -> CoupledOutcome {
        let n = velocity.len();
        let volume = self.problem.near.rest_volume;
        let mut outcome = CoupledOutcome::default();
        if n == 0 {
            outcome.converged = true;
            return outcome;
        }
        let cold = pressure.iter().all(|&p| p == 0.0);
        let mut x: Vec<Packed> = (0..n)
            .map(|i| {
                [
                    velocity[i].x,
                    velocity[i].y,
                    velocity[i].z,
                    pressure[i].max(0.0),
                ]
            })
            .collect();
        // The first guess decides the cost: a set that starts too small grows ring by ring.
        self.active = vec![false; n];
        let mut image = self.image(&x);
        let guess = self.momentum_residual(&self.surplus(&image));
        let slack = SLACK * self.problem.near.spacing / self.problem.dt;
        self.contacts = Contacts::new(std::mem::take(&mut self.problem.contacts), slack, &x);
        let velocity_goal = goal
            .velocity
            .min((goal.reduction * guess).max(1e-3 * goal.velocity));
        let closed = self.problem.closed;
        let s = |i: usize| self.source[i] + image[i][3];
        let mut active: Vec<bool> = (0..n)
            .map(|i| {
                closed
                    || x[i][3] > 0.0
                    || if cold {
                        full(i) || s(i) > 0.0
                    } else {
                        s(i) > 0.0 && full(i)
                    }
            })
            .collect();
        let mut settled = false;
        let mut fresh = true;
        loop {
            if fresh {
                self.set_active(&active, settled);
                for i in 0..n {
                    if !active[i] {
                        x[i][3] = 0.0;
                    }
                }
                self.contacts.take_out(&mut x);
                self.contacts.impose(&mut x);
                image = self.image(&x);
            }
            let mut residual: Vec<Packed> = (0..n)
                .map(|i| {
                    let (f, a) = (self.force[i], image[i]);
                    let s = if active[i] {
                        -(self.source[i] + a[3])
                    } else {
                        0.0
                    };
                    [f.x - a[0], f.y - a[1], f.z - a[2], s]
                })
                .collect();
            self.level(&mut residual);
            self.contacts.take_out(&mut residual);
            let norms = |r: &[Packed<f32>]| {
                let [strain, speed, balance] = ordered_sums(n, |i| {
                    let [x, y, z, s] = r[i].map(Real::from);
                    let inverse = self.inverse[i];
                    [s * s, (x * x + y * y + z * z) * (inverse * inverse), s]
                });
                let mean = 1.0 / n as Real;
                [
                    (strain * mean).sqrt() / volume,
                    (speed * mean).sqrt(),
                    balance.abs(),
                ]
            };
            let spread = |r: &[Packed<f32>]| self.spread(goal, |i| Real::from(r[i][3]));
            let finest = [goal.strain_rate, velocity_goal, goal.balance, goal.spread];
            let reduction = if settled { 0.0 } else { LOOSE };
            let mut target = None;
            let residual = residual.iter().map(|r| r.map(|r| r as f32)).collect();
            let (correction, iterations) = minres::solve(&*self, residual, MOST_INNER, |r| {
                let [strain, speed, balance] = norms(r);
                let target: [Real; 4] = *target.get_or_insert_with(|| {
                    let left = [strain, speed, balance, spread(r)];
                    std::array::from_fn(|k| (reduction * left[k]).max(0.7 * finest[k]))
                });
                // The dearest last.
                strain <= target[0]
                    && speed <= target[1]
                    && balance <= target[2]
                    && spread(r) <= target[3]
            });
            outcome.iterations += iterations;
            outcome.outers += 1;
            for (x, correction) in x.iter_mut().zip(&correction) {
                for (x, correction) in x.iter_mut().zip(correction) {
                    *x += Real::from(*correction);
                }
            }
            if !closed {
                for value in &mut x {
                    value[3] = value[3].max(0.0);
                }
            }
            image = self.image(&x);
            let s = |i: usize| self.source[i] + image[i][3];
            let mean = if closed {
                ordered_sum(n, s) / n as Real
            } else {
                0.0
            };
            let left = |i: usize| {
                if closed || x[i][3] > 0.0 {
                    s(i) - mean
                } else {
                    s(i).max(0.0)
                }
            };
            outcome.strain_rate =
                (ordered_sum(n, |i| left(i) * left(i)) / n as Real).sqrt() / volume;
            outcome.balance = ordered_sum(n, left).abs();
            let mut surplus = self.surplus(&image);
            let changed = outcome.outers < MOST_CHANGES && self.contacts.decide(&x, &surplus);
            self.contacts.take_out(&mut surplus);
            outcome.velocity = self.momentum_residual(&surplus);
            outcome.converged = !changed
                && outcome.strain_rate <= goal.strain_rate
                && outcome.balance <= goal.balance
                && self.spread(goal, left) <= goal.spread
                && outcome.velocity <= velocity_goal;
            if outcome.converged || outcome.outers >= MOST_OUTERS {
                break;
            }
            fresh = changed;
            if closed {
                settled = true;
                continue;
            }
            let next: Vec<bool> = (0..n).map(|i| x[i][3] > 0.0 || s(i) > 0.0).collect();
            let moved = active.iter().zip(&next).filter(|(a, b)| a != b).count();
            settled = moved as Real <= SETTLED * n as Real;
            fresh |= moved > 0;
            active = next;
        }
        for i in 0..n {
            velocity[i] = Vec3::new(x[i][0], x[i][1], x[i][2]);
            pressure[i] = x[i][3];
        }
        outcome
    }

    /// What the cells of the coarse level have left over, each by itself, if anything is asked of that [m³/s].
    fn spread(&self, goal: &CoupledGoal, residual: impl Fn(usize) -> Real + Sync) -> Real {
        if goal.spread.is_finite() {
            self.coarse.spread(residual)
        } else {
            0.0
        }
    }

    /// Takes a new set F: C, and the coarse level unless that of the last round is as good.
    fn set_active(&mut self, active: &[bool], settled: bool) {
        self.smooth(active);
        let near = self.problem.near;
        self.active = active.to_vec();
        if !settled {
            self.coarse = Coarse::new(near, self.problem.position, active, &self.mobility);
        }
    }

    /// C for the set F, into the couplings of velocity and pressure.
    fn smooth(&mut self, active: &[bool]) {
        let near = self.problem.near;
        let stiffness: Vec<Real> = (0..active.len())
            .map(|i| {
                if active[i] {
                    (STABILISATION / self.firm[i]).sqrt()
                } else {
                    0.0
                }
            })
            .collect();
        self.couplings.for_each_row_mut(|i, row| {
            for (coupling, pair) in row.iter_mut().zip(near.pairs(i)) {
                let smooth = stiffness[i] * stiffness[pair.j as usize];
                coupling[3] = (Real::from(pair.weight) * smooth) as f32;
            }
        });
    }

    /// H v + P k less the forces [N], where `image` is of v and k.
    fn surplus(&self, image: &[Packed]) -> Vec<Packed> {
        let mut surplus = image.to_vec();
        for (row, force) in surplus.iter_mut().zip(&self.force) {
            for axis in 0..3 {
                row[axis] -= force[axis];
            }
        }
        surplus
    }

    /// Root mean square of r_v/H_ii [m/s].
    fn momentum_residual(&self, surplus: &[Packed]) -> Real {
        let n = surplus.len();
        let squares = ordered_sum(n, |i| {
            let r = &surplus[i];
            (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]) / (self.diagonal[i] * self.diagonal[i])
        });
        (squares / n as Real).sqrt()
    }
}
