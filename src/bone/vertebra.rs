//! A lumbar vertebra made from formulas: watertight, of a patient's size, in the anatomical frame.
//!
//! x to the left, y to the back, z up; the origin is the centre of the body. A signed distance field is composed of
//! the body (a kidney-shaped column with a waist, raised rims and hollow endplates) and of limbs (pedicles, laminae,
//! processes), joined by smooth unions; the vertebral canal is taken out of the limbs. Lengths in the tables
//! are millimetres of an L3 whose body is 45 wide, 34 deep and 28 high; other sizes scale each axis.

use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{LengthUnit, ObjStyle, TriMesh, UpAxis, surface_nets, write_obj_with};
use serde::{Deserialize, Serialize};

/// Size of the vertebra to make.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VertebraSettings {
    /// Width of the body, left to right [m].
    pub body_width: Real,
    /// Depth of the body, front to back [m].
    pub body_depth: Real,
    /// Height of the body at its rims [m].
    pub body_height: Real,
    /// Edge of the lattice that the surface is drawn on [m].
    pub resolution: Real,
    /// Share of its height that the front of the body has lost, as in a wedge fracture [1].
    pub wedge: Real,
    /// Share of its height that the middle of the body has lost, as where an endplate has sunk in [1].
    pub collapse: Real,
}

/// A lumbar vertebra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The first.
    L1,
    /// The second.
    L2,
    /// The third, which the tables are of.
    L3,
    /// The fourth.
    L4,
    /// The fifth.
    L5,
}

impl Level {
    /// Mean size of an adult's body: width, depth, height [m], after [Panjabi92], in proportion to the third.
    pub fn body(self) -> [Real; 3] {
        let millimetres = match self {
            Self::L1 => [41.5, 34.0, 26.5],
            Self::L2 => [43.0, 34.0, 27.5],
            Self::L3 => [45.0, 34.0, 28.0],
            Self::L4 => [47.0, 34.5, 28.0],
            Self::L5 => [49.5, 34.5, 28.0],
        };
        millimetres.map(|length: Real| length * 1e-3)
    }
}

impl Default for VertebraSettings {
    fn default() -> Self {
        Self {
            body_width: 0.045,
            body_depth: 0.034,
            body_height: 0.028,
            resolution: 0.0014,
            wedge: 0.0,
            collapse: 0.0,
        }
    }
}

impl VertebraSettings {
    /// Metres per table unit on each axis.
    fn scale(&self) -> Vec3 {
        Vec3::new(
            self.body_width / (2.0 * HALF_WIDTH),
            self.body_depth / (2.0 * HALF_DEPTH),
            self.body_height / (2.0 * HALF_HEIGHT),
        )
    }
}

/// The vertebra's surface [m], closed and facing outwards.
pub fn make(settings: &VertebraSettings) -> TriMesh {
    let scale = settings.scale();
    let bounds = Aabb {
        min: Vec3::new(-50.0, -22.0, -40.0).component_mul(&scale),
        max: Vec3::new(50.0, 75.0, 30.0).component_mul(&scale),
    };
    surface_nets(&bounds, settings.resolution, |x| {
        let p = sound(&x.component_div(&scale), settings);
        distance(&p) * scale.min()
    })
}

/// Writes the vertebra as an OBJ file in millimetres, z up, that says how it was made.
pub fn write(out: &mut impl std::io::Write, settings: &VertebraSettings) -> std::io::Result<()> {
    let size = format!(
        "body {:.1} mm wide, {:.1} mm deep, {:.1} mm high; x to the left, y to the back, origin in the body's centre",
        settings.body_width * 1e3,
        settings.body_depth * 1e3,
        settings.body_height * 1e3
    );
    let mut mesh = make(settings);
    let arch = parted(&mut mesh, settings);
    let style = ObjStyle {
        unit: LengthUnit::Millimetre,
        up: UpAxis::Z,
        comments: &[
            "lumbar vertebra from formulas: osteoflow make vertebra",
            &size,
        ],
        groups: &[("body", 0), ("arch", arch)],
    };
    write_obj_with(out, &style, &mesh, None, None)
}

