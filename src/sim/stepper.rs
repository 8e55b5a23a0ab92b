//! The terms of a step, one method each; `schemes` says in which order.

use super::health::{SimError, Symptom, first_symptom};
use super::inlet::InletState;
use super::settings::{Scheme, SimSettings, StressStep};
use super::time_step::{self, FlowMeasures, Limit};
use crate::fluid::{
    FluidParticles, MixtureFields, bonding, conformation, mixture, stress, transfer,
};
use crate::math::{Mat3, Real, Sym3, Vec3, ordered_max, ordered_sum};
use crate::solid::Solid;
use crate::sph::operators::{Mean, stress_force, velocity_gradient, viscous_force, wall_friction};
use crate::sph::{
    ApgdGoal, CoupledGoal, CoupledProblem, CoupledSolver, Domain, Kernel, Neighbourhood, Pistons,
    PressureOperator, Source, Walls, solve_pressure,
};
use rayon::prelude::*;

/// ψ from which a particle counts as surrounded.
const FULL: Real = 0.9;
/// Volume strain that a split solve may leave, per u_ref dt/dx.
const SPLIT_TOLERANCE: Real = 1e-4;
/// The same, and the velocity residual per u_ref, for the coupled solve.
const COUPLED_TOLERANCE: Real = 1e-3;
/// Share of the inflow that a solve may leave unbalanced.
const BALANCE: Real = 0.01;
const MOST_SWEEPS: usize = 600;

/// What a step did.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepReport {
    /// dt [s].
    pub dt: Real,
    /// What limited it.
    pub limit: Option<Limit>,
    /// Iterations of all solves.
    pub iterations: usize,
    /// Whether every solve met its goals.
    pub converged: bool,
    /// Volume strain left over in the step [1].
    pub strain: Real,
    /// Inflow left unbalanced, of the inflow [1]; 0 where nothing flows in.
    pub balance: Real,
    /// Pairs of fluid particles.
    pub pairs: usize,
    /// Static wall particles that touch fluid.
    pub awake: usize,
}

/// One step in progress.
pub struct Stepper<'a> {
    pub settings: &'a SimSettings,
    pub kernel: &'a Kernel,
    pub domain: &'a Domain,
    pub solid: &'a Solid,
    pub walls: &'a Walls,
    pub fluid: &'a mut FluidParticles,
    pub inlets: &'a mut [InletState],
    pub near: Neighbourhood,
    pub mix: MixtureFields,
    pub gradient: Vec<Mat3>,
    pub dt: Real,
    pub time: Real,
    pub step: u64,
    pub report: StepReport,
}

