//! Surface, volumes, pictures.

use super::check::{Checker, point};
use crate::preview::PictureSettings;
use crate::scene::recipe::Recipe;
use crate::scene::show::BoneLook;
use crate::scene::{Plane, Preview, View};

/// What the rooms themselves say about their settings: `key: message`.
pub(super) fn checked(c: &mut Checker<'_>, table: &str, found: Result<(), String>) {
    if let Err(text) = found {
        let (key, message) = text.split_once(": ").unwrap_or(("", &text));
        c.error(&format!("{table}.{key}"), message);
    }
}

pub(super) fn preview(c: &mut Checker<'_>, recipe: &Recipe) -> Preview {
    let preview = &recipe.preview;
    for (key, pixels) in [("width", preview.width), ("height", preview.height)] {
        c.within(&format!("preview.{key}"), pixels.into(), 16.0..=8192.0);
    }
    c.within("preview.samples", preview.samples.into(), 1.0..=16.0);
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
        c.require(
            !view.cut_cement || cut.is_some(),
            &format!("{key}.cut_cement"),
            "needs a plane: cut = { point = …, normal = … }",
        );
        c.within(
            &format!("{key}.turntable"),
            view.turntable.into(),
            0.0..=360.0,
        );
        View {
            name: view.name.clone(),
            azimuth: view.azimuth.si(),
            elevation: view.elevation.si(),
            zoom: c.within(&format!("{key}.zoom"), view.zoom, 0.01..=100.0),
            target: view.target.map(point),
            cut,
            cut_cement: view.cut_cement,
            bone: view.bone,
            colour: view.colour,
            turntable: view.turntable,
        }
    });
    Preview {
        views: views.collect(),
        picture: PictureSettings {
            width: preview.width,
            height: preview.height,
            samples: preview.samples,
            background: preview.background,
        },
    }
}
