//! A grid's transform: from voxel indices to the space of the file.

use super::codec::{Fault, Input};
use crate::math::{Real, Vec3};
use nalgebra::Matrix3;

/// x = A i + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    linear: Matrix3<Real>,
    inverse: Matrix3<Real>,
    shift: Vec3,
}

impl Affine {
    fn new(linear: Matrix3<Real>, shift: Vec3) -> Option<Self> {
        let finite = linear.iter().chain(shift.iter()).all(|c| c.is_finite());
        let inverse = linear.try_inverse().filter(|_| finite)?;
        inverse.iter().all(|c| c.is_finite()).then_some(Self {
            linear,
            inverse,
            shift,
        })
    }

    /// Where voxel `index` lies.
    pub fn there(&self, index: &Vec3) -> Vec3 {
        self.linear * index + self.shift
    }

    /// The voxel index of a point.
    pub fn back(&self, x: &Vec3) -> Vec3 {
        self.inverse * (x - self.shift)
    }

    /// Lengths of a voxel's edges.
    pub fn edges(&self) -> Vec3 {
        Vec3::from_fn(|axis, _| self.linear.column(axis).norm())
    }
}

/// Reads a transform: its type, then its numbers.
pub(super) fn read(input: &mut Input<'_>) -> Result<Affine, Fault> {
    let kind = input.string()?;
    let made = match kind.as_str() {
        // Vectors are rows in OpenVDB: the translation is the last row.
        "AffineMap" | "UnitaryMap" => {
            let mut m = [0.0; 16];
            for value in &mut m {
                *value = input.f64()?;
            }
            let linear = Matrix3::from_fn(|row, column| m[4 * column + row]);
            Affine::new(linear, Vec3::new(m[12], m[13], m[14]))
        }
        "ScaleMap" | "UniformScaleMap" => {
            let scale = scales(input)?;
            Affine::new(Matrix3::from_diagonal(&scale), Vec3::zeros())
        }
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let shift = vector(input)?;
            let scale = scales(input)?;
            Affine::new(Matrix3::from_diagonal(&scale), shift)
        }
        "TranslationMap" => Affine::new(Matrix3::identity(), vector(input)?),
        other => {
            let shown: String = other.chars().take(40).collect();
            return input.fault(format!(
                "transform `{shown}` is not supported: resample the grid to a linear transform"
            ));
        }
    };
    match made {
        Some(affine) => Ok(affine),
        None => input.fault("the grid's transform cannot be inverted"),
    }
}

fn vector(input: &mut Input<'_>) -> Result<Vec3, Fault> {
    Ok(Vec3::new(input.f64()?, input.f64()?, input.f64()?))
}

/// The scale, then four vectors that follow from it.
fn scales(input: &mut Input<'_>) -> Result<Vec3, Fault> {
    let scale = vector(input)?;
    for _ in 0..4 {
        vector(input)?;
    }
    Ok(scale)
}
