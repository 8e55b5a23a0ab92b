//! Small scenes that the cases share.

use osteoflow::math::{Aabb, Real, Vec3};
use osteoflow::sim::Simulation;
use osteoflow::solid::Solid;
use osteoflow::sph::WallParticles;

pub use osteoflow::study::scenes::{flowing, newtonian, settings};

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
