//! The ledger: what there is, what came and went, and how the solver fared since the last entry.

use super::energy::{self, Energy};
use super::inlet::InletState;
use super::settings::SimSettings;
use super::stepper::StepReport;
use super::time_step::Limit;
use crate::fluid::{FluidParticles, PerPhase, mixture};
use crate::math::{Real, Vec3, ordered_max, ordered_sum};
use serde::{Deserialize, Serialize};

/// One line of `stats.csv`.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Simulated time [s].
    pub time: Real,
    /// Steps so far.
    pub steps: u64,
    /// Particles.
    pub particles: usize,
    /// Volume of each phase in the simulation [m³].
    pub inside: PerPhase<Real>,
    /// Volume of each phase that became fluid at inlets [m³].
    pub injected: PerPhase<Real>,
    /// Volume of each phase that left the domain [m³].
    pub escaped: PerPhase<Real>,
    /// Volume that the pistons have pushed [m³].
    pub pushed: Real,
    /// Particles deeper than half a spacing inside a wall.
    pub in_walls: usize,
    /// Σ α_k ρ_k v_k V [kg m/s].
    pub momentum: Vec3,
    /// Kinetic energy of both phases [J].
    pub kinetic: Real,
    /// Elastic energy of the polymer [J].
    pub elastic: Real,
    /// Where the energy came from and went, if that is kept account of.
    pub energy: Option<Energy>,
    /// Least and largest eigenvalue of U [1].
    pub stretch: [Real; 2],
    /// Largest |v_mix| [m/s].
    pub speed: Real,
    /// Largest pressure [Pa].
    pub pressure: Real,
    /// Mean pressure at the first inlet's opening [Pa].
    pub inlet_pressure: Real,
    /// Mean and largest of (ψ − 1)⁺ at the last step [1].
    pub compression: [Real; 2],
    /// Since the last entry: steps, of which converged.
    pub window: [u64; 2],
    /// Since the last entry: how often a step was taken back.
    pub retries: u64,
    /// Since the last entry: solver iterations.
    pub iterations: u64,
    /// Since the last entry: largest volume strain left in a step [1], largest unbalanced share of the inflow.
    pub residual: [Real; 2],
    /// Last dt [s] and what limited most steps of the window.
    pub dt: Real,
    /// What limited most steps since the last entry.
    pub limit: Option<Limit>,
    /// Static walls that touched fluid in the last step.
    pub awake: usize,
}

impl Ledger {
    /// Column names of [`Ledger::row`], with units.
    pub const COLUMNS: [&'static str; 39] = [
        "time_s",
        "steps",
        "particles",
        "liquid_inside_m3",
        "polymer_inside_m3",
        "liquid_injected_m3",
        "polymer_injected_m3",
        "liquid_escaped_m3",
        "polymer_escaped_m3",
        "pushed_m3",
        "particles_in_walls",
        "momentum_x_kg_m_s",
        "momentum_y_kg_m_s",
        "momentum_z_kg_m_s",
        "kinetic_J",
        "elastic_J",
        "stretch_min",
        "stretch_max",
        "speed_max_m_s",
        "pressure_max_Pa",
        "inlet_pressure_Pa",
        "compression_mean",
        "compression_max",
        "window_steps",
        "window_converged",
        "retries",
        "iterations",
        "strain_residual",
        "balance_residual",
        "dt_s",
        "dt_limit",
        "walls_awake",
        "gravity_work_J",
        "wall_work_J",
        "viscous_loss_J",
        "relaxation_loss_J",
        "slip_loss_J",
        "numerical_loss_J",
        "energy_residual_J",
    ];

    /// The values in the order of [`Ledger::COLUMNS`]; numbers in shortest exact form.
    pub fn row(&self) -> Vec<String> {
        let mut row = vec![
            self.time.to_string(),
            self.steps.to_string(),
            self.particles.to_string(),
        ];
        let reals = |row: &mut Vec<String>, values: &[Real]| {
            row.extend(values.iter().map(|v| format!("{v:e}")));
        };
        reals(
            &mut row,
            &[
                self.inside.liquid,
                self.inside.polymer,
                self.injected.liquid,
                self.injected.polymer,
            ],
        );
        reals(
            &mut row,
            &[self.escaped.liquid, self.escaped.polymer, self.pushed],
        );
        row.push(self.in_walls.to_string());
        reals(
            &mut row,
            &[
                self.momentum.x,
                self.momentum.y,
                self.momentum.z,
                self.kinetic,
                self.elastic,
            ],
        );
        reals(
            &mut row,
            &[
                self.stretch[0],
                self.stretch[1],
                self.speed,
                self.pressure,
                self.inlet_pressure,
            ],
        );
        reals(&mut row, &self.compression);
        row.extend(self.window.iter().map(u64::to_string));
        row.push(self.retries.to_string());
        row.push(self.iterations.to_string());
        reals(&mut row, &self.residual);
        reals(&mut row, &[self.dt]);
        row.push(self.limit.map_or("none", Limit::name).to_string());
        row.push(self.awake.to_string());
        row.extend(match &self.energy {
            Some(e) => [
                e.gravity,
                e.walls,
                e.viscous,
                e.relaxed,
                e.slipped,
                e.numerical(),
                e.residual(self.kinetic + self.elastic),
            ]
            .map(|joule| format!("{joule:e}")),
            None => Default::default(),
        });
        row
    }
}

