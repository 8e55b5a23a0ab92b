//! What moves: volume between phases, particles with the mixture, past walls that may move themselves, pistons,
//! and rows that become fluid.

use super::contact::{MOST_DEPTH, beside_all};
use super::settings::StressStep;
use super::stepper::Stepper;
use crate::fluid::transfer;
use crate::sph::PressureOperator;
use rayon::prelude::*;

impl Stepper<'_> {
    /// Eqs 8, 9: volume and momentum move between the phases of neighbours.
    pub fn transfer_phases(&mut self) {
        if self.mixes() {
            transfer::advance(&self.settings.cement, self.fluid, self.near, self.dt);
        } else {
            transfer::unite_vanished_phases(&self.settings.cement, self.fluid);
        }
        self.mix.refresh_velocity(self.fluid);
    }

    /// x ← x + dt v_mix, and who meets a wall keeps no velocity into it; pistons advance and their rows become fluid.
    pub fn move_particles(&mut self) {
        let dt = self.dt;
        let shift = self.shift();
        let mut velocity = self.carrying_velocity();
        if self.stress != StressStep::Explicit {
            let each = velocity.par_iter_mut().enumerate().with_min_len(128);
            each.for_each(|(i, v)| *v += self.bend(i));
        }
        let (near, domain) = (&self.near, self.domain);
        let before = self.around.at(self.time);
        let after = self.around.at(self.time + dt);
        let most_depth = MOST_DEPTH * self.settings.spacing;
        let mixed = &self.mix.velocity;
        self.fluid
            .position
            .par_iter_mut()
            .zip(&mut self.fluid.phase_velocity)
            .enumerate()
            .with_min_len(128)
            .for_each(|(i, (x, phases))| {
                let aim = *x + velocity[i] * dt + shift[i];
                if near.wall.row(i).is_empty() {
                    *x = domain.wrapped(aim);
                    return;
                }
                let (kept, wall) = beside_all(&before, &after, x, aim, most_depth);
                let way = kept - aim;
                if let Some(outward) = way.try_normalize(0.0) {
                    let into = (wall / dt - mixed[i]).dot(&outward);
                    let stopped = outward * into.clamp(0.0, way.norm() / dt);
                    phases.liquid += stopped;
                    phases.polymer += stopped;
                }
                *x = domain.wrapped(kept);
            });
        self.book_shift();
        self.measure_inlet_pressure();
        let rest_volume = self.near.rest_volume;
        let mut next_id = self.fluid.id.iter().max().map_or(0, |id| id + 1);
        for (number, inlet) in self.inlets.iter_mut().enumerate() {
            inlet.advance(dt);
            while let Some(row) = inlet.emit(rest_volume) {
                let velocity = inlet.settings.direction * inlet.speed();
                for position in row {
                    self.fluid.push(
                        position,
                        velocity,
                        inlet.settings.polymer_fraction,
                        next_id,
                        number as u16 + 1,
                    );
                    if let Some(pressure) = self.fluid.pressure.last_mut() {
                        pressure[0] = inlet.pressure;
                    }
                    next_id += 1;
                }
            }
        }
    }

    /// What the fluid presses against each piston with.
    fn measure_inlet_pressure(&mut self) {
        let operator = PressureOperator { near: self.near };
        let pressure = self.fluid.multiplier(0);
        for (number, inlet) in self.inlets.iter_mut().enumerate() {
            inlet.pressure = operator.piston_pressure(number as u16, &pressure);
        }
    }
}
