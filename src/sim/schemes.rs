//! The schemes that the paper compares, as lists of what a step does.
//!
//! Where the order differs from the paper's Algorithm 1: C_d is refreshed before the pressure that uses it; there
//! are two pressure solves, before and after the other forces, so that the velocity that moves the particles keeps
//! their volume; drift is taken before the fractions that it moves. With `StressStep::Coupled` velocity and
//! pressure are one solve, which lets the step grow to the CFL limit.

use super::health::SimError;
use super::settings::{Scheme, StressStep};
use super::stepper::Stepper;
use crate::sph::Source;

/// One step; `left` [s] remain to the end of the frame.
pub fn step(s: &mut Stepper, left: f64) -> Result<(), SimError> {
    match s.settings.scheme {
        Scheme::Dfsph => step_dfsph(s, left),
        Scheme::Imm => step_imm(s, left),
        // Without memory the polymer is a Newtonian fluid: nothing to conform.
        Scheme::ImmCt if s.settings.cement.relaxation_time == 0.0 => step_imm(s, left),
        Scheme::ImmCt => step_imm_ct(s, left),
    }
}

/// One velocity, fractions that stay on their particles [DFSPH].
fn step_dfsph(s: &mut Stepper, left: f64) -> Result<(), SimError> {
    s.find_neighbours();
    s.refresh_mixture(false); //                                        Eqs 4, 5
    s.choose_step(left);
    s.open_books();
    match s.stress {
        StressStep::Explicit => {
            s.project(Source::Divergence);
            s.apply_gravity();
            s.apply_viscosity();
            s.project(Source::Volume);
        }
        StressStep::Coupled | StressStep::Auto => s.solve_newtonian(),
    }
    s.check("pressure")?;
    s.book_work();
    s.move_particles();
    s.check("the step")
}

/// Two phase velocities, Newtonian viscosity: implicit mixture model.
fn step_imm(s: &mut Stepper, left: f64) -> Result<(), SimError> {
    s.find_neighbours();
    s.refresh_mixture(false); //                                        Eqs 4, 5, 8
    s.choose_step(left);
    s.open_books();
    match s.stress {
        StressStep::Explicit => {
            s.project(Source::Divergence); //                           Eq. 6
            s.apply_gravity();
            s.apply_viscosity(); //                                     Eq. 7
            s.project(Source::Volume); //                               Eq. 6
        }
        StressStep::Coupled | StressStep::Auto => s.solve_newtonian(), //                  Eqs 6, 7
    }
    s.book_work();
    s.relax_slip();
    s.check("pressure")?;
    s.transfer_phases(); //                                             Eqs 8, 9
    s.check("phase transfer")?;
    s.book_exchange();
    s.move_particles();
    s.check("the step")
}

/// Implicit mixture model with conformation tensor: [IMM-CT] Algorithm 1 b).
fn step_imm_ct(s: &mut Stepper, left: f64) -> Result<(), SimError> {
    s.fluid.hold_conformation();
    s.find_neighbours();
    s.refresh_mixture(true); //                                         Eqs 4, 5, 8, 10
    s.refresh_gradient(); //                                            Eq. 2
    s.choose_step(left);
    s.open_books();
    match s.stress {
        StressStep::Explicit => {
            s.project(Source::Divergence); //                           Eq. 6
            s.apply_gravity();
            s.apply_polymer_stress(); //                                Eqs 12–16
            s.check_untamed("polymer stress")?;
            s.project(Source::Volume); //                               Eq. 6
        }
        StressStep::Coupled | StressStep::Auto => s.solve_viscoelastic(), //               Eqs 6, 12–16
    }
    s.book_work();
    s.relax_slip();
    s.check("pressure")?;
    s.transfer_phases(); //                                             Eqs 8, 9
    s.check("phase transfer")?;
    s.book_exchange();
    s.move_particles();
    s.check("the step")
}
