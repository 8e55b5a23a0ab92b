//! The scenes of the trials: pots of a dozen spacings.

use super::trial::{Family, Trial};
use crate::fluid::{Cement, PhaseMaterial};
use crate::math::{Aabb, Real, Vec3};
use crate::sim::{Body, BodyShape, Inlet, Motion, MovingSolid, Path, Scheme};
use crate::solid::{Shape, Solid, wall_particles};
use crate::study::scenes::{Place, body, newtonian, settings};
use std::f64::consts::PI;

/// Viscosity of the liquid [Pa·s].
const LIQUID: Real = 0.01;
const GRAVITY: Real = 9.81;
/// Of the fluid on a plate [Pa].
const PRESSURE: Real = 3e6;
/// Depth of the fluid on a plate, in spacings.
const DEPTH: Real = 8.0;

/// Where a trial takes place, and what may happen in it.
pub struct Arena {
    /// Walls and fluid.
    pub place: Place,
    /// Speed of whatever drives [m/s].
    pub speed: Real,
    /// Height of the pot times gravity [J/kg].
    pub fall: Real,
    /// Whether a particle has no business at a place.
    pub outside: Box<dyn Fn(&Vec3) -> bool>,
}

impl Arena {
    /// The scene of a trial.
    pub fn of(trial: &Trial) -> Self {
        match trial.family {
            Family::Stirred | Family::Dense | Family::Doubled => stirred(trial, 4.5),
            Family::Overlapping | Family::InWalls => stirred(trial, 7.5),
            Family::Squeezed => squeezed(trial, 5.0, 22.0),
            // Just room enough for what 60 CFL steps press in, and not enough.
            Family::Filled => squeezed(trial, 5.0, 8.5),
            Family::Overfilled => squeezed(trial, 5.0, 7.0),
            Family::Single => single(trial, 6.0),
            Family::Cornered => single(trial, 0.6),
            Family::Plate(thickness) => plate(trial, thickness),
        }
    }
}

fn cement(trial: &Trial) -> Cement {
    let densities = match trial.family {
        Family::Dense => [300.0, 3000.0],
        _ => [940.0, 1180.0],
    };
    Cement {
        liquid: PhaseMaterial {
            density: densities[0],
            viscosity: LIQUID,
        },
        polymer: PhaseMaterial {
            density: densities[1],
            viscosity: LIQUID * trial.ratio,
        },
        relaxation_time: trial.relaxation_time,
        thinning: trial.thinning,
        diffusion: 1e-7,
        normalised_bonding: true,
        slip_relaxation: (trial.seed % 2 == 1).then_some(1e-4),
        ..newtonian(densities[0], LIQUID)
    }
}

/// A pot that is solid outside, with what stands in it.
fn pot(trial: &Trial, pot: Shape, inside: Vec<Shape>, bodies: Vec<Body>, jitter: Real) -> Place {
    let dx = trial.spacing;
    let bounds = pot.bounds().unwrap_or_else(Aabb::empty);
    let domain = bounds.grown(3.0 * dx);
    let mut s = settings(dx, domain);
    s.scheme = Scheme::ImmCt;
    s.gravity = Vec3::new(0.0, 0.0, -GRAVITY);
    s.seed = trial.seed;
    s.jitter = jitter;
    s.cement = cement(trial);
    s.bodies = bodies;
    let depth = (s.support_ratio - 0.4) * dx;
    let mut solid = Solid {
        shapes: vec![pot],
        grids: Vec::new(),
    };
    solid.shapes.extend(inside);
    let walls = wall_particles(&solid, &domain.grown(s.support_ratio * dx), dx, depth);
    Place {
        settings: s,
        solid,
        walls,
        moving: Vec::new(),
    }
}

fn beyond(pot: Shape, spacing: Real) -> Box<dyn Fn(&Vec3) -> bool> {
    Box::new(move |x| pot.distance(x).0 < -spacing)
}

/// A round pot, liquid on one side and polymer on the other, and a blade of twice `half` spacings that turns.
fn stirred(trial: &Trial, half: Real) -> Arena {
    let dx = trial.spacing;
    let (radius, height) = (6.0 * dx, 12.0 * dx);
    let shape = Shape::Cylinder {
        base: Vec3::zeros(),
        axis: Vec3::z(),
        length: height,
        radius,
        hollow: true,
    };
    let over = match trial.family {
        Family::InWalls => 3.0 * dx,
        _ => 0.0,
    };
    let jitter = if over > 0.0 { 0.5 } else { 0.1 };
    let side = |from: Real, to: Real, fraction: Real| {
        let region = Aabb {
            min: Vec3::new(from, -radius - over, -over),
            max: Vec3::new(to, radius + over, 8.0 * dx),
        };
        body(BodyShape::Box(region), fraction)
    };
    let mut bodies = vec![
        side(-radius - over, 0.0, 0.0),
        side(0.0, radius + over, 1.0),
    ];
    if trial.family == Family::Doubled {
        bodies.extend(bodies.clone());
    }
    let mut place = pot(trial, shape.clone(), Vec::new(), bodies, jitter);
    let size = Vec3::new(half, 0.8, 2.0) * dx;
    let middle = Vec3::z() * 3.5 * dx;
    let blade = Shape::Box {
        min: middle - size,
        max: middle + size,
        hollow: false,
    };
    let region = Aabb {
        min: middle - size,
        max: middle + size,
    };
    let solid = Solid {
        shapes: vec![blade],
        grids: Vec::new(),
    };
    let particles = wall_particles(&solid, &region.grown(dx), dx, 2.0 * dx);
    place.moving = vec![MovingSolid {
        motion: Motion {
            path: Path::Turning {
                point: Vec3::zeros(),
                axis: Vec3::z(),
                rate: trial.speed / (half * dx),
            },
            ramp: 0.0,
        },
        solid,
        particles,
    }];
    Arena {
        place,
        speed: trial.speed,
        fall: GRAVITY * height,
        outside: beyond(shape, dx),
    }
}

