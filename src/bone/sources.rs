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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::build::build_alone;
    use crate::bone::{Place, Region};
    use crate::mesh::tests::cuboid;

    /// A block painted from black in front to white at the back, with its left face as a part of its own: each region
    /// is where it should be and as porous as asked.
    #[test]
    fn parts_and_paint_of_the_surface_are_met() {
        let size = Vec3::new(0.02, 0.014, 0.016);
        let block = cuboid(Vec3::zeros(), size);
        let on_the_left = |t: usize| block.corners(t).iter().all(|x| x.x == 0.0);
        let shade = |x: &Vec3| [if x.y > 0.0 { 1.0_f32 } else { 0.0 }; 3];
        let painted = Painted {
            mesh: block.clone(),
            colour: block.positions.iter().map(shade).collect(),
            coloured: true,
            names: vec!["rest".into(), "left".into()],
            part: (0..12).map(|t| u32::from(on_the_left(t))).collect(),
        };
        let region = |name: &str, place, struts| Region {
            name: name.into(),
            place,
            period: 1.6e-3,
            struts,
            lost: 0.0,
        };
        let paint = Varying::Painted {
            black: 0.78,
            white: 0.92,
        };
        let settings = BoneSettings {
            regions: vec![
                region("left", Place::Part(1), Struts::Porosity(0.72)),
                region("painted", Place::Everywhere, Struts::Varying(paint)),
            ],
            nodes_per_spacing: 4.0,
            ..Default::default()
        };
        let sources = Sources {
            surface: Some((painted, MeshDistance::new(&block))),
            volume: None,
        };
        let middle = 0.5 * size;
        let at = |x: Real, y: Real| Vec3::new(x, y, middle.z);
        assert_eq!(sources.region_at(&settings, &at(0.001, middle.y)), 0);
        assert_eq!(sources.region_at(&settings, &at(0.019, middle.y)), 1);
        let asked = |x: &Vec3| sources.asked(&settings.regions[1].struts, x).unwrap();
        assert!((asked(&at(0.01, 1e-4)) - 0.78).abs() < 1e-9);
        assert!((asked(&at(0.01, size.y - 1e-4)) - 0.92).abs() < 1e-9);
        assert!((asked(&at(0.0199, middle.y)) - 0.85).abs() < 1e-9);

        let report = build_alone(&block, &settings, &sources, 0.5e-3, &[])
            .unwrap()
            .report;
        for (region, asked) in report.regions.iter().zip([0.72, 0.85]) {
            let told = region.asked_porosity.unwrap();
            assert!((told - asked).abs() < 0.02, "{region:?}");
            assert!((region.porosity - told).abs() < 0.01, "{region:?}");
        }
        assert!(report.regions[1].classes.len() > 1);
        for [asked, made] in &report.regions[1].classes {
            assert!((asked - made).abs() < 0.02, "{report:?}");
        }
        assert!(report.struts_connected > 0.99 && report.pores_connected > 0.99);
    }
}
