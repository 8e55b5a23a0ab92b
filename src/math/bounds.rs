//! Axis-aligned boxes.

use super::{Real, Vec3};
use serde::{Deserialize, Serialize};

/// The lower corner of each of so many cells, in cells.
pub fn lattice(count: &Vec3) -> impl Iterator<Item = Vec3> {
    let [x, y, z] = [count.x, count.y, count.z].map(|c| c as usize);
    (0..x * y * z)
        .map(move |n| Vec3::new((n / (y * z)) as Real, (n / z % y) as Real, (n % z) as Real))
}

/// An axis-aligned box, `min ≤ max` on every axis unless it is empty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    /// Lower corner [m].
    pub min: Vec3,
    /// Upper corner [m].
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing, and grows with [`Aabb::include`].
    pub fn empty() -> Self {
        Self {
            min: Vec3::repeat(Real::INFINITY),
            max: Vec3::repeat(Real::NEG_INFINITY),
        }
    }

    /// The smallest box around `points`.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let mut bounds = Self::empty();
        for point in points {
            bounds.include(point);
        }
        bounds
    }

    /// Grows to hold `point`.
    pub fn include(&mut self, point: &Vec3) {
        self.min = self.min.inf(point);
        self.max = self.max.sup(point);
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    /// The box with `margin` [m] added on every side.
    #[must_use]
    pub fn grown(&self, margin: Real) -> Self {
        Self {
            min: self.min.add_scalar(-margin),
            max: self.max.add_scalar(margin),
        }
    }

    /// Edge lengths [m].
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// Centre [m].
    pub fn centre(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        !(0..3).all(|axis| self.min[axis] <= self.max[axis])
    }

    /// Whether `point` lies inside or on the surface.
    pub fn contains(&self, point: &Vec3) -> bool {
        self.min <= *point && *point <= self.max
    }
}
