//! Camera, rasteriser, shading: pictures without a GPU.
//!
//! A picture is made in the order of [`Backdrop::draw`]: which surface every sample sees, how much sky and lamp
//! reaches it, then light, glass and lettering. Nothing depends on the number of threads. In a sequence of pictures what
//! stands still is drawn once.

mod backdrop;
mod camera;
mod changes;
mod chart;
pub mod colour;
mod compare;
mod exposure;
mod geometry;
mod layers;
mod occlusion;
mod overlay;
mod panes;
mod primitive;
mod raster;
mod settings;
mod shade;
mod shadow;
mod sheet;

pub use backdrop::Backdrop;
pub use camera::Camera;
pub use chart::Chart;
pub use colour::Colour;
pub use compare::{Comparison, compare, side_by_side};
pub use overlay::{Legend, Lettering};
pub use settings::{Background, PictureSettings};
pub use sheet::{FELL_OVER, LEAKED, Row, WELL, animation, contact_sheet, shrunk};

use crate::math::{Real, Vec3};
use image::RgbImage;

/// What there is to see, and from where: at most 2³¹ triangles and spheres in all.
#[derive(Clone, Debug, Default)]
pub struct Scene<'a> {
    /// Surfaces, in any order.
    pub meshes: Vec<MeshLayer<'a>>,
    /// Balls, drawn exactly.
    pub spheres: &'a [Sphere],
    /// The eye.
    pub camera: Camera,
    /// What is written over it.
    pub lettering: Lettering,
}

/// One surface. Triangles that are degenerate, not finite or refer to missing vertices are left out.
#[derive(Clone, Copy, Debug)]
pub struct MeshLayer<'a> {
    /// Vertex positions [m].
    pub positions: &'a [Vec3],
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Outward directions at the vertices; without them every triangle is flat.
    pub normals: Option<&'a [Vec3]>,
    /// Colour of the surface.
    pub colours: Colours<'a>,
    /// How it takes light.
    pub material: Material,
    /// Where it is cut open.
    pub cut: Option<Cut<'a>>,
}

/// Colour of a surface, linear RGB.
#[derive(Clone, Copy, Debug)]
pub enum Colours<'a> {
    /// The same everywhere.
    Uniform(Colour),
    /// One a vertex.
    Vertex(&'a [Colour]),
}

/// How a surface takes light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// Hides what is behind it.
    Opaque {
        /// Strength of its highlights [1]: 0 chalk, 1 wet.
        gloss: Real,
    },
    /// Lets what is behind it shine through; only faces turned to the eye are drawn.
    Glass {
        /// Opacity where it faces the eye [1].
        facing: Real,
        /// Opacity where it is seen edge-on [1].
        edge: Real,
    },
}

impl Material {
    /// Bone: matt.
    pub const BONE: Self = Self::Opaque { gloss: 0.2 };
    /// Cement: wet.
    pub const CEMENT: Self = Self::Opaque { gloss: 0.7 };
    /// Bone as a pane of glass, of which little more than the outline is left.
    pub const GLASS_BONE: Self = Self::Glass {
        facing: 0.07,
        edge: 0.85,
    };
}

/// A plane that takes away one side of a surface. Opaque solids are capped where they are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut<'a> {
    /// A point of the plane [m].
    pub point: Vec3,
    /// Points to the side that is taken away.
    pub normal: Vec3,
    /// Colour of the cut face.
    pub cap: Cap<'a>,
}

/// Colour of a cut face, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cap<'a> {
    /// The same everywhere.
    Uniform(Colour),
    /// As a map of the plane has it.
    Chart(&'a Chart),
}

/// A ball, for example a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre [m].
    pub centre: Vec3,
    /// Radius [m].
    pub radius: Real,
    /// Colour, linear RGB.
    pub colour: Colour,
}

/// Draws `scene`: the same bytes for the same input, on any number of threads.
pub fn render(scene: &Scene, settings: &PictureSettings) -> RgbImage {
    if settings.width == 0 || settings.height == 0 {
        return RgbImage::new(settings.width, settings.height);
    }
    let lit = shadow::bounds(&scene.meshes, scene.spheres);
    Backdrop::new(&[], &scene.camera, &lit, settings).draw(
        &scene.meshes,
        scene.spheres,
        &scene.lettering,
    )
}

#[cfg(test)]
mod tests;
