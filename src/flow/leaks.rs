//! How much cement left a bone, and by which opening.

use super::{FlowError, Job};
use crate::bone::Opening;
use crate::math::Vec3;
use crate::mesh::{LengthUnit, MeshDistance, UpAxis, read_obj};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Cement that is first seen farther from every opening has not come out of one [m].
const FARTHEST: f64 = 5e-3;

/// Particles that left the bone, by identity, and the opening by which each did; none where no opening is near. One that
/// leaves the domain afterwards stays here; one that comes back does not.
pub(super) type Left = BTreeMap<u32, Option<u16>>;

/// The outer surface of a bone and its openings.
pub(super) struct Leaks {
    distance: MeshDistance,
    openings: Vec<Opening>,
}

impl Leaks {
    /// Those of the job's bone, if it has one.
    pub fn of(job: &Job) -> Result<Option<Self>, FlowError> {
        let Some(bone) = &job.scene.bone else {
            return Ok(None);
        };
        let surface = read_obj(&job.folder.bone_mesh(), LengthUnit::Metre, UpAxis::Y)?;
        Ok(Some(Self {
            distance: MeshDistance::new(&surface),
            openings: bone.settings.openings.clone(),
        }))
    }

    fn outside(&self, position: &[Vec3]) -> Vec<bool> {
        let outside = |x: &Vec3| self.distance.signed(x) >= 0.0;
        position.par_iter().map(outside).collect()
    }

    fn nearest(&self, x: &Vec3) -> Option<u16> {
        let depths = (0_u16..).zip(self.openings.iter().map(|opening| opening.shape.depth(x)));
        let nearest = depths.max_by(|a, b| a.1.total_cmp(&b.1));
        nearest
            .filter(|(_, depth)| *depth > -FARTHEST)
            .map(|(n, _)| n)
    }

    /// Enters who has left since the last time, and strikes out who came back.
    pub fn note(&self, position: &[Vec3], id: &[u32], left: &mut Left) {
        let outside = self.outside(position);
        for ((x, id), outside) in position.iter().zip(id).zip(outside) {
            if outside {
                left.entry(*id).or_insert_with(|| self.nearest(x));
            } else {
                left.remove(id);
            }
        }
    }

    /// The share of what is in the domain that is inside the bone, and the volume that left it by each opening [m³].
    pub fn report(&self, position: &[Vec3], left: &Left, rest_volume: f64) -> Value {
        let outside = self.outside(position).iter().filter(|out| **out).count();
        let inside = 1.0 - outside as f64 / position.len().max(1) as f64;
        let mut leaked: BTreeMap<&str, f64> = BTreeMap::new();
        for opening in left.values() {
            let opening = opening.and_then(|n| self.openings.get(usize::from(n)));
            let name = opening.map_or("elsewhere", |opening| opening.name.as_str());
            *leaked.entry(name).or_default() += rest_volume;
        }
        json!({ "inside_share": inside, "leaked_m3": leaked })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::OpeningShape;
    use crate::math::Aabb;
    use crate::mesh::tests::cuboid;

    /// A cube of 20 mm that is open to the right.
    fn cube() -> Leaks {
        let mesh = cuboid(Vec3::repeat(-10e-3), Vec3::repeat(10e-3));
        let around = Aabb {
            min: Vec3::new(8e-3, -2e-3, -2e-3),
            max: Vec3::new(12e-3, 2e-3, 2e-3),
        };
        let opening = Opening {
            name: "right".to_owned(),
            shape: OpeningShape::Box(around),
        };
        Leaks {
            distance: MeshDistance::new(&mesh),
            openings: vec![opening],
        }
    }

    #[test]
    fn who_left_by_an_opening_stays_counted_when_it_leaves_the_domain() {
        let leaks = cube();
        let mut left = Left::new();
        let at = |x: f64| Vec3::new(x * 1e-3, 0.0, 0.0);
        // One stays inside, one comes out at the opening, one on the other side.
        leaks.note(&[at(0.0), at(9.0), at(-9.0)], &[4, 5, 6], &mut left);
        assert!(left.is_empty());
        leaks.note(&[at(0.0), at(11.0), at(-11.0)], &[4, 5, 6], &mut left);
        // It flows on, far from the opening, and out of the domain.
        leaks.note(&[at(0.0), at(30.0), at(-11.0)], &[4, 5, 6], &mut left);
        leaks.note(&[at(0.0), at(-11.0)], &[4, 6], &mut left);
        let report = leaks.report(&[at(0.0), at(-11.0)], &left, 2.0);
        assert_eq!(
            report["leaked_m3"],
            json!({ "right": 2.0, "elsewhere": 2.0 })
        );
        assert_eq!(report["inside_share"], 0.5);
        // What comes back has not leaked.
        leaks.note(&[at(0.0), at(-9.0)], &[4, 6], &mut left);
        let report = leaks.report(&[at(0.0), at(-9.0)], &left, 2.0);
        assert_eq!(report["leaked_m3"], json!({ "right": 2.0 }));
    }
}