/// Puts the triangles of the arch, pedicles and processes behind those of the body; the first of them.
fn parted(mesh: &mut TriMesh, settings: &VertebraSettings) -> usize {
    let scale = settings.scale();
    let of_arch = |triangle: &[u32; 3]| {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        let p = sound(&middle.component_div(&scale), settings);
        arch(&p) < body(&p)
    };
    let (behind, front): (Vec<_>, Vec<_>) = mesh.triangles.iter().copied().partition(of_arch);
    let first = front.len();
    mesh.triangles = [front, behind].concat();
    first
}

const HALF_WIDTH: Real = 22.5;
const HALF_DEPTH: Real = 17.0;
const HALF_HEIGHT: Real = 14.0;

/// A bar of elliptic section that may thicken or taper from one end to the other.
struct Limb {
    from: [Real; 3],
    from_radii: [Real; 3],
    to: [Real; 3],
    to_radii: [Real; 3],
}

const fn limb(from: [Real; 3], from_radii: [Real; 3], to: [Real; 3], to_radii: [Real; 3]) -> Limb {
    Limb {
        from,
        from_radii,
        to,
        to_radii,
    }
}

/// Limbs of the left side; the right side mirrors them.
const PAIRED: [Limb; 9] = [
    // Pedicle.
    limb(
        [14.0, 8.0, 5.5],
        [5.5, 5.0, 7.5],
        [15.5, 21.0, 4.5],
        [4.6, 5.0, 7.0],
    ),
    // Superior articular process, whose joint is taken out of it, and the mamillary process on its edge.
    limb(
        [15.5, 22.0, 5.5],
        [5.2, 5.5, 6.5],
        [16.6, 28.0, 14.0],
        [6.4, 7.4, 7.0],
    ),
    limb(
        [19.5, 29.5, 10.5],
        [3.6, 5.0, 5.5],
        [20.5, 33.5, 9.5],
        [3.0, 3.2, 4.5],
    ),
    // Isthmus between the articular processes.
    limb(
        [15.5, 24.0, 3.0],
        [5.0, 5.0, 6.5],
        [12.5, 31.0, -8.0],
        [5.0, 4.4, 6.5],
    ),
    // Inferior articular process, flaring towards its joint.
    limb(
        [12.0, 31.0, -9.0],
        [5.0, 4.2, 6.5],
        [12.8, 32.5, -23.5],
        [4.6, 5.2, 5.5],
    ),
    // Lamina: upper and lower part.
    limb(
        [12.5, 28.5, -3.5],
        [3.8, 3.6, 8.0],
        [2.0, 35.5, -6.0],
        [3.4, 3.6, 7.5],
    ),
    limb(
        [11.0, 31.0, -11.0],
        [4.0, 3.6, 6.5],
        [2.0, 36.5, -10.5],
        [3.4, 3.6, 6.5],
    ),
    // Transverse process: a stout root, then a blade that flattens.
    limb(
        [16.0, 22.5, 4.5],
        [5.0, 5.0, 6.5],
        [26.0, 26.5, 3.5],
        [3.5, 3.4, 5.0],
    ),
    limb(
        [26.0, 26.5, 3.5],
        [3.5, 3.2, 4.8],
        [41.0, 29.5, 5.0],
        [2.6, 2.4, 4.4],
    ),
];

/// Limbs on the midline: the spinous process, a blade with a thick free edge.
const MEDIAN: [Limb; 4] = [
    limb(
        [0.0, 35.0, -4.0],
        [3.6, 4.5, 5.5],
        [0.0, 57.0, -7.0],
        [2.5, 5.0, 5.0],
    ),
    limb(
        [0.0, 38.0, -9.0],
        [3.0, 5.0, 6.5],
        [0.0, 57.0, -13.0],
        [2.4, 5.0, 6.0],
    ),
    limb(
        [0.0, 40.0, -12.0],
        [2.6, 5.0, 6.0],
        [0.0, 56.0, -18.0],
        [2.5, 5.0, 5.0],
    ),
    limb(
        [0.0, 60.0, -8.0],
        [3.0, 3.2, 5.0],
        [0.0, 58.5, -20.0],
        [3.6, 3.4, 4.5],
    ),
];

/// Where the left inferior process of the next vertebra stands in its joint, with room for the cartilage: the superior
/// articular process is the cup in front of and beside it.
const JOINT: Limb = limb(
    [12.2, 34.0, 13.0],
    [5.4, 6.2, 6.5],
    [11.6, 33.0, 28.0],
    [5.4, 6.2, 6.5],
);

