//! A thorough look at a mesh from outside: what is wrong, how much of it, where, and what comes of it.

use super::edges::Edges;
use super::{LengthUnit, MeshNote, TriMesh, UpAxis, crossing, inspect, repaired};
use crate::math::{Real, Vec3};
use serde::Serialize;
use std::collections::HashSet;

/// What a look at a mesh finds.
#[derive(Clone, Debug, Serialize)]
pub struct Survey {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Pieces that share no edge.
    pub pieces: usize,
    /// Extent along x, y, z (z up) [m].
    pub size_m: Vec3,
    /// Area [m²].
    pub area_m2: Real,
    /// Signed volume as stored; means little if the mesh is open [m³].
    pub volume_m3: Real,
    /// How many triangles have each fault, worst first, and where the first of them are.
    pub faults: Vec<Finding>,
    /// What [`repaired`] does about it.
    pub repairs: Vec<MeshNote>,
    /// The same, for people.
    pub repairs_told: Vec<String>,
    /// Volume after repairs, if it has one [m³].
    pub repaired_volume_m3: Option<Real>,
    /// Why there is none.
    pub unusable: Option<String>,
    /// What may have been meant.
    pub suggestions: Vec<String>,
}

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// At the rim of a hole.
    Open,
    /// At an edge of three or more triangles.
    NonManifold,
    /// Passes through another triangle.
    Crossing,
    /// Faces against a neighbour.
    Turned,
    /// Over the same vertices as another.
    Copy,
    /// Without area.
    Degenerate,
    /// Forty times as long as high, or more.
    Sliver,
}

impl Fault {
    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "at the rim of a hole",
            Self::NonManifold => "at an edge of three or more triangles",
            Self::Crossing => "pass through others",
            Self::Turned => "face against a neighbour",
            Self::Copy => "copies of others",
            Self::Degenerate => "without area",
            Self::Sliver => "slivers",
        }
    }

    /// Its colour in [`Survey`]'s picture, sRGB.
    fn colour(self) -> [f32; 3] {
        match self {
            Self::Open => [0.9, 0.1, 0.1],
            Self::NonManifold => [1.0, 0.5, 0.0],
            Self::Crossing => [0.8, 0.1, 0.8],
            Self::Turned => [0.1, 0.3, 0.95],
            Self::Copy => [0.1, 0.7, 0.7],
            Self::Degenerate => [1.0, 0.9, 0.1],
            Self::Sliver => [0.6, 0.8, 0.2],
        }
    }
}

/// How often a fault occurs.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Which.
    pub fault: Fault,
    /// Triangles that have it.
    pub triangles: usize,
    /// Middles of the first of them [m].
    pub first_m: Vec<Vec3>,
}

/// Colour of triangles without fault.
const SOUND: [f32; 3] = [0.75, 0.75, 0.72];
/// So many places of a fault are told.
const SHOWN: usize = 3;
/// Height over length of a triangle below which it is a sliver.
const SLIVER: Real = 1.0 / 40.0;
/// Bones that a needle goes into measure between these [m].
const USUAL: [Real; 2] = [0.02, 0.15];

/// Looks at `mesh`, which was read with `unit` and `up`; also gives the fault of each triangle.
pub fn survey(mesh: &TriMesh, unit: LengthUnit, up: UpAxis) -> (Survey, Vec<Option<Fault>>) {
    let found = inspect(mesh);
    let faults = faults(mesh);
    let mut worst: Vec<Option<Fault>> = vec![None; mesh.triangles.len()];
    let mut findings: Vec<Finding> = Vec::new();
    for (fault, triangles) in faults {
        for &t in triangles.iter().rev() {
            worst[t].get_or_insert(fault);
        }
        let middle = |t: &usize| mesh.corners(*t).iter().sum::<Vec3>() / 3.0;
        if !triangles.is_empty() {
            findings.push(Finding {
                fault,
                triangles: triangles.len(),
                first_m: triangles.iter().take(SHOWN).map(middle).collect(),
            });
        }
    }
    let size = mesh.bounds().extent();
    let outcome = repaired(mesh.clone());
    let (repairs, repaired_volume, unusable) = match outcome {
        Ok((mesh, notes)) => (notes, Some(mesh.signed_volume()), None),
        Err(problem) => (Vec::new(), None, Some(problem.to_string())),
    };
    let survey = Survey {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        pieces: found.components,
        size_m: size,
        area_m2: mesh.area(),
        volume_m3: found.signed_volume,
        faults: findings,
        repairs_told: repairs.iter().map(ToString::to_string).collect(),
        repairs,
        repaired_volume_m3: repaired_volume,
        unusable,
        suggestions: suggestions(&size, unit, up),
    };
    (survey, worst)
}

