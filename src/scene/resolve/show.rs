//! Surface, volumes, pictures.

use super::check::{Checker, point};
use crate::scene::recipe::Recipe;
use crate::scene::show::BoneLook;
use crate::scene::{Export, Plane, Preview, Surface, View};

pub(super) fn surface(c: &mut Checker<'_>, recipe: &Recipe) -> Surface {
    let surface = &recipe.surface;
    c.require(
        surface.smoothing <= 100,
        "surface.smoothing",
        "is at most 100 passes",
    );
    Surface {
        cube: recipe.spacing.si() * c.within("surface.cube", surface.cube, 0.1..=2.0),
        smoothing: surface.smoothing,
        threshold: c.within("surface.threshold", surface.threshold, 0.05..=0.95),
    }
}

pub(super) fn export(c: &mut Checker<'_>, recipe: &Recipe) -> Export {
    let export = &recipe.export;
    let name = &export.velocity_grid;
    c.require(
        !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'),
        "export.velocity_grid",
        "must be letters, digits or _",
    );
    Export {
        voxel: recipe.spacing.si() * c.within("export.voxel", export.voxel, 0.1..=4.0),
        up: export.up,
        velocity_grid: name.clone(),
    }
}

pub(super) fn preview(c: &mut Checker<'_>, recipe: &Recipe) -> Preview {
    let preview = &recipe.preview;
    for (key, pixels) in [("width", preview.width), ("height", preview.height)] {
        c.within(&format!("preview.{key}"), pixels.into(), 16.0..=8192.0);
    }
    c.within("preview.samples", preview.samples.into(), 1.0..=8.0);
    c.distinct(
        "preview.view",
        preview.view.iter().map(|view| view.name.as_str()),
    );
    let views = preview.view.iter().enumerate().map(|(n, view)| {
        let key = format!("preview.view[{n}]");
        let cut = view.cut.map(|cut| Plane {
            point: point(cut.point),
            normal: c.direction(&format!("{key}.cut.normal"), cut.normal),
        });
        c.require(
            view.bone != BoneLook::Cut || cut.is_some(),
            &format!("{key}.bone"),
            "\"cut\" needs a plane: cut = { point = …, normal = … }",
        );
        View {
            name: view.name.clone(),
            azimuth: view.azimuth.si(),
            elevation: view.elevation.si(),
            zoom: c.within(&format!("{key}.zoom"), view.zoom, 0.01..=100.0),
            target: view.target.map(point),
            cut,
            bone: view.bone,
        }
    });
    Preview {
        views: views.collect(),
        width: preview.width,
        height: preview.height,
        samples: preview.samples,
    }
}
