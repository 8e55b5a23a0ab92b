//! Inlets: rows of particles that a piston pushes through a round opening at an exact rate.
//!
//! Rows stand behind the opening at equal distances and move with the speed Q/A. They are walls to the fluid until
//! they reach the opening; there they become fluid. A row of N particles is N V₀/A thick, so particles and
//! piston carry the same volume.

use super::settings::Inlet;
use crate::math::{Real, Vec3};
use crate::sph::MovingWalls;

/// An inlet in the course of time. State.
#[derive(Clone, Debug)]
pub struct InletState {
    /// What it was told.
    pub settings: Inlet,
    /// Places of a row in the plane of the opening, relative to its centre [m].
    pub places: Vec<Vec3>,
    /// Distance between rows [m].
    pub row_distance: Real,
    /// How far the piston has come since the last row became fluid [m].
    pub travelled: Real,
    /// Volume that the piston has pushed [m³].
    pub pushed: Real,
    /// Volume that has become fluid [m³].
    pub emitted: Real,
    /// Pressure against the piston: its power per volume pushed [Pa].
    pub pressure: Real,
}

impl InletState {
    /// An inlet that has not started.
    pub fn new(settings: Inlet, spacing: Real, rest_volume: Real) -> Self {
        let places = disc(&settings.direction, 0.5 * settings.diameter, spacing);
        let area = 0.25 * core::f64::consts::PI * settings.diameter * settings.diameter;
        let row_distance = places.len() as Real * rest_volume / area;
        // The first row is fluid at once: half a row stands before the opening.
        Self {
            settings,
            places,
            row_distance,
            travelled: row_distance,
            pushed: 0.0,
            emitted: 0.0,
            pressure: 0.0,
        }
    }

    /// Speed of the piston [m/s]: 0 once the dose is in.
    pub fn speed(&self) -> Real {
        if self.pushed >= self.settings.dose {
            return 0.0;
        }
        let area = 0.25 * core::f64::consts::PI * self.settings.diameter * self.settings.diameter;
        self.settings.flow_rate / area
    }

    /// Largest step that does not push more than the dose [s].
    pub fn most_step(&self) -> Real {
        let left = self.settings.dose - self.pushed;
        if left > 0.0 {
            left / self.settings.flow_rate
        } else {
            Real::INFINITY
        }
    }

    /// Moves the piston for `dt` [s].
    pub fn advance(&mut self, dt: Real) {
        let speed = self.speed();
        self.travelled += speed * dt;
        if speed > 0.0 {
            self.pushed += self.settings.flow_rate * dt;
            // Rounding must not leave an immeasurable rest that would cost a step.
            if self.settings.dose - self.pushed < 1e-9 * self.settings.dose {
                self.pushed = self.settings.dose;
            }
        }
    }

    /// Positions of a row that reaches the opening now, if one does.
    pub fn emit(&mut self, rest_volume: Real) -> Option<Vec<Vec3>> {
        if self.travelled < self.row_distance || self.speed() == 0.0 {
            return None;
        }
        self.travelled -= self.row_distance;
        self.emitted += rest_volume * self.places.len() as Real;
        Some(self.row(self.travelled))
    }

    /// Adds the rows behind the opening that lie within `reach` [m] of it, particles of `volume` [m³], as those of
    /// inlet `number`.
    pub fn stand(&self, number: u16, reach: Real, volume: Real, walls: &mut MovingWalls) {
        let velocity = self.settings.direction * self.speed();
        let mut behind = self.travelled - self.row_distance;
        while behind > -reach - self.row_distance {
            for position in self.row(behind) {
                walls.push_piston(number, position, velocity, volume);
            }
            behind -= self.row_distance;
        }
    }

    fn row(&self, along: Real) -> Vec<Vec3> {
        let centre = self.settings.position + self.settings.direction * along;
        self.places.iter().map(|place| centre + place).collect()
    }
}

/// Evenly filled disc across `axis`: rings one spacing apart, half a spacing off the rim, with or without a
/// particle in the middle, whichever fits the radius better.
fn disc(axis: &Vec3, radius: Real, spacing: Real) -> Vec<Vec3> {
    let helper = if axis.x.abs() < 0.9 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let u = (helper - axis * helper.dot(axis)).normalize();
    let v = axis.cross(&u);
    let halves = (2.0 * radius / spacing).round().max(1.0) as usize;
    let half = radius / halves as Real;
    let mut places = Vec::new();
    if halves % 2 == 1 {
        places.push(Vec3::zeros());
    }
    let first = if halves % 2 == 1 { 2 } else { 1 };
    for ring in (first..halves).step_by(2) {
        let r = half * ring as Real;
        // 3 a half ring: as dense along the ring as across.
        let count = 3 * ring;
        for k in 0..count {
            let angle =
                core::f64::consts::TAU * (k as Real + 0.5 * (ring / 2 % 2) as Real) / count as Real;
            places.push(u * (r * libm::cos(angle)) + v * (r * libm::sin(angle)));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inlet(diameter: Real) -> Inlet {
        Inlet {
            name: "needle".into(),
            position: Vec3::zeros(),
            direction: Vec3::z(),
            diameter,
            flow_rate: 2e-7,
            polymer_fraction: 0.5,
            dose: 1e-8,
        }
    }

    #[test]
    fn rows_are_as_dense_as_the_lattice_and_keep_off_the_rim() {
        let spacing: Real = 0.5e-3;
        for diameter in [1.6e-3, 1.8e-3, 2.39e-3, 2.69e-3, 3.43e-3, 6e-3] {
            let state = InletState::new(inlet(diameter), spacing, spacing.powi(3));
            assert!(
                (state.row_distance / spacing - 1.0).abs() < 0.2,
                "{diameter} {}",
                state.row_distance
            );
            for (a, p) in state.places.iter().enumerate() {
                assert!(p.norm() < 0.5 * diameter - 0.35 * spacing);
                for q in &state.places[..a] {
                    assert!((p - q).norm() > 0.7 * spacing, "{diameter}");
                }
            }
        }
    }

    #[test]
    fn pushes_the_dose_and_not_more() {
        let spacing: Real = 0.5e-3;
        let rest_volume = spacing.powi(3);
        let mut state = InletState::new(inlet(2.39e-3), spacing, rest_volume);
        let (mut time, mut rows) = (0.0, 0);
        while state.speed() > 0.0 {
            let dt = state.most_step().min(1.7e-3);
            state.advance(dt);
            time += dt;
            while state.emit(rest_volume).is_some() {
                rows += 1;
            }
        }
        assert!((time - 0.05).abs() < 1e-12);
        assert_eq!(state.pushed, 1e-8);
        let row = rest_volume * state.places.len() as Real;
        assert!((Real::from(rows) * row - state.emitted).abs() < 1e-20);
        assert!((state.emitted - state.pushed).abs() <= row);
    }
}
