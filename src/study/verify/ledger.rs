//! What has to be kept: volume of each phase, the sum of the fractions, and momentum.

use super::series::dots;
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Real, Stream, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{BodyShape, Scheme, Simulation, StressStep, TimeStep};
use crate::solid::Solid;
use crate::sph::WallParticles;
use crate::study::scenes::{body, boxed, newtonian, settings};
use std::f64::consts::TAU;

pub(super) const CASE: Case = Case {
    name: "ledger",
    about: "volume of each phase, sum of fractions and momentum in a stirred periodic box",
    measure,
};

const SIZE: Real = 0.01;
const MODES: [(&str, Scheme, StressStep); 4] = [
    ("imm_ct", Scheme::ImmCt, StressStep::Coupled),
    ("imm_ct explicit", Scheme::ImmCt, StressStep::Explicit),
    ("imm", Scheme::Imm, StressStep::Coupled),
    ("dfsph", Scheme::Dfsph, StressStep::Coupled),
];

/// Errors of volume, of the sum of fractions and of momentum at each look, relative.
type Books = Vec<[Real; 3]>;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let steps = bench.level.pick(100, 5000);
    let mut plot = Plot {
        title: "Drift of the ledger in a stirred box".into(),
        x: Axis::linear("steps"),
        y: Axis::log("relative change"),
        series: Vec::new(),
    };
    let mut figures = Vec::new();
    for (colour, (what, scheme, stress)) in MODES.into_iter().enumerate() {
        let run = format!("ledger-{colour}");
        let (books, seconds): (Books, _) = bench.run(&run, &(what, steps), || {
            keep_books(&run, scheme, stress, steps)
        })?;
        let worst = |k: usize| books.iter().map(|b| b[k]).fold(0.0, Real::max);
        for (k, quantity, most) in [
            (0, "volume of a phase", 1e-12),
            (1, "sum of fractions", 1e-12),
            (2, "momentum", 1e-10),
        ] {
            figures.push(Figure {
                what: format!("{what}: {quantity}"),
                resolution: format!("{steps} steps"),
                reached: worst(k),
                goal: Goal::AtMost(most),
                seconds,
            });
        }
        let every = Real::from(steps) / LOOKS as Real;
        let points = books.iter().enumerate();
        let mut series = dots(
            colour,
            points
                .map(|(n, b)| [every * (n + 1) as Real, b[2].max(1e-17)])
                .collect(),
        );
        series.name = format!("{what}: momentum");
        plot.series.push(series);
    }
    Ok(Measured { figures, plot })
}

const LOOKS: usize = 20;

fn keep_books(
    name: &str,
    scheme: Scheme,
    stress: StressStep,
    steps: u32,
) -> Result<Books, StudyError> {
    let domain = boxed(Vec3::repeat(SIZE));
    let mut s = settings(SIZE / 10.0, domain);
    s.periodic = [true; 3];
    s.scheme = scheme;
    s.stress = stress;
    s.jitter = 0.1;
    let phase = |density: Real, viscosity: Real| PhaseMaterial { density, viscosity };
    s.cement = Cement {
        liquid: phase(940.0, 0.01),
        polymer: phase(1180.0, 8.0),
        relaxation_time: 0.05,
        thinning: 0.5,
        rest_drag: 0.3,
        diffusion: 1e-6,
        ..newtonian(1000.0, 1.0)
    };
    let half = |low: Real, high: Real, alpha: Real| {
        let mut bounds = domain;
        bounds.min.x = low * SIZE;
        bounds.max.x = high * SIZE;
        body(BodyShape::Box(bounds), alpha)
    };
    s.bodies = vec![half(0.0, 0.5, 0.1), half(0.5, 1.0, 1.0)];
    let dt = if stress == StressStep::Coupled {
        2e-4
    } else {
        2e-5
    };
    s.time_step = TimeStep::Adaptive {
        min: 1e-9,
        max: dt,
        cfl: 0.3,
    };
    let mut simulation = Simulation::new(s, Solid::default(), WallParticles::default())
        .map_err(StudyError::run(name))?;
    let mut random = Stream::new(7, "stir");
    for i in 0..simulation.fluid.len() {
        let x = simulation.fluid.position[i] * (TAU / SIZE);
        let swirl = Vec3::new(
            libm::sin(x.y) + libm::cos(x.z),
            libm::sin(x.x) + libm::sin(x.z),
            libm::cos(x.x) + libm::cos(x.y),
        ) * 0.05;
        let v = &mut simulation.fluid.phase_velocity[i];
        v.liquid = swirl + random.cube() * 0.01 + Vec3::new(0.02, 0.0, 0.0);
        v.polymer = swirl + random.cube() * 0.01;
    }
    let before = simulation.ledger();
    let volume = before.inside.liquid + before.inside.polymer;
    let mut books = Books::new();
    let mut taken = 0;
    while books.len() < LOOKS {
        let (look, now) = (steps as usize * (books.len() + 1) / LOOKS, simulation.time);
        while taken < look {
            let goal = simulation.time + dt;
            simulation
                .advance_to(goal, |_| taken += 1)
                .map_err(StudyError::run(name))?;
        }
        debug_assert!(simulation.time > now);
        let after = simulation.ledger();
        let fractions = simulation.fluid.polymer_fraction.iter();
        let outside = fractions.map(|a| (-a).max(a - 1.0).max(0.0));
        books.push([
            (after.inside.polymer - before.inside.polymer)
                .abs()
                .max((after.inside.liquid - before.inside.liquid).abs())
                / volume,
            // Σ α = 1 by construction; what could fail is a fraction outside [0, 1].
            outside.fold(0.0, Real::max),
            (after.momentum - before.momentum).norm() / before.momentum.norm(),
        ]);
    }
    Ok(books)
}
