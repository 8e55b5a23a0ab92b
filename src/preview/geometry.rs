//! The scene as the eye has it: everything in view space, every primitive with a number.

use super::{
    Cap, Colour, Colours, Material, MeshLayer, Sphere,
    camera::View,
    primitive::{Ball, Primitive, Triangle, Window},
};
use crate::math::{Real, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// The number of no primitive.
pub(super) const NOTHING: u32 = u32::MAX;
/// Gloss of a cut face that shows what lies behind it.
const WET: Real = 0.3;

/// A scene in view space. Numbers: triangles mesh by mesh, then spheres; caps of cut meshes count down from the end.
pub(super) struct Geometry<'a> {
    pub view: View,
    pub meshes: Vec<Arc<PlacedMesh<'a>>>,
    pub spheres: &'a [Sphere],
    /// Number of the first sphere.
    pub first_sphere: u32,
}

/// A mesh in view space.
pub(super) struct PlacedMesh<'a> {
    pub layer: MeshLayer<'a>,
    /// Number of its first triangle.
    pub first: u32,
    /// Number of its cut face.
    pub cap: u32,
    pub cut: Option<Plane>,
    positions: Vec<Vec3>,
}

/// Takes away what has normal·p > offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub normal: Vec3,
    pub offset: Real,
}

impl Plane {
    /// Whether a point at `depth` on `ray` is taken away.
    pub fn removes(&self, ray: &Vec3, depth: Real) -> bool {
        self.normal.dot(ray) * depth > self.offset
    }

    /// Depth at which `ray` enters the side that is kept; none if the eye is on that side.
    pub fn entry(&self, ray: &Vec3) -> Option<Real> {
        (self.offset < 0.0).then(|| self.offset / self.normal.dot(ray))
    }
}

/// What there is at a sample.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Position in view space [m].
    pub position: Vec3,
    /// Unit length, in view space, on the side of the eye.
    pub normal: Vec3,
    /// Linear RGB.
    pub colour: Colour,
    pub material: Material,
}

impl<'a> Geometry<'a> {
    pub fn new(meshes: &[MeshLayer<'a>], spheres: &'a [Sphere], view: View) -> Self {
        let nothing = Self {
            view,
            meshes: Vec::new(),
            spheres: &[],
            first_sphere: 0,
        };
        nothing.with(meshes, spheres)
    }

    /// With further meshes, and with `spheres` for those that there are.
    pub fn with<'b>(&self, further: &[MeshLayer<'b>], spheres: &'b [Sphere]) -> Geometry<'b>
    where
        'a: 'b,
    {
        let view = self.view.clone();
        let mut meshes: Vec<Arc<PlacedMesh<'b>>> = self.meshes.clone();
        let mut first = self.first_sphere;
        for layer in further {
            meshes.push(Arc::new(PlacedMesh {
                layer: *layer,
                first,
                cap: NOTHING - 1 - meshes.len() as u32,
                cut: layer.cut.and_then(|cut| {
                    let normal = view.axes * cut.normal.try_normalize(1e-300)?;
                    let offset = normal.dot(&view.place(&cut.point));
                    Some(Plane { normal, offset })
                }),
                positions: layer.positions.par_iter().map(|p| view.place(p)).collect(),
            }));
            first += layer.triangles.len() as u32;
        }
        Geometry {
            view,
            meshes,
            spheres,
            first_sphere: first,
        }
    }

    /// The sphere `i`, if it can be drawn.
    pub fn ball(&self, i: usize) -> Option<Ball<'_>> {
        let sphere = &self.spheres[i];
        Ball::new(self.view.place(&sphere.centre), sphere.radius, &self.view)
    }

    /// The pixels that each sphere may touch.
    pub fn ball_windows(&self) -> Vec<Option<Window>> {
        let window = |i| self.ball(i)?.window();
        (0..self.spheres.len())
            .into_par_iter()
            .map(window)
            .collect()
    }

    /// What a sample at (x, y) sees of the primitive `number`.
    pub fn surface(&self, number: u32, x: Real, y: Real) -> Option<Surface> {
        let ray = self.view.ray(x, y);
        if number == NOTHING {
            None
        } else if let Some(mesh) = self.meshes.get((NOTHING - 1 - number) as usize) {
            let plane = mesh.cut?;
            let position = ray * plane.entry(&ray)?;
            let (colour, slope, gloss) = match mesh.layer.cut?.cap {
                Cap::Uniform(colour) => (colour, Vec3::zeros(), 0.0),
                Cap::Chart(chart) => {
                    let place = self.view.world(&position);
                    (chart.at(&place), chart.slope(&place), WET)
                }
            };
            Some(Surface {
                position,
                normal: (plane.normal - self.view.axes * slope).normalize(),
                colour,
                material: Material::Opaque { gloss },
            })
        } else if number >= self.first_sphere {
            let i = (number - self.first_sphere) as usize;
            let ball = self.ball(i)?;
            // The mean of samples on the outline may lie a little outside.
            let depth = ball.depth(x, y).unwrap_or(ball.centre.z);
            let position = ray * depth;
            Some(Surface {
                position,
                normal: (position - ball.centre).normalize(),
                colour: self.spheres[i].colour,
                material: Material::Opaque { gloss: 0.5 },
            })
        } else {
            let after = self.meshes.partition_point(|mesh| mesh.first <= number);
            let mesh = &self.meshes[after - 1];
            mesh.surface(number - mesh.first, &ray, x, y, &self.view)
        }
    }
}

impl PlacedMesh<'_> {
    /// Corners of a triangle in view space.
    pub fn corners(&self, triangle: u32) -> Option<[Vec3; 3]> {
        let [a, b, c] = self.layer.triangles[triangle as usize].map(|v| v as usize);
        let at = |v: usize| self.positions.get(v).copied();
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// The pixels that each triangle may touch; none for those that the cut takes away.
    pub fn windows(&self, view: &View) -> Vec<Option<Window>> {
        let window = |i| {
            let corners = self.corners(i as u32)?;
            let removed = |plane: Plane| corners.iter().all(|c| plane.normal.dot(c) > plane.offset);
            if self.cut.is_some_and(removed) {
                return None;
            }
            Triangle::window(&corners, view)
        };
        let count = self.layer.triangles.len();
        (0..count).into_par_iter().map(window).collect()
    }

    fn surface(&self, triangle: u32, ray: &Vec3, x: Real, y: Real, view: &View) -> Option<Surface> {
        let corners = self.corners(triangle)?;
        let shape = Triangle::new(&corners, view)?;
        let weights = shape.weights(x, y);
        let vertices = self.layer.triangles[triangle as usize].map(|v| v as usize);
        let blend = |values: &[Vec3]| {
            let at = |k: usize| values.get(vertices[k]).copied().unwrap_or_default() * weights[k];
            at(0) + at(1) + at(2)
        };

        let flat = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        // Crossing in left-handed view space turns the normal inside out.
        let outward = self
            .layer
            .normals
            .and_then(|normals| (view.axes * blend(normals)).try_normalize(1e-9))
            .or_else(|| (-flat).try_normalize(0.0))?;
        let depth =
            weights[0] * corners[0].z + weights[1] * corners[1].z + weights[2] * corners[2].z;
        Some(Surface {
            position: ray * depth,
            normal: if shape.front { outward } else { -outward },
            colour: match self.layer.colours {
                Colours::Uniform(colour) => colour,
                Colours::Vertex(colours) => blend(colours),
            },
            material: self.layer.material,
        })
    }
}
