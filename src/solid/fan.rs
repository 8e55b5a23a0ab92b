//! A mixing fan made from formulas: a hub and pitched blades.

use super::Shape;
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{LengthUnit, ObjStyle, TriMesh, UpAxis, surface_nets, write_obj_with};
use std::f64::consts::TAU;

/// Size of a fan. It turns about z, its lowest edge at z = 0; turned anticlockwise it lifts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FanSettings {
    /// From blade tip to blade tip [m].
    pub diameter: Real,
    /// Height of the blades [m].
    pub height: Real,
    /// Of the hub [m].
    pub hub_diameter: Real,
    /// Of a blade [m].
    pub thickness: Real,
    /// How many.
    pub blades: u32,
    /// Between the blades and the horizontal [rad].
    pub pitch: Real,
    /// Edge of the lattice that the surface is drawn on [m].
    pub resolution: Real,
}

impl Default for FanSettings {
    fn default() -> Self {
        Self {
            diameter: 0.03,
            height: 0.005,
            hub_diameter: 0.006,
            thickness: 0.002,
            blades: 4,
            pitch: TAU / 8.0,
            resolution: 0.0005,
        }
    }
}

/// The fan's surface [m], closed and facing outwards; why not, if the measures do not fit together.
pub fn make(settings: &FanSettings) -> Result<TriMesh, String> {
    let s = settings;
    let (sine, cosine) = (libm::sin(s.pitch), libm::cos(s.pitch));
    // A tilted plate is chord · sin + thickness · cos high.
    let chord = (s.height - s.thickness * cosine) / sine;
    if chord < s.thickness {
        return Err("the blades are too thick for their height".to_owned());
    }
    if s.hub_diameter >= s.diameter {
        return Err("the hub is wider than the fan".to_owned());
    }
    let radius = 0.5 * s.diameter;
    let hub = Shape::Cylinder {
        base: Vec3::zeros(),
        axis: Vec3::z(),
        length: s.height,
        radius: 0.5 * s.hub_diameter,
        hollow: false,
    };
    let half = 0.5 * Vec3::new(2.0 * radius, chord, s.thickness);
    let plate = Shape::Box {
        min: Vec3::new(0.0, -half.y, -half.z),
        max: Vec3::new(2.0 * half.x, half.y, half.z),
        hollow: false,
    };
    let turns: Vec<(Real, Real)> = (0..s.blades)
        .map(|n| TAU * Real::from(n) / Real::from(s.blades))
        .map(|angle| (libm::sin(angle), libm::cos(angle)))
        .collect();
    let distance = |x: &Vec3| {
        let blade = |(sin, cos): &(Real, Real)| {
            let along = cos * x.x + sin * x.y;
            let across = cos * x.y - sin * x.x;
            let up = x.z - 0.5 * s.height;
            // The chord leads forwards and down, so that what it meets slides up.
            let local = Vec3::new(
                along,
                cosine * across - sine * up,
                sine * across + cosine * up,
            );
            plate.distance(&local).0
        };
        let blades = turns.iter().map(blade).fold(Real::INFINITY, Real::min);
        let within = blades.max(x.x.hypot(x.y) - radius);
        within.min(hub.distance(x).0)
    };
    let bounds = Aabb {
        min: Vec3::new(-radius, -radius, 0.0),
        max: Vec3::new(radius, radius, s.height),
    };
    Ok(surface_nets(
        &bounds.grown(s.resolution),
        s.resolution,
        distance,
    ))
}

/// Writes the fan as an OBJ file in millimetres, z up, that says how it was made.
pub fn write(out: &mut impl std::io::Write, settings: &FanSettings) -> std::io::Result<()> {
    let mesh = make(settings).map_err(std::io::Error::other)?;
    let size = format!(
        "{} blades, {:.1} mm wide, {:.1} mm high; turns about z, lowest edge at z = 0",
        settings.blades,
        settings.diameter * 1e3,
        settings.height * 1e3
    );
    let style = ObjStyle {
        groups: &[],
        unit: LengthUnit::Millimetre,
        up: UpAxis::Z,
        comments: &["mixing fan from formulas: osteoflow make fan", &size],
    };
    write_obj_with(out, &style, &mesh, None, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    #[test]
    fn it_is_closed_and_as_large_as_asked() {
        let settings = FanSettings::default();
        let mesh = make(&settings).unwrap();
        let found = inspect(&mesh);
        assert!(found.is_closed() && found.components == 1, "{found:?}");
        let size = mesh.bounds().extent();
        for (made, asked) in [(size.x, 0.03), (size.y, 0.03), (size.z, 0.005)] {
            assert!((made - asked).abs() < 0.3e-3, "{size}");
        }
        // Hub and four plates, which overlap at the hub: bounded by both sums.
        let hub = 0.25 * core::f64::consts::PI * 6e-3_f64.powi(2) * 5e-3;
        let chord = 5e-3 * 2.0_f64.sqrt() - 2e-3;
        let outside = 4.0 * 12e-3 * chord * 2e-3;
        let volume = mesh.signed_volume();
        assert!((volume / (hub + outside) - 1.0).abs() < 0.05, "{volume}");
    }

    /// Going round anticlockwise, the front of a blade is its lower edge.
    #[test]
    fn anticlockwise_it_lifts() {
        let mesh = make(&FanSettings::default()).unwrap();
        let on_blade = |v: &&Vec3| v.x > 8e-3 && v.y.abs() < 4e-3;
        let (mut low, mut high) = ((1.0, 0.0), (0.0, 0.0));
        for v in mesh.positions.iter().filter(on_blade) {
            if v.z < low.0 {
                low = (v.z, v.y);
            }
            if v.z > high.0 {
                high = (v.z, v.y);
            }
        }
        assert!(low.1 > 1e-3 && high.1 < -1e-3, "{low:?} {high:?}");
    }

    #[test]
    fn the_asset_is_what_the_formulas_make() {
        let mut made = Vec::new();
        write(&mut made, &FanSettings::default()).unwrap();
        let stored = include_bytes!("../../assets/fan.obj");
        assert!(made == stored, "run `osteoflow make fan -o assets/fan.obj`");
    }

    #[test]
    fn measures_that_do_not_fit_are_refused() {
        let thick = FanSettings {
            thickness: 0.005,
            ..FanSettings::default()
        };
        let hub = FanSettings {
            hub_diameter: 0.03,
            ..FanSettings::default()
        };
        assert!(make(&thick).is_err() && make(&hub).is_err());
    }
}
