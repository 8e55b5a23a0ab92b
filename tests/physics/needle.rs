//! A needle whose end is open: fluid pressed through a tube by a piston.

use crate::scenes::{newtonian, settings, walls};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Inlet, Scheme, Simulation, TimeStep};
use osteoflow::solid::{Shape, Solid};

fn needle(scheme: Scheme, length: f64, end: f64, dt: f64) {
    let dx = 0.5e-3;
    let (inner, outer) = (1.195e-3, 1.195e-3 + 1.2e-3);
    let solid = Solid {
        shapes: vec![Shape::Tube {
            base: Vec3::new(0.0, 0.0, -2e-3),
            axis: Vec3::z(),
            length: length + 2e-3,
            inner,
            outer,
        }],
        grids: Vec::new(),
    };
    let domain = Aabb {
        min: Vec3::new(-3e-2, -3e-2, -3e-3),
        max: Vec3::new(3e-2, 3e-2, 6e-2),
    };
    let region = Aabb {
        min: Vec3::new(-outer, -outer, -2e-3),
        max: Vec3::new(outer, outer, length),
    };
    let mut s = settings(dx, domain);
    s.scheme = scheme;
    s.cement = newtonian(1070.0, 4.4);
    if scheme == Scheme::ImmCt {
        s.cement.polymer.viscosity = 8.0;
        s.cement.liquid.viscosity = 0.01;
        s.cement.relaxation_time = 0.05;
        s.cement.thinning = 0.5;
    }
    s.inlets = vec![Inlet {
        name: "needle".into(),
        position: Vec3::zeros(),
        direction: Vec3::z(),
        diameter: 2.0 * inner,
        flow_rate: 2e-7,
        polymer_fraction: 0.55,
        dose: 1e-5,
    }];
    s.time_step = TimeStep::Adaptive {
        min: 1e-7,
        max: dt,
        cfl: 0.4,
    };
    let particles = walls(
        &solid,
        region.grown(dx),
        Vec3::repeat(0.11e-3),
        dx,
        2.0 * dx,
    );
    let mut sim = Simulation::new(s, solid, particles).unwrap();
    let viscosity = if scheme == Scheme::ImmCt { 4.4 } else { 4.4 };
    let begin = std::time::Instant::now();
    for k in 1..=10 {
        let mut shown = 0;
        let result = sim.advance_to(end * f64::from(k) / 10.0, |r| {
            if !r.converged && shown < 2 {
                shown += 1;
                eprintln!("   {r:?}");
            }
        });
        let l = sim.ledger();
        let top = sim.fluid.position.iter().map(|x| x.z).fold(0.0, f64::max);
        let poiseuille =
            8.0 * viscosity * top.min(length) * 2e-7 / (std::f64::consts::PI * inner.powi(4));
        eprintln!(
            "t {:.3} n {} top {:.2} mm p_in {:.0} (Poiseuille {:.0}) comp {:.4} {:.3} steps {} conv {} it/step {:.1} dt {:.2e} {:?} speed {:.3} stretch {:?} in_walls {} wall {:.1} s",
            l.time,
            l.particles,
            top * 1e3,
            l.inlet_pressure,
            poiseuille,
            l.compression[0],
            l.compression[1],
            l.window[0],
            l.window[1],
            l.iterations as f64 / l.window[0] as f64,
            l.dt,
            l.limit.map(|l| l.name()),
            l.speed,
            l.stretch,
            l.in_walls,
            begin.elapsed().as_secs_f64()
        );
        if let Err(e) = result {
            eprintln!("{e}");
            break;
        }
    }
}

#[test]
fn newtonian_needle() {
    needle(Scheme::Dfsph, 8e-3, 0.4, 5e-3);
}

#[test]
fn viscoelastic_needle() {
    needle(Scheme::ImmCt, 8e-3, 0.4, 5e-3);
}
