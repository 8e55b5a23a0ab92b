//! The bone: its regions, cracks, veins and sources of porosity.

use super::check::{Checker, point};
use super::place::{LEAST_ACROSS, sphere};
use super::wall::tube;
use crate::bone::{BoneSettings, Channel, Opening, OpeningShape, Place, Region, Struts, Varying};
use crate::math::{Real, Vec3};
use crate::scene::bone::{BoneRecipe, CrackRecipe, RegionRecipe};
use crate::scene::recipe::Recipe;
use crate::scene::{Bone, MeshFile, VolumeFile};
use std::path::Path;

pub(super) fn bone(c: &mut Checker<'_>, recipe: &Recipe, folder: &Path) -> Option<Bone> {
    let bone = recipe.bone.as_ref()?;
    let scale = bone.scale.unwrap_or(1.0);
    c.within("bone.scale", scale, 0.1..=20.0);
    c.require(
        bone.scale.is_none() || bone.preset.is_some(),
        "bone.scale",
        "enlarges a preset, and none is given",
    );
    let mut parts = Vec::new();
    let mut regions = regions(c, recipe, bone, &mut parts);
    if let Some(preset) = bone.preset {
        let region = preset.region(scale);
        let gap = region.period / recipe.spacing.si();
        if gap < LEAST_ACROSS + 1.0 {
            let message = format!(
                "puts struts {gap:.1} spacings apart: pores are not resolved; a spacing of {:.2} mm would resolve them, \
                 or bone.scale = {:.1} at this one",
                region.period / (LEAST_ACROSS + 1.0) * 1e3,
                scale * (LEAST_ACROSS + 1.0) / gap
            );
            c.warn("bone.preset", message);
        }
        if scale > 1.0 {
            let message = format!("enlarges pores {scale} times: a teaching scale, not a patient");
            c.warn("bone.scale", message);
        }
        regions.push(region);
    }
    c.require(!regions.is_empty(), "bone.region", "at least one is needed");
    let preset = |of: fn(crate::bone::Preset) -> Real| bone.preset.map(|p| of(p) * scale);
    let cortex = bone.cortex.map(crate::units::Length::si);
    let cortex = cortex.or(preset(crate::bone::Preset::cortex));
    c.require(
        cortex.is_some(),
        "bone",
        "needs cortex, the thickness of its shell, or a preset",
    );
    let shell = cortex.unwrap_or(0.0);
    c.require(shell >= 0.0, "bone.cortex", "must not be below zero");
    let endplate = bone.endplate.map(crate::units::Length::si);
    let endplate =
        endplate.or(preset(crate::bone::Preset::endplate).filter(|_| bone.cortex.is_none()));
    let endplate = endplate.unwrap_or(shell);
    c.require(endplate >= 0.0, "bone.endplate", "must not be below zero");

    let cannulas = recipe
        .inlet
        .iter()
        .filter_map(|inlet| Some((inlet, inlet.cannula.as_ref()?)));
    let channels = cannulas.map(|(inlet, cannula)| {
        let (base, axis, length) = tube(recipe, inlet, cannula);
        // As wide as the opening: the tube sits tight in the bone.
        Channel {
            base,
            axis,
            length: length + cannula.clearance.si(),
            radius: 0.5 * inlet.diameter.si(),
        }
    });
    Some(Bone {
        file: MeshFile {
            path: folder.join(&bone.mesh),
            unit: bone.unit,
            up: bone.up,
            at: Vec3::zeros(),
        },
        frame: bone.frame,
        channels: channels.collect(),
        parts,
        volume: bone.volume.as_ref().map(|volume| VolumeFile {
            path: folder.join(&volume.path),
            grid: volume.grid.clone(),
            holds: volume.holds,
            unit: volume.unit,
            up: volume.up,
        }),
        settings: BoneSettings {
            shell_thickness: shell,
            endplate_thickness: endplate,
            openings: openings(c, recipe, bone),
            regions,
            seed: recipe.seed.into(),
            ..BoneSettings::default()
        },
    })
}

