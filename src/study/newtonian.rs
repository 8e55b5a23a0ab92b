//! How far a memory takes the tank's polymer from the Newtonian fluid of its viscosity: a shear wave u = U cos(k y) falls
//! as e^{−ν k² t} there, and here as the scheme lets it, at its step.

use super::StudyError;
use super::scenes::{body, boxed, flowing, settings, viscoelastic};
use crate::math::{Real, Vec3, ordered_sum};
use crate::sim::{BodyShape, Scheme, StressStep, TimeStep};
use serde::Serialize;
use std::f64::consts::TAU;

/// A wave in one fluid, stepped in one way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wave {
    /// Which list of terms a step is.
    pub scheme: Scheme,
    /// How stress is stepped.
    pub stress: StressStep,
    /// ρ [kg/m³].
    pub density: Real,
    /// Viscosity of the solvent [Pa·s]; none of its own without a memory.
    pub solvent: Real,
    /// Viscosity of the polymer [Pa·s].
    pub polymer: Real,
    /// λ [s].
    pub relaxation_time: Real,
    /// γ [1/s].
    pub thinning: Real,
    /// Distance between particles [m].
    pub spacing: Real,
    /// Fixed step [s].
    pub step: Real,
    /// U [m/s].
    pub speed: Real,
    /// Until when it is watched at most [s].
    pub longest: Real,
}

/// Wavelength, and breadth of the box, in spacings.
const LENGTH: Real = 16.0;
const BREADTH: Real = 7.0;

impl Wave {
    /// Largest difference of the amplitude from e^{−ν k² t}, of that at the start, after every step until that has fallen
    /// to 1/e; none if the scheme falls over.
    pub fn error(&self, name: &str) -> Result<Option<Real>, StudyError> {
        let dx = self.spacing;
        let bounds = boxed(Vec3::new(BREADTH, LENGTH, BREADTH) * dx);
        let mut s = settings(dx, bounds);
        s.scheme = self.scheme;
        s.stress = self.stress;
        s.periodic = [true; 3];
        s.bodies = vec![body(BodyShape::Box(bounds), 1.0)];
        s.time_step = TimeStep::Fixed(self.step);
        s.cement = viscoelastic(
            self.density,
            self.solvent,
            self.polymer,
            self.relaxation_time,
            self.thinning,
        );
        let wavenumber = TAU / (LENGTH * dx);
        let shape = |x: &Vec3| libm::cos(wavenumber * x.y);
        let mut simulation = flowing(name, s, |x| Vec3::x() * (self.speed * shape(x)))?;
        let viscosity = match self.scheme {
            Scheme::ImmCt => self.solvent + self.polymer,
            Scheme::Dfsph | Scheme::Imm => self.polymer,
        };
        let rate = viscosity / self.density * wavenumber * wavenumber;
        // At least a step, whole ones: a shorter last one would be another scheme.
        let steps = (self.longest.min(1.0 / rate) / self.step).round().max(1.0) as u64;
        let mut worst: Real = 0.0;
        for _ in 0..steps {
            if simulation.step_towards(Real::INFINITY).is_err() {
                return Ok(None);
            }
            let velocity = simulation.velocity();
            let n = velocity.len();
            let sum = ordered_sum(n, |i| velocity[i].x * shape(&simulation.fluid.position[i]));
            let amplitude = 2.0 * sum / (n as Real * self.speed);
            worst = worst.max((amplitude - libm::exp(-rate * simulation.time)).abs());
        }
        Ok(Some(worst))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(scheme: Scheme, relaxation_time: Real, step: Real) -> Real {
        let wave = Wave {
            scheme,
            stress: StressStep::Coupled,
            density: 1180.0,
            solvent: 0.01,
            polymer: 1.0,
            relaxation_time,
            thinning: 0.5,
            spacing: 2e-3,
            step,
            speed: 0.1,
            longest: 1.0,
        };
        wave.error("wave").expect("a scene").expect("stable")
    }

    /// Of the first order in λ ν k² (0.013 and 1.6 here), beside what step and spacing do to the Newtonian wave itself.
    #[test]
    fn a_short_memory_comes_near_the_newtonian_answer_and_a_long_one_does_not() {
        let [newtonian, short, long] = [
            wave(Scheme::Imm, 0.0, 4e-4),
            wave(Scheme::ImmCt, 4e-4, 4e-4),
            wave(Scheme::ImmCt, 0.05, 4e-4),
        ];
        assert!(newtonian < 0.02, "{newtonian}");
        assert!(short < 0.04, "{short}");
        assert!(long > 0.3, "{long}");
    }
}
