//! Approximate inverse of the velocity–pressure system: two Chebyshev–Jacobi steps for the velocity; for the pressure
//! viscosity and inertia by particle, and the coarse level.

use super::coupled::CoupledSolver;
use super::minres::{Packed, Preconditioner};
use crate::math::{Real, WideRows, widest_rows};

/// Interval of D⁻¹H on which the Chebyshev polynomial is small. H is diagonally dominant, so 2 bounds it.
const LARGEST: Real = 2.0;
const SMALLEST: Real = LARGEST / 20.0;

impl Preconditioner for CoupledSolver<'_> {
    fn precondition(&self, r: &[Packed], z: &mut [Packed]) {
        self.approximate(r, z);
        self.contacts.take_out(z);
    }
}

impl CoupledSolver<'_> {
    /// With no particle held.
    fn approximate(&self, r: &[Packed], z: &mut [Packed]) {
        let by_cell = self.coarse.solve(|i| r[i][3]);
        let approximate = Approximate {
            solver: self,
            r,
            by_cell: &by_cell,
        };
        widest_rows(&approximate, z);
        self.level(z);
    }
}

/// The approximate inverse on its rows. `by_cell`: what the coarse level adds to the pressure.
struct Approximate<'a> {
    solver: &'a CoupledSolver<'a>,
    r: &'a [Packed],
    by_cell: &'a [Real],
}

impl WideRows<Packed> for Approximate<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [Packed]) {
        const CENTRE: Real = 0.5 * (LARGEST + SMALLEST);
        const HALF: Real = 0.5 * (LARGEST - SMALLEST);
        const RHO: Real = 1.0 / (2.0 * CENTRE / HALF - HALF / CENTRE);
        let (solver, r) = (self.solver, self.r);
        let inverse = &solver.inverse;
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            // First Chebyshev step: scaled Jacobi, read off r where it is needed.
            let mut pull = [0.0; 4];
            for pair in solver.drags.row(i) {
                let j = pair.j as usize;
                let c = Real::from(pair.drag) * inverse[j];
                for (pull, r) in pull.iter_mut().zip(r[j]) {
                    *pull += c * r;
                }
            }
            for axis in 0..3 {
                let start = inverse[i] / CENTRE * r[i][axis];
                let rest = r[i][axis] * (1.0 - 1.0 / CENTRE) + pull[axis] / CENTRE;
                row[axis] =
                    (1.0 + RHO * HALF / CENTRE) * start + 2.0 * RHO / HALF * rest * inverse[i];
            }
            row[3] = match solver.coarse.cell_of(i) {
                Some(cell) => solver.fine[i] * r[i][3] + self.by_cell[cell],
                None => 0.0,
            };
        }
    }
}