fn regions(
    c: &mut Checker<'_>,
    recipe: &Recipe,
    bone: &BoneRecipe,
    parts: &mut Vec<String>,
) -> Vec<Region> {
    c.distinct(
        "bone.region",
        bone.region.iter().map(|region| region.name.as_str()),
    );
    let last = bone.region.len().saturating_sub(1);
    let mut regions = Vec::new();
    for (n, region) in bone.region.iter().enumerate() {
        let key = format!("bone.region[{n}]");
        let place = place(c, &key, region, parts);
        // With a preset, that is everywhere else.
        let rest = n == last && bone.preset.is_none();
        c.require(
            rest == (place == Place::Everywhere),
            &key,
            "the last region, and no other, is everywhere else: without a place of its own",
        );
        let period = c.positive(&format!("{key}.strut_period"), region.strut_period.si());
        c.within(&format!("{key}.lost"), region.lost, 0.0..=0.8);
        let struts = struts(c, recipe, bone, &key, region);
        regions.push(Region {
            name: region.name.clone(),
            place,
            period,
            struts,
            lost: region.lost,
        });
    }
    regions
}

fn struts(
    c: &mut Checker<'_>,
    recipe: &Recipe,
    bone: &BoneRecipe,
    key: &str,
    region: &RegionRecipe,
) -> Struts {
    let names = [
        "strut_diameter",
        "porosity",
        "gradient",
        "painted",
        "volume",
    ];
    let given = [
        region.strut_diameter.is_some(),
        region.porosity.is_some(),
        region.gradient.is_some(),
        region.painted.is_some(),
        region.volume.is_some(),
    ];
    c.exactly_one(key, &names, &given);
    if let Some(diameter) = region.strut_diameter {
        let key = format!("{key}.strut_diameter");
        let (diameter, period) = (diameter.si(), region.strut_period.si());
        c.positive(&key, diameter);
        c.require(
            diameter < period,
            &key,
            "leaves no gap: it must be below strut_period",
        );
        let gap = (period - diameter) / recipe.spacing.si();
        if gap < LEAST_ACROSS {
            let finest = (period - diameter) / LEAST_ACROSS;
            c.warn(
                &key,
                format!(
                    "leaves gaps of {gap:.1} spacings: pores are not resolved; a spacing of {:.2} mm would resolve them",
                    finest * 1e3
                ),
            );
        }
        return Struts::Diameter(diameter);
    }
    if let Some(porosity) = region.porosity {
        c.within(&format!("{key}.porosity"), porosity, 0.3..=1.0);
        return Struts::Porosity(porosity);
    }
    let varying = if let Some(gradient) = &region.gradient {
        let (from, to) = (point(gradient.from), point(gradient.to));
        c.require(
            (to - from).norm() > 0.0,
            &format!("{key}.gradient"),
            "has both ends at one point",
        );
        Varying::Gradient {
            from,
            to,
            values: gradient.values,
        }
    } else if let Some(painted) = &region.painted {
        Varying::Painted {
            black: painted.black,
            white: painted.white,
        }
    } else if let Some([least, most]) = region.volume {
        c.require(
            bone.volume.is_some(),
            &format!("{key}.volume"),
            "needs [bone.volume], the file it is read from",
        );
        c.require(
            least <= most,
            &format!("{key}.volume"),
            "is a least and a greatest porosity, in this order",
        );
        Varying::Volume { least, most }
    } else {
        return Struts::Porosity(0.9);
    };
    for porosity in varying.range() {
        c.within(key, porosity, 0.3..=0.99);
    }
    Struts::Varying(varying)
}

