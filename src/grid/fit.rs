//! The linear field that fits values around a point best.
//!
//! ```text
//! G = Σ_j w (v_j − v) d_jᵀ (Σ_j w d_j d_jᵀ)⁻¹,   d_j = x_j − x
//! ```
//!
//! with w of [`super::kernel`]: least squares, each point weighted by the kernel.

use super::near::{LANES, NearPoints, across, kernel};
use crate::math::{Mat3, Real, Wide, widest};

/// Places of the entries of a symmetric matrix among its six sums.
const SYMMETRIC: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

impl NearPoints {
    /// Gradient ∂v_i/∂x_j [1/voxel] at `at`, where the vector is `here`; `values` are picked from these points, one list a
    /// component. Where the points span no volume, as threads and sheets, it is 0 across them.
    pub fn gradient(&self, at: [f32; 3], here: [f32; 3], values: &[Vec<f32>; 3]) -> Mat3 {
        let (moment, product) = widest(Fit {
            near: self,
            at,
            here,
            values,
        });
        let mut moment = Mat3::from_fn(|i, j| Real::from(moment[SYMMETRIC[i][j]]));
        // Without it, a quotient of rounding errors.
        moment += Mat3::identity() * (1e-3 * moment.trace() + 1e-12);
        let product = Mat3::from_fn(|i, j| Real::from(product[i][j]));
        moment
            .try_inverse()
            .map_or(Mat3::zeros(), |inverse| product * inverse)
    }
}

struct Fit<'a> {
    near: &'a NearPoints,
    at: [f32; 3],
    here: [f32; 3],
    values: &'a [Vec<f32>; 3],
}

impl Wide for Fit<'_> {
    /// Σ w d_i d_j and Σ w (v_i − v) d_j.
    type Out = ([f32; 6], [[f32; 3]; 3]);

    #[inline(always)]
    fn run(self) -> Self::Out {
        let per_reach = 1.0 / self.near.reach;
        let mut moment = [[0.0_f32; LANES]; 6];
        let mut product = [[[0.0_f32; LANES]; 3]; 3];
        for run in 0..self.near.runs() {
            let (d, r2) = self.near.offsets(self.at, run);
            // Minus w d: `offsets` counts from the points.
            let mut weighted = [[0.0; LANES]; 3];
            for k in 0..LANES {
                let w = kernel(r2[k].sqrt() * per_reach);
                for axis in 0..3 {
                    weighted[axis][k] = w * d[axis][k];
                }
            }
            for i in 0..3 {
                for j in i..3 {
                    for k in 0..LANES {
                        moment[SYMMETRIC[i][j]][k] += weighted[i][k] * d[j][k];
                    }
                }
                let values = &self.values[i].as_chunks::<LANES>().0[run];
                for j in 0..3 {
                    for k in 0..LANES {
                        product[i][j][k] -= (values[k] - self.here[i]) * weighted[j][k];
                    }
                }
            }
        }
        let (mut moments, mut products) = ([0.0; 6], [[0.0; 3]; 3]);
        for i in 0..6 {
            moments[i] = across(&moment[i]);
        }
        for i in 0..3 {
            for j in 0..3 {
                products[i][j] = across(&product[i][j]);
            }
        }
        (moments, products)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::PointBricks;
    use crate::math::{Stream, Vec3};

    #[test]
    fn a_linear_field_has_its_gradient_at_scattered_points() {
        let mut random = Stream::new(9, "fit");
        let points: Vec<[f32; 3]> = (0..400)
            .map(|_| (random.cube() * 1.5).map(|x| x as f32).into())
            .collect();
        let gradient = Mat3::new(1.0, -2.0, 0.5, 0.3, 0.7, -1.1, 2.0, 0.1, -0.4);
        let field = |i: usize| -> [f32; 3] {
            let x = Vec3::from(points[i].map(Real::from));
            (gradient * x).add_scalar(7.0).map(|c| c as f32).into()
        };
        let bricks = PointBricks::new(&points, 0.25, 1.0);
        let value = |row: usize| field(bricks.order[row] as usize);
        let found = bricks.map_points(
            |near| [0, 1, 2].map(|c| near.pick(|row| value(row)[c])),
            |near, values, at, row| near.gradient(at, value(row), values) / 0.25,
        );
        let errors: Vec<Real> = found.iter().map(|g| (g - gradient).norm()).collect();
        let mean = errors.iter().sum::<Real>() / errors.len() as Real;
        // What the term against empty directions takes; larger at corners.
        assert!(mean < 0.05, "{mean}");
    }
}
