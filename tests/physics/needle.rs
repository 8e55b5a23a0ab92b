//! A needle with an open end: fluid pressed through a tube by a piston at a given rate.

use crate::scenes::{newtonian, settings, walls};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Inlet, Scheme, Simulation, TimeStep};
use osteoflow::solid::{Shape, Solid};

const RADIUS: f64 = 1.195e-3;
const LENGTH: f64 = 8e-3;
const FLOW_RATE: f64 = 2e-7;

/// Mean inlet pressure [Pa] once the needle is full; every step has to converge, nothing may enter the wall.
fn inlet_pressure(scheme: Scheme, cfl: f64) -> f64 {
    let dx = 0.5e-3;
    let outer = RADIUS + 1.2e-3;
    let tube = Shape::Tube {
        base: Vec3::new(0.0, 0.0, -2e-3),
        axis: Vec3::z(),
        length: LENGTH + 2e-3,
        inner: RADIUS,
        outer,
    };
    let solid = Solid {
        shapes: vec![tube],
        grids: Vec::new(),
    };
    let domain = Aabb {
        min: Vec3::new(-3e-2, -3e-2, -3e-3),
        max: Vec3::new(3e-2, 3e-2, 6e-2),
    };
    let region = Aabb {
        min: Vec3::new(-outer, -outer, -2e-3),
        max: Vec3::new(outer, outer, LENGTH),
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
        diameter: 2.0 * RADIUS,
        flow_rate: FLOW_RATE,
        polymer_fraction: 0.55,
        dose: 1e-5,
    }];
    s.time_step = TimeStep::Adaptive {
        min: 1e-7,
        max: 5e-3,
        cfl,
    };
    let particles = walls(
        &solid,
        region.grown(dx),
        Vec3::repeat(0.11e-3),
        dx,
        2.0 * dx,
    );
    let mut simulation = Simulation::new(s, solid, particles).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    while simulation.time < 0.4 {
        let report = simulation.step_towards(0.4).unwrap();
        assert!(report.converged, "{report:?}");
        if simulation.time > 0.25 {
            sum += simulation.inlets[0].pressure * report.dt;
            count += report.dt;
        }
    }
    let ledger = simulation.ledger();
    assert_eq!(ledger.in_walls, 0);
    assert!(ledger.stretch[0] > 0.0);
    // What the piston pushed is there, but for the row that has not come out yet.
    let there = ledger.inside.liquid + ledger.inside.polymer;
    assert!((there - ledger.pushed).abs() < 20.0 * simulation.rest_volume);
    eprintln!("{scheme:?}: inlet pressure {:.0} Pa", sum / count);
    sum / count
}

#[test]
fn needle_takes_the_pressure_of_poiseuille_and_thins() {
    let poiseuille = 8.0 * 4.4 * LENGTH * FLOW_RATE / (std::f64::consts::PI * RADIUS.powi(4));
    let newtonian = inlet_pressure(Scheme::Dfsph, 0.4);
    // Five spacings across: the wall's half spacing alone is worth a fifth.
    assert!(
        (newtonian / poiseuille - 1.0).abs() < 0.2,
        "{newtonian} {poiseuille}"
    );
    let cement = inlet_pressure(Scheme::ImmCt, 0.4);
    assert!(
        (0.2..0.8).contains(&(cement / newtonian)),
        "{cement} {newtonian}"
    );
}

/// Compression is undone over a time, not over a step: a quarter of the step gives the same pressure.
#[test]
fn pressure_of_a_needle_does_not_depend_on_the_step() {
    for scheme in [Scheme::Dfsph, Scheme::ImmCt] {
        let (long, short) = (inlet_pressure(scheme, 0.4), inlet_pressure(scheme, 0.1));
        assert!(
            (short / long - 1.0).abs() < 0.02,
            "{scheme:?} {long} {short}"
        );
    }
}
