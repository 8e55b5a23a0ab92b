//! `make`: meshes from formulas.

use super::args::{FanArguments, Shape, SyringeArguments, VertebraArguments};
use super::failed;
use crate::bone::vertebra::{self, Level, VertebraSettings};
use crate::cache;
use crate::flow::{self, FlowError};
use crate::math::Real;
use crate::solid::fan::{self, FanSettings};
use crate::solid::syringe::{self, SyringeSettings};
use crate::units::Length;
use std::io;
use std::path::Path;

pub(super) fn make(shape: &Shape) -> Result<(), FlowError> {
    match shape {
        Shape::Vertebra(size) => {
            let settings = vertebra(size);
            put(&size.out, |out| vertebra::write(out, &settings))?;
            let beside = |ending| size.out.with_extension(ending);
            flow::draw_three_sides(&beside("png"), &vertebra::make(&settings))?;
            let Some(preset) = size.preset else {
                return Ok(());
            };
            let name = size.out.file_name().unwrap_or_default().to_string_lossy();
            flow::write_bone_section(&beside("toml"), &name, preset)
        }
        Shape::Fan(size) => put(&size.out, |out| fan::write(out, &fan(size))),
        Shape::Syringe(size) => put(&size.out, |out| syringe::write(out, &syringe(size))),
    }
}

/// Nothing is written unless all of it can be made.
fn put(path: &Path, write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<(), FlowError> {
    let mut text = Vec::new();
    write(&mut text).map_err(failed(path))?;
    Ok(cache::write(path, &text)?)
}

fn or(given: Option<Length>, default: Real) -> Real {
    given.map_or(default, Length::si)
}

fn vertebra(size: &VertebraArguments) -> VertebraSettings {
    let default = VertebraSettings::default();
    let [width, depth, height] = size.level.unwrap_or(Level::L3).body();
    VertebraSettings {
        body_width: or(size.width, width),
        body_depth: or(size.depth, depth),
        body_height: or(size.height, height),
        resolution: or(size.resolution, default.resolution),
        wedge: size.wedge,
        collapse: size.collapse,
    }
}

fn fan(size: &FanArguments) -> FanSettings {
    let default = FanSettings::default();
    FanSettings {
        diameter: or(size.diameter, default.diameter),
        height: or(size.height, default.height),
        hub_diameter: or(size.hub, default.hub_diameter),
        thickness: or(size.thickness, default.thickness),
        blades: size.blades.unwrap_or(default.blades),
        resolution: or(size.resolution, default.resolution),
        ..default
    }
}

fn syringe(size: &SyringeArguments) -> SyringeSettings {
    let default = SyringeSettings::default();
    SyringeSettings {
        barrel_diameter: or(size.barrel, default.barrel_diameter),
        barrel_length: or(size.length, default.barrel_length),
        nozzle_diameter: or(size.nozzle, default.nozzle_diameter),
        thickness: or(size.thickness, default.thickness),
        ..default
    }
}
