//! Velocity and pressure in one implicit solve, with p ≥ 0.
//!
//! ```text
//! [ H   P ] [v]   [ b ]      H = M/dt + K        K: compact Laplacian with no-slip walls
//! [ Pᵀ −C ] [k] = [−c ]      k ≥ 0,  s = c + Pᵀv − C k ≤ 0,  k s = 0
//! ```
//!
//! An outer active set F = {k > 0} ∪ {s > 0} around block MINRES (`minres`), loosely solved. C is a graph
//! Laplacian over F that damps pressure modes which the velocity cannot see; it is zero on constants, so no inflow
//! is lost. Preconditioner: two Chebyshev–Jacobi steps for H; for the pressure block viscosity and inertia by
//! particle, and a coarse level that knows the mobility of the fluid.

use super::coarse::Coarse;
use super::minres::{self, Packed};
use super::mobility;
use super::neighbourhood::{Neighbourhood, vector};
use super::operators::{Mean, laplacian_weight, wall_friction};
use super::pressure::PressureOperator;
use super::rows::Rows;
use crate::math::{BLOCK, Real, Vec3, ordered_sum};
use rayon::prelude::*;

/// Strength of the pressure stabilisation C.
const STABILISATION: Real = 0.1;
/// Each outer iteration reduces its residual by this factor: the set is not final anyway.
const LOOSE: Real = 0.3;
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
    /// Time step [s].
    pub dt: Real,
    /// b without the walls' part: M/dt v* plus explicit forces [N].
    pub force: &'a [Vec3],
    /// c without the walls' motion: excess volume / dt [m³/s].
    pub excess: &'a [Real],
    /// Whether the fluid has neither a free surface nor a way in or out. Then only differences of pressure mean
    /// anything, of either sign. On a disordered lattice its level is felt a little all the same (P 1 ≠ 0), enough for
    /// a solve that is free to choose it to hold particles in place with it, so it stays that of the guess.
    pub closed: bool,
}

/// When the solve is good enough.
#[derive(Clone, Copy, Debug)]
pub struct CoupledGoal {
    /// Root mean square volume strain left over [1/s].
    pub strain_rate: Real,
    /// |Σ s| over the particles under pressure [m³/s].
    pub balance: Real,
    /// Root mean square velocity residual r_v/H_ii [m/s]; where the step's change is smaller than that, a fiftieth
    /// of the residual that the guess leaves.
    pub velocity: Real,
}

/// Share of the guess's velocity residual that may be left.
const REDUCTION: Real = 0.02;

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

#[derive(Clone, Copy)]
pub(super) struct SaddlePair {
    pub(super) j: u32,
    gradient: [f32; 3],
    /// V_i c_ij η_ij [kg/s].
    pub(super) drag: f32,
    /// V_j W_ij [1].
    weight: f32,
    /// Entry of C inside F [m³/(Pa s)], 0 outside.
    smooth: f32,
}

/// The assembled system.
pub struct CoupledSolver<'a> {
    problem: CoupledProblem<'a>,
    pub(super) pairs: Rows<SaddlePair>,
    /// H_ii [kg/s].
    pub(super) diagonal: Vec<Real>,
    /// b with the walls' part [N].
    force: Vec<Vec3>,
    /// c with the walls' part [m³/s].
    source: Vec<Real>,
    /// Fine part of the inverse Schur complement [Pa s/m³].
    pub(super) fine: Vec<Real>,
    /// Mobility: velocity per force of a uniform push [m/(s N)].
    mobility: Vec<Real>,
    active: Vec<bool>,
    pub(super) coarse: Coarse,
}

