//! Coarse level of the pressure preconditioner: pressure constant in background cells, solved directly.
//!
//! A_c = Σ_l mob_l g_l g_lᵀ with g_lc = Σ_{j in cell c} P_lj: how easily the fluid moves is in `mobility`, so that a
//! tube has its Darcy resistance and long modes are right for any viscosity.

use super::neighbourhood::{Neighbourhood, vector};
use crate::math::{Real, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Cells are this many spacings wide, wider where there would be too many.
const CELL: Real = 5.0;
/// Largest dense system that is worth a step.
const MOST_CELLS: usize = 320;

/// Cells of the particles under pressure, and the factorised system.
pub struct Coarse {
    /// Cell of each particle; `u32::MAX` where no pressure acts.
    cell: Vec<u32>,
    /// Particles of each cell, ascending.
    members: Vec<Vec<u32>>,
    /// Cholesky factor, row by row.
    factor: Vec<Real>,
    /// A uniform pressure moves nothing: a closed body on a lattice.
    closed: bool,
}

/// Row sums of A_c below this share of its diagonal are rounding.
const NOTHING: Real = 1e-4;

impl Coarse {
    /// Builds and factorises the coarse system for the particles in `active`.
    pub fn new(
        near: &Neighbourhood,
        position: &[Vec3],
        active: &[bool],
        mobility: &[Real],
    ) -> Self {
        let mut width = CELL * near.spacing;
        let (cell, count) = loop {
            let (cell, count) = assign(position, active, width);
            if count <= MOST_CELLS {
                break (cell, count);
            }
            width *= 1.3;
        };
        let mut members = vec![Vec::new(); count];
        for (i, &c) in cell.iter().enumerate() {
            if c != u32::MAX {
                members[c as usize].push(i as u32);
            }
        }
        if count == 0 {
            return Self {
                cell,
                members,
                factor: Vec::new(),
                closed: false,
            };
        }
        // Each particle touches a handful of cells: gather its few (cell, g) and add the products in order.
        let touched: Vec<Vec<(u32, Vec3)>> = (0..near.len())
            .into_par_iter()
            .with_min_len(128)
            .map(|l| {
                let mut of_cell: Vec<(u32, Vec3)> = Vec::with_capacity(8);
                let mut add = |c: u32, g: Vec3| {
                    if c == u32::MAX {
                        return;
                    }
                    match of_cell.iter_mut().find(|entry| entry.0 == c) {
                        Some(entry) => entry.1 += g,
                        None => of_cell.push((c, g)),
                    }
                };
                let mut own = Vec3::zeros();
                for pair in near.fluid.row(l) {
                    let g = vector(pair.gradient);
                    own += g;
                    add(cell[pair.j as usize], g);
                }
                for pair in near.wall.row(l) {
                    // A wall's pressure is close to that of the fluid before it.
                    own += vector(pair.gradient) * 2.0;
                }
                add(cell[l], own);
                of_cell
            })
            .collect();
        let mut matrix = vec![0.0; count * count];
        for (l, of_cell) in touched.iter().enumerate() {
            let weight = mobility[l] * near.rest_volume * near.rest_volume;
            for (c, g_c) in of_cell {
                for (d, g_d) in of_cell {
                    matrix[*c as usize * count + *d as usize] += weight * g_c.dot(g_d);
                }
            }
        }
        let diagonal = (0..count).map(|c| matrix[c * count + c]);
        let nothing = NOTHING * diagonal.fold(0.0, Real::max);
        let closed = matrix
            .chunks_exact(count)
            .all(|row| row.iter().sum::<Real>().abs() <= nothing);
        factorise(&mut matrix, count);
        Self {
            cell,
            members,
            factor: matrix,
            closed,
        }
    }

    /// Q A_c⁻¹ Qᵀ r, by cell: the correction of particle i is `result[cell]`. In a closed body only differences of
    /// pressure mean anything: its level, which the residual's rounding would decide, is left alone.
    pub fn solve(&self, residual: impl Fn(usize) -> Real) -> Vec<Real> {
        let n = self.members.len();
        let mut x: Vec<Real> = self
            .members
            .iter()
            .map(|m| m.iter().map(|&i| residual(i as usize)).sum())
            .collect();
        self.without_level(&mut x);
        for r in 0..n {
            let row = &self.factor[r * n..r * n + r];
            let sum: Real = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            x[r] = (x[r] - sum) / self.factor[r * n + r];
        }
        for r in (0..n).rev() {
            x[r] /= self.factor[r * n + r];
            let top = x[r];
            for (c, value) in x[..r].iter_mut().enumerate() {
                *value -= self.factor[r * n + c] * top;
            }
        }
        self.without_level(&mut x);
        x
    }

    fn without_level(&self, x: &mut [Real]) {
        if self.closed {
            let mean = x.iter().sum::<Real>() / x.len() as Real;
            for value in x {
                *value -= mean;
            }
        }
    }

    /// The cell of particle i, if pressure acts on it.
    #[inline]
    pub fn cell_of(&self, i: usize) -> Option<usize> {
        (self.cell[i] != u32::MAX).then_some(self.cell[i] as usize)
    }
}

fn assign(position: &[Vec3], active: &[bool], width: Real) -> (Vec<u32>, usize) {
    let key = |x: &Vec3| [x.x, x.y, x.z].map(|c| (c / width).floor() as i64);
    let mut numbers: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    for (x, _) in position.iter().zip(active).filter(|(_, on)| **on) {
        numbers.insert(key(x), 0);
    }
    for (number, slot) in numbers.values_mut().enumerate() {
        *slot = number as u32;
    }
    let cell = position
        .iter()
        .zip(active)
        .map(|(x, &on)| if on { numbers[&key(x)] } else { u32::MAX })
        .collect();
    (cell, numbers.len())
}

/// Cholesky, lower triangle in place; a pivot that is lost to rounding (a cell that nothing resists) decouples.
fn factorise(a: &mut [Real], n: usize) {
    let largest = (0..n)
        .map(|i| a[i * n + i])
        .fold(0.0, Real::max)
        .max(Real::MIN_POSITIVE);
    for i in 0..n {
        a[i * n + i] += 1e-9 * largest;
    }
    for r in 0..n {
        for c in 0..=r {
            let (row_r, row_c) = (&a[r * n..r * n + c], &a[c * n..c * n + c]);
            let sum: Real = row_r.iter().zip(row_c).map(|(x, y)| x * y).sum();
            let rest = a[r * n + c] - sum;
            a[r * n + c] = if r == c {
                rest.max(1e-12 * largest).sqrt()
            } else {
                rest / a[c * n + c]
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cholesky_solves() {
        let n = 5;
        let mut random = crate::math::Stream::new(4, "coarse");
        let b: Vec<Real> = (0..n * n).map(|_| random.between(-1.0, 1.0)).collect();
        let mut a = vec![0.0; n * n];
        for r in 0..n {
            for c in 0..n {
                a[r * n + c] = (0..n).map(|k| b[r * n + k] * b[c * n + k]).sum::<Real>()
                    + f64::from(u8::from(r == c));
            }
        }
        let matrix = a.clone();
        factorise(&mut a, n);
        let members = (0..n as u32).map(|i| vec![i]).collect();
        let coarse = Coarse {
            cell: (0..n as u32).collect(),
            members,
            factor: a,
            closed: false,
        };
        let x = coarse.solve(|i| i as Real);
        for r in 0..n {
            let image: Real = (0..n).map(|c| matrix[r * n + c] * x[c]).sum();
            assert!((image - r as Real).abs() < 1e-6);
        }
    }
}
