//! The velocity–pressure system applied: [H P; Pᵀ −C] [v; k] in one pass over the pairs, and with the particles that
//! walls hold (`contact`) left out.

use super::coupled::CoupledSolver;
use super::minres::{self, Packed};
use super::neighbourhood::Neighbourhood;
use crate::math::{Real, WideRows, widest_rows};

/// What the velocity block has for a pair of fluid particles. Kept apart from what couples them to the pressure, because
/// the preconditioner reads it alone, and memory is what an iteration waits for.
#[derive(Clone, Copy)]
pub(super) struct Drag {
    pub(super) j: u32,
    /// V_i c_ij η_ij [kg/s].
    pub(super) drag: f32,
}

/// V_j ∇_i W_ij [1/m], and the entry of C inside F [m³/(Pa s)] (0 outside): the weights of the differences of velocity and
/// pressure.
pub(super) type Coupling = [f32; 4];

impl CoupledSolver<'_> {
    /// The system with no particle held.
    pub(super) fn whole(&self, x: &[Packed], out: &mut [Packed]) {
        let near = self.problem.near;
        let mut of_walls = vec![[0.0; 2]; near.of_wall.len()];
        widest_rows(&OfWalls { near, x }, &mut of_walls);
        let apply = Apply {
            solver: self,
            x,
            of_walls: &of_walls,
        };
        widest_rows(&apply, out);
        self.level(out);
    }
}

/// Pressure of each wall particle, and what the fluid closes in on it.
struct OfWalls<'a> {
    near: &'a Neighbourhood,
    x: &'a [Packed],
}

impl WideRows<[Real; 2]> for OfWalls<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [[Real; 2]]) {
        for (offset, row) in rows.iter_mut().enumerate() {
            let b = first + offset;
            let mut sum = [0.0; 4];
            for pair in self.near.of_wall.row(b) {
                let [g_x, g_y, g_z] = pair.gradient;
                let weight = [g_x, g_y, g_z, pair.share].map(Real::from);
                let y = self.x[pair.i as usize];
                for lane in 0..4 {
                    sum[lane] += weight[lane] * y[lane];
                }
            }
            *row = [
                sum[3],
                -(sum[0] + sum[1] + sum[2]) * self.near.wall_volume[b],
            ];
        }
    }
}

/// The system on its rows.
struct Apply<'a> {
    solver: &'a CoupledSolver<'a>,
    x: &'a [Packed],
    of_walls: &'a [[Real; 2]],
}

impl WideRows<Packed> for Apply<'_> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [Packed]) {
        let (solver, x) = (self.solver, self.x);
        let near = solver.problem.near;
        let volume = near.rest_volume;
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = x[i];
            let (mut drag, mut push, mut differ) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            let pairs = solver.drags.row(i).iter().zip(solver.couplings.row(i));
            for (pair, coupling) in pairs {
                let y = x[pair.j as usize];
                let (c, k) = (Real::from(pair.drag), own[3] + y[3]);
                let g = coupling.map(Real::from);
                for lane in 0..4 {
                    drag[lane] += c * y[lane];
                    push[lane] += g[lane] * k;
                    differ[lane] += g[lane] * (own[lane] - y[lane]);
                }
            }
            let smooth = differ[3];
            let mut given_back = 0.0;
            for pair in near.wall.row(i) {
                let [k_b, q_b] = self.of_walls[pair.b as usize];
                let [g_x, g_y, g_z] = pair.gradient;
                let g = [g_x, g_y, g_z, pair.share].map(Real::from);
                let k = own[3] + k_b;
                for lane in 0..4 {
                    push[lane] += g[lane] * k;
                    differ[lane] += g[lane] * own[lane];
                }
                given_back += g[3] * q_b;
            }
            let h = solver.diagonal[i];
            for axis in 0..3 {
                row[axis] = h * own[axis] - drag[axis] + volume * push[axis];
            }
            let rate = differ[0] + differ[1] + differ[2];
            row[3] = if solver.active[i] {
                volume * rate + given_back - smooth
            } else {
                0.0
            };
        }
    }
}

impl minres::Operator for CoupledSolver<'_> {
    /// Vectors have nothing along the normals of held particles, and keep nothing there.
    fn apply(&self, x: &[Packed], out: &mut [Packed]) {
        self.whole(x, out);
        self.contacts.take_out(out);
    }
}
