//! A rheometer of particles: fluid between a plate at rest and one that moves, U from the particles' own gradient.

use super::StudyError;
use super::scenes::{Lie, shear_cell, viscoelastic};
use crate::math::Real;
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
/// Linear relaxation times λ' until it is read.
const MEMORIES: Real = 8.0;
/// Most strain of the cell in a step.
const STRAIN: Real = 0.04;
/// Strains after which thinning flow is steady; fast cells need not wait for λ'.
const STRAINS: Real = 30.0;

/// Shears a cell at `rate` [1/s] with λ [s] and γ [1/s] until it is steady.
pub fn read(
    name: &str,
    relaxation: Real,
    thinning: Real,
    rate: Real,
) -> Result<Reading, StudyError> {
    let memory = 1.0 / (1.0 / relaxation + thinning);
    let lie = Lie {
        turned: false,
        seed: 9,
    };
    let mut place = shear_cell(GAP, ACROSS, lie, rate * GAP, 0.0);
    place.settings.scheme = Scheme::ImmCt;
    // So light that the cell is sheared evenly from the start.
    let density = 1e-3;
    place.settings.cement = viscoelastic(density, SOLVENT, POLYMER, relaxation, thinning);
    place.settings.time_step = TimeStep::Fixed((0.1 * memory).min(STRAIN / rate));
    let end = (MEMORIES * memory).min(0.5 * memory + STRAINS / rate);
    let mut simulation = place.start(name)?;
    simulation
        .advance_to(end, |_| {})
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
