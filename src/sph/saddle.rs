//! The velocity–pressure system applied: [H P; Pᵀ −C] [v; k] in one pass over the pairs, and with the particles that
//! walls hold (`contact`) left out.

use super::coupled::{CoupledSolver, GRAIN};
use super::minres::{self, Packed};
use crate::math::{Real, Wide, widest};
use rayon::prelude::*;

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
        let of_walls: Vec<[Real; 2]> = (0..near.of_wall.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let mut sum = [0.0; 4];
                for pair in near.of_wall.row(b) {
                    let [g_x, g_y, g_z] = pair.gradient;
                    add(&mut sum, &[g_x, g_y, g_z, pair.share], &x[pair.i as usize]);
                }
                [sum[3], -(sum[0] + sum[1] + sum[2]) * near.wall_volume[b]]
            })
            .collect();
        out.par_chunks_mut(GRAIN)
            .enumerate()
            .for_each(|(block, rows)| {
                widest(Apply {
                    solver: self,
                    x,
                    of_walls: &of_walls,
                    first: block * GRAIN,
                    rows,
                });
            });
        self.level(out);
    }
}

/// The system for a block of particles. `of_walls`: pressure of each wall particle, and what the fluid closes in on it.
struct Apply<'a> {
    solver: &'a CoupledSolver<'a>,
    x: &'a [Packed],
    of_walls: &'a [[Real; 2]],
    first: usize,
    rows: &'a mut [Packed],
}

impl Wide for Apply<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let (solver, x) = (self.solver, self.x);
        let near = solver.problem.near;
        let volume = near.rest_volume;
        for (offset, row) in self.rows.iter_mut().enumerate() {
            let i = self.first + offset;
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

#[inline(always)]
fn add(sum: &mut [Real; 4], weight: &[f32; 4], y: &Packed) {
    for lane in 0..4 {
        sum[lane] += Real::from(weight[lane]) * y[lane];
    }
}

impl minres::Operator for CoupledSolver<'_> {
    /// Vectors have nothing along the normals of held particles, and keep nothing there.
    fn apply(&self, x: &[Packed], out: &mut [Packed]) {
        self.whole(x, out);
        self.contacts.take_out(out);
    }
}
