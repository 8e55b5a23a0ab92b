//! Walls that move: what fluid between them does is known in closed form.

use crate::scenes::{newtonian, run, settings, walls};
use osteoflow::math::{Aabb, Real, Vec3};
use osteoflow::sim::{
    Body, BodyShape, Motion, MovingSolid, Path, SimSettings, Simulation, TimeStep,
};
use osteoflow::solid::{Shape, Solid};
use std::f64::consts::{PI, TAU};

const DX: Real = 1e-3;

fn shape(shape: Shape) -> Solid {
    Solid {
        shapes: vec![shape],
        grids: Vec::new(),
    }
}

/// A slab of the plane flow problem: periodic along `axes`, fluid wherever no wall is.
fn slab(domain: Aabb, periodic: [bool; 3], dt: Real) -> SimSettings {
    let mut s = settings(DX, domain);
    s.periodic = periodic;
    s.cement = newtonian(1000.0, 1.0);
    s.time_step = TimeStep::Fixed(dt);
    s.bodies = vec![Body {
        shape: BodyShape::Box(domain),
        polymer_fraction: 0.0,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    s
}

/// Half-open, so that a lattice closes on itself around the periodic axes.
fn region(domain: Aabb, periodic: [bool; 3]) -> Aabb {
    let mut region = domain;
    for axis in (0..3).filter(|&axis| periodic[axis]) {
        region.max[axis] -= 1e-9;
    }
    region
}

fn moving(solid: Solid, domain: Aabb, periodic: [bool; 3], motion: Motion) -> MovingSolid {
    let origin = domain.min;
    let particles = walls(&solid, region(domain, periodic), origin, DX, 2.4 * DX);
    MovingSolid {
        motion,
        solid,
        particles,
    }
}

/// A plate oscillates over fluid whose other side is held: the finite form of Stokes' second problem,
/// v = Re[U e^{iωt} sinh(k (H − y))/sinh(k H)], k² = iωρ/η; here a cos from rest, so several periods are let pass.
#[test]
fn an_oscillating_plate_drags_the_fluid_along() {
    let gap = 12.0 * DX;
    let periodic = [true, false, true];
    let domain = Aabb {
        min: Vec3::new(0.0, -4.0 * DX, 0.0),
        max: Vec3::new(7.0 * DX, gap + 4.0 * DX, 7.0 * DX),
    };
    let frequency = 20.0;
    let steps = 100.0;
    let dt = 1.0 / (frequency * steps);
    let s = slab(domain, periodic, dt);
    let top = shape(Shape::HalfSpace {
        point: Vec3::new(0.0, gap, 0.0),
        normal: -Vec3::y(),
    });
    let held = walls(&top, region(domain, periodic), domain.min, DX, 2.4 * DX);
    let amplitude = 0.5 * DX;
    let plate = moving(
        shape(Shape::HalfSpace {
            point: Vec3::zeros(),
            normal: Vec3::y(),
        }),
        domain,
        periodic,
        Motion {
            path: Path::Oscillating {
                amplitude: Vec3::x() * amplitude,
                frequency,
            },
            ramp: 0.0,
        },
    );
    let simulation = Simulation::with_movers(s, top, held, vec![plate]).unwrap();
    let end = 2.0 / frequency;
    let simulation = run(simulation, end);
    // sinh of a complex number a + ib is sinh a cos b + i cosh a sin b; k = (1 + i) κ.
    let kappa = (PI * frequency * 1000.0 / 1.0_f64).sqrt();
    let sinh = |y: Real| {
        let a = kappa * y;
        (a.sinh() * a.cos(), a.cosh() * a.sin())
    };
    let speed = TAU * frequency * amplitude;
    let below = sinh(gap);
    let (mut square, mut norm) = (0.0, 0.0);
    for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
        let above = sinh(gap - x.y);
        // The plate's velocity is U cos(ωt) and cos(ω end) is 1: the real part of the quotient.
        let exact = speed * (above.0 * below.0 + above.1 * below.1)
            / (below.0 * below.0 + below.1 * below.1);
        square += (v.x - exact).powi(2);
        norm += exact * exact;
    }
    let error = (square / norm).sqrt();
    eprintln!("oscillating plate: L2 {error:.4}");
    assert!(error < 0.05, "{error}");
}

/// Between a turning and a resting cylinder v_θ = A r + B/r, whichever of them turns; in a turning pail, ω r.
fn rings(inner: bool, outer: bool) -> Real {
    let (r1, r2) = (6.0 * DX, 16.0 * DX);
    let periodic = [false, false, true];
    let edge = r2 + 4.0 * DX;
    let domain = Aabb {
        min: Vec3::new(-edge, -edge, 0.0),
        max: Vec3::new(edge, edge, 7.0 * DX),
    };
    let long = |radius, hollow| {
        shape(Shape::Cylinder {
            base: Vec3::new(0.0, 0.0, -1.0),
            axis: Vec3::z(),
            length: 2.0,
            radius,
            hollow,
        })
    };
    let rate = 2.0;
    let turning = Motion {
        path: Path::Turning {
            point: Vec3::zeros(),
            axis: Vec3::z(),
            rate,
        },
        ramp: 0.0,
    };
    let mut held = Solid::default();
    let mut movers = Vec::new();
    for (solid, turns) in [(long(r1, false), inner), (long(r2, true), outer)] {
        if turns {
            movers.push(moving(solid, domain, periodic, turning));
        } else {
            held.shapes.extend(solid.shapes);
        }
    }
    let particles = walls(&held, region(domain, periodic), domain.min, DX, 2.4 * DX);
    let s = slab(domain, periodic, 4e-3);
    let simulation = Simulation::with_movers(s, held, particles, movers).unwrap();
    // Momentum crosses the gap in ρ d²/η = 0.1 s.
    let simulation = run(simulation, 0.16);
    let [w1, w2] = [inner, outer].map(|turns| if turns { rate } else { 0.0 });
    let a = (w2 * r2 * r2 - w1 * r1 * r1) / (r2 * r2 - r1 * r1);
    let b = (w1 - w2) * r1 * r1 * r2 * r2 / (r2 * r2 - r1 * r1);
    let (mut square, mut norm) = (0.0, 0.0);
    for (x, v) in simulation.fluid.position.iter().zip(simulation.velocity()) {
        let r = x.x.hypot(x.y);
        let exact = Vec3::new(-x.y, x.x, 0.0) * ((a * r + b / r) / r);
        square += (v - exact).norm_squared();
        norm += exact.norm_squared();
    }
    (square / norm).sqrt()
}

#[test]
fn between_turning_cylinders_the_flow_is_couettes() {
    for (inner, outer, most) in [(true, false, 0.05), (false, true, 0.03), (true, true, 0.02)] {
        let error = rings(inner, outer);
        eprintln!("inner turns {inner}, outer turns {outer}: L2 {error:.4}");
        assert!(error < most, "{inner} {outer}: {error}");
    }
}

/// A plate thinner than two spacings is swept through a box of fluid from wall to wall, many times the distance that
/// a particle moves in a step: what it drives before it stays before it.
#[test]
fn nothing_passes_through_a_blade_that_sweeps_a_box() {
    let (width, length) = (8.0 * DX, 30.0 * DX);
    let inside = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(length, width, 20.0 * DX),
    };
    let domain = inside.grown(4.0 * DX);
    let mut s = slab(domain, [false; 3], 1e-3);
    s.gravity = Vec3::z() * -9.81;
    s.cement.liquid.viscosity = 0.05;
    s.bodies[0].shape = BodyShape::Box(Aabb {
        min: Vec3::new(4.0 * DX, 0.0, 0.0),
        max: Vec3::new(length, width, 6.0 * DX),
    });
    s.time_step = TimeStep::Adaptive {
        min: 1e-6,
        max: 0.01,
        cfl: 0.4,
    };
    let pail = shape(Shape::Box {
        min: inside.min,
        max: inside.max,
        hollow: true,
    });
    let held = walls(&pail, domain, domain.min, DX, 2.4 * DX);
    let blade = |first: Real| {
        shape(Shape::Box {
            min: Vec3::new(first, -2.0 * DX, -2.0 * DX),
            max: Vec3::new(first + 1.5 * DX, width + 2.0 * DX, 22.0 * DX),
            hollow: false,
        })
    };
    let (speed, travel) = (0.1, 12.0 * DX);
    let plate = moving(
        blade(2.0 * DX),
        domain,
        [false; 3],
        Motion {
            path: Path::Moving {
                velocity: Vec3::x() * speed,
                travel: Some(travel),
            },
            ramp: 0.02,
        },
    );
    let mut simulation = Simulation::with_movers(s, pail, held, vec![plate]).unwrap();
    let count = simulation.fluid.len();
    for frame in 1..=20 {
        simulation
            .advance_to(0.01 * Real::from(frame), |_| {})
            .unwrap();
        assert_eq!(simulation.ledger().in_walls, 0, "frame {frame}");
    }
    let face = 2.0 * DX + 1.5 * DX + travel;
    let behind = |x: &&Vec3| x.x < face - 0.5 * DX;
    assert_eq!(simulation.fluid.len(), count);
    assert_eq!(simulation.fluid.position.iter().filter(behind).count(), 0);
    // The fluid has risen as much as its room has shrunk.
    let room = (length - face) * width;
    let height = count as Real * DX.powi(3) / room;
    let mean: Real = simulation.fluid.position.iter().map(|x| x.z).sum::<Real>() / count as Real;
    eprintln!("mean height {:.2} of {:.2} mm", mean * 1e3, 0.5e3 * height);
    assert!((mean / (0.5 * height) - 1.0).abs() < 0.1);
}
