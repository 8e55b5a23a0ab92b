//! Time step, frames, periodic axes and the material.

use super::check::Checker;
use crate::math::{Aabb, Real};
use crate::scene::recipe::{Axis, Bonding, Modulus, PhaseRecipe, Recipe};
use crate::sim::{Cement, PhaseMaterial, SimSettings, TimeStep};
use crate::units::Time;

/// File names hold four digits.
const MOST_FRAMES: Real = 9999.0;

pub(super) fn time_step(c: &mut Checker<'_>, recipe: &Recipe) -> TimeStep {
    let step = &recipe.time_step;
    if let Some(fixed) = step.fixed {
        let alone = step.min.is_none() && step.max.is_none() && step.cfl.is_none();
        c.require(alone, "time_step", "give either fixed, or min, max and cfl");
        c.require(
            fixed <= recipe.duration,
            "time_step.fixed",
            "is longer than the duration",
        );
        return TimeStep::Fixed(c.positive("time_step.fixed", fixed.si()));
    }
    let (min, max, cfl) = step.limits();
    c.require(min <= max, "time_step.min", "is above time_step.max");
    TimeStep::Adaptive {
        min: c.positive("time_step.min", min.si()),
        max: c.positive("time_step.max", max.si()),
        cfl: c.within("time_step.cfl", cfl, 0.01..=1.0),
    }
}

pub(super) fn frames(c: &mut Checker<'_>, sim: &SimSettings) {
    let frames = sim.duration * sim.frames_per_second;
    if frames > MOST_FRAMES {
        let message = format!(
            "with this duration gives {frames:.1e} frames, at most {MOST_FRAMES:.0e} are allowed"
        );
        c.error("frames_per_second", message);
    } else if frames < 1.0 {
        c.error(
            "frames_per_second",
            "with this duration gives no frame after the start",
        );
    }
}

/// Neighbours must not be met twice around the ring, and the lattice must close.
pub(super) fn periodic(c: &mut Checker<'_>, recipe: &Recipe, domain: &Aabb) -> [bool; 3] {
    let mut periodic = [false; 3];
    let spacing = recipe.spacing.si();
    for axis in &recipe.periodic {
        let n = match axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        c.require(!periodic[n], "periodic", "names an axis twice");
        periodic[n] = true;
        let along = domain.extent()[n] / spacing;
        let least = 2.0 * recipe.support_ratio + 1.0;
        if along < least {
            let message = format!(
                "is {along:.2} spacings long on a periodic axis, {least:.2} are needed (two support radii and one)"
            );
            c.error("domain", message);
        }
        if (along - along.round()).abs() > 1e-6 * along {
            let message = format!("is {along:.3} spacings long on a periodic axis: make it whole");
            c.error("domain", message);
        }
    }
    periodic
}

pub(super) fn cement(c: &mut Checker<'_>, recipe: &Recipe) -> Cement {
    let cement = &recipe.cement;
    let mut phase = |name: &str, phase: &PhaseRecipe| PhaseMaterial {
        density: c.positive(&format!("cement.{name}.density"), phase.density.si()),
        viscosity: c.positive(&format!("cement.{name}.viscosity"), phase.viscosity.si()),
    };
    let liquid = phase("liquid", &cement.liquid);
    let polymer = phase("polymer", &cement.polymer);
    let slip_relaxation = cement.slip_relaxation.0.map(Time::si);
    if let Some(time) = slip_relaxation {
        c.positive("cement.slip_relaxation", time);
    }
    let at_least_zero = |c: &mut Checker<'_>, key: &str, value: Real| {
        c.require(value >= 0.0, key, "must not be below zero");
        value
    };
    Cement {
        liquid,
        polymer,
        relaxation_time: c.positive("cement.relaxation_time", cement.relaxation_time.si()),
        thinning: at_least_zero(c, "cement.thinning", cement.thinning.si()),
        rest_drag: c.within("cement.rest_drag", cement.rest_drag, 0.0..=1.0),
        diffusion: at_least_zero(c, "cement.diffusion", cement.diffusion.si()),
        normalised_bonding: cement.bonding == Bonding::Normalised,
        literal_modulus: cement.modulus == Modulus::Literal,
        slip_relaxation,
    }
}
