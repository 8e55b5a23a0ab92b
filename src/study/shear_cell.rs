//! A rheometer of particles: fluid between a plate at rest and one that moves, U from the particles' own gradient.

use super::StudyError;
use super::exact::steady_shear;
use super::scenes::{Lie, shear_cell, viscoelastic};
use crate::fluid::conformation;
use crate::math::{Mat3, Real, Sym3};
use crate::sim::{Scheme, TimeStep};
use serde::{Deserialize, Serialize};

/// What a steady cell shows.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Reading {
    /// Mean of U_xy.
    pub xy: Real,
    /// Mean of U_xx − U_yy.
    pub first: Real,
    /// Standard deviation of U_xy over the particles, by its mean.
    pub spread: Real,
}

const GAP: Real = 0.02;
/// η_s [Pa·s]: as the solvent of the paper; G is that of 8 Pa·s.
const SOLVENT: Real = 0.01;
const POLYMER: Real = 8.0;
/// Spacings across.
const ACROSS: u32 = 10;
/// Most strain of the cell in a step.
const STRAIN: Real = 0.04;
/// A cell is read once a particle alone would stay so close to the steady state.
const STEADY: Real = 1e-3;
/// Linear relaxation times λ' for which a particle alone is watched.
const MEMORIES: u32 = 20;
/// Steps in one of them at least.
const STEPS: u32 = 10;

/// Shears a cell at `rate` [1/s] with λ [s] and γ [1/s] until it is steady.
pub fn read(
    name: &str,
    relaxation: Real,
    thinning: Real,
    rate: Real,
) -> Result<Reading, StudyError> {
    let memory = conformation::linear_relaxation_time(relaxation, thinning);
    let step = (memory / Real::from(STEPS)).min(STRAIN / rate);
    let lie = Lie {
        turned: false,
        seed: 9,
    };
    let mut place = shear_cell(GAP, ACROSS, lie, rate * GAP, 0.0);
    place.settings.scheme = Scheme::ImmCt;
    // So light that the cell is sheared evenly from the start.
    let density = 1e-3;
    place.settings.cement = viscoelastic(density, SOLVENT, POLYMER, relaxation, thinning);
    place.settings.time_step = TimeStep::Fixed(step);
    let mut simulation = place.start(name)?;
    simulation
        .advance_to(settled(relaxation, thinning, rate, step), |_| {})
        .map_err(StudyError::run(name))?;
    let u = &simulation.fluid.conformation;
    let n = u.len() as Real;
    let xy = u.iter().map(|u| u.xy).sum::<Real>() / n;
    let first = u.iter().map(|u| u.xx - u.yy).sum::<Real>() / n;
    let square = u.iter().map(|u| (u.xy - xy) * (u.xy - xy)).sum::<Real>() / n;
    Ok(Reading {
        xy,
        first,
        spread: square.sqrt() / xy,
    })
}

/// Velocity gradient [1/s] of shear along x across y.
pub fn shear(rate: Real) -> Mat3 {
    Mat3::new(0.0, rate, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
}

/// U of a particle that is sheared alone, from rest, at the end of each step.
pub fn alone(
    relaxation: Real,
    thinning: Real,
    rate: Real,
    step: Real,
) -> impl Iterator<Item = Sym3> {
    std::iter::repeat(shear(rate)).scan(Sym3::IDENTITY, move |u, gradient| {
        *u = conformation::advance(u, &gradient, relaxation, thinning, step);
        Some(*u)
    })
}

/// Time [s] from which a particle that is sheared alone stays close to its steady state.
fn settled(relaxation: Real, thinning: Real, rate: Real, step: Real) -> Real {
    let memory = conformation::linear_relaxation_time(relaxation, thinning);
    let steady = steady_shear(relaxation, thinning, rate);
    let off = |reached: Real, steady: Real| (reached / steady - 1.0).abs() > STEADY;
    let steps = (Real::from(MEMORIES) * memory / step).ceil() as usize;
    let (mut time, mut last) = (0.0, 0.0);
    for u in alone(relaxation, thinning, rate, step).take(steps) {
        time += step;
        if off(u.xy, steady.xy) || off(u.xx - u.yy, steady.first) {
            last = time;
        }
    }
    last + step
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without thinning N₁ nears its steady state as (1 + t/λ) e^{−t/λ}; a particle that thins is soon there.
    #[test]
    fn a_cell_is_read_once_it_is_steady() {
        let slow = settled(0.5, 0.0, 1.0, 0.001);
        assert!((slow / 0.5 - 9.23).abs() < 0.05, "{slow}");
        assert!(settled(0.5, 1.0, 100.0, 1e-4) < 0.5);
    }
}