/// How far apart [mm] two parts begin to flow into each other.
const LIMB_BLEND: Real = 2.6;
const BODY_BLEND: Real = 5.0;

/// Where a point of the fractured bone lies in the sound one: heights over the lower endplate are stretched back.
fn sound(p: &Vec3, settings: &VertebraSettings) -> Vec3 {
    if settings.wedge == 0.0 && settings.collapse == 0.0 {
        return *p;
    }
    // 0 at the back wall and behind it, 1 at the front.
    let forward = ((HALF_DEPTH - p.y) / (2.0 * HALF_DEPTH)).clamp(0.0, 1.0);
    let (u, v) = (p.x / HALF_WIDTH, p.y / HALF_DEPTH);
    let middle = (1.0 - (u * u + v * v) / 0.8).max(0.0);
    let left = 1.0 - settings.wedge * forward - settings.collapse * middle * middle;
    Vec3::new(p.x, p.y, (p.z + HALF_HEIGHT) / left.max(0.2) - HALF_HEIGHT)
}

/// About the distance to the surface [mm], negative inside; exact only at the surface.
fn distance(p: &Vec3) -> Real {
    smooth_min(arch(p), body(p), BODY_BLEND)
}

/// Distance to pedicles, laminae and processes.
fn arch(p: &Vec3) -> Real {
    let left = Vec3::new(p.x.abs(), p.y, p.z);
    let limbs = PAIRED.iter().map(|limb| limb.distance(&left));
    let spine = MEDIAN.iter().map(|limb| limb.distance(p));
    let arch = limbs
        .chain(spine)
        .fold(40.0, |d, limb| smooth_min(d, limb, LIMB_BLEND));
    let arch = -smooth_min(-arch, JOINT.distance(&left), 1.5);
    -smooth_min(-arch, canal(p), 2.0)
}

