//! The barrel of a syringe made from formulas: open at the back, where a plunger goes in, and at its nozzle.

use crate::math::{Real, Vec3};
use crate::mesh::{LengthUnit, ObjStyle, TriMesh, UpAxis, write_obj_with};
use std::f64::consts::TAU;

/// Facets around: the inner radius is met within 0.06 %.
const SIDES: u32 = 128;

/// Size of a syringe. Its nozzle points down and ends at z = 0; the barrel begins above the cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SyringeSettings {
    /// Inner diameter of the barrel [m].
    pub barrel_diameter: Real,
    /// Length of the barrel [m].
    pub barrel_length: Real,
    /// Inner diameter of the nozzle [m].
    pub nozzle_diameter: Real,
    /// Length of the nozzle [m].
    pub nozzle_length: Real,
    /// Of the wall [m].
    pub thickness: Real,
}

impl Default for SyringeSettings {
    fn default() -> Self {
        Self {
            barrel_diameter: 0.01,
            barrel_length: 0.03,
            nozzle_diameter: 0.004,
            nozzle_length: 0.008,
            thickness: 0.002,
        }
    }
}

impl SyringeSettings {
    /// Height of the cone between nozzle and barrel [m]: 45 degrees steep.
    pub fn cone(&self) -> Real {
        0.5 * (self.barrel_diameter - self.nozzle_diameter)
    }

    /// Radius and height of the corners of the wall's section, anticlockwise with the radius to the right.
    fn section(&self) -> [(Real, Real); 8] {
        let (wide, narrow) = (0.5 * self.barrel_diameter, 0.5 * self.nozzle_diameter);
        let (t, low) = (self.thickness, self.nozzle_length);
        let high = low + self.cone();
        let top = high + self.barrel_length;
        // The outside of the cone lies t from its inside.
        let drop = t * (core::f64::consts::SQRT_2 - 1.0);
        [
            (narrow, 0.0),
            (narrow + t, 0.0),
            (narrow + t, low - drop),
            (wide + t, high - drop),
            (wide + t, top),
            (wide, top),
            (wide, high),
            (narrow, low),
        ]
    }
}

/// The barrel's surface [m], closed and facing outwards; why not, if the measures do not fit together.
pub fn make(settings: &SyringeSettings) -> Result<TriMesh, String> {
    if settings.nozzle_diameter >= settings.barrel_diameter {
        return Err("the nozzle is as wide as the barrel".to_owned());
    }
    if settings.nozzle_length <= settings.thickness {
        return Err("the nozzle is shorter than its wall is thick".to_owned());
    }
    let section = settings.section();
    let corners = section.len() as u32;
    let mut mesh = TriMesh::default();
    for side in 0..SIDES {
        let angle = TAU * Real::from(side) / Real::from(SIDES);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        for (r, z) in section {
            mesh.positions.push(Vec3::new(r * cos, r * sin, z));
        }
        let (here, there) = (side * corners, (side + 1) % SIDES * corners);
        for corner in 0..corners {
            let next = (corner + 1) % corners;
            let [a, b, c, d] = [here + corner, there + corner, there + next, here + next];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Ok(mesh)
}

/// Writes the barrel as an OBJ file in millimetres, z up, that says how it was made.
pub fn write(out: &mut impl std::io::Write, settings: &SyringeSettings) -> std::io::Result<()> {
    let mesh = make(settings).map_err(std::io::Error::other)?;
    let size = format!(
        "barrel {:.1} mm wide and {:.1} mm long inside, nozzle {:.1} mm wide, ends at z = 0",
        settings.barrel_diameter * 1e3,
        settings.barrel_length * 1e3,
        settings.nozzle_diameter * 1e3
    );
    let style = ObjStyle {
        groups: &[],
        unit: LengthUnit::Millimetre,
        up: UpAxis::Z,
        comments: &[
            "barrel of a syringe from formulas: osteoflow make syringe",
            &size,
        ],
    };
    write_obj_with(out, &style, &mesh, None, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    #[test]
    fn it_is_closed_and_has_the_volume_of_its_wall() {
        let settings = SyringeSettings::default();
        let found = inspect(&make(&settings).unwrap());
        assert!(found.is_closed() && found.components == 1, "{found:?}");
        // Pappus: area of the section times the way of its centroid, from the corners.
        let section = settings.section();
        let mut moment = 0.0;
        for (n, (r, z)) in section.iter().enumerate() {
            let (r2, z2) = section[(n + 1) % section.len()];
            moment += (r * r + r * r2 + r2 * r2) * (z2 - z) / 6.0;
        }
        let exact = TAU * moment;
        assert!(
            (found.signed_volume / exact - 1.0).abs() < 0.002,
            "{} {exact}",
            found.signed_volume
        );
    }

    #[test]
    fn the_asset_is_what_the_formulas_make() {
        let mut made = Vec::new();
        write(&mut made, &SyringeSettings::default()).unwrap();
        let stored = include_bytes!("../../assets/syringe.obj");
        assert!(
            made == stored,
            "run `osteoflow make syringe -o assets/syringe.obj`"
        );
    }
}
