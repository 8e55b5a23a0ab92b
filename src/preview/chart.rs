//! A map of colours on a plane: what a cut face shows of the points behind it.
//!
//! A plane in one light is one flat tone, on which nobody tells what is near from what is far. So the face has a lip: it is
//! shaded as if it bent down where its points end, at its rim and around what stands in it.

use super::Colour;
use crate::grid::kernel;
use crate::math::{Real, Vec3};

/// Nodes along an edge at most, however far the points lie apart.
const MOST: Real = 2000.0;
/// How far the face is taken to bend down where its points end, in reaches of the kernel.
const LIP: Real = 0.45;
/// Shares of the weight among points where the lip ends and begins: disorder within does not show.
const BEND: [Real; 2] = [0.3, 0.9];

/// Colours at the nodes of a square lattice on a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Unit directions of its rows and columns, and the way between nodes [m].
    axes: [Vec3; 2],
    step: Real,
    /// Numbers of the first node along both.
    first: [Real; 2],
    size: [usize; 2],
    /// Colour times weight, and weight, of each node; columns running fastest.
    nodes: Vec<(Colour, Real)>,
    elsewhere: Colour,
    /// Height of the lip at each node [m].
    height: Vec<f32>,
}

impl Chart {
    /// Of the plane through `point` [m] across `normal`: the `colour` of the means of `values` at `points` [m], by a
    /// kernel that vanishes at `reach` [m]; `elsewhere` where no point is in reach.
    pub fn new(
        [point, normal]: [&Vec3; 2],
        points: &[[f32; 3]],
        values: &[f32],
        reach: Real,
        colour: impl Fn(f32) -> Colour,
        elsewhere: Colour,
    ) -> Self {
        let normal = normal.try_normalize(1e-300).unwrap_or_else(Vec3::z);
        let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
        let axes = [across, normal.cross(&across)];
        // Within reach of the plane: on it, and how far from it.
        let near: Vec<([Real; 3], f32)> = (points.iter().zip(values))
            .filter_map(|(p, value)| {
                let p = Vec3::from(p.map(Real::from));
                let away = normal.dot(&(p - point));
                let place = [axes[0].dot(&p), axes[1].dot(&p), away];
                (away.abs() < reach && place.iter().all(|c| c.is_finite()))
                    .then_some((place, *value))
            })
            .collect();
        let end = |axis: usize, fold: fn(Real, Real) -> Real| {
            near.iter()
                .map(|(p, _)| p[axis])
                .reduce(fold)
                .unwrap_or(0.0)
        };
        let low = [0, 1].map(|a| end(a, Real::min) - reach);
        let high = [0, 1].map(|a| end(a, Real::max) + reach);
        let step = (0.25 * reach).max((high[0] - low[0]).max(high[1] - low[1]) / MOST);
        // Nodes lie on multiples of the step: from picture to picture they stay where they are.
        let first = low.map(|c| (c / step).floor());
        let size = [0, 1].map(|a| ((high[a] / step).ceil() - first[a]) as usize + 1);

        let mut sums = vec![[0.0_f32; 2]; size[0] * size[1]];
        for (p, value) in &near {
            let span = |a: usize| {
                let node = |x: Real| (x / step - first[a]).max(0.0);
                node(p[a] - reach).ceil() as usize
                    ..=(node(p[a] + reach).floor() as usize).min(size[a] - 1)
            };
            for i in span(0) {
                for j in span(1) {
                    let aside = [(i, 0), (j, 1)].map(|(n, a)| (first[a] + n as Real) * step - p[a]);
                    let square = aside[0] * aside[0] + aside[1] * aside[1] + p[2] * p[2];
                    let weight = kernel((square.sqrt() / reach) as f32);
                    let sum = &mut sums[i * size[1] + j];
                    sum[0] += weight * value;
                    sum[1] += weight;
                }
            }
        }
        let node = |[sum, weight]: [f32; 2]| {
            if weight > 0.0 {
                (colour(sum / weight) * Real::from(weight), weight.into())
            } else {
                (Colour::zeros(), 0.0)
            }
        };
        // The mean that a place picked by weight has: that among points.
        let total = |power: i32| {
            sums.iter()
                .map(|s| Real::from(s[1]).powi(power))
                .sum::<Real>()
        };
        let among = total(2) / total(1);
        let height = |[_, weight]: &[f32; 2]| {
            let share = (Real::from(*weight) / among - BEND[0]) / (BEND[1] - BEND[0]);
            let share = share.clamp(0.0, 1.0);
            (LIP * reach * share * share * (3.0 - 2.0 * share)) as f32
        };
        Self {
            axes,
            step,
            first,
            size,
            height: sums.iter().map(height).collect(),
            nodes: sums.into_iter().map(node).collect(),
            elsewhere,
        }
    }