fn place(c: &mut Checker<'_>, key: &str, region: &RegionRecipe, parts: &mut Vec<String>) -> Place {
    let given = [
        region.r#box.is_some(),
        region.ellipsoid.is_some(),
        region.sphere.is_some(),
        region.plane.is_some(),
        region.part.is_some(),
    ];
    if given.iter().filter(|&&given| given).count() > 1 {
        c.error(
            key,
            "has several of box, ellipsoid, sphere, plane, part: give one",
        );
    }
    if let Some(bounds) = &region.r#box {
        Place::Box(c.bounds(&format!("{key}.box"), bounds))
    } else if let Some(ellipsoid) = &region.ellipsoid {
        let radii = point(ellipsoid.radii);
        c.positive(&format!("{key}.ellipsoid.radii"), radii.min());
        Place::Ellipsoid {
            centre: point(ellipsoid.centre),
            semi_axes: radii,
        }
    } else if let Some(ball) = &region.sphere {
        let (centre, radius) = sphere(c, key, ball);
        Place::Ellipsoid {
            centre,
            semi_axes: Vec3::repeat(radius),
        }
    } else if let Some(plane) = &region.plane {
        Place::HalfSpace {
            point: point(plane.point),
            normal: c.direction(&format!("{key}.plane.normal"), plane.normal),
        }
    } else if let Some(part) = &region.part {
        let known = parts.iter().position(|name| name == part);
        Place::Part(known.unwrap_or_else(|| {
            parts.push(part.clone());
            parts.len() - 1
        }) as u32)
    } else {
        Place::Everywhere
    }
}

fn openings(c: &mut Checker<'_>, recipe: &Recipe, bone: &BoneRecipe) -> Vec<Opening> {
    let cracks = bone.crack.iter().map(|crack| crack.name.as_str());
    c.distinct("bone.crack", cracks);
    let veins = bone.vein.iter().map(|vein| vein.name.as_str());
    c.distinct("bone.vein", veins);
    let mut openings = Vec::new();
    for (n, crack) in bone.crack.iter().enumerate() {
        let key = format!("bone.crack[{n}]");
        if let Some(shape) = crack_shape(c, &key, crack, recipe.spacing.si()) {
            openings.push(Opening {
                name: crack.name.clone(),
                shape,
            });
        }
    }
    for (n, vein) in bone.vein.iter().enumerate() {
        let key = format!("bone.vein[{n}]");
        let diameter = c.positive(&format!("{key}.diameter"), vein.diameter.si());
        c.require(
            vein.points.len() >= 2,
            &format!("{key}.points"),
            "at least two are needed",
        );
        narrow(c, &format!("{key}.diameter"), diameter, recipe.spacing.si());
        openings.push(Opening {
            name: vein.name.clone(),
            shape: OpeningShape::Canal {
                points: vein.points.iter().map(|p| point(*p)).collect(),
                radius: 0.5 * diameter,
            },
        });
    }
    openings
}

fn crack_shape(
    c: &mut Checker<'_>,
    key: &str,
    crack: &CrackRecipe,
    spacing: Real,
) -> Option<OpeningShape> {
    let within = crack.r#box.as_ref();
    let within = within.map(|bounds| c.bounds(&format!("{key}.box"), bounds));
    match (&crack.plane, crack.aperture) {
        (Some(plane), Some(aperture)) => {
            let at = format!("{key}.aperture");
            let aperture = c.positive(&at, aperture.si());
            narrow(c, &at, aperture, spacing);
            Some(OpeningShape::Slit {
                point: point(plane.point),
                normal: c.direction(&format!("{key}.plane.normal"), plane.normal),
                aperture,
                within,
            })
        }
        (None, None) if within.is_some() => within.map(OpeningShape::Box),
        _ => {
            c.error(
                key,
                "needs a box, or a plane and its aperture, or all three",
            );
            None
        }
    }
}

fn narrow(c: &mut Checker<'_>, key: &str, width: Real, spacing: Real) {
    let across = width / spacing;
    if across < LEAST_ACROSS {
        c.warn(
            key,
            format!("is {across:.1} spacings wide: flow through it is not resolved"),
        );
    }
}