impl<'a> CoupledSolver<'a> {
    /// Assembles the system.
    pub fn new(problem: CoupledProblem<'a>) -> Self {
        let near = problem.near;
        let n = near.len();
        let volume = near.rest_volume;
        let pairs = Rows::build(n, |i, row| {
            for pair in near.pairs(i) {
                let eta = problem
                    .mean
                    .of(problem.viscosity[i], problem.viscosity[pair.j as usize]);
                row.push(SaddlePair {
                    j: pair.j,
                    gradient: pair.gradient,
                    drag: (volume * eta * laplacian_weight(near, i, &pair)) as f32,
                    weight: pair.weight,
                    smooth: 0.0,
                });
            }
        });
        let rows: Vec<(Real, Vec3)> = (0..n)
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let drags: Real = pairs.row(i).iter().map(|p| Real::from(p.drag)).sum();
                let (friction, carried) = wall_friction(near, i);
                let scale = volume * problem.viscosity[i];
                (
                    problem.mass[i] / problem.dt + drags + scale * friction,
                    problem.force[i] + carried * scale,
                )
            })
            .collect();
        let operator = PressureOperator { near };
        let carried = operator.volume_rate_with_walls(&vec![Vec3::zeros(); n]);
        let inertial = operator.diagonal(problem.mass);
        let mut solver = Self {
            pairs,
            diagonal: rows.iter().map(|r| r.0).collect(),
            force: rows.iter().map(|r| r.1).collect(),
            source: (0..n).map(|i| problem.excess[i] + carried[i]).collect(),
            fine: Vec::new(),
            mobility: Vec::new(),
            active: vec![false; n],
            coarse: Coarse::new(near, problem.position, &vec![false; n], &[]),
            problem,
        };
        let p = &solver.problem;
        // A particle without neighbours has no diagonal of its own.
        let least = 1e-3 * (volume / near.spacing).powi(2);
        solver.fine = (0..n)
            .map(|i| {
                let inertial = inertial[i].max(least / p.mass[i]);
                p.viscosity[i] / volume + 1.0 / (p.dt * inertial)
            })
            .collect();
        solver.mobility = mobility::of_uniform_push(
            &solver.pairs,
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
        let s = self.constraint(&x);
        let guess = self.momentum_residual(&x);
        let velocity_goal = goal
            .velocity
            .min((REDUCTION * guess).max(1e-3 * goal.velocity));
        let closed = self.problem.closed;
        let mut active: Vec<bool> = (0..n)
            .map(|i| {
                closed
                    || x[i][3] > 0.0
                    || if cold {
                        full(i) || s[i] > 0.0
                    } else {
                        s[i] > 0.0 && full(i)
                    }
            })
            .collect();
        loop {
            self.set_active(&active);
            for i in 0..n {
                if !active[i] {
                    x[i][3] = 0.0;
                }
            }
            let mut b: Vec<Packed> = (0..n)
                .map(|i| {
                    let f = self.force[i];
                    [f.x, f.y, f.z, if active[i] { -self.source[i] } else { 0.0 }]
                })
                .collect();
            self.level(&mut b);
            let norms = |r: &[Packed]| {
                let strain = ordered_sum(n, |i| r[i][3] * r[i][3]) / n as Real;
                let speed = ordered_sum(n, |i| {
                    let h = self.diagonal[i];
                    (r[i][0] * r[i][0] + r[i][1] * r[i][1] + r[i][2] * r[i][2]) / (h * h)
                }) / n as Real;
                let balance = ordered_sum(n, |i| r[i][3]).abs();
                [strain.sqrt() / volume, speed.sqrt(), balance]
            };
            let finest = [goal.strain_rate, velocity_goal, goal.balance];
            let mut target = None;
            let iterations = minres::solve(&*self, &b, &mut x, MOST_INNER, |r| {
                let left = norms(r);
                let target = *target.get_or_insert_with(|| {
                    std::array::from_fn::<Real, 3, _>(|k| (LOOSE * left[k]).max(0.7 * finest[k]))
                });
                left.iter()
                    .zip(target)
                    .all(|(left, target)| *left <= target)
            });
            outcome.iterations += iterations;
            outcome.outers += 1;
            if !closed {
                for value in &mut x {
                    value[3] = value[3].max(0.0);
                }
            }
            let s = self.constraint(&x);
            let mean = if closed {
                ordered_sum(n, |i| s[i]) / n as Real
            } else {
                0.0
            };
            let left = |i: usize| {
                if closed || x[i][3] > 0.0 {
                    s[i] - mean
                } else {
                    s[i].max(0.0)
                }
            };
            outcome.strain_rate =
                (ordered_sum(n, |i| left(i) * left(i)) / n as Real).sqrt() / volume;
            outcome.balance = ordered_sum(n, left).abs();
            outcome.velocity = self.momentum_residual(&x);
            outcome.converged = outcome.strain_rate <= goal.strain_rate
                && outcome.balance <= goal.balance
                && outcome.velocity <= velocity_goal;
            if outcome.converged || outcome.outers >= MOST_OUTERS {
                break;
            }
            if closed {
                continue;
            }
            active = (0..n).map(|i| x[i][3] > 0.0 || s[i] > 0.0).collect();
        }
        for i in 0..n {
            velocity[i] = Vec3::new(x[i][0], x[i][1], x[i][2]);
            pressure[i] = x[i][3];
        }
        outcome
    }

    /// Takes the mean out of the pressure rows of a closed body.
    pub(super) fn level(&self, rows: &mut [Packed]) {
        if self.problem.closed {
            let mean = ordered_sum(rows.len(), |i| rows[i][3]) / rows.len() as Real;
            for row in rows {
                row[3] -= mean;
            }
        }
    }

    /// Takes a new set F: C, the coarse level.
    fn set_active(&mut self, active: &[bool]) {
        let near = self.problem.near;
        let fine = &self.fine;
        self.pairs.for_each_mut(|i, pair| {
            let j = pair.j as usize;
            let strength = STABILISATION * Real::from(pair.weight) / (fine[i] * fine[j]).sqrt();
            pair.smooth = if active[i] && active[j] {
                strength as f32
            } else {
                0.0
            };
        });
        self.active = active.to_vec();
        self.coarse = Coarse::new(near, self.problem.position, active, &self.mobility);
    }

    /// s = c + Pᵀv − C k on all particles [m³/s].
    fn constraint(&self, x: &[Packed]) -> Vec<Real> {
        let velocity: Vec<Vec3> = x.iter().map(|p| Vec3::new(p[0], p[1], p[2])).collect();
        let rate = PressureOperator {
            near: self.problem.near,
        }
        .volume_rate(&velocity);
        (0..x.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|i| {
                let smooth: Real = self
                    .pairs
                    .row(i)
                    .iter()
                    .map(|p| Real::from(p.smooth) * (x[i][3] - x[p.j as usize][3]))
                    .sum();
                self.source[i] + rate[i] - smooth
            })
            .collect()
    }

    fn momentum_residual(&self, x: &[Packed]) -> Real {
        let n = x.len();
        let mut image = vec![[0.0; 4]; n];
        minres::Operator::apply(self, x, &mut image);
        let squares = ordered_sum(n, |i| {
            let f = self.force[i];
            let r = [f.x - image[i][0], f.y - image[i][1], f.z - image[i][2]];
            (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]) / (self.diagonal[i] * self.diagonal[i])
        });
        (squares / n as Real).sqrt()
    }
}

