//! `check` of a mesh or a volume: what is in it, what is wrong with it, what may have been meant.

use super::args::CheckArguments;
use super::{Failure, failed, print};
use crate::cache;
use crate::flow::{self, FlowError};
use crate::grid::vdb::{self, VdbFile, VdbGrid};
use crate::math::Vec3;
use crate::mesh::{self, LengthUnit, ObjStyle, Survey, UpAxis};
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// Whether the file is something else than a recipe, and what.
pub(super) fn is_other(path: &Path) -> bool {
    matches!(ending(path).as_str(), "obj" | "vdb")
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_lowercase()
}

pub(super) fn check(arguments: &CheckArguments, as_json: bool) -> Result<(), Failure> {
    let path = &arguments.recipe.recipe;
    if ending(path) == "vdb" {
        let file = vdb::read_vdb(path).map_err(FlowError::from)?;
        return print(&if as_json {
            volume_json(&file)
        } else {
            volume(&file)
        });
    }
    let unit = arguments.unit.unwrap_or(LengthUnit::Metre);
    let up = arguments.up.unwrap_or(UpAxis::Z);
    let read = mesh::read_obj(path, unit, up).map_err(FlowError::from)?;
    let (survey, faults) = mesh::survey(&read, unit, up);
    if let Some(out) = &arguments.picture {
        flow::draw_three_sides(out, &read)?;
    }
    if let Some(out) = &arguments.defects {
        let (apart, colours) = mesh::painted_faults(&read, &faults);
        let style = ObjStyle {
            groups: &[],
            unit,
            up,
            comments: &[
                "red: rim of a hole, orange: edge of three or more, purple: crossing, blue: turned,",
                "teal: copy, yellow: without area, green: sliver, grey: sound",
            ],
        };
        let mut text = Vec::new();
        mesh::write_obj_with(&mut text, &style, &apart, None, Some(&colours))
            .map_err(failed(out))?;
        cache::write(out, &text).map_err(FlowError::from)?;
    }
    if as_json {
        return print(&format!("{:#}\n", json!(survey)));
    }
    print(&text(&survey))
}

struct Lines(String);

impl Lines {
    fn add(&mut self, name: &str, value: &str) {
        // Writing into a string cannot fail.
        let _ = writeln!(self.0, "{name:<12} {value}");
    }
}

fn millimetres(p: &Vec3) -> String {
    format!("{:.2}, {:.2}, {:.2} mm", p.x * 1e3, p.y * 1e3, p.z * 1e3)
}

fn text(survey: &Survey) -> String {
    let mut lines = Lines(String::new());
    let parts = [
        (survey.triangles, "triangles"),
        (survey.vertices, "vertices"),
        (survey.pieces, "pieces"),
    ];
    let parts: Vec<String> = parts
        .iter()
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    lines.add("mesh", &parts.join(", "));
    lines.add("size", &millimetres(&survey.size_m));
    lines.add("area", &format!("{:.1} mm²", survey.area_m2 * 1e6));
    lines.add(
        "volume",
        &format!("{:.3} ml as stored", survey.volume_m3 * 1e6),
    );
    if survey.faults.is_empty() {
        lines.add("faults", "none");
    }
    for finding in &survey.faults {
        let first: Vec<String> = finding
            .first_m
            .iter()
            .map(|p| format!("({})", millimetres(p)))
            .collect();
        let told = format!(
            "{} triangles {}, first at {}",
            finding.triangles,
            finding.fault.name(),
            first.join(" ")
        );
        lines.add("fault", &told);
    }
    for repair in &survey.repairs_told {
        lines.add("repair", repair);
    }
    match (&survey.unusable, survey.repaired_volume_m3) {
        (Some(why), _) => lines.add("unusable", why),
        (None, Some(volume)) => lines.add("usable", &format!("encloses {:.3} ml", volume * 1e6)),
        (None, None) => {}
    }
    for suggestion in &survey.suggestions {
        lines.add("perhaps", suggestion);
    }
    lines.0
}

fn volume(file: &VdbFile) -> String {
    let mut lines = Lines(String::new());
    for grid in &file.grids {
        let [least, mean, most] = grid.range;
        lines.add(
            "grid",
            &format!("{}: {}, {}", grid.name, grid.class, grid.packing),
        );
        let edges = grid.voxel_size();
        let told = format!(
            "{} active, {:.4} × {:.4} × {:.4} units each",
            grid.active, edges.x, edges.y, edges.z
        );
        lines.add("voxels", &told);
        if grid.active > 0 {
            let bounds = grid.world_bounds();
            let (low, high) = (bounds.min, bounds.max);
            let told = format!(
                "{:.3}, {:.3}, {:.3} to {:.3}, {:.3}, {:.3} units",
                low.x, low.y, low.z, high.x, high.y, high.z
            );
            lines.add("from", &told);
        }
        lines.add(
            "values",
            &format!("{least:.4} to {most:.4}, mean {mean:.4}"),
        );
        for suggestion in suggestions(grid) {
            lines.add("perhaps", &suggestion);
        }
    }
    for (name, kind) in &file.passed_over {
        lines.add("passed over", &format!("{name}: {kind}"));
    }
    lines.0
}

fn suggestions(grid: &VdbGrid) -> Vec<String> {
    let mut told = Vec::new();
    let [least, _, most] = grid.range;
    if grid.active == 0 {
        told.push("the grid holds nothing".to_owned());
        return told;
    }
    if least < -0.01 || most > 1.01 {
        told.push(
            "values leave 0 to 1: neither a bone fraction nor a porosity (Hounsfield units have to be mapped first)"
                .to_owned(),
        );
    }
    let size = grid.world_bounds().extent().max();
    let units = [
        LengthUnit::Metre,
        LengthUnit::Centimetre,
        LengthUnit::Millimetre,
    ];
    let fits = units
        .into_iter()
        .find(|unit| (0.02..0.2).contains(&(size * unit.metres())));
    told.push(match fits {
        Some(unit) => format!(
            "with unit = \"{unit}\" it is {:.1} mm long, the size of a bone",
            size * unit.metres() * 1e3
        ),
        None => format!("{size:.3} units are no size of a bone in m, cm or mm"),
    });
    told
}

fn volume_json(file: &VdbFile) -> String {
    let grids: Vec<_> = file
        .grids
        .iter()
        .map(|grid| {
            json!({
                "name": grid.name,
                "class": grid.class,
                "packing": grid.packing,
                "active_voxels": grid.active,
                "voxel_size": grid.voxel_size(),
                "bounds": grid.world_bounds(),
                "range": grid.range,
                "suggestions": suggestions(grid),
            })
        })
        .collect();
    let passed_over: Vec<_> = file
        .passed_over
        .iter()
        .map(|(name, kind)| json!({ "name": name, "type": kind }))
        .collect();
    format!(
        "{:#}\n",
        json!({ "grids": grids, "passed_over": passed_over })
    )
}
