//! Walls that stand, walls that move, and cannulas.

use super::check::{Checker, point};
use super::place::{cylinder, sphere};
use crate::math::{Aabb, Real, Vec3};
use crate::scene::place::{CannulaRecipe, InletRecipe, MeshRecipe, WallRecipe};
use crate::scene::recipe::{Axis, Recipe};
use crate::scene::{MeshFile, MovingWall, Region};
use crate::sim::{Motion, Path as Way};
use crate::solid::Shape;
use crate::units::{Length, Time, Velocity};
use std::f64::consts::TAU;
use std::path::Path;

/// Everything solid but the bone.
#[derive(Default)]
pub(super) struct Walls {
    pub shapes: Vec<Shape>,
    pub tubes: Vec<Shape>,
    pub meshes: Vec<MeshFile>,
    pub movers: Vec<MovingWall>,
}

pub(super) fn walls(c: &mut Checker<'_>, recipe: &Recipe, folder: &Path) -> Walls {
    let mut walls = Walls::default();
    for (n, wall) in recipe.wall.iter().enumerate() {
        let key = format!("wall[{n}]");
        let Some(region) = region(c, &key, wall, folder) else {
            continue;
        };
        match (motion(c, &key, wall, recipe, &region), region) {
            (Some(motion), region) => walls.movers.push(MovingWall { region, motion }),
            (None, Region::Shape(shape)) => walls.shapes.push(shape),
            (None, Region::Mesh(mesh)) => walls.meshes.push(mesh),
        }
    }
    for inlet in &recipe.inlet {
        if let Some(cannula) = &inlet.cannula {
            let (base, axis, length) = tube(recipe, inlet, cannula);
            let inner = 0.5 * inlet.diameter.si();
            let outer = 0.5 * cannula.outer_diameter.si();
            let tight = inner + CANNULA_WALL * recipe.spacing.si();
            let tube = |outer: Real| Shape::Tube {
                base,
                axis,
                length,
                inner,
                outer,
            };
            walls.shapes.push(tube(outer.max(tight)));
            walls.tubes.push(tube(outer));
        }
    }
    walls
}

fn region(c: &mut Checker<'_>, key: &str, wall: &WallRecipe, folder: &Path) -> Option<Region> {
    let names = ["box", "sphere", "cylinder", "plane", "mesh"];
    let given = [
        wall.r#box.is_some(),
        wall.sphere.is_some(),
        wall.cylinder.is_some(),
        wall.plane.is_some(),
        wall.mesh.is_some(),
    ];
    c.exactly_one(key, &names, &given)?;
    let hollow = wall.hollow;
    if let Some(bounds) = &wall.r#box {
        let Aabb { min, max } = c.bounds(&format!("{key}.box"), bounds);
        return Some(Region::Shape(Shape::Box { min, max, hollow }));
    }
    if let Some(ball) = &wall.sphere {
        let (centre, radius) = sphere(c, key, ball);
        return Some(Region::Shape(Shape::Sphere {
            centre,
            radius,
            hollow,
        }));
    }
    if let Some(round) = &wall.cylinder {
        let (base, axis, length, radius) = cylinder(c, key, round);
        return Some(Region::Shape(Shape::Cylinder {
            base,
            axis,
            length,
            radius,
            hollow,
        }));
    }
    c.require(
        !hollow,
        &format!("{key}.hollow"),
        "goes with box, sphere or cylinder only",
    );
    if let Some(plane) = &wall.plane {
        return Some(Region::Shape(Shape::HalfSpace {
            point: point(plane.point),
            normal: c.direction(&format!("{key}.plane.normal"), plane.normal),
        }));
    }
    wall.mesh
        .as_ref()
        .map(|mesh| Region::Mesh(mesh_file(mesh, folder)))
}

/// A mesh that a recipe names, relative to `folder`.
pub(super) fn mesh_file(mesh: &MeshRecipe, folder: &Path) -> MeshFile {
    MeshFile {
        path: folder.join(&mesh.path),
        unit: mesh.unit,
        up: mesh.up,
        at: mesh.at.map_or(Vec3::zeros(), point),
    }
}

/// Farther than this, in lengths of the domain, no wall need move.
const MOST_SHIFT: Real = 10.0;

