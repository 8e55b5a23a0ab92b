//! Flow through a slit and a tube.

use crate::scenes::{newtonian, run, settings, walls};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Body, BodyShape, Scheme, Simulation, TimeStep};
use osteoflow::solid::{Shape, Solid};

/// Body-force flow between two plates `across` spacings apart; (flow rate, L2 of the profile) against exact.
fn slit(across: f64, dt: f64, steps: f64, scheme: Scheme) -> (f64, f64) {
    let gap = 1e-3;
    let dx = gap / across;
    let (eta, rho, g) = (8.0, 1000.0, 100.0);
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(7.0 * dx, gap, 7.0 * dx),
    };
    let offset = 0.27 * dx;
    let solid = Solid {
        shapes: vec![
            Shape::HalfSpace {
                point: Vec3::zeros(),
                normal: Vec3::y(),
            },
            Shape::HalfSpace {
                point: Vec3::new(0.0, gap, 0.0),
                normal: -Vec3::y(),
            },
        ],
        grids: Vec::new(),
    };
    let domain = Aabb {
        min: bounds.min - Vec3::y() * 4.0 * dx,
        max: bounds.max + Vec3::y() * 4.0 * dx,
    };
    let mut s = settings(dx, domain);
    s.periodic = [true, false, true];
    s.scheme = scheme;
    s.gravity = Vec3::new(g, 0.0, 0.0);
    s.cement = newtonian(rho, eta);
    if scheme == Scheme::ImmCt {
        s.cement.relaxation_time = 1e-6;
        s.cement.liquid.viscosity = 0.0;
    }
    s.bodies = vec![Body {
        shape: BodyShape::Box(bounds),
        polymer_fraction: 1.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    s.time_step = TimeStep::Fixed(dt);
    // The period holds whole spacings, so the offset lattice of the walls closes on itself along x and z.
    let region = Aabb {
        min: domain.min,
        max: domain.max - Vec3::new(1e-9, 0.0, 1e-9),
    };
    let particles = walls(
        &solid,
        region,
        Vec3::new(0.0, offset - dx, 0.0),
        dx,
        2.4 * dx,
    );
    let simulation = run(Simulation::new(s, solid, particles).unwrap(), dt * steps);
    let top = rho * g * gap * gap / (8.0 * eta);
    let (mut flow, mut square, mut norm, mut exact_flow) = (0.0, 0.0, 0.0, 0.0);
    for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
        let exact = top * 4.0 * (x.y / gap) * (1.0 - x.y / gap);
        flow += v.x;
        exact_flow += exact;
        square += (v.x - exact).powi(2);
        norm += exact * exact;
    }
    (flow / exact_flow - 1.0, (square / norm).sqrt())
}

#[test]
fn slit_flow_is_parabolic_wherever_the_wall_particles_stand() {
    for scheme in [Scheme::Dfsph, Scheme::ImmCt] {
        let (flow, profile) = slit(16.0, 1e-4, 20.0, scheme);
        eprintln!("{scheme:?}: flow {flow:.4} profile {profile:.4}");
        assert!(
            flow.abs() < 0.03 && profile < 0.03,
            "{scheme:?} {flow} {profile}"
        );
    }
}
