//! Finds the anatomical frame of a vertebra: centre of the body, and which way is back.
//!
//! The body is the thickest part, so its core is where the surface is farthest; the processes behind it pull the
//! centroid of the whole bone backwards, so the way from the body to the centroid points at the spinous process.
//! Up is known (z); nothing else needs to be marked by hand.

use crate::math::{Real, Vec3};
use crate::mesh::{Lattice, MeshDistance, TriMesh, inside_columns};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use rayon::prelude::*;

/// Where a vertebra is and how it is turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmarks {
    /// Centre of the vertebral body [m].
    pub body_centre: Vec3,
    /// Radius of the largest sphere inside the bone [m].
    pub body_radius: Real,
    /// Unit vector to the left.
    pub left: Vec3,
    /// Horizontal unit vector to the back.
    pub posterior: Vec3,
}

/// Why no frame was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LandmarkError {
    /// Less than a few lattice cells inside.
    #[error(
        "the mesh is too thin to have a body: is it a closed mesh of a whole bone, in the right unit?"
    )]
    TooThin,
    /// The centroid lies above the body's centre.
    #[error(
        "cannot tell front from back: the mesh reaches equally far to all sides of its thickest part; \
         give a vertebra with its processes, and its up axis"
    )]
    NoPosterior,
}

/// Cells of the search lattice along the longest edge of the bone.
const CELLS: Real = 80.0;
/// Share of the largest depth from which on a point belongs to the core of the body.
const CORE: Real = 0.8;

/// Finds the frame of the closed `mesh`, whose distance is `distance`.
pub fn find(mesh: &TriMesh, distance: &MeshDistance) -> Result<Landmarks, LandmarkError> {
    let bounds = mesh.bounds();
    let size = bounds.extent().max();
    let step = size / CELLS;
    let depths = depths(mesh, distance, &Lattice::cells(&bounds, step));
    let deepest = depths.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let &(thickest, _) = deepest.ok_or(LandmarkError::TooThin)?;
    let (_, body_radius) = deepest_near(distance, thickest, step);

    // The core is flat where endplates are parallel: its middle is steadier than its one deepest point.
    let threshold = CORE * body_radius;
    let core = depths.iter().filter(|(_, depth)| *depth > threshold);
    let (sum, weight) = core.fold((Vec3::zeros(), 0.0), |(sum, weight), (x, depth)| {
        let w = depth - threshold;
        (sum + x * w, weight + w)
    });
    if weight == 0.0 {
        return Err(LandmarkError::TooThin);
    }
    let body_centre = sum / weight;

    let backwards = mesh.centroid() - body_centre;
    let horizontal = Vec3::new(backwards.x, backwards.y, 0.0);
    if horizontal.norm() < 0.02 * size {
        return Err(LandmarkError::NoPosterior);
    }
    let posterior = horizontal.normalize();
    Ok(Landmarks {
        body_centre,
        body_radius,
        left: posterior.cross(&Vec3::z()),
        posterior,
    })
}

impl Landmarks {
    /// The motion that brings the bone into its frame: body centre to the origin, x left, y to the back, z up.
    pub fn to_frame(&self) -> Isometry3<Real> {
        let axes = Matrix3::from_columns(&[self.left, self.posterior, Vec3::z()]).transpose();
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Isometry3::from_parts(Translation3::identity(), turn)
            * Isometry3::from_parts(
                Translation3::from(-self.body_centre),
                UnitQuaternion::identity(),
            )
    }
}

/// Points of the lattice inside the mesh, and how deep they lie.
fn depths(mesh: &TriMesh, distance: &MeshDistance, lattice: &Lattice) -> Vec<(Vec3, Real)> {
    let inside = inside_columns(mesh, lattice);
    (0..inside.len())
        .into_par_iter()
        .filter(|&index| inside[index])
        .map(|index| {
            let x = lattice.position(index);
            (x, -distance.signed(&x))
        })
        .collect()
}

/// Uphill from `x` to a point that is deepest inside, and its depth [m]: steps along the axes, halved when none leads
/// deeper.
pub fn deepest_near(distance: &MeshDistance, mut x: Vec3, mut step: Real) -> (Vec3, Real) {
    let mut depth = -distance.signed(&x);
    for _ in 0..24 {
        let neighbours = (0..6).map(|k| {
            let mut y = x;
            y[k / 2] += if k % 2 == 0 { step } else { -step };
            (y, -distance.signed(&y))
        });
        match neighbours.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((y, deeper)) if deeper > depth => (x, depth) = (y, deeper),
            _ => step *= 0.5,
        }
    }
    (x, depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bone::vertebra;
    use crate::mesh::{LengthUnit, tests::cuboid, tests::shared};

    fn found(mesh: &TriMesh) -> Result<Landmarks, LandmarkError> {
        find(mesh, &MeshDistance::new(mesh))
    }

    #[test]
    fn a_turned_and_moved_vertebra_is_brought_back() {
        let mesh = vertebra::make(&vertebra::VertebraSettings {
            resolution: 2e-3,
            ..Default::default()
        });
        let still = found(&mesh).unwrap();
        assert!(still.body_centre.norm() < 2e-3, "{still:?}");
        assert!(still.posterior.y > 0.9999 && still.left.x > 0.9999);
        assert!((still.body_radius - 0.0125).abs() < 1.5e-3);
        for turn in [0.5, 2.0, -2.6] {
            let motion = Isometry3::new(Vec3::new(0.3, -0.1, 0.7), Vec3::z() * turn);
            let frame = found(&mesh.transformed(&motion)).unwrap();
            let back = frame.to_frame() * motion;
            assert!(back.rotation.angle() < 0.01, "{}", back.rotation.angle());
            assert!((back.translation.vector + still.body_centre).norm() < 5e-4);
        }
    }

    #[test]
    fn the_back_of_real_vertebrae_is_where_the_spinous_process_is() {
        for (name, unit) in [
            ("vhm_L3_m.obj", LengthUnit::Metre),
            ("ssm_mean_L3_mm.obj", LengthUnit::Millimetre),
        ] {
            let Some(mesh) = shared(name, unit) else {
                return;
            };
            let frame = found(&mesh).unwrap();
            let home = mesh.transformed(&frame.to_frame());
            let bounds = home.bounds();
            // The tip of the spinous process is the farthest point behind, and lies near the midline.
            let tip = home.positions.iter().max_by(|a, b| a.y.total_cmp(&b.y));
            let tip = tip.unwrap();
            assert!(tip.x.abs() < 5e-3, "{name} {tip}");
            assert!(bounds.max.y > -2.0 * bounds.min.y, "{name} {bounds:?}");
            assert!(
                (bounds.max.x + bounds.min.x).abs() < 8e-3,
                "{name} {bounds:?}"
            );
            assert!(frame.body_radius > 0.01 && frame.body_radius < 0.02);
        }
    }

    #[test]
    fn a_box_has_no_back() {
        let mesh = cuboid(Vec3::zeros(), Vec3::repeat(0.03));
        assert_eq!(found(&mesh), Err(LandmarkError::NoPosterior));
    }
}
