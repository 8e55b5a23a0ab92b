//! Small scenes that the cases share.

use osteoflow::fluid::{Cement, PhaseMaterial};
use osteoflow::math::{Aabb, Real, Vec3};
use osteoflow::sim::{ElasticWaves, Scheme, SimSettings, Simulation, StressStep, TimeStep};
use osteoflow::solid::Solid;
use osteoflow::sph::WallParticles;

/// A Newtonian cement: both phases alike.
pub fn newtonian(density: Real, viscosity: Real) -> Cement {
    let phase = PhaseMaterial { density, viscosity };
    Cement {
        liquid: phase,
        polymer: phase,
        relaxation_time: 0.0,
        thinning: 0.0,
        rest_drag: 0.5,
        diffusion: 0.0,
        normalised_bonding: false,
        literal_modulus: false,
        slip_relaxation: None,
    }
}

/// Settings that a case starts from.
pub fn settings(spacing: Real, domain: Aabb) -> SimSettings {
    SimSettings {
        scheme: Scheme::Dfsph,
        stress: StressStep::Coupled,
        elastic_waves: ElasticWaves::Damped,
        spacing,
        support_ratio: 2.4,
        duration: 1.0,
        frames_per_second: 10.0,
        gravity: Vec3::zeros(),
        periodic: [false; 3],
        domain,
        time_step: TimeStep::Adaptive {
            min: 1e-9,
            max: 1.0,
            cfl: 0.4,
        },
        cement: newtonian(1000.0, 1.0),
        bodies: Vec::new(),
        inlets: Vec::new(),
        seed: 1,
        jitter: 0.0,
        skip_unneeded: true,
    }
}

/// Wall particles on a lattice with a node at `origin` + half a spacing, `depth` deep.
pub fn walls(
    solid: &Solid,
    region: Aabb,
    origin: Vec3,
    spacing: Real,
    depth: Real,
) -> WallParticles {
    let mut walls = WallParticles::default();
    let first = (region.min - origin).map(|c| (c / spacing).floor() as i64);
    let last = (region.max - origin).map(|c| (c / spacing).ceil() as i64);
    for x in first.x..=last.x {
        for y in first.y..=last.y {
            for z in first.z..=last.z {
                let cell = Vec3::new(x as Real + 0.5, y as Real + 0.5, z as Real + 0.5);
                let position = origin + cell * spacing;
                let phi = solid.distance(&position).0;
                if phi < 0.0 && phi > -depth && region.contains(&position) {
                    walls.position.push(position);
                    walls.volume.push(spacing.powi(3));
                }
            }
        }
    }
    walls
}

/// Runs to the end and says how it went.
pub fn run(mut simulation: Simulation, end: Real) -> Simulation {
    let mut steps = 0_u64;
    let mut iterations = 0;
    let mut unconverged = 0;
    // Inside the pool a parallel loop need not wake anyone to start it.
    let pool = rayon::ThreadPoolBuilder::new().build().unwrap();
    let each = |report: &osteoflow::sim::StepReport| {
        steps += 1;
        iterations += report.iterations;
        unconverged += u32::from(!report.converged);
    };
    pool.install(|| simulation.advance_to(end, each)).unwrap();
    let mean = iterations as Real / steps as Real;
    eprintln!("{steps} steps, {mean:.1} iterations each, {unconverged} not converged");
    simulation
}