/// What adds up between entries.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Volume of each phase that became fluid at inlets [m³].
    pub injected: PerPhase<Real>,
    /// Volume of each phase that left the domain [m³].
    pub escaped: PerPhase<Real>,
    /// Since the last entry: steps, of which converged.
    pub window: [u64; 2],
    /// Since the last entry: how often a step was taken back.
    pub retries: u64,
    /// Since the last entry: solver iterations.
    pub iterations: u64,
    /// Since the last entry: largest strain and unbalanced share left.
    pub residual: [Real; 2],
    /// Since the last entry: how many steps each limit set.
    pub limits: Vec<(Limit, u64)>,
    /// Mean and largest of (ψ − 1)⁺ at the last step [1].
    pub compression: [Real; 2],
    /// Where the energy came from and went, if that is kept account of.
    #[serde(default)]
    pub energy: Option<Energy>,
    /// The last step.
    pub last: StepReport,
}

impl Tally {
    /// Adds a step.
    pub fn add(&mut self, report: &StepReport, compression: &[Real]) {
        self.window[0] += 1;
        self.window[1] += u64::from(report.converged);
        self.retries += u64::from(report.retries);
        self.iterations += report.iterations as u64;
        self.residual[0] = self.residual[0].max(report.strain);
        self.residual[1] = self.residual[1].max(report.balance);
        if let Some(limit) = report.limit {
            match self.limits.iter_mut().find(|entry| entry.0 == limit) {
                Some(entry) => entry.1 += 1,
                None => self.limits.push((limit, 1)),
            }
        }
        let n = compression.len();
        let excess = |i: usize| (compression[i] - 1.0).max(0.0);
        self.compression = [
            ordered_sum(n, excess) / n.max(1) as Real,
            ordered_max(n, excess).max(0.0),
        ];
        self.last = *report;
    }

    /// Starts a new window.
    pub fn reset_window(&mut self) {
        self.window = [0; 2];
        self.retries = 0;
        self.iterations = 0;
        self.residual = [0.0; 2];
        self.limits.clear();
    }
}

/// The entry for the present state.
pub fn enter(
    settings: &SimSettings,
    fluid: &FluidParticles,
    inlets: &[InletState],
    tally: &Tally,
    rest_volume: Real,
    time: Real,
    steps: u64,
    in_walls: usize,
) -> Ledger {
    let n = fluid.len();
    let cement = &settings.cement;
    let alpha = &fluid.polymer_fraction;
    let polymer = rest_volume * ordered_sum(n, |i| alpha[i]);
    let liquid = rest_volume * ordered_sum(n, |i| 1.0 - alpha[i]);
    let momentum = |axis: usize| {
        rest_volume
            * ordered_sum(n, |i| {
                mixture::momentum_density(&fluid.phase_velocity[i], alpha[i], cement)[axis]
            })
    };
    let stretch = |largest: usize| {
        if n == 0 {
            1.0
        } else {
            ordered_max(n, |i| {
                let e = fluid.conformation(i).eigenvalues();
                if largest == 1 { e[2] } else { -e[0] }
            })
        }
    };
    Ledger {
        time,
        steps,
        particles: n,
        inside: PerPhase { liquid, polymer },
        injected: tally.injected,
        escaped: tally.escaped,
        pushed: inlets.iter().map(|inlet| inlet.pushed).sum(),
        in_walls,
        momentum: Vec3::new(momentum(0), momentum(1), momentum(2)),
        kinetic: energy::kinetic(cement, fluid, rest_volume),
        elastic: energy::elastic(settings, fluid, rest_volume),
        energy: tally.energy,
        stretch: [if n == 0 { 1.0 } else { -stretch(0) }, stretch(1)],
        speed: ordered_max(n, |i| {
            mixture::mixture_velocity(&fluid.phase_velocity[i], alpha[i]).norm()
        })
        .max(0.0),
        pressure: ordered_max(n, |i| fluid.pressure[i][0]).max(0.0),
        inlet_pressure: inlets.first().map_or(0.0, |inlet| inlet.pressure),
        compression: tally.compression,
        window: tally.window,
        retries: tally.retries,
        iterations: tally.iterations,
        residual: tally.residual,
        dt: tally.last.dt,
        limit: tally
            .limits
            .iter()
            .max_by_key(|entry| entry.1)
            .map(|entry| entry.0),
        awake: tally.last.awake,
    }
}