    /// The colour at a point of the plane [m], evenly between nodes.
    pub fn at(&self, x: &Vec3) -> Colour {
        let (mut colour, mut weight) = (Colour::zeros(), 0.0);
        for (node, share) in self.around(self.place(x)) {
            let (c, w) = &self.nodes[node];
            colour += c * share;
            weight += w * share;
        }
        if weight > 0.0 {
            colour / weight
        } else {
            self.elsewhere
        }
    }

    /// How steeply, and which way, the lip rises at a point of the plane [1].
    pub fn slope(&self, x: &Vec3) -> Vec3 {
        let place = self.place(x);
        let height = |aside: [Real; 2]| -> Real {
            let there = [place[0] + aside[0], place[1] + aside[1]];
            let nodes = self.around(there);
            nodes
                .map(|(node, share)| Real::from(self.height[node]) * share)
                .sum()
        };
        let along = [
            height([1.0, 0.0]) - height([-1.0, 0.0]),
            height([0.0, 1.0]) - height([0.0, -1.0]),
        ];
        (self.axes[0] * along[0] + self.axes[1] * along[1]) / (2.0 * self.step)
    }

    /// Where a point is among the nodes [nodes].
    fn place(&self, x: &Vec3) -> [Real; 2] {
        [0, 1].map(|a| self.axes[a].dot(x) / self.step - self.first[a])
    }

    /// The nodes around a place, and the share of each.
    fn around(&self, place: [Real; 2]) -> impl Iterator<Item = (usize, Real)> {
        let size = self.size;
        (0..4).filter_map(move |corner| {
            let node = [corner >> 1, corner & 1];
            let node = [0, 1].map(|a| place[a].floor() + Real::from(node[a]));
            let inside = (0..2).all(|a| node[a] >= 0.0 && node[a] < size[a] as Real);
            let share = (1.0 - (place[0] - node[0]).abs()) * (1.0 - (place[1] - node[1]).abs());
            inside.then_some((node[0] as usize * size[1] + node[1] as usize, share))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_through_a_lattice_shows_the_field_of_its_points() {
        // A field that rises along x and y; the plane is aslant, between the points.
        let mut points = Vec::new();
        for x in -8..8 {
            for y in -8..8 {
                for z in -8..8 {
                    points.push([x, y, z].map(|c| c as f32 + 0.5));
                }
            }
        }
        let field = |x: f32, y: f32| 0.5 + 0.03 * x - 0.02 * y;
        let values: Vec<f32> = points.iter().map(|p| field(p[0], p[1])).collect();
        let (point, normal) = (Vec3::new(0.2, 0.1, 0.3), Vec3::new(1.0, 2.0, 3.0));
        let chart = Chart::new(
            [&point, &normal],
            &points,
            &values,
            2.0,
            |v| Colour::repeat(v.into()),
            Colour::repeat(-1.0),
        );
        let [a, b] = chart.axes;
        assert!(a.dot(&normal).abs() + b.dot(&normal).abs() + a.dot(&b).abs() < 1e-12);
        for i in -12..=12 {
            for j in -12..=12 {
                let x = point + a * (0.35 * Real::from(i)) + b * (0.35 * Real::from(j));
                let expected = Real::from(field(x.x as f32, x.y as f32));
                let found = chart.at(&x).x;
                assert!((found - expected).abs() < 2e-3, "{x}: {found} {expected}");
                assert!(chart.slope(&x).norm() < 1e-12, "{x}");
            }
        }
        // Outwards the face falls, by no more than it may, and lies flat beyond.
        let mut fall = 0.0;
        for i in 0..200 {
            let slope = chart.slope(&(point + a * (0.1 * Real::from(i))));
            assert!(slope.dot(&a) < 1e-6 && slope.dot(&normal).abs() < 1e-6);
            fall -= 0.1 * slope.dot(&a);
        }
        assert!((fall - LIP * 2.0).abs() < 0.02, "{fall}");
        assert_eq!(chart.at(&(point + a * 90.0)).x, -1.0);
        let lost = [[f32::NAN; 3], [1e30; 3]];
        let none = Chart::new([&point, &normal], &lost, &[1.0; 2], 2.0, |_| a, b);
        assert_eq!(none.at(&point), b);
    }
}
