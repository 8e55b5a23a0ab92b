//! Coarse level of the pressure preconditioner: pressure constant in background cells, solved directly.
//!
//! A_c = Σ_l mob_l g_l g_lᵀ with g_lc = Σ_{j in cell c} P_lj: how easily the fluid moves is in `mobility`, so that a
//! tube has its Darcy resistance and long modes are right for any viscosity.

use super::neighbourhood::Neighbourhood;
use super::pairs::vector;
use crate::math::{Real, Vec3, Wide, widest};
use rayon::prelude::*;
use std::collections::HashMap;

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
    /// Cholesky factor, lower triangle, row by row.
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
        let mut row_sums = vec![0.0; count];
        for (l, of_cell) in touched.iter().enumerate() {
            let weight = mobility[l] * near.rest_volume * near.rest_volume;
            let all = of_cell.iter().fold(Vec3::zeros(), |all, (_, g)| all + g);
            for (c, g_c) in of_cell {
                row_sums[*c as usize] += weight * g_c.dot(&all);
                for (d, g_d) in of_cell {
                    if d <= c {
                        matrix[*c as usize * count + *d as usize] += weight * g_c.dot(g_d);
                    }
                }
            }
        }
        let diagonal = (0..count).map(|c| matrix[c * count + c]);
        let nothing = NOTHING * diagonal.fold(0.0, Real::max);
        let closed = row_sums.iter().all(|sum| sum.abs() <= nothing);
        widest(Factorise {
            matrix: &mut matrix,
            n: count,
        });
        Self {
            cell,
            members,
            factor: matrix,
            closed,
        }
    }

    /// Q A_c⁻¹ Qᵀ r, by cell: the correction of particle i is `result[cell]`. In a closed body only differences of
    /// pressure mean anything: its level, which the residual's rounding would decide, is left alone.
    pub fn solve(&self, residual: impl Fn(usize) -> Real + Sync) -> Vec<Real> {
        let mut x = self.sums(residual);
        self.without_level(&mut x);
        widest(Substitute {
            factor: &self.factor,
            x: &mut x,
        });
        self.without_level(&mut x);
        x
    }

    /// Σ |Σ r| over the cells: what flows too much or too little from one to the next, where a sum over all would let one
    /// make up for another.
    pub fn spread(&self, residual: impl Fn(usize) -> Real + Sync) -> Real {
        self.sums(residual).iter().map(|sum| sum.abs()).sum()
    }

    /// Σ r of each cell.
    fn sums(&self, residual: impl Fn(usize) -> Real + Sync) -> Vec<Real> {
        (self.members.par_iter())
            .map(|m| m.iter().map(|&i| residual(i as usize)).sum())
            .collect()
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

/// The cell of each particle that is on, and how many there are, numbered in the order of the particles.
fn assign(position: &[Vec3], active: &[bool], width: Real) -> (Vec<u32>, usize) {
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    let cell = position
        .iter()
        .zip(active)
        .map(|(x, &on)| {
            if !on {
                return u32::MAX;
            }
            let next = numbers.len() as u32;
            let key = [x.x, x.y, x.z].map(|c| (c / width).floor() as i32);
            *numbers.entry(key).or_insert(next)
        })
        .collect();
    (cell, numbers.len())
}

/// Cholesky, lower triangle in place; a pivot that is lost to rounding (a cell that nothing resists) decouples.
struct Factorise<'a> {
    matrix: &'a mut [Real],
    n: usize,
}

impl Wide for Factorise<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let (a, n) = (self.matrix, self.n);
        let largest = (0..n)
            .map(|i| a[i * n + i])
            .fold(0.0, Real::max)
            .max(Real::MIN_POSITIVE);
        for i in 0..n {
            a[i * n + i] += 1e-9 * largest;
        }
        for r in 0..n {
            let (above, own) = a.split_at_mut(r * n);
            for c in 0..r {
                let row_c = &above[c * n..=c * n + c];
                own[c] = (own[c] - dot(&own[..c], &row_c[..c])) / row_c[c];
            }
            let rest = own[r] - dot(&own[..r], &own[..r]);
            own[r] = rest.max(1e-12 * largest).sqrt();
        }
    }
}

/// x ← (L Lᵀ)⁻¹ x.
struct Substitute<'a> {
    factor: &'a [Real],
    x: &'a mut [Real],
}

impl Wide for Substitute<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let (factor, x) = (self.factor, self.x);
        let n = x.len();
        for r in 0..n {
            let row = &factor[r * n..=r * n + r];
            x[r] = (x[r] - dot(&row[..r], &x[..r])) / row[r];
        }
        for r in (0..n).rev() {
            let row = &factor[r * n..=r * n + r];
            x[r] /= row[r];
            let top = x[r];
            for (value, entry) in x[..r].iter_mut().zip(row) {
                *value -= entry * top;
            }
        }
    }
}

/// Σ a_i b_i in lanes that do not wait for each other.
#[inline(always)]
fn dot(a: &[Real], b: &[Real]) -> Real {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder());
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: Real = rest.map(|(a, b)| a * b).sum();
    sums.iter().sum::<Real>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cholesky_solves() {
        let n = 21;
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
        widest(Factorise { matrix: &mut a, n });
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