impl Stepper<'_> {
    /// Neighbours, pistons and all that follows from positions.
    pub fn find_neighbours(&mut self) {
        let mut pistons = Pistons {
            volume: self.kernel.rest_volume(self.settings.spacing),
            ..Pistons::default()
        };
        for inlet in &*self.inlets {
            inlet.stand(self.kernel.support_radius, &mut pistons);
        }
        let solid = self.solid;
        self.near = Neighbourhood::new(
            &self.fluid.position,
            self.settings.spacing,
            self.kernel,
            self.domain,
            self.walls,
            &pistons,
            |x| solid.distance(x),
        );
        self.report.pairs = self.near.fluid.entries();
        self.report.awake = self.near.awake;
        self.report.converged = true;
    }

    /// Whether mixture work has anything to do: with a single pure phase it only copies (same bits).
    fn mixes(&self) -> bool {
        let first = self.fluid.polymer_fraction.first().copied().unwrap_or(0.0);
        let pure = (first == 0.0 || first == 1.0)
            && self.fluid.polymer_fraction.iter().all(|&a| a == first);
        !(pure && self.settings.skip_unneeded)
    }

    /// Eqs 4, 5 and the effective mass; C_d of (Eq. 10) if `bonds`, C_d⁰ everywhere if not.
    pub fn refresh_mixture(&mut self, bonds: bool) {
        let cement = &self.settings.cement;
        let drag = if bonds && self.mixes() {
            let own = self.near.rest_volume * self.kernel.w(0.0);
            bonding::drag(cement, self.fluid, &self.near, own)
        } else if self.settings.scheme == Scheme::Dfsph {
            vec![1.0; self.fluid.len()]
        } else {
            vec![cement.rest_drag; self.fluid.len()]
        };
        self.mix
            .refresh(cement, self.fluid, self.near.rest_volume, drag);
    }

    /// L from v_mix (Eq. 2).
    pub fn refresh_gradient(&mut self) {
        self.gradient = velocity_gradient(&self.near, &self.mix.velocity);
    }

    /// Chooses dt; `left` [s] remain to the end of the frame.
    pub fn choose_step(&mut self, left: Real) {
        let cement = &self.settings.cement;
        let fluid = &*self.fluid;
        let n = fluid.len();
        let fluid_speed = ordered_max(n, |i| {
            let v = &fluid.phase_velocity[i];
            self.mix.velocity[i].norm().max(match self.settings.scheme {
                Scheme::Dfsph => 0.0,
                _ => v.liquid.norm().max(v.polymer.norm()),
            })
        });
        let pistons = self
            .inlets
            .iter()
            .map(InletState::speed)
            .fold(0.0, Real::max);
        let flow = FlowMeasures {
            speed: fluid_speed.max(pistons),
            strain_rate: ordered_max(self.gradient.len(), |i| self.gradient[i].norm()).max(0.0),
            stiffness: match self.settings.scheme {
                Scheme::ImmCt if cement.relaxation_time > 0.0 => ordered_max(n, |i| {
                    let u = &fluid.conformation[i];
                    cement.modulus(fluid.polymer_fraction[i]) * u.eigenvalues()[2]
                }),
                _ => 0.0,
            },
            viscosity: ordered_max(n, |i| cement.mixture_viscosity(fluid.polymer_fraction[i])),
            density: -ordered_max(n, |i| -self.mix.density[i]),
            pressure: ordered_max(n, |i| fluid.pressure[i][0]),
        };
        let (mut dt, mut limit) = time_step::choose(self.settings, &flow);
        for inlet in &*self.inlets {
            if inlet.most_step() < dt {
                (dt, limit) = (inlet.most_step(), Limit::Dose);
            }
        }
        if limit == Limit::Fixed {
            if left < dt * (1.0 + 1e-9) {
                dt = left;
            }
        } else if left < dt * (1.0 + 1e-9) {
            (dt, limit) = (left, Limit::Frame);
        } else if left < 2.0 * dt {
            // Two equal steps rather than a full one and a sliver.
            dt = 0.5 * left;
        }
        self.dt = dt;
        self.report.dt = dt;
        self.report.limit = Some(limit);
    }

    /// Reference speed of the tolerances [m/s].
    fn reference_speed(&self) -> Real {
        self.fastest().max(0.01 * self.settings.spacing / self.dt)
    }

    /// Fastest particle or piston [m/s].
    fn fastest(&self) -> Real {
        let velocity = &self.mix.velocity;
        let pistons = self
            .inlets
            .iter()
            .map(InletState::speed)
            .fold(0.0, Real::max);
        ordered_max(velocity.len(), |i| velocity[i].norm()).max(pistons)
    }

    /// What the pistons push in [m³/s].
    fn inflow(&self) -> Real {
        let running = self.inlets.iter().filter(|inlet| inlet.speed() > 0.0);
        running.map(|inlet| inlet.settings.flow_rate).sum()
    }

    /// Volume rate that may be left unbalanced [m³/s]: a share of the inflow; where nothing flows in, what the
    /// tolerated strain rate amounts to over the whole fluid.
    fn balance_goal(&self, strain_rate: Real) -> Real {
        let inflow = self.inflow();
        if inflow > 0.0 {
            BALANCE * inflow
        } else {
            0.3 * strain_rate * self.near.rest_volume * self.fluid.len() as Real
        }
    }

    fn note(&mut self, iterations: usize, converged: bool, strain_rate: Real, balance: Real) {
        self.report.iterations += iterations;
        self.report.converged &= converged;
        self.report.strain = self.report.strain.max(strain_rate * self.dt);
        let inflow = self.inflow();
        if inflow > 0.0 {
            self.report.balance = self.report.balance.max(balance / inflow);
        }
    }

    /// Whether the fluid has neither a free surface nor a way in or out.
    fn is_closed(&self) -> bool {
        self.inlets.is_empty() && self.near.compression.iter().all(|&psi| psi > FULL)
    }

    /// Volume that pressure has to push away [m³]; a closed body can only even it out.
    fn excess_volume(&self, operator: &PressureOperator) -> Vec<Real> {
        let mut excess = operator.excess_volume();
        if self.is_closed() {
            let n = excess.len();
            let mean = (ordered_sum(n, |i| excess[i]) / n.max(1) as Real).max(0.0);
            for e in &mut excess {
                *e -= mean;
            }
        }
        excess
    }

    /// One pressure solve apart from viscosity, handed to the phases by (Eq. 6).
    pub fn project(&mut self, source: Source) {
        let n = self.fluid.len();
        let dt = self.dt;
        let operator = PressureOperator { near: &self.near };
        let rate = operator.volume_rate_with_walls(&self.mix.velocity);
        let (slot, source_rate, free) = match source {
            Source::Volume => {
                let excess = self.excess_volume(&operator);
                (
                    0,
                    (0..n).map(|i| excess[i] / dt + rate[i]).collect::<Vec<_>>(),
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
        let mass = &self.mix.mass;
        let mobility = |force: &[Vec3]| -> Vec<Vec3> {
            force
                .par_iter()
                .zip(mass)
                .with_min_len(256)
                .map(|(f, m)| f * (dt / m))
                .collect()
        };
        let diagonal: Vec<Real> = operator.diagonal(mass).iter().map(|d| d * dt).collect();
        let loose = if source == Source::Divergence {
            10.0
        } else {
            1.0
        };
        let strain_rate = loose * SPLIT_TOLERANCE * self.reference_speed() / self.settings.spacing;
        let goal = ApgdGoal {
            strain_rate,
            balance: loose * self.balance_goal(strain_rate),
            most_iterations: MOST_SWEEPS,
        };
        let mut k: Vec<Real> = self.fluid.pressure.iter().map(|p| p[slot]).collect();
        let outcome = solve_pressure(
            &operator,
            mobility,
            &diagonal,
            &source_rate,
            &free,
            &goal,
            &mut k,
        );
        let push = operator.force(&k);
        let velocity: Vec<Vec3> = (0..n)
            .map(|i| self.mix.velocity[i] - push[i] * (dt / mass[i]))
            .collect();
        for (p, k) in self.fluid.pressure.iter_mut().zip(k) {
            p[slot] = k;
        }
        self.mix.distribute(
            &self.settings.cement,
            self.fluid,
            &velocity,
            self.near.rest_volume,
        );
        self.note(
            outcome.iterations,
            outcome.converged,
            outcome.strain_rate,
            outcome.balance,
        );
    }

    /// Gravity: the same acceleration for every phase.
    pub fn apply_gravity(&mut self) {
        mixture::accelerate(self.fluid, &self.settings.gravity, self.dt);
        self.mix.refresh_velocity(self.fluid);
    }

    /// Interphase friction, if the cement has any.
    pub fn relax_slip(&mut self) {
        if let Some(relaxation) = self.settings.cement.slip_relaxation {
            mixture::relax_slip(&self.settings.cement, self.fluid, relaxation, self.dt);
            self.mix.refresh_velocity(self.fluid);
        }
    }

    fn mixture_viscosity(&self) -> Vec<Real> {
        let cement = &self.settings.cement;
        self.fluid
            .polymer_fraction
            .iter()
            .map(|&a| cement.mixture_viscosity(a))
            .collect()
    }

    /// Newtonian viscosity of the mixture, explicit (Eq. 7 with M_k = α_k M); walls implicit, else they would set
    /// the step.
    pub fn apply_viscosity(&mut self) {
        let viscosity = self.mixture_viscosity();
        let force = viscous_force(
            &self.near,
            &viscosity,
            Mean::Harmonic,
            &self.mix.velocity,
            false,
        );
        self.push(&force, &viscosity);
    }

    /// v ← (v + dt F/m + walls) for an explicit force [N], friction at walls with `viscosity` implicit.
    fn push(&mut self, force: &[Vec3], viscosity: &[Real]) {
        let (dt, volume) = (self.dt, self.near.rest_volume);
        let velocity: Vec<Vec3> = (0..self.fluid.len())
            .into_par_iter()
            .with_min_len(128)
            .map(|i| {
                let (friction, carried) = wall_friction(&self.near, i);
                let inverse_mass = dt / self.mix.mass[i];
                let scale = inverse_mass * volume * viscosity[i];
                (self.mix.velocity[i] + force[i] * inverse_mass + carried * scale)
                    / (1.0 + scale * friction)
            })
            .collect();
        self.mix
            .distribute(&self.settings.cement, self.fluid, &velocity, volume);
    }

    /// Eq. 12, then Eqs 13–16 with the new U: explicit, stabilised as far as the step allows.
    pub fn apply_polymer_stress(&mut self) {
        self.refresh_gradient();
        self.advance_conformation();
        let cement = &self.settings.cement;
        let spacing = self.settings.spacing;
        let n = self.fluid.len();
        let mut stabiliser = vec![0.0; n];
        let tau: Vec<Mat3> = (0..n)
            .map(|i| {
                let modulus = cement.modulus(self.fluid.polymer_fraction[i]);
                let rho = self.mix.density[i];
                let full = stress::stabiliser_viscosity(cement, modulus, rho, spacing, self.dt);
                stabiliser[i] = full.min(0.1 * rho * spacing * spacing / self.dt);
                stress::of_conformation(modulus, &self.fluid.conformation[i])
                    - self.gradient[i] * stabiliser[i]
            })
            .collect();
        let elastic = stress_force(&self.near, &tau);
        let viscosity: Vec<Real> = stabiliser
            .iter()
            .map(|s| s + cement.liquid.viscosity)
            .collect();
        let viscous = viscous_force(
            &self.near,
            &viscosity,
            Mean::Arithmetic,
            &self.mix.velocity,
            false,
        );
        let force: Vec<Vec3> = elastic.iter().zip(&viscous).map(|(a, b)| a + b).collect();
        self.push(&force, &viscosity);
    }

    /// U^{n+1} (Eq. 12) with the current gradient.
    fn advance_conformation(&mut self) {
        let cement = &self.settings.cement;
        let dt = self.dt;
        self.fluid
            .conformation
            .par_iter_mut()
            .zip(&self.gradient)
            .with_min_len(128)
            .for_each(|(u, l)| {
                *u = conformation::advance(u, l, cement.relaxation_time, cement.thinning, dt);
            });
    }

    /// Gravity, Newtonian viscosity and pressure in one solve.
    pub fn solve_newtonian(&mut self) {
        let viscosity = self.mixture_viscosity();
        let force = vec![Vec3::zeros(); self.fluid.len()];
        self.solve_coupled(&viscosity, Mean::Harmonic, force);
    }

    /// Gravity, solvent viscosity, polymer stress (Eqs 12–16) and pressure in one solve.
    ///
    /// The stress enters in increment form around a prediction with L(v^n),
    /// div[(1 − b) τ^n + b τ_p] + Lap[η_K](v' − v^n) plus the stabiliser Lap[η_a] v − div(η_a L); steady states
    /// depend on neither dt nor η_K, and λ → 0 leaves the plain viscous step. η_K is weighted with the largest
    /// stretch, without which steps beyond Wi = 1 blow up.
    pub fn solve_viscoelastic(&mut self) {
        let cement = &self.settings.cement;
        let (dt, spacing) = (self.dt, self.settings.spacing);
        let n = self.fluid.len();
        let (b, memory) = stress::implicit_weight(cement, dt);
        let terms: Vec<(Mat3, Real, Real)> = (0..n)
            .into_par_iter()
            .with_min_len(128)
            .map(|i| {
                let u = &self.fluid.conformation[i];
                let modulus = cement.modulus(self.fluid.polymer_fraction[i]);
                let predicted = conformation::advance(
                    u,
                    &self.gradient[i],
                    cement.relaxation_time,
                    cement.thinning,
                    dt,
                );
                let stretch = largest(u).max(largest(&predicted));
                let stabiliser =
                    stress::stabiliser_viscosity(cement, modulus, self.mix.density[i], spacing, dt);
                let implicit = (modulus * memory * stretch).max(stabiliser);
                let tau = stress::of_conformation(modulus, u) * (1.0 - b)
                    + stress::of_conformation(modulus, &predicted) * b
                    - self.gradient[i] * stabiliser;
                (tau, implicit, implicit - stabiliser)
            })
            .collect();
        let tau: Vec<Mat3> = terms.iter().map(|t| t.0).collect();
        let increment: Vec<Real> = terms.iter().map(|t| t.2).collect();
        let elastic = stress_force(&self.near, &tau);
        let lagged = viscous_force(
            &self.near,
            &increment,
            Mean::Arithmetic,
            &self.mix.velocity,
            true,
        );
        let force = elastic.iter().zip(&lagged).map(|(e, l)| e - l).collect();
        let viscosity: Vec<Real> = terms
            .iter()
            .map(|t| t.1 + cement.liquid.viscosity)
            .collect();
        self.solve_coupled(&viscosity, Mean::Arithmetic, force);
        self.refresh_gradient();
        self.advance_conformation();
    }

    fn solve_coupled(&mut self, viscosity: &[Real], mean: Mean, mut force: Vec<Vec3>) {
        let n = self.fluid.len();
        let dt = self.dt;
        let operator = PressureOperator { near: &self.near };
        let excess: Vec<Real> = self
            .excess_volume(&operator)
            .iter()
            .map(|e| e / dt)
            .collect();
        let start: Vec<Vec3> = self
            .mix
            .velocity
            .iter()
            .map(|v| v + self.settings.gravity * dt)
            .collect();
        for i in 0..n {
            force[i] += start[i] * (self.mix.mass[i] / dt);
        }
        let u_ref = self.reference_speed();
        let strain_rate = COUPLED_TOLERANCE * u_ref / self.settings.spacing;
        let goal = CoupledGoal {
            strain_rate,
            balance: self.balance_goal(strain_rate),
            velocity: COUPLED_TOLERANCE * self.fastest().max(self.settings.gravity.norm() * dt),
        };
        let mut velocity = self.mix.velocity.clone();
        let mut pressure: Vec<Real> = self.fluid.pressure.iter().map(|p| p[0]).collect();
        let mut solver = CoupledSolver::new(CoupledProblem {
            near: &self.near,
            position: &self.fluid.position,
            mass: &self.mix.mass,
            viscosity,
            mean,
            dt,
            force: &force,
            excess: &excess,
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
        for (p, k) in self.fluid.pressure.iter_mut().zip(pressure) {
            p[0] = k;
        }
        // Gravity moves all phases alike; the rest of the change is force, shared out by C_d.
        mixture::accelerate(self.fluid, &self.settings.gravity, dt);
        self.mix.refresh_velocity(self.fluid);
        self.mix.distribute(
            &self.settings.cement,
            self.fluid,
            &velocity,
            self.near.rest_volume,
        );
        self.note(
            outcome.iterations,
            outcome.converged,
            outcome.strain_rate,
            outcome.balance,
        );
    }

    /// Eqs 8, 9: volume and momentum move between the phases of neighbours.
    pub fn transfer_phases(&mut self) {
        if self.mixes() {
            transfer::advance(&self.settings.cement, self.fluid, &self.near, self.dt);
        } else {
            transfer::unite_vanished_phases(&self.settings.cement, self.fluid);
        }
        self.mix.refresh_velocity(self.fluid);
    }

    /// x ← x + dt v_mix; pistons advance and their rows become fluid.
    pub fn move_particles(&mut self) {
        let dt = self.dt;
        let (near, solid, domain) = (&self.near, self.solid, self.domain);
        let most_depth = MOST_DEPTH * self.settings.spacing;
        self.fluid
            .position
            .par_iter_mut()
            .enumerate()
            .with_min_len(128)
            .for_each(|(i, x)| {
                let aim = *x + self.mix.velocity[i] * dt;
                let open = near.wall.row(i).is_empty();
                *x = domain.wrapped(if open {
                    aim
                } else {
                    beside(solid, x, aim, most_depth)
                });
            });
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

    /// Mean pressure of the fluid within a support radius of each opening.
    fn measure_inlet_pressure(&mut self) {
        let reach = self.kernel.support_radius;
        for inlet in &mut *self.inlets {
            let near = |i: &usize| {
                let x = self.fluid.position[*i] - inlet.settings.position;
                let along = x.dot(&inlet.settings.direction);
                let across = (x - inlet.settings.direction * along).norm();
                along.abs() < reach && across < 0.5 * inlet.settings.diameter
            };
            let members: Vec<usize> = (0..self.near.len()).filter(near).collect();
            let sum: Real = members.iter().map(|&i| self.fluid.pressure[i][0]).sum();
            inlet.pressure = if members.is_empty() {
                0.0
            } else {
                sum / members.len() as Real
            };
        }
    }

    /// Stops the run if a particle is ill after `term`.
    pub fn check(&self, term: &'static str) -> Result<(), SimError> {
        let Some((i, what)) = first_symptom(self.fluid, self.kernel.support_radius, self.dt) else {
            return Ok(());
        };
        // Explicit steps may legitimately be violent in a single term; only the whole step can run away.
        if what == Symptom::Runaway
            && self.settings.stress == StressStep::Explicit
            && term != "the step"
        {
            return Ok(());
        }
        Err(SimError::Diverged {
            step: self.step,
            time: self.time,
            particle: self.fluid.id[i],
            position: self.fluid.position[i],
            term,
            what,
        })
    }
}

/// How far a particle's centre may lie inside the solid, in spacings: the true surface of a rough wall is only
/// known that well to the particles, and holding them off it costs flow and stability.
const MOST_DEPTH: Real = 0.3;

/// Where a particle comes to rest that aims at a point too deep inside the solid: as deep as allowed, on the side it
/// came from. Without it slow creep takes one particle in a thousand through a strut.
fn beside(solid: &Solid, from: &Vec3, aim: Vec3, most_depth: Real) -> Vec3 {
    let (mut phi, mut normal) = solid.distance(&aim);
    if phi >= -most_depth {
        return aim;
    }
    let (start, outward) = solid.distance(from);
    let mut x = aim;
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

fn largest(u: &Sym3) -> Real {
    u.eigenvalues()[2]
}