/// The mesh with a colour for each triangle: grey, or that of its fault. No two triangles share a vertex.
pub fn painted_faults(mesh: &TriMesh, faults: &[Option<Fault>]) -> (TriMesh, Vec<[f32; 3]>) {
    let count = mesh.triangles.len();
    let apart = TriMesh {
        positions: (0..count).flat_map(|t| mesh.corners(t)).collect(),
        triangles: (0..count as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    };
    let colour = |fault: &Option<Fault>| [fault.map_or(SOUND, Fault::colour); 3];
    (apart, faults.iter().flat_map(colour).collect())
}

/// Triangles of each fault, ascending, worst fault first.
fn faults(mesh: &TriMesh) -> Vec<(Fault, Vec<usize>)> {
    let count = mesh.triangles.len();
    let mut flags: Vec<[bool; 3]> = vec![[false; 3]; count];
    for around in Edges::of(mesh).iter() {
        let kind = match around {
            [_] => 0,
            [a, b] if a.forward == b.forward => 2,
            [_, _] => continue,
            _ => 1,
        };
        for side in around {
            flags[side.triangle as usize][kind] = true;
        }
    }
    let with = |kind: usize| (0..count).filter(|t| flags[*t][kind]).collect::<Vec<_>>();
    let crossing = crossing::crossing(mesh);
    let mut seen = HashSet::new();
    let copies = (0..count).filter(|&t| {
        let mut key = mesh.triangles[t];
        key.sort_unstable();
        !seen.insert(key)
    });
    let shape = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let longest = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        let longest = longest.into_iter().fold(0.0, Real::max);
        (mesh.area_normal(t).norm(), longest)
    };
    vec![
        (Fault::Open, with(0)),
        (Fault::NonManifold, with(1)),
        (
            Fault::Crossing,
            (0..count).filter(|t| crossing[*t]).collect(),
        ),
        (Fault::Turned, with(2)),
        (Fault::Copy, copies.collect()),
        (
            Fault::Degenerate,
            (0..count).filter(|t| shape(*t).0 == 0.0).collect(),
        ),
        (
            Fault::Sliver,
            (0..count)
                .filter(|t| {
                    let (area, longest) = shape(*t);
                    area > 0.0 && area < SLIVER * longest * longest
                })
                .collect(),
        ),
    ]
}

fn suggestions(size: &Vec3, unit: LengthUnit, up: UpAxis) -> Vec<String> {
    let mut suggestions = Vec::new();
    let usual = |length: Real| (USUAL[0]..=USUAL[1]).contains(&length);
    let stored = size.max() / unit.metres();
    if !usual(size.max()) {
        let units = [
            LengthUnit::Metre,
            LengthUnit::Centimetre,
            LengthUnit::Millimetre,
        ];
        match units.into_iter().find(|unit| usual(stored * unit.metres())) {
            Some(meant) => suggestions.push(format!(
                "{:.3} m is no size of a bone: with unit = \"{meant}\" it would be {:.1} mm",
                size.max(),
                stored * meant.metres() * 1e3
            )),
            None if size.max() > USUAL[1] => suggestions.push(format!(
                "{:.3} m is no size of a bone, in any unit that can be given",
                size.max()
            )),
            None => {}
        }
    }
    // A vertebra is lowest along its axis. Turning a file's up axis exchanges y and z.
    if size.y * 1.15 < size.z && size.y < size.x {
        let other = match up {
            UpAxis::Y => UpAxis::Z,
            UpAxis::Z => UpAxis::Y,
        };
        suggestions.push(format!(
            "a vertebra is lowest along its axis, this mesh from front to back: with up = \"{other}\" it would stand"
        ));
    }
    suggestions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::cuboid;

    #[test]
    fn each_fault_is_found_and_coloured() {
        let whole = cuboid(Vec3::zeros(), Vec3::new(0.04, 0.05, 0.03));
        let look = |mesh: &TriMesh| survey(mesh, LengthUnit::Metre, UpAxis::Z);
        let (clean, worst) = look(&whole);
        assert!(
            clean.faults.is_empty() && clean.suggestions.is_empty(),
            "{clean:?}"
        );
        assert!(worst.iter().all(Option::is_none));
        assert!((clean.repaired_volume_m3.unwrap() / 6e-5 - 1.0).abs() < 1e-12);

        let mut bad = whole.clone();
        bad.triangles[0].swap(0, 1);
        bad.triangles.push(bad.triangles[4]);
        bad.triangles.remove(10);
        let small = cuboid(Vec3::new(0.017, 0.011, 0.021), Vec3::new(0.02, 0.02, 0.041));
        bad.append(&small);
        bad.positions.push(Vec3::new(0.02, 0.0, 0.0));
        bad.triangles.push([0, bad.positions.len() as u32 - 1, 1]);
        let (found, worst) = look(&bad);
        let kinds: Vec<Fault> = found.faults.iter().map(|f| f.fault).collect();
        for fault in [
            Fault::Open,
            Fault::NonManifold,
            Fault::Crossing,
            Fault::Turned,
            Fault::Copy,
            Fault::Degenerate,
        ] {
            assert!(kinds.contains(&fault), "{fault:?}: {kinds:?}");
        }
        let (apart, colours) = painted_faults(&bad, &worst);
        assert_eq!(apart.positions.len(), colours.len());
        assert!(colours.contains(&Fault::Open.colour()));
    }

    #[test]
    fn unit_and_up_are_suggested() {
        let size = Vec3::new(85.0, 90.0, 45.0);
        let told = suggestions(&size, LengthUnit::Metre, UpAxis::Z);
        assert!(
            told.len() == 1 && told[0].contains("unit = \"mm\""),
            "{told:?}"
        );
        let lying = Vec3::new(0.085, 0.045, 0.09);
        let told = suggestions(&lying, LengthUnit::Metre, UpAxis::Z);
        assert!(
            told.len() == 1 && told[0].contains("up = \"y\""),
            "{told:?}"
        );
    }
}
