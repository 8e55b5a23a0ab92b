//! Bodies and inlets.

use super::check::{Checker, point};
use super::wall::mesh_file;
use crate::math::{Aabb, Real, Vec3};
use crate::scene::MeshFile;
use crate::scene::place::{BodyRecipe, CylinderRecipe, InletRecipe, Ratio, SphereRecipe};
use crate::scene::recipe::Recipe;
use crate::sim::{Body, BodyShape, Inlet, Inside};
use crate::units::Velocity;
use std::path::Path;

/// Fewer spacings than this across an opening do not carry a flow profile.
pub(super) const LEAST_ACROSS: Real = 3.0;

/// Bodies, and the meshes of those that fill one, in their order.
pub(super) fn bodies(
    c: &mut Checker<'_>,
    recipe: &Recipe,
    domain: &Aabb,
    folder: &Path,
) -> (Vec<Body>, Vec<MeshFile>) {
    let (mut bodies, mut meshes) = (Vec::new(), Vec::new());
    for (n, body) in recipe.body.iter().enumerate() {
        let key = format!("body[{n}]");
        let polymer_fraction = c.within(
            &format!("{key}.polymer_fraction"),
            body.polymer_fraction,
            0.0..=1.0,
        );
        let Some((shape, bounds)) = body_shape(c, &key, body, domain) else {
            continue;
        };
        // A hair of tolerance: "0.1 m" as a centre plus a radius need not add up to the last bit.
        let room = domain.grown(1e-9 * domain.extent().max());
        c.require(
            room.contains(&bounds.min) && room.contains(&bounds.max),
            &key,
            "reaches out of the domain",
        );
        meshes.extend(body.mesh.as_ref().map(|mesh| mesh_file(mesh, folder)));
        bodies.push(Body {
            shape,
            polymer_fraction,
            velocity: body
                .velocity
                .map_or(Vec3::zeros(), |v| v.map(Velocity::si).into()),
            saturated: body.saturated,
        });
    }
    (bodies, meshes)
}

/// Its shape and its bounds; those of a mesh are not known yet.
fn body_shape(
    c: &mut Checker<'_>,
    key: &str,
    body: &BodyRecipe,
    domain: &Aabb,
) -> Option<(BodyShape, Aabb)> {
    let given = [
        body.r#box.is_some(),
        body.sphere.is_some(),
        body.cylinder.is_some(),
        body.mesh.is_some(),
    ];
    c.exactly_one(key, &["box", "sphere", "cylinder", "mesh"], &given)?;
    if body.mesh.is_some() {
        // Where it lies is seen when it is read.
        let nowhere = Aabb::around([&domain.min]);
        return Some((BodyShape::Mesh(Inside::default()), nowhere));
    }
    if let Some(bounds) = &body.r#box {
        let bounds = c.bounds(&format!("{key}.box"), bounds);
        return Some((BodyShape::Box(bounds), bounds));
    }
    if let Some(ball) = &body.sphere {
        let (centre, radius) = sphere(c, key, ball);
        let bounds = Aabb::around([&centre]).grown(radius);
        return Some((BodyShape::Sphere { centre, radius }, bounds));
    }
    body.cylinder.as_ref().map(|round| {
        let (base, axis, length, radius) = cylinder(c, key, round);
        // Half extents of a disc of this radius across the axis.
        let disc = axis.map(|a| radius * (1.0 - a * a).max(0.0).sqrt());
        let end = base + axis * length;
        let bounds = Aabb::around([&(base - disc), &(base + disc), &(end - disc), &(end + disc)]);
        let shape = BodyShape::Cylinder {
            base,
            axis,
            length,
            radius,
        };
        (shape, bounds)
    })
}

pub(super) fn sphere(c: &mut Checker<'_>, key: &str, sphere: &SphereRecipe) -> (Vec3, Real) {
    let radius = c.positive(&format!("{key}.sphere.radius"), sphere.radius.si());
    (point(sphere.centre), radius)
}

pub(super) fn cylinder(
    c: &mut Checker<'_>,
    key: &str,
    cylinder: &CylinderRecipe,
) -> (Vec3, Vec3, Real, Real) {
    let key = |part| format!("{key}.cylinder.{part}");
    (
        point(cylinder.base),
        c.direction(&key("axis"), cylinder.axis),
        c.positive(&key("length"), cylinder.length.si()),
        c.positive(&key("radius"), cylinder.radius.si()),
    )
}

pub(super) fn inlets(c: &mut Checker<'_>, recipe: &Recipe, domain: &Aabb) -> Vec<Inlet> {
    c.distinct(
        "inlet",
        recipe.inlet.iter().map(|inlet| inlet.name.as_str()),
    );
    let inlets = recipe.inlet.iter().enumerate();
    inlets
        .map(|(n, inlet)| self::inlet(c, recipe, domain, &format!("inlet[{n}]"), inlet))
        .collect()
}

fn inlet(
    c: &mut Checker<'_>,
    recipe: &Recipe,
    domain: &Aabb,
    key: &str,
    inlet: &InletRecipe,
) -> Inlet {
    let at = |part: &str| format!("{key}.{part}");
    let direction = c.direction(&at("direction"), inlet.direction);
    let diameter = c.positive(&at("diameter"), inlet.diameter.si());
    let across = diameter / recipe.spacing.si();
    if across < LEAST_ACROSS {
        let message = format!("is {across:.2} spacings across, at least {LEAST_ACROSS} are needed");
        c.error(&at("diameter"), message);
    }
    let tip = point(inlet.position);
    let mut position = tip;
    if let Some(cannula) = &inlet.cannula {
        position -= direction * c.positive(&at("cannula.length"), cannula.length.si());
        let outer = cannula.outer_diameter.si();
        c.require(
            outer > diameter,
            &at("cannula.outer_diameter"),
            "must be above the diameter",
        );
        c.require(
            cannula.clearance.si() >= 0.0,
            &at("cannula.clearance"),
            "must not be below zero",
        );
    }
    c.require(
        domain.contains(&tip) && domain.contains(&position),
        &at("position"),
        "this point or the far end of its cannula lies outside the domain",
    );

    let given = [inlet.ratio.is_some(), inlet.polymer_fraction.is_some()];
    c.exactly_one(key, &["ratio", "polymer_fraction"], &given);
    let fraction = inlet
        .ratio
        .map(Ratio::polymer_fraction)
        .or(inlet.polymer_fraction);
    let polymer_fraction = c.within(&at("polymer_fraction"), fraction.unwrap_or(0.0), 0.0..=1.0);

    let flow_rate = c.positive(&at("flow_rate"), inlet.flow_rate.si());
    let dose = c.positive(&at("dose"), inlet.dose.si());
    let needed = dose / flow_rate;
    let duration = recipe.duration.si();
    if needed > duration * (1.0 + 1e-9) {
        let message =
            format!("takes {needed:.3} s at this flow rate, the duration is {duration} s");
        c.error(&at("dose"), message);
    }
    Inlet {
        name: inlet.name.clone(),
        position,
        direction,
        diameter,
        flow_rate,
        polymer_fraction,
        dose,
    }
}
