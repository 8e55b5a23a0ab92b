//! The dam break of Martin and Moyce: the front of the bulk.

use super::series::{Refined, curve, dots};
use super::{Bench, Case, Measured, StudyError};
use crate::math::{Aabb, Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sim::{BodyShape, StressStep, TimeStep};
use crate::solid::{Shape, Solid, wall_particles};
use crate::study::exact::DAM_FRONT;
use crate::study::scenes::{Place, body, newtonian, settings};

pub(super) const CASE: Case = Case {
    name: "dam",
    about: "front of a breaking dam, against the experiment of Martin and Moyce",
    measure,
};

const LENGTH: Real = 0.057_15;
const GRAVITY: Real = 9.81;
/// Share of the water that is ahead of the front of the bulk. The toe, a particle or two thick on a floor without friction,
/// runs further ahead than the measured one. A given share is a given front at any spacing: with 12 and 24 particles along
/// the column it is within 2.8 and 2.6 % of the measured one from T = 1 on.
const AHEAD: Real = 1.0 / 48.0;
/// T from which it is compared as such. At the first two points, 0.41 and 0.84, it is 11 and 7 % behind: a column that is let
/// go at once has not put that share of its water beyond its foot by then.
const RELEASED: Real = 1.0;
/// Rows across the slab.
const WIDTH: usize = 6;

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let sizes = bench.level.pick(vec![12], vec![12, 18, 24]);
    let samples = bench.level.pick(10, 15);
    let measured = &DAM_FRONT[..samples];
    let [mut bulk, mut early] = [Refined::default(), Refined::default()];
    let mut finest = Vec::new();
    for across in sizes {
        let run = format!("dam-{across}");
        let (fronts, seconds) =
            bench.run(&run, &(across, samples), || fronts(&run, across, samples))?;
        let worst = |of: fn(Real) -> bool| {
            let compared = fronts.iter().zip(measured).filter(|(_, m)| of(m[0]));
            let errors = compared.map(|(f, m)| (f[1] / m[1] - 1.0).abs());
            errors.fold(0.0, Real::max)
        };
        bulk.add(across, worst(|time| time >= RELEASED), seconds);
        early.add(across, worst(|time| time < RELEASED), seconds);
        finest = fronts;
    }
    let what = |when: &str| format!("front of the bulk {when}, largest deviation");
    let mut figures = bulk.figures(&what("from T = 1 on"), "long", 0.05, Some(0.0));
    figures.extend(early.figures(&what("before T = 1"), "long", 0.05, None));
    let plot = Plot {
        title: "Front of a breaking dam".into(),
        x: Axis::linear("t √(2 g / a)".replace('√', "sqrt ").as_str()),
        y: Axis::linear("front / a"),
        series: vec![curve("measured", 0, measured.to_vec()), dots(1, finest)],
    };
    Ok(Measured { figures, plot })
}

/// T and x/a of the bulk's front.
fn fronts(name: &str, across: u32, samples: usize) -> Result<Vec<[Real; 2]>, StudyError> {
    let dx = LENGTH / Real::from(across);
    let solid = Solid {
        shapes: [Vec3::z(), Vec3::x()]
            .map(|normal| Shape::HalfSpace {
                point: Vec3::zeros(),
                normal,
            })
            .to_vec(),
        grids: Vec::new(),
    };
    let domain = Aabb {
        min: Vec3::new(-3.0 * dx, 0.0, -3.0 * dx),
        max: Vec3::new(6.0 * LENGTH, WIDTH as Real * dx, 2.5 * LENGTH),
    };
    let mut s = settings(dx, domain);
    s.periodic = [false, true, false];
    s.stress = StressStep::Explicit;
    s.gravity = Vec3::z() * -GRAVITY;
    s.cement = newtonian(1000.0, 1e-3);
    s.time_step = TimeStep::Adaptive {
        min: 1e-7,
        max: 5e-3,
        cfl: 0.4,
    };
    let bounds = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(LENGTH, domain.max.y, 2.0 * LENGTH),
    };
    s.bodies = vec![body(BodyShape::Box(bounds), 0.0)];
    let region = Aabb {
        min: domain.min,
        max: domain.max - Vec3::y() * (1e-6 * dx),
    };
    let walls = wall_particles(&solid, &region, dx, (s.support_ratio - 0.4) * dx);
    let place = Place {
        settings: s,
        solid,
        walls,
        moving: Vec::new(),
    };
    let mut simulation = place.start(name)?;
    let mut fronts = Vec::new();
    for [time, _] in &DAM_FRONT[..samples] {
        simulation
            .advance_to(time * (LENGTH / (2.0 * GRAVITY)).sqrt(), |_| {})
            .map_err(StudyError::run(name))?;
        let mut x: Vec<Real> = simulation.fluid.position.iter().map(|x| x.x).collect();
        x.sort_by(Real::total_cmp);
        let water = (2 * across * across) as usize * WIDTH;
        let ahead = (AHEAD * water as Real).round() as usize;
        fronts.push([*time, x[x.len() - 1 - ahead] / LENGTH]);
    }
    Ok(fronts)
}