fn motion(
    c: &mut Checker<'_>,
    key: &str,
    wall: &WallRecipe,
    recipe: &Recipe,
    region: &Region,
) -> Option<Motion> {
    let plane = matches!(region, Region::Shape(Shape::HalfSpace { .. }));
    let ramp = |c: &mut Checker<'_>, key: String, ramp: Option<Time>| {
        let ramp = ramp.map_or(0.0, Time::si);
        c.require(
            ramp >= 0.0 && ramp.is_finite(),
            &format!("{key}.ramp"),
            "must not be below zero",
        );
        ramp
    };
    let given = [
        wall.turning.is_some(),
        wall.moving.is_some(),
        wall.oscillating.is_some(),
    ];
    if !given.contains(&true) {
        return None;
    }
    c.exactly_one(key, &["turning", "moving", "oscillating"], &given)?;
    let periodic = recipe.periodic.iter().map(|axis| match axis {
        Axis::X => Vec3::x(),
        Axis::Y => Vec3::y(),
        Axis::Z => Vec3::z(),
    });
    if let Some(turning) = &wall.turning {
        let key = format!("{key}.turning");
        let axis = c.direction(&format!("{key}.axis"), turning.axis);
        c.require(!plane, &key, "does not go with a plane");
        for along in periodic {
            c.require(
                axis.dot(&along).abs() > 1.0 - 1e-12,
                &format!("{key}.axis"),
                "must lie along the periodic axis of the domain",
            );
        }
        let rate = turning.rate.si() * TAU;
        c.require(rate.is_finite(), &format!("{key}.rate"), "must be finite");
        return Some(Motion {
            path: Way::Turning {
                point: point(turning.point),
                axis,
                rate,
            },
            ramp: ramp(c, key, turning.ramp),
        });
    }
    let (motion, key) = if let Some(moving) = &wall.moving {
        let key = format!("{key}.moving");
        let velocity = Vec3::from(moving.velocity.map(Velocity::si));
        let travel = moving.travel.map(Length::si);
        if let Some(travel) = travel {
            c.positive(&format!("{key}.travel"), travel);
        }
        let path = Way::Moving { velocity, travel };
        let ramp = ramp(c, key.clone(), moving.ramp);
        (Motion { path, ramp }, key)
    } else {
        let oscillating = wall.oscillating.as_ref()?;
        let key = format!("{key}.oscillating");
        let path = Way::Oscillating {
            amplitude: point(oscillating.amplitude),
            frequency: c.positive(&format!("{key}.frequency"), oscillating.frequency.si()),
        };
        let ramp = ramp(c, key.clone(), oscillating.ramp);
        (Motion { path, ramp }, key)
    };
    let shift = motion.most_shift(recipe.duration.si());
    let domain = Vec3::from(recipe.domain.max.map(Length::si))
        - Vec3::from(recipe.domain.min.map(Length::si));
    if !shift.is_finite() || shift > MOST_SHIFT * domain.norm() {
        let message = format!("takes it {shift:.3e} m away, far out of the domain");
        c.error(&key, message);
    }
    let way = match motion.path {
        Way::Oscillating { amplitude, .. } => amplitude,
        Way::Moving { velocity, .. } => velocity,
        Way::Turning { .. } => Vec3::zeros(),
    };
    for along in periodic {
        c.require(
            plane || way.dot(&along) == 0.0,
            &key,
            "leads along a periodic axis, which only a plane can follow",
        );
    }
    Some(motion)
}

/// A cannula's wall is made at least this many spacings thick, outwards: that much is tight. (Of 0.66, at a spacing of
/// 0.5 mm, six sevenths of the cement left an 11G cannula through its wall.)
const CANNULA_WALL: Real = 2.0;

/// The tube reaches at least one support radius behind the plane where cement enters, so that cement which waits
/// there to come in has walls as well: base, axis, length.
pub(super) fn tube(
    recipe: &Recipe,
    inlet: &InletRecipe,
    cannula: &CannulaRecipe,
) -> (Vec3, Vec3, Real) {
    let axis = Vec3::from(inlet.direction)
        .try_normalize(1e-12)
        .unwrap_or(Vec3::z());
    let simulated = cannula.length.si() + recipe.support_ratio * recipe.spacing.si();
    let length = cannula.shaft.map_or(simulated, |l| simulated.max(l.si()));
    (point(inlet.position) - axis * length, axis, length)
}
