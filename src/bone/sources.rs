//! What is known of a bone from outside beside its mesh: paint and parts of its surface, a density volume.

use super::settings::{BoneSettings, Struts, Varying};
use crate::grid::vdb::VdbGrid;
use crate::math::{Real, Vec3};
use crate::mesh::{MeshDistance, Painted};
use nalgebra::{Isometry3, Point3};

/// Where regions and porosities are looked up.
#[derive(Default)]
pub struct Sources {
    /// The bone's mesh as painted and divided, in the frame of the recipe.
    pub surface: Option<(Painted, MeshDistance)>,
    /// A volume.
    pub volume: Option<Volume>,
}

/// A volume that tells how porous the bone is.
pub struct Volume {
    /// Its values.
    pub grid: VdbGrid,
    /// Metres in a unit of the file.
    pub metres: Real,
    /// From the frame of the recipe to the volume's axes [m].
    pub back: Isometry3<Real>,
    /// Whether it holds the share of bone rather than of pores.
    pub of_bone: bool,
}

impl Volume {
    /// Share of the vertices of `mesh` that lie in the box of its active voxels [1].
    pub fn covers(&self, mesh: &crate::mesh::TriMesh) -> Real {
        let bounds = self.grid.world_bounds();
        let inside = mesh
            .positions
            .iter()
            .filter(|x| bounds.contains(&self.there(x)));
        inside.count() as Real / mesh.positions.len().max(1) as Real
    }

    fn there(&self, x: &Vec3) -> Vec3 {
        self.back.transform_point(&Point3::from(*x)).coords / self.metres
    }

    /// The porosity at `x` [1].
    fn porosity(&self, x: &Vec3) -> Real {
        let value = self.grid.value(&self.there(x));
        if self.of_bone { 1.0 - value } else { value }
    }
}

impl Sources {
    /// Index of the region that decides at `x`.
    pub fn region_at(&self, settings: &BoneSettings, x: &Vec3) -> usize {
        let part = || {
            let (painted, distance) = self.surface.as_ref()?;
            Some(painted.part[distance.closest_triangle(x)?])
        };
        let regions = &settings.regions;
        let found = regions
            .iter()
            .position(|region| region.place.holds(x, part));
        found.unwrap_or(regions.len() - 1)
    }

    /// The porosity asked for at `x` in a region, if one is [1].
    pub fn asked(&self, struts: &Struts, x: &Vec3) -> Option<Real> {
        match struts {
            Struts::Diameter(_) => None,
            Struts::Porosity(porosity) => Some(*porosity),
            Struts::Varying(varying) => Some(self.varying(varying, x)),
        }
    }

    fn varying(&self, varying: &Varying, x: &Vec3) -> Real {
        match varying {
            Varying::Gradient { from, to, values } => {
                let way = to - from;
                let t = (x - from).dot(&way) / way.norm_squared().max(1e-30);
                values[0] + (values[1] - values[0]) * t.clamp(0.0, 1.0)
            }
            Varying::Painted { black, white } => black + (white - black) * self.brightness(x),
            Varying::Volume { least, most } => {
                let found = self.volume.as_ref().map_or(*most, |v| v.porosity(x));
                // Outside the volume and where it holds no number, nothing is known: no bone.
                if found.is_nan() {
                    *most
                } else {
                    found.clamp(*least, *most)
                }
            }
        }
    }

    fn brightness(&self, x: &Vec3) -> Real {
        let Some((painted, distance)) = &self.surface else {
            return 1.0;
        };
        let triangle = distance.closest_triangle(x);
        let (_, point) = distance.closest(x);
        triangle.map_or(1.0, |t| painted.brightness(t, &point))
    }
}