/// A box of `height` spacings, full of struts and, to `depth` spacings, of fluid, and a needle that presses from above.
fn squeezed(trial: &Trial, depth: Real, height: Real) -> Arena {
    let dx = trial.spacing;
    let size = Vec3::new(12.0, 12.0, height) * dx;
    let shape = Shape::Box {
        min: Vec3::zeros(),
        max: size,
        hollow: true,
    };
    let middle = Vec3::new(6.0, 6.0, 0.0) * dx;
    let strut = |base: Vec3, axis: Vec3| Shape::Cylinder {
        base: base * dx - axis * dx,
        axis,
        length: 14.0 * dx,
        radius: 0.8 * dx,
        hollow: false,
    };
    let tip = 0.5 * height * dx;
    let inside = vec![
        strut(Vec3::new(0.0, 3.0, 2.5), Vec3::x()),
        strut(Vec3::new(0.0, 8.5, 4.0), Vec3::x()),
        strut(Vec3::new(3.4, 0.0, 4.2), Vec3::y()),
        strut(Vec3::new(8.2, 0.0, 2.2), Vec3::y()),
        Shape::Tube {
            base: middle + Vec3::z() * tip,
            axis: Vec3::z(),
            length: 6.0 * dx,
            inner: 2.0 * dx,
            outer: 3.5 * dx,
        },
    ];
    let region = Aabb {
        min: Vec3::zeros(),
        max: Vec3::new(12.0, 12.0, depth) * dx,
    };
    let bodies = vec![body(BodyShape::Box(region), 1.0)];
    let mut place = pot(trial, shape.clone(), inside, bodies, 0.1);
    place.settings.inlets = vec![Inlet {
        name: "needle".into(),
        position: middle + Vec3::z() * (tip + 2.5 * dx),
        direction: -Vec3::z(),
        diameter: 4.0 * dx,
        flow_rate: trial.speed * 4.0 * PI * dx * dx,
        polymer_fraction: 0.6,
        dose: 0.0,
    }];
    Arena {
        place,
        // The gaps are about as wide as the needle.
        speed: trial.speed,
        fall: GRAVITY * size.z,
        outside: beyond(shape, dx),
    }
}

/// One particle `off` spacings from a wall of a box.
fn single(trial: &Trial, off: Real) -> Arena {
    let dx = trial.spacing;
    let size = Vec3::repeat(12.0 * dx);
    let shape = Shape::Box {
        min: Vec3::zeros(),
        max: size,
        hollow: true,
    };
    let centre = Vec3::new(off, off, 3.0) * dx;
    let region = Aabb {
        min: centre.add_scalar(-0.5 * dx),
        max: centre.add_scalar(0.5 * dx),
    };
    let bodies = vec![body(BodyShape::Box(region), 0.5)];
    let place = pot(trial, shape.clone(), Vec::new(), bodies, 0.0);
    Arena {
        place,
        speed: (2.0 * GRAVITY * 3.0 * dx).sqrt(),
        fall: GRAVITY * 3.0 * dx,
        outside: beyond(shape, dx),
    }
}

/// Fluid on a plate, `thickness` spacings thick and askew of the voxels, under a gravity that makes it press.
fn plate(trial: &Trial, thickness: Real) -> Arena {
    let dx = trial.spacing;
    let shape = Shape::Box {
        min: Vec3::zeros(),
        max: Vec3::new(8.0, 8.0, 22.0) * dx,
        hollow: true,
    };
    let low = 5.37 * dx;
    let high = low + thickness * dx;
    let inside = vec![Shape::Box {
        min: Vec3::new(-1.0, -1.0, low),
        max: Vec3::new(1.0, 1.0, high),
        hollow: false,
    }];
    let region = Aabb {
        min: Vec3::new(0.0, 0.0, high),
        max: Vec3::new(8.0 * dx, 8.0 * dx, high + DEPTH * dx),
    };
    let mut place = pot(
        trial,
        shape.clone(),
        inside,
        vec![body(BodyShape::Box(region), 1.0)],
        0.1,
    );
    let gravity = PRESSURE / (place.settings.cement.polymer.density * DEPTH * dx);
    place.settings.gravity = Vec3::new(0.0, 0.0, -gravity);
    let through = low - 0.5 * dx;
    Arena {
        place,
        speed: (2.0 * gravity * dx).sqrt(),
        fall: gravity * DEPTH * dx,
        outside: Box::new(move |x| x.z < through || shape.distance(x).0 < -dx),
    }
}
