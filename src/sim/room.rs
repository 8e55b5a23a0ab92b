//! Room for what is pressed in: an incompressible fluid cannot be pressed into a space that has no way out and is full.

use super::health::SimError;
use super::mover::Scenery;
use super::settings::{Inlet, SimSettings};
use crate::math::{Real, Vec3};
use std::collections::{HashSet, VecDeque};

type Cell = [i32; 3];

/// Refuses a scene where an inlet is to press more into a closed space than it has room for. The space is searched cell
/// by cell of a spacing, from the opening on, until it has room enough or a way out of the domain.
///
/// # Errors
/// [`SimError::NoRoom`].
pub fn require(
    settings: &SimSettings,
    around: &Scenery<'_>,
    start: &[Vec3],
) -> Result<(), SimError> {
    if settings.inlets.is_empty() {
        return Ok(());
    }
    let grid = Grid { settings, around };
    let full: HashSet<Cell> = start.iter().map(|x| grid.cell(x)).collect();
    let all: Real = settings.inlets.iter().map(|i| volume(settings, i)).sum();
    let cell = settings.spacing.powi(3);
    for inlet in &settings.inlets {
        let Some(space) = grid.closed_space(inlet, &full, (all / cell).ceil()) else {
            continue;
        };
        let room = space.difference(&full).count() as Real * cell;
        let sharing = settings.inlets.iter();
        let pressed: Real = sharing
            .filter(|other| space.contains(&grid.opening(other)))
            .map(|other| volume(settings, other))
            .sum();
        if pressed > room {
            return Err(SimError::NoRoom {
                inlet: inlet.name.clone(),
                pressed,
                room,
            });
        }
    }
    Ok(())
}

/// What an inlet presses in before the end [m³].
fn volume(settings: &SimSettings, inlet: &Inlet) -> Real {
    inlet.dose.min(inlet.flow_rate * settings.duration)
}

struct Grid<'a> {
    settings: &'a SimSettings,
    around: &'a Scenery<'a>,
}

impl Grid<'_> {
    fn cell(&self, x: &Vec3) -> Cell {
        let at = (x - self.settings.domain.min) / self.settings.spacing;
        [0, 1, 2].map(|a| at[a].floor() as i32)
    }

    fn centre(&self, cell: Cell) -> Vec3 {
        let at = Vec3::from_fn(|a, _| Real::from(cell[a]) + 0.5);
        self.settings.domain.min + at * self.settings.spacing
    }

    /// The first cell before an inlet's opening.
    fn opening(&self, inlet: &Inlet) -> Cell {
        self.cell(&(inlet.position + inlet.direction * self.settings.spacing))
    }

    /// The space that an inlet opens into, fluid and empty, if it is closed and holds fewer than `enough` empty cells.
    fn closed_space(
        &self,
        inlet: &Inlet,
        full: &HashSet<Cell>,
        enough: Real,
    ) -> Option<HashSet<Cell>> {
        let (domain, dx) = (self.settings.domain, self.settings.spacing);
        let count = domain.extent().map(|e| (e / dx).ceil() as i32);
        // The piston stands behind the opening.
        let behind = |x: &Vec3| {
            let from = x - inlet.position;
            let along = from.dot(&inlet.direction);
            let across = (from - inlet.direction * along).norm();
            (-2.0 * dx..0.0).contains(&along) && across < 0.5 * inlet.diameter + 2.0 * dx
        };
        let first = self.opening(inlet);
        let mut space = HashSet::from([first]);
        let mut edge = VecDeque::from([first]);
        let mut empty = Real::from(u8::from(!full.contains(&first)));
        while let Some(cell) = edge.pop_front() {
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut next = cell;
                next[axis] += step;
                if !(0..count[axis]).contains(&next[axis]) {
                    if !self.settings.periodic[axis] {
                        return None;
                    }
                    next[axis] = next[axis].rem_euclid(count[axis]);
                }
                let x = self.centre(next);
                if space.contains(&next) || behind(&x) || self.around.distance(&x).0 <= 0.0 {
                    continue;
                }
                space.insert(next);
                edge.push_back(next);
                empty += Real::from(u8::from(!full.contains(&next)));
                if empty >= enough {
                    return None;
                }
            }
        }
        Some(space)
    }
}
