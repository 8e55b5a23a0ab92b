//! A steady flow does not know the step: what the coupled solve smooths its pressure with must not either.

use osteoflow::math::{Aabb, Real, Stream, Vec3};
use osteoflow::sph::operators::Mean;
use osteoflow::sph::{
    CoupledGoal, CoupledProblem, CoupledSolver, Domain, Kernel, Neighbourhood, PressureOperator,
};

const SIDE: u32 = 8;

/// Slightly uneven particles in a periodic box, a spacing of 1 apart.
fn packed() -> (Vec<Vec3>, Neighbourhood) {
    let mut random = Stream::new(5, "packed");
    let places = (0..SIDE).flat_map(|x| (0..SIDE).map(move |y| (x, y)));
    let position: Vec<Vec3> = places
        .flat_map(|(x, y)| (0..SIDE).map(move |z| Vec3::new(x.into(), y.into(), z.into())))
        .map(|x| x + random.cube() * 0.02)
        .collect();
    let domain = Domain {
        bounds: Aabb {
            min: Vec3::repeat(-0.5),
            max: Vec3::repeat(Real::from(SIDE) - 0.5),
        },
        periodic: [true; 3],
    };
    let kernel = Kernel::new(2.4);
    let mut near = Neighbourhood::without_walls(&position, 1.0, &kernel, &domain);
    near.straighten(true);
    (position, near)
}

/// Pressure of particles that stand still while what flows between them comes to rest in steps of `dt`.
fn steady_pressure(dt: Real, settling: Real) -> Vec<Real> {
    let (position, near) = packed();
    let n = position.len();
    let mass = vec![near.rest_volume; n];
    let viscosity = vec![1.0; n];
    let lag = vec![0.0; n];
    // Sources and sinks, from particle to particle, which is what a smoothed pressure sees least of.
    let mut random = Stream::new(6, "sources");
    let mut excess: Vec<Real> = (0..n).map(|_| random.unit() - 0.5).collect();
    let mean = excess.iter().sum::<Real>() / n as Real;
    for e in &mut excess {
        *e -= mean;
    }
    let goal = CoupledGoal {
        strain_rate: 1e-7,
        balance: Real::INFINITY,
        spread: Real::INFINITY,
        velocity: 1e-7,
        reduction: 1.0,
    };
    let (mut velocity, mut pressure) = (vec![Vec3::zeros(); n], vec![0.0; n]);
    let mut time = 0.0;
    while time < 10.0 {
        let force: Vec<Vec3> = velocity
            .iter()
            .zip(&mass)
            .map(|(v, m)| v * (m / dt))
            .collect();
        let likely = velocity.clone();
        let mut solver = CoupledSolver::new(CoupledProblem {
            near: &near,
            position: &position,
            mass: &mass,
            viscosity: &viscosity,
            mean: Mean::Harmonic,
            lag: &lag,
            likely: &likely,
            dt,
            settling,
            force: &force,
            excess: &excess,
            closed: true,
            contacts: Vec::new(),
        });
        // Only differences mean anything in a closed body, and guesses are positive.
        let least = pressure.iter().copied().fold(Real::INFINITY, Real::min);
        for p in &mut pressure {
            *p -= least;
        }
        let outcome = solver.solve(&mut velocity, &mut pressure, |_| true, &goal);
        assert!(outcome.converged, "{outcome:?}");
        time += dt;
    }
    let rate = PressureOperator { near: &near }.volume_rate(&velocity);
    let flows = rate.iter().map(|r| r * r).sum::<Real>().sqrt();
    assert!(flows > 1.0, "nothing flows: {flows}");
    let mean = pressure.iter().sum::<Real>() / n as Real;
    pressure.iter().map(|p| p - mean).collect()
}

fn difference(a: &[Real], b: &[Real]) -> Real {
    let squares = |v: &mut dyn Iterator<Item = Real>| v.map(|x| x * x).sum::<Real>();
    let apart = squares(&mut a.iter().zip(b).map(|(a, b)| a - b));
    (apart / squares(&mut b.iter().copied())).sqrt()
}

#[test]
fn pressure_of_a_steady_flow_does_not_know_the_step() {
    let settling = 0.5;
    let long = steady_pressure(2.0, settling);
    let short = steady_pressure(0.05, settling);
    let apart = difference(&short, &long);
    assert!(apart < 1e-4, "{apart}");
    // It is that time which decides: smoothed by the step itself, pressure is another.
    let by_step = difference(&steady_pressure(0.05, 0.05), &long);
    assert!(by_step > 0.1, "{by_step}");
}