impl minres::Operator for CoupledSolver<'_> {
    fn apply(&self, x: &[Packed], out: &mut [Packed]) {
        let near = self.problem.near;
        let volume = near.rest_volume;
        let of_walls: Vec<(Real, Real)> = (0..near.of_wall.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let (mut pressure, mut closing) = (0.0, 0.0);
                for pair in near.of_wall.row(b) {
                    let y = x[pair.i as usize];
                    let g = vector(pair.gradient);
                    pressure += Real::from(pair.share) * y[3];
                    closing -= g.x * y[0] + g.y * y[1] + g.z * y[2];
                }
                (pressure, closing * near.wall_volume[b])
            })
            .collect();
        out.par_chunks_mut(GRAIN)
            .enumerate()
            .for_each(|(block, rows)| {
                for (offset, row) in rows.iter_mut().enumerate() {
                    let i = block * GRAIN + offset;
                    let own = x[i];
                    let h = self.diagonal[i];
                    let mut drag = [h * own[0], h * own[1], h * own[2]];
                    let (mut push, mut rate, mut smooth) = ([0.0; 3], 0.0, 0.0);
                    for pair in self.pairs.row(i) {
                        let y = x[pair.j as usize];
                        let c = Real::from(pair.drag);
                        let g = pair.gradient.map(Real::from);
                        let k = own[3] + y[3];
                        for axis in 0..3 {
                            drag[axis] -= c * y[axis];
                            push[axis] += g[axis] * k;
                            rate += g[axis] * (own[axis] - y[axis]);
                        }
                        smooth += Real::from(pair.smooth) * (own[3] - y[3]);
                    }
                    let mut given_back = 0.0;
                    for pair in near.wall.row(i) {
                        let (k_b, q_b) = of_walls[pair.b as usize];
                        let g = pair.gradient.map(Real::from);
                        let k = own[3] + k_b;
                        for axis in 0..3 {
                            push[axis] += g[axis] * k;
                            rate += g[axis] * own[axis];
                        }
                        given_back += Real::from(pair.share) * q_b;
                    }
                    let p = if self.active[i] {
                        volume * rate + given_back - smooth
                    } else {
                        0.0
                    };
                    *row = [
                        drag[0] + volume * push[0],
                        drag[1] + volume * push[1],
                        drag[2] + volume * push[2],
                        p,
                    ];
                }
            });
        self.level(out);
    }
}

/// Blocks of the vector loops in MINRES are those of the ordered sums.
pub(super) const VECTOR_BLOCK: usize = BLOCK;
