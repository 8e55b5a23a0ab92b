//! The velocity–pressure system applied: [H P; Pᵀ −C] [v; k] in one pass over the pairs, and with the particles that
//! walls hold (`contact`) left out.

use super::coupled::{CoupledSolver, GRAIN};
use super::minres::{self, Packed};
use super::neighbourhood::vector;
use crate::math::Real;
use rayon::prelude::*;

/// What the system has for a pair of fluid particles.
#[derive(Clone, Copy)]
pub(super) struct SaddlePair {
    pub(super) j: u32,
    pub(super) gradient: [f32; 3],
    /// V_i c_ij η_ij [kg/s].
    pub(super) drag: f32,
    /// V_j W_ij [1].
    pub(super) weight: f32,
    /// Entry of C inside F [m³/(Pa s)], 0 outside.
    pub(super) smooth: f32,
}

impl CoupledSolver<'_> {
    /// The system with no particle held.
    pub(super) fn whole(&self, x: &[Packed], out: &mut [Packed]) {
        let near = self.problem.near;
        let volume = near.rest_volume;
        let of_walls: Vec<(Real, Real)> = (0..near.of_wall.len())
            .into_par_iter()
            .with_min_len(GRAIN)
            .map(|b| {
                let (mut pressure, mut closing) = (0.0, 0.0);
                for pair in near.of_wall.row(b) {
                    let y = x[pair.i as usize];
                    let g = vector(pair.gradient);
                    pressure += Real::from(pair.share) * y[3];
                    closing -= g.x * y[0] + g.y * y[1] + g.z * y[2];
                }
                (pressure, closing * near.wall_volume[b])
            })
            .collect();
        out.par_chunks_mut(GRAIN)
            .enumerate()
            .for_each(|(block, rows)| {
                for (offset, row) in rows.iter_mut().enumerate() {
                    let i = block * GRAIN + offset;
                    let own = x[i];
                    let h = self.diagonal[i];
                    let mut drag = [h * own[0], h * own[1], h * own[2]];
                    let (mut push, mut rate, mut smooth) = ([0.0; 3], 0.0, 0.0);
                    for pair in self.pairs.row(i) {
                        let y = x[pair.j as usize];
                        let c = Real::from(pair.drag);
                        let g = pair.gradient.map(Real::from);
                        let k = own[3] + y[3];
                        for axis in 0..3 {
                            drag[axis] -= c * y[axis];
                            push[axis] += g[axis] * k;
                            rate += g[axis] * (own[axis] - y[axis]);
                        }
                        smooth += Real::from(pair.smooth) * (own[3] - y[3]);
                    }
                    let mut given_back = 0.0;
                    for pair in near.wall.row(i) {
                        let (k_b, q_b) = of_walls[pair.b as usize];
                        let g = pair.gradient.map(Real::from);
                        let k = own[3] + k_b;
                        for axis in 0..3 {
                            push[axis] += g[axis] * k;
                            rate += g[axis] * own[axis];
                        }
                        given_back += Real::from(pair.share) * q_b;
                    }
                    let p = if self.active[i] {
                        volume * rate + given_back - smooth
                    } else {
                        0.0
                    };
                    *row = [
                        drag[0] + volume * push[0],
                        drag[1] + volume * push[1],
                        drag[2] + volume * push[2],
                        p,
                    ];
                }
            });
        self.level(out);
    }
}

impl minres::Operator for CoupledSolver<'_> {
    fn apply(&self, x: &[Packed], out: &mut [Packed]) {
        if !self.contacts.any() {
            return self.whole(x, out);
        }
        let mut free = x.to_vec();
        self.contacts.take_out(&mut free);
        self.whole(&free, out);
        self.contacts.take_out(out);
        self.contacts.put_back(x, out, |i| self.diagonal[i]);
    }
}
