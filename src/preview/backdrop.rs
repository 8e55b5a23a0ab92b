//! What stands still in a sequence of pictures, drawn once; each picture then draws only what the moving part changes.
//!
//! A pixel is drawn anew if one of its samples sees something else, or if what could hide sky or lamp from it, or from
//! the pixels that its exposure is averaged with, has changed. All others keep their bytes, so that a picture has the same
//! bits as one in which everything moves.

use super::{
    Camera, Lettering, MeshLayer, PictureSettings, Sphere,
    changes::Changes,
    exposure::{self, Exposures},
    geometry::Geometry,
    layers::{self, Seen},
    overlay,
    panes::Panes,
    raster::Samples,
    shadow::{self, Shadow},
};
use crate::math::Aabb;
use image::RgbImage;
use rayon::prelude::*;

/// The part of a scene that stands still, as one camera sees it. Takes about 100 bytes a pixel at 4 samples.
pub struct Backdrop<'a> {
    settings: PictureSettings,
    samples: Samples,
    geometry: Geometry<'a>,
    visible: Vec<Seen>,
    shadow: Option<Shadow>,
    /// Where in the lamp's view each pixel's surface is.
    lamp_places: Vec<[f32; 2]>,
    exposures: Exposures,
    panes: Panes,
    picture: Vec<u8>,
}

impl<'a> Backdrop<'a> {
    /// Draws `still`. The lamp lights it and all of `lit`: what moves beyond casts no shadow.
    pub fn new(
        still: &[MeshLayer<'a>],
        camera: &Camera,
        lit: &Aabb,
        settings: &PictureSettings,
    ) -> Self {
        let view = camera.view(settings.width, settings.height);
        let samples = Samples::new(settings.samples);
        let geometry = Geometry::new(still, &[], view);
        let visible = layers::opaque(&geometry, 0, &samples, None);
        let lit = shadow::bounds(still, &[]).union(lit);
        let shadow = Shadow::new(still, &lit, &geometry.view);
        let exposures = exposure::measure(&geometry, &samples, &visible, shadow.as_ref());
        let lamp_places = exposure::lamp_places(&geometry, &samples, &visible, shadow.as_ref());
        let panes = Panes::new(&geometry, &samples);
        let picture = layers::shade(
            &geometry,
            &samples,
            &visible,
            &exposures,
            &panes,
            settings.background,
            None,
        );
        Self {
            settings: *settings,
            samples,
            geometry,
            visible,
            shadow,
            lamp_places,
            exposures,
            panes,
            picture,
        }
    }

    /// Draws what moves in front of it, and lettering over all.
    pub fn draw(
        &self,
        moving: &[MeshLayer<'_>],
        spheres: &[Sphere],
        lettering: &Lettering,
    ) -> RgbImage {
        let (count, first) = (self.samples.count(), self.geometry.meshes.len());
        let geometry = self.geometry.with(moving, spheres);
        let view = &geometry.view;
        let visible = layers::opaque(&geometry, first, &self.samples, Some(&self.visible));
        let sees_else: Vec<bool> = visible
            .par_chunks(count)
            .zip(self.visible.par_chunks(count))
            .map(|(now, before)| now != before)
            .collect();
        let lamp = self.shadow.as_ref().map(|s| s.with(moving, spheres));
        let (shadow, lamp_changes) = lamp.unzip();
        let touched = self.touched(&visible, lamp_changes.as_ref());
        let exposures = self.exposures.again(
            &touched,
            &geometry,
            &self.samples,
            &visible,
            shadow.as_ref(),
        );
        let panes = self.panes.with(&geometry, first, &self.samples);

        // An exposure changes up to a tile's width around what was touched, and a pixel may take its neighbour's.
        let around = Changes::new(view.width, &touched);
        let redrawn: Vec<bool> = (0..sees_else.len())
            .into_par_iter()
            .map(|pixel| {
                sees_else[pixel]
                    || around.near(pixel, exposure::SPREAD + 1)
                    || panes.differ(&self.panes, pixel, view.width, count)
            })
            .collect();
        let bytes = layers::shade(
            &geometry,
            &self.samples,
            &visible,
            &exposures,
            &panes,
            self.settings.background,
            Some((&self.picture, &redrawn)),
        );
        let mut image = RgbImage::from_raw(self.settings.width, self.settings.height, bytes)
            .expect("three bytes a pixel were made");
        overlay::draw(&mut image, lettering, view, self.settings.background);
        image
    }

    /// Pixels whose own share of sky or lamp may have changed, or what they see first.
    fn touched(&self, visible: &[Seen], lamp: Option<&Changes>) -> Vec<bool> {
        let (view, count) = (&self.geometry.view, self.samples.count());
        let pixels = view.width * view.height;
        let first: Vec<bool> = (0..pixels)
            .into_par_iter()
            .map(|pixel| visible[pixel * count] != self.visible[pixel * count])
            .collect();
        let seen = Changes::new(view.width, &first);
        let reach = exposure::sky_reach(view);
        let disc = self.shadow.as_ref().map_or(0.0, Shadow::reach) as f32;
        let lamp_near = |[x, y]: [f32; 2]| {
            let ends = |v: f32| [(v - disc).floor() as i64 - 1, (v + disc).ceil() as i64 + 1];
            lamp.is_some_and(|lamp| x.is_finite() && lamp.any(ends(x), ends(y)))
        };
        (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                first[pixel]
                    || (visible[pixel * count] != Seen::NOTHING
                        && (seen.near(pixel, reach) || lamp_near(self.lamp_places[pixel])))
            })
            .collect()
    }
}
