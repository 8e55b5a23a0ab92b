//! The velocity–pressure system applied: [H P; Pᵀ −C] [v; k] in one pass over the pairs, in double precision for what a
//! solution leaves over, and in single precision for the corrections to it: without the rows of particles that no pressure
//! acts on, and with those that walls hold (`contact`) left out.

use super::coupled::CoupledSolver;
use super::minres::{self, Packed};
use super::neighbourhood::Neighbourhood;
use crate::math::{Real, Scalar, WideRows, ordered_sum, widest_rows};

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
    /// [H v + P k; Pᵀ v − C k] of all particles, also of those that no pressure acts on.
    pub(super) fn image(&self, x: &[Packed]) -> Vec<Packed> {
        let mut out = vec![[0.0; 4]; x.len()];
        self.apply_to(x, true, &mut out);
        out
    }

    /// `free`: whether the pressure rows of particles that no pressure acts on are wanted; 0 if not.
    fn apply_to<T: Scalar>(&self, x: &[Packed<T>], free: bool, out: &mut [Packed<T>]) {
        let near = self.problem.near;
        let mut of_walls = vec![[T::default(); 2]; near.of_wall.len()];
        widest_rows(&OfWalls { near, x }, &mut of_walls);
        let apply = Apply {
            solver: self,
            x,
            of_walls: &of_walls,
            free,
        };
        widest_rows(&apply, out);
    }

    /// Takes the mean out of the pressure rows of a closed body.
    pub(super) fn level<T: Scalar>(&self, rows: &mut [Packed<T>]) {
        if self.problem.closed {
            let sum: Real = ordered_sum(rows.len(), |i| rows[i][3].into());
            let mean = sum / rows.len() as Real;
            for row in rows {
                row[3] = T::of(row[3].into() - mean);
            }
        }
    }
}

impl minres::Operator<f32> for CoupledSolver<'_> {
    /// Vectors have nothing along the normals of held particles, and keep nothing there.
    fn apply(&self, x: &[Packed<f32>], out: &mut [Packed<f32>]) {
        self.apply_to(x, false, out);
        self.level(out);
        self.contacts.take_out(out);
    }
}

/// Pressure of each wall particle, and what the fluid closes in on it.
struct OfWalls<'a, T> {
    near: &'a Neighbourhood,
    x: &'a [Packed<T>],
}

impl<T: Scalar> WideRows<[T; 2]> for OfWalls<'_, T> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [[T; 2]]) {
        for (offset, row) in rows.iter_mut().enumerate() {
            let b = first + offset;
            let mut sum = T::Four::default();
            for pair in self.near.of_wall.row(b) {
                let [g_x, g_y, g_z] = pair.gradient;
                let weight = T::four([g_x, g_y, g_z, pair.share].map(T::from));
                sum = sum + weight * T::four(self.x[pair.i as usize]);
            }
            let sum = T::lanes(sum);
            let closing = -(sum[0] + sum[1] + sum[2]);
            *row = [sum[3], closing * T::of(self.near.wall_volume[b])];
        }
    }
}

/// The system on its rows.
struct Apply<'a, T> {
    solver: &'a CoupledSolver<'a>,
    x: &'a [Packed<T>],
    of_walls: &'a [[T; 2]],
    free: bool,
}

impl<T: Scalar> WideRows<Packed<T>> for Apply<'_, T> {
    #[inline(always)]
    fn fill(&self, first: usize, rows: &mut [Packed<T>]) {
        let (solver, x) = (self.solver, self.x);
        let near = solver.problem.near;
        let volume = T::of(near.rest_volume);
        for (offset, row) in rows.iter_mut().enumerate() {
            let i = first + offset;
            let own = x[i];
            let (own_four, own_pressure) = (T::four(own), own[3].splat());
            let mut drag = T::Four::default();
            let (mut push, mut differ) = (drag, drag);
            let pairs = solver.drags.row(i).iter().zip(solver.couplings.row(i));
            for (pair, coupling) in pairs {
                let theirs = x[pair.j as usize];
                let y = T::four(theirs);
                let g = T::four(coupling.map(T::from));
                drag = drag + T::from(pair.drag).splat() * y;
                push = push + g * (own_pressure + theirs[3].splat());
                differ = differ + g * (own_four - y);
            }
            let smooth = T::lanes(differ)[3];
            let mut given_back = T::default();
            for pair in near.wall.row(i) {
                let [k_b, q_b] = self.of_walls[pair.b as usize];
                let [g_x, g_y, g_z] = pair.gradient;
                let g = T::four([g_x, g_y, g_z, pair.share].map(T::from));
                push = push + g * (own_pressure + k_b.splat());
                differ = differ + g * own_four;
                given_back += T::from(pair.share) * q_b;
            }
            let [drag, push, differ] = [drag, push, differ].map(T::lanes);
            let h = T::of(solver.diagonal[i]);
            for axis in 0..3 {
                row[axis] = h * own[axis] - drag[axis] + volume * push[axis];
            }
            let rate = differ[0] + differ[1] + differ[2];
            row[3] = if self.free || solver.active[i] {
                volume * rate + given_back - smooth
            } else {
                T::default()
            };
        }
    }
}
