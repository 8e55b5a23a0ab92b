//! Pressure, apart from viscosity or coupled with it: goals, sources, and handing the result to the phases.

use super::stepper::Stepper;
use crate::fluid::mixture;
use crate::math::{Real, Vec3, ordered_max, ordered_sum};
use crate::sph::operators::Mean;
use crate::sph::{
    ApgdGoal, CoupledGoal, CoupledProblem, CoupledSolver, PressureOperator, RepeatedPressure,
    Source, solve_pressure,
};
use rayon::prelude::*;

/// ψ from which a particle counts as surrounded.
const FULL: Real = 0.9;
/// ψ below which a particle is as good as alone.
const ALONE: Real = 0.5;
/// Volume strain that a split solve may leave, per u_ref dt/dx.
const SPLIT_TOLERANCE: Real = 1e-4;
/// The same, and the velocity residual per u_ref, for the coupled solve.
const COUPLED_TOLERANCE: Real = 1e-3;
/// Share of the guess's velocity residual that the coupled solve may leave. What is left is the slowest mode, in each step
/// the same: with 0.02, 0.01, 0.005 a viscous wave is 0.95, 0.69, 0.62 % off at 64 spacings (order 1.4, 1.8, 1.9), and the
/// vertebra takes 21.8, 24.6, 29.8 iterations a step.
const REDUCTION: Real = 0.01;
/// Spacings a step that count as rest: where forces are rounding errors, no solver reaches a goal of 0.
const STILL: Real = 1e-6;
/// Share of the inflow that a solve may leave unbalanced.
const BALANCE: Real = 0.01;
/// The same, summed over the cells of the solver's coarse level, each by itself.
const SPREAD: Real = 0.1;
/// Viscosity per p dt that a pressed packing needs: pressure pushes particles apart that lie closer than others, and where
/// nothing but viscosity resists they overshoot once p dt/η is beyond about 4, and the flow rings from step to step (in an
/// 11G cannula by a third of its pressure). With 0.25 a run through an array of struts crawls: 60 times its time and no end.
const PACKING: Real = 0.5;
/// Most of it, per viscosity of the fluid. Counted from v^n it is what pressure still knows of the step (see `outlook`): with
/// 0.5, 0.4, 0.3, 0.25 that of a Newtonian array is 1.2, 1.0, 0.7, 0.3 % higher at the CFL step than at 0.3 of it; but with
/// 0.25 the vertebra has 43 to 66 steps back and takes 1.14 to 1.18 times the iterations.
const MOST_LAG: Real = 0.5;
/// Level of the pressure that evens a packing, per stress η u/dx + ρ u²/2 that spoils it, with u the [`Stepper::pace`]; see
/// [`Stepper::relieve`]. With 10 pipes 320 deep have 0.99 times Poiseuille's gradient (1 and 100 Pa·s). More lets the
/// packing stiffen; with 5, and without the lag, the vertebra, which needs no relief, takes 1.6 times the iterations.
const EVENING: Real = 10.0;
/// Spacings that the flow covers, at its [`Stepper::pace`], while inertia resists what the coupled solve's C lets through
/// (viscosity does without the lag, which knows the step as well).
///
/// With the step itself, established flow in a needle into closed pores (4.4 Pa·s, a tenth of the CFL step, 3029 Pa) that
/// went on in steps of 0.03, 0.01 jumped to 3083, 3154 Pa within two of them; with 0.4, the CFL step, it went on at 3033,
/// 3038 (not asked with 0.05). But with 0.4 C lets a column that rests sink into its bottom: pressure there is 3.4 % off, with
/// 0.1, 0.05, 0.02 0.8, 0.1, 0.8 %. And with viscosity as far as the polymer is stretched a fluid stretched 17 times shears 3
/// to 12 % too hard.
const SETTLING: Real = 0.05;
const MOST_SWEEPS: usize = 600;
impl Stepper<'_> {
    /// Reference speed of the tolerances [m/s].
    pub(super) fn reference_speed(&self) -> Real {
        self.fastest().max(0.01 * self.settings.spacing / self.dt)
    }

    /// Fastest particle, piston or moving wall [m/s].
    pub(super) fn fastest(&self) -> Real {
        let velocity = &self.mix.velocity;
        ordered_max(velocity.len(), |i| velocity[i].norm()).max(self.driven_speed())
    }

    /// What the pistons push in [m³/s].
    pub(super) fn inflow(&self) -> Real {
        let running = self.inlets.iter().filter(|inlet| inlet.speed() > 0.0);
        running.map(|inlet| inlet.settings.flow_rate).sum()
    }

    /// Volume rate that may be left unbalanced [m³/s]: a share of the inflow; where nothing flows in, what the
    /// tolerated strain rate amounts to over the whole fluid.
    pub(super) fn balance_goal(&self, strain_rate: Real) -> Real {
        let inflow = self.inflow();
        if inflow > 0.0 {
            BALANCE * inflow
        } else {
            0.3 * strain_rate * self.near.rest_volume * self.fluid.len() as Real
        }
    }

    /// The same for the coarse cells by themselves [m³/s]: a vessel 320 spacings deep could swallow all that is pushed in
    /// within the tolerated strain, below, and give it back above.
    fn spread_goal(&self) -> Real {
        let inflow = self.inflow();
        if inflow > 0.0 {
            SPREAD * inflow
        } else {
            Real::INFINITY
        }
    }

    pub(super) fn note(
        &mut self,
        iterations: usize,
        converged: bool,
        strain_rate: Real,
        balance: Real,
    ) {
        self.report.iterations += iterations;
        self.report.converged &= converged;
        self.report.strain = self.report.strain.max(strain_rate * self.dt);
        let inflow = self.inflow();
        if inflow > 0.0 {
            self.report.balance = self.report.balance.max(balance / inflow);
        }
    }

    /// Whether the fluid has neither a free surface nor a way in or out. At a surface a particle has neighbours on one
    /// side; in a gap between disordered particles, all round. (ψ cannot tell: a surface that rests comes up to 1.)
    pub(super) fn find_closed(&self) -> bool {
        let near = &*self.near;
        let all = (0..near.len()).into_par_iter().with_min_len(256);
        self.inlets.is_empty() && !all.any(|i| near.compression[i] < ALONE || near.one_sided(i))
    }

    /// Takes the least pressure [Pa] of a closed body off its guess: only differences mean anything there, and a level
    /// that grew from step to step would press particles into the dents of walls and lattices.
    fn lower(&self, pressure: &mut [Real]) {
        if self.closed {
            let n = pressure.len();
            let least = -ordered_max(n, |i| -pressure[i]);
            for p in pressure {
                *p -= least;
            }
        }
    }

    /// Takes off what the level of the pressure does to the packing beyond what evens it: adds that to `force` [N].
    ///
    /// (P 1)_i = 2 V ∇ψ_i is 0 on a lattice alone: particles that lie closer than others are pushed apart, as hard as
    /// pressure is high. That keeps a packing even; but far more than it takes makes it stiff, a granular matter with
    /// friction (at the foot of a pipe 320 deep by a third of its gradient), or overshoots in each step, so that nothing
    /// comes out. Differences of pressure, which drive the flow, stay whole.
    fn relieve(&mut self, force: &mut [Vec3]) {
        if self.closed {
            return;
        }
        let near = &*self.near;
        let operator = PressureOperator { near };
        let cement = &self.settings.cement;
        let dx = self.settings.spacing;
        let pace = self.pace.unwrap_or_default();
        let beyond = |i: usize| {
            let viscosity = cement.mixture_viscosity(self.fluid.polymer_fraction[i]);
            let stress = (viscosity / dx + 0.5 * self.mix.density[i] * pace) * pace;
            self.fluid.pressure[i][0] - EVENING * stress
        };
        let all = (0..near.len()).into_par_iter().with_min_len(256);
        if !all.clone().any(|i| beyond(i) > 0.0) {
            return;
        }
        let relief: Vec<Vec3> = all
            .map(|i| {
                let beyond = beyond(i);
                if beyond <= 0.0 {
                    return Vec3::zeros();
                }
                let crowding = near.crowding(i);
                if near.is_one_sided(&crowding) {
                    return Vec3::zeros();
                }
                operator.force_of_level(&crowding, beyond)
            })
            .collect();
        for (force, relief) in force.iter_mut().zip(&relief) {
            *force += relief;
        }
        self.book_relief(&relief);
    }

    /// Raises the lag to what keeps pressed fluid from ringing ([`PACKING`]).
    fn steady(&self, viscosity: &[Real], lag: &mut [Real]) {
        for (i, lag) in lag.iter_mut().enumerate() {
            let needed = PACKING * self.fluid.pressure[i][0].max(0.0) * self.dt;
            *lag = lag.max((needed - viscosity[i]).min(MOST_LAG * viscosity[i]));
        }
    }

    /// Keeps a solved pressure [Pa] as the next guess, and hands the velocity that it left to the phases.
    fn accept(&mut self, slot: usize, pressure: &[Real], velocity: &[Vec3]) {
        self.book_pressure(pressure);
        for (guess, k) in self.fluid.pressure.iter_mut().zip(pressure) {
            guess[slot] = *k;
        }
        let volume = self.near.rest_volume;
        self.mix
            .distribute(&self.settings.cement, self.fluid, velocity, volume);
    }

    /// One pressure solve apart from viscosity, handed to the phases by (Eq. 6).
    pub fn project(&mut self, source: Source) {
        let n = self.fluid.len();
        let dt = self.dt;
        let mass = &self.mix.mass;
        let mobility: Vec<Real> = mass.iter().map(|m| dt / m).collect();
        let operator = PressureOperator { near: self.near };
        let mut repeated = RepeatedPressure::new(self.near, &mobility);
        let rate = operator.volume_rate_with_walls(&self.mix.velocity);
        let (slot, source_rate, free) = match source {
            Source::Volume => {
                let excess = self.correction_rate(&operator, self.split_correction_time());
                (
                    0,
                    (0..n).map(|i| excess[i] + rate[i]).collect::<Vec<_>>(),
                    vec![false; n],
                )
            }
            Source::Divergence => (
                1,
                rate,
                self.near
                    .compression
                    .iter()
                    .map(|&psi| psi < FULL)
                    .collect(),
            ),
        };
        let diagonal: Vec<Real> = operator.diagonal(mass).iter().map(|d| d * dt).collect();
        let loose = if source == Source::Divergence {
            10.0
        } else {
            1.0
        };
        let tolerance = loose * SPLIT_TOLERANCE * self.settings.tolerance;
        let strain_rate = tolerance * self.reference_speed() / self.settings.spacing;
        let goal = ApgdGoal {
            strain_rate,
            balance: loose * self.balance_goal(strain_rate),
            most_iterations: MOST_SWEEPS,
        };
        let mut k = self.fluid.multiplier(slot);
        self.lower(&mut k);
        let outcome = solve_pressure(&mut repeated, &diagonal, &source_rate, &free, &goal, &mut k);
        let force = operator.force(&k);
        let velocity: Vec<Vec3> = (0..n)
            .map(|i| self.mix.velocity[i] - force[i] * mobility[i])
            .collect();
        self.accept(slot, &k, &velocity);
        self.note(
            outcome.iterations,
            outcome.converged,
            outcome.strain_rate,
            outcome.balance,
        );
    }

    /// Velocity and pressure at once, under `force` [N] and gravity. `lag`: viscosity [Pa·s] that resists only what changes
    /// from a likely `change` [m/s] of the velocity.
    pub(super) fn solve_coupled(
        &mut self,
        viscosity: &[Real],
        mean: Mean,
        mut lag: Vec<Real>,
        change: &[Vec3],
        mut force: Vec<Vec3>,
    ) {
        let n = self.fluid.len();
        self.steady(viscosity, &mut lag);
        self.relieve(&mut force);
        // v_θ is what an implicit Euler step of θ dt comes to; the end of the step lies beyond it on the same line.
        let dt = self.settings.theta * self.dt;
        let operator = PressureOperator { near: self.near };
        let closed = self.closed;
        let excess = self.correction_rate(&operator, self.correction_time());
        let velocity = self.mix.velocity.iter();
        let start: Vec<Vec3> = velocity.map(|v| v + self.settings.gravity * dt).collect();
        for i in 0..n {
            force[i] += start[i] * (self.mix.mass[i] / dt);
        }
        let likely = self.mix.velocity.iter().zip(change);
        let likely: Vec<Vec3> = likely.map(|(v, change)| v + change).collect();
        let u_ref = self.reference_speed();
        let tolerance = COUPLED_TOLERANCE * self.settings.tolerance;
        let dx = self.settings.spacing;
        let strain_rate = tolerance * u_ref / dx;
        let least = (self.settings.gravity.norm() * dt).max(STILL * dx / dt);
        let goal = CoupledGoal {
            strain_rate,
            balance: self.balance_goal(strain_rate),
            spread: self.spread_goal(),
            velocity: tolerance * self.fastest().max(least),
            reduction: REDUCTION * self.settings.tolerance,
        };
        let mut velocity = self.mix.velocity.clone();
        let mut pressure = self.fluid.multiplier(0);
        self.lower(&mut pressure);
        let mut solver = CoupledSolver::new(CoupledProblem {
            near: self.near,
            position: &self.fluid.position,
            mass: &self.mix.mass,
            viscosity,
            mean,
            lag: &lag,
            likely: &likely,
            dt,
            settling: self.time_over(SETTLING),
            force: &force,
            excess: &excess,
            closed,
            contacts: self.contacts(),
        });
        let compression = &self.near.compression;
        let outcome = solver.solve(
            &mut velocity,
            &mut pressure,
            |i| compression[i] > FULL,
            &goal,
        );
        if self.near.wall.entries() == 0 && n > 0 {
            // Nothing outside pushes: what the solver left of the sum of forces would be momentum from nowhere.
            let mass: Real = ordered_sum(n, |i| self.mix.mass[i]);
            let left = |axis: usize| {
                ordered_sum(n, |i| {
                    self.mix.mass[i] * velocity[i][axis] - dt * force[i][axis]
                }) / mass
            };
            let drift = Vec3::new(left(0), left(1), left(2));
            for v in &mut velocity {
                *v -= drift;
            }
        }
        self.lead.clear();
        if self.settings.theta < 1.0 {
            let beyond = 1.0 / self.settings.theta - 1.0;
            for (v, before) in velocity.iter_mut().zip(&self.mix.velocity) {
                let step = (*v - before) * beyond;
                *v += step;
                self.lead.push(-step);
            }
        }
        self.keep_change(&velocity);
        // Gravity moves all phases alike; the rest of the change is force, shared out by C_d.
        mixture::accelerate(self.fluid, &self.settings.gravity, self.dt);
        self.mix.refresh_velocity(self.fluid);
        self.accept(0, &pressure, &velocity);
        self.report.velocity = self.report.velocity.max(outcome.velocity);
        self.note(
            outcome.iterations,
            outcome.converged,
            outcome.strain_rate,
            outcome.balance,
        );
    }
}