impl Limb {
    fn distance(&self, p: &Vec3) -> Real {
        let (from, to) = (Vec3::from(self.from), Vec3::from(self.to));
        let axis = to - from;
        let t = ((p - from).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
        let radii = Vec3::from(self.from_radii).lerp(&Vec3::from(self.to_radii), t);
        ellipsoid(&(p - from - axis * t), &radii)
    }
}

/// First-order distance to an ellipsoid about the origin.
fn ellipsoid(p: &Vec3, radii: &Vec3) -> Real {
    let q = p.component_div(radii);
    let slope = q.component_div(radii).norm();
    let level = q.norm();
    if slope > 1e-9 {
        level * (level - 1.0) / slope
    } else {
        -radii.min()
    }
}

/// Distance to the opening for the spinal cord: an oval in front, a gable behind.
fn canal(p: &Vec3) -> Real {
    let (x, y) = (p.x.abs(), p.y - 21.0);
    let oval = ellipsoid(&Vec3::new(x, y, 0.0), &Vec3::new(11.5, 7.8, 1e3));
    let gable = (x * 0.62 + y * 0.78) - 8.2;
    -smooth_min(-oval, -gable, 3.0)
}

/// Distance to the vertebral body.
fn body(p: &Vec3) -> Real {
    let height = (p.z / HALF_HEIGHT).clamp(-1.0, 1.0);
    // Waist: narrowest at mid-height, flaring into the rims, and deeper at the sides than in front.
    let waist = (1.0 - height * height) * (1.0 - 0.3 * height * height);
    let (a, b) = (
        HALF_WIDTH * (1.0 - 0.20 * waist),
        HALF_DEPTH * (1.0 - 0.15 * waist),
    );
    // The back wall is hollow towards the canal: near the midline it lies further forward.
    let hollow = 3.2 * libm::exp(-(p.x / 9.0) * (p.x / 9.0));
    let y = p.y
        + if p.y > 0.0 {
            hollow * (p.y / b).min(1.2)
        } else {
            0.0
        };
    // Superellipse: fuller than an ellipse, as the apophyseal ring is.
    let level = libm::pow(
        libm::pow(p.x.abs() / a, 2.2) + libm::pow(y.abs() / b, 2.2),
        1.0 / 2.2,
    );
    let side = (level - 1.0) * 0.5 * (a + b) * 0.95 - 1.0;
    // Endplates: hollow in the middle, deeper below than above.
    let dish = (1.0 - (level / 0.88) * (level / 0.88)).max(0.0);
    let depth = if p.z > 0.0 { 1.9 } else { 2.4 };
    let lid = p.z.abs() - HALF_HEIGHT - 0.6 + depth * dish * (1.6 - 0.6 * dish);
    -smooth_min(-side, -lid, 6.0)
}

/// Minimum whose crease is rounded over a width of about `k`.
fn smooth_min(a: Real, b: Real, k: Real) -> Real {
    let overlap = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - overlap * overlap * k * 0.25
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::inspect;

    #[test]
    fn it_is_one_closed_piece_with_one_canal_and_the_asked_body() {
        let mesh = make(&VertebraSettings::default());
        let found = inspect(&mesh);
        assert!(found.is_closed(), "{found:?}");
        assert_eq!(found.components, 1);
        assert!((10_000..=22_000).contains(&found.triangles), "{found:?}");
        // Euler: a ring (genus 1) around the vertebral canal, and no other hole.
        let euler = mesh.positions.len() as i64 - found.triangles as i64 / 2;
        assert_eq!(euler, 0);
        let section = |pick: fn(&Vec3) -> Real, keep: &dyn Fn(&Vec3) -> bool| {
            let kept = mesh.positions.iter().filter(|p| keep(p)).map(pick);
            kept.fold((Real::MAX, Real::MIN), |r, v| (r.0.min(v), r.1.max(v)))
        };
        let width = section(|p| p.x, &|p| p.y < 5e-3);
        assert!((width.1 - width.0 - 0.045).abs() < 1.5e-3, "{width:?}");
        let height = section(|p| p.z, &|p| p.y < 5e-3);
        assert!((height.1 - height.0 - 0.028).abs() < 1.5e-3, "{height:?}");
        // Two real L3 have waists of 0.80 and 0.86 of the width at the rims.
        let waist = section(|p| p.x, &|p| p.y < 5e-3 && p.z.abs() < 1e-3);
        let waist = (waist.1 - waist.0) / (width.1 - width.0);
        assert!((0.82..0.88).contains(&waist), "{waist}");
        let front = section(|p| p.y, &|_| true).0;
        assert!((front + 0.017).abs() < 1e-3, "{front}");
    }

    #[test]
    fn a_wedge_loses_height_in_front_and_a_collapse_in_the_middle() {
        let heights = |settings: &VertebraSettings| {
            let mesh = make(settings);
            let found = inspect(&mesh);
            assert!(found.is_closed() && found.components == 1, "{found:?}");
            let top = |keep: &dyn Fn(&Vec3) -> bool| {
                let kept = mesh.positions.iter().filter(|p| keep(p)).map(|p| p.z);
                kept.fold(Real::MIN, Real::max) + 0.014
            };
            [
                top(&|p| p.x.abs() < 3e-3 && (p.y + 0.0145).abs() < 1.5e-3),
                top(&|p| p.x.abs() < 3e-3 && (p.y + 0.001).abs() < 1.5e-3),
            ]
        };
        let sound = heights(&VertebraSettings::default());
        let wedged = heights(&VertebraSettings {
            wedge: 0.4,
            ..Default::default()
        });
        let sunk = heights(&VertebraSettings {
            collapse: 0.3,
            ..Default::default()
        });
        // At y = −14.5 mm of −17 to 17 mm a wedge has 0.93 of its effect.
        assert!(
            (wedged[0] / sound[0] - (1.0 - 0.4 * 0.93)).abs() < 0.04,
            "{wedged:?} {sound:?}"
        );
        assert!(
            (sunk[1] / sound[1] - 0.7).abs() < 0.04,
            "{sunk:?} {sound:?}"
        );
        assert!(
            (sunk[0] / sound[0] - 1.0).abs() < 0.06,
            "{sunk:?} {sound:?}"
        );
    }

    #[test]
    fn the_asset_is_what_the_formulas_make() {
        let mut made = Vec::new();
        write(&mut made, &VertebraSettings::default()).unwrap();
        let stored = include_bytes!("../../assets/vertebra.obj");
        assert!(
            made == stored,
            "run `osteoflow make vertebra -o assets/vertebra.obj`"
        );
    }
}
