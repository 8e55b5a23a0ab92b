//! Approximate inverse of the velocity–pressure system: two Chebyshev–Jacobi steps for the velocity; for the pressure
//! viscosity and inertia by particle, and the coarse level.

use super::coupled::{CoupledSolver, GRAIN};
use super::minres::{Packed, Preconditioner};
use crate::math::Real;
use rayon::prelude::*;

/// Interval of D⁻¹H on which the Chebyshev polynomial is small. H is diagonally dominant, so 2 bounds it.
const LARGEST: Real = 2.0;
const SMALLEST: Real = LARGEST / 20.0;

impl Preconditioner for CoupledSolver<'_> {
    fn precondition(&self, r: &[Packed], z: &mut [Packed]) {
        if !self.contacts.any() {
            return self.approximate(r, z);
        }
        let mut free = r.to_vec();
        self.contacts.take_out(&mut free);
        self.approximate(&free, z);
        self.contacts.take_out(z);
        self.contacts.put_back(r, z, |i| 1.0 / self.diagonal[i]);
    }
}

impl CoupledSolver<'_> {
    /// With no particle held.
    fn approximate(&self, r: &[Packed], z: &mut [Packed]) {
        let centre = 0.5 * (LARGEST + SMALLEST);
        let half = 0.5 * (LARGEST - SMALLEST);
        let rho_0 = half / centre;
        let rho_1 = 1.0 / (2.0 * centre / half - rho_0);
        // First Chebyshev step: scaled Jacobi, read off r where it is needed.
        let first: Vec<Real> = self.diagonal.iter().map(|d| 1.0 / (centre * d)).collect();
        let by_cell = self.coarse.solve(|i| r[i][3]);
        z.par_chunks_mut(GRAIN)
            .enumerate()
            .for_each(|(block, rows)| {
                for (offset, row) in rows.iter_mut().enumerate() {
                    let i = block * GRAIN + offset;
                    let d = self.diagonal[i];
                    let start = first[i];
                    let mut pull = [0.0; 3];
                    for pair in self.pairs.row(i) {
                        let j = pair.j as usize;
                        let c = Real::from(pair.drag) * first[j];
                        for axis in 0..3 {
                            pull[axis] += c * r[j][axis];
                        }
                    }
                    for axis in 0..3 {
                        let z_0 = start * r[i][axis];
                        let rest = r[i][axis] - d * z_0 + pull[axis];
                        row[axis] = z_0 + rho_1 * rho_0 * z_0 + 2.0 * rho_1 / half * rest / d;
                    }
                    row[3] = match self.coarse.cell_of(i) {
                        Some(cell) => self.fine[i] * r[i][3] + by_cell[cell],
                        None => 0.0,
                    };
                }
            });
        self.level(z);
    }
}
