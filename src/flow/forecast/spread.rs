//! Where cement gets to before anything is simulated: open cells in the order of their way from an opening.

use crate::math::{Real, Vec3};
use crate::sim::{Inlet, SimSettings};
use crate::solid::Solid;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap, HashSet};

pub(super) type Cell = [i32; 3];

/// Particles keep this far off the walls, in spacings.
const CLEARANCE: Real = 0.25;

/// Cells of a spacing in the domain, and which of them are open.
pub(super) struct Cells<'a> {
    sim: &'a SimSettings,
    solid: &'a Solid,
    open: HashMap<Cell, bool>,
}

/// An open cell that was come to.
pub(super) struct Reached {
    pub cell: Cell,
    /// Its middle [m].
    pub x: Vec3,
    /// Length of the way there [m].
    pub way: Real,
    /// Whether it lies at the edge of the domain.
    pub at_edge: bool,
}

impl<'a> Cells<'a> {
    pub fn new(sim: &'a SimSettings, solid: &'a Solid) -> Self {
        Self {
            sim,
            solid,
            open: HashMap::new(),
        }
    }

    pub fn of(&self, x: &Vec3) -> Cell {
        let at = (x - self.sim.domain.min) / self.sim.spacing;
        [0, 1, 2].map(|a| at[a].floor() as i32)
    }

    fn middle(&self, cell: Cell) -> Vec3 {
        let at = Vec3::from_fn(|a, _| Real::from(cell[a]) + 0.5);
        self.sim.domain.min + at * self.sim.spacing
    }

    fn is_open(&mut self, cell: Cell, inlet: &Inlet) -> bool {
        let x = self.middle(cell);
        let (solid, spacing) = (self.solid, self.sim.spacing);
        let open = *(self.open.entry(cell)).or_insert_with(|| solid.phi(&x) > CLEARANCE * spacing);
        // The piston stands behind the opening.
        let from = x - inlet.position;
        let along = from.dot(&inlet.direction);
        let across = (from - inlet.direction * along).norm();
        let behind =
            (-2.0 * spacing..0.0).contains(&along) && across < 0.5 * inlet.diameter + 2.0 * spacing;
        open && !behind
    }

    /// Visits open cells by the way that leads to them through open cells, the nearest first, until `each` says
    /// that it is enough.
    pub fn visit(&mut self, inlet: &Inlet, mut each: impl FnMut(Reached) -> bool) {
        let dx = self.sim.spacing;
        let count = self.sim.domain.extent().map(|e| (e / dx).ceil() as i32);
        let first = self.of(&(inlet.position + inlet.direction * dx));
        let mut edge = BinaryHeap::from([Step {
            way: 0.0,
            cell: first,
        }]);
        let mut done = HashSet::new();
        while let Some(Step { way, cell }) = edge.pop() {
            if !done.insert(cell) {
                continue;
            }
            let mut at_edge = false;
            for offset in NEIGHBOURS {
                let mut next = cell;
                let mut leaves = false;
                for axis in 0..3 {
                    next[axis] += offset[axis];
                    if (0..count[axis]).contains(&next[axis]) {
                        continue;
                    }
                    if self.sim.periodic[axis] {
                        next[axis] = next[axis].rem_euclid(count[axis]);
                    } else {
                        leaves = true;
                    }
                }
                let straight = offset.iter().filter(|o| **o != 0).count();
                if leaves {
                    at_edge |= straight == 1;
                    continue;
                }
                // Across an edge only where both ways round it are open: no way slips between two solids.
                let round = |axis: usize| {
                    let mut corner = cell;
                    corner[axis] = next[axis];
                    corner
                };
                let turns = (0..3).filter(|&axis| straight == 2 && offset[axis] != 0);
                let passes = self.is_open(next, inlet)
                    && turns.map(round).all(|corner| self.is_open(corner, inlet));
                if passes && !done.contains(&next) {
                    let length = dx * (straight as Real).sqrt();
                    edge.push(Step {
                        way: way + length,
                        cell: next,
                    });
                }
            }
            let reached = Reached {
                cell,
                x: self.middle(cell),
                way,
                at_edge,
            };
            if !each(reached) {
                return;
            }
        }
    }
}

/// Across faces and across edges.
const NEIGHBOURS: [Cell; 18] = [
    [-1, 0, 0],
    [1, 0, 0],
    [0, -1, 0],
    [0, 1, 0],
    [0, 0, -1],
    [0, 0, 1],
    [-1, -1, 0],
    [-1, 1, 0],
    [1, -1, 0],
    [1, 1, 0],
    [-1, 0, -1],
    [-1, 0, 1],
    [1, 0, -1],
    [1, 0, 1],
    [0, -1, -1],
    [0, -1, 1],
    [0, 1, -1],
    [0, 1, 1],
];

/// A cell to be visited; the shortest way first.
struct Step {
    way: Real,
    cell: Cell,
}

impl Ord for Step {
    fn cmp(&self, other: &Self) -> Ordering {
        (other.way.total_cmp(&self.way)).then_with(|| other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Step {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Step {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::scene;
    use crate::solid::Shape;
    use std::path::Path;

    /// Two rooms of a box 20 mm long, with a wall between them that ends short of the ceiling.
    #[test]
    fn cells_are_visited_by_the_way_that_leads_to_them() {
        let text = include_str!("../../../pipeline/vertebra.toml");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipeline");
        let (_, scene) = scene::read("r.toml", text, &folder, &[]).unwrap();
        let mut sim = scene.sim;
        let box_of = |min: [Real; 3], max: [Real; 3]| [min, max].map(|p| Vec3::from(p) * 1e-3);
        let [min, max] = box_of([0.0; 3], [20.0, 8.0, 10.0]);
        sim.spacing = 1e-3;
        sim.domain = Aabb { min, max };
        let mut inlet = sim.inlets[0].clone();
        inlet.position = Vec3::new(4.5, 4.5, 1.5) * 1e-3;
        inlet.direction = Vec3::z();
        inlet.diameter = 1e-3;
        let [min, max] = box_of([9.0, -1.0, -1.0], [11.0, 9.0, 7.0]);
        let hollow = false;
        let solid = Solid {
            shapes: vec![Shape::Box { min, max, hollow }],
            grids: Vec::new(),
        };
        let mut seen = Vec::new();
        Cells::new(&sim, &solid).visit(&inlet, |reached| {
            seen.push((reached.x, reached.way, reached.at_edge));
            true
        });
        assert!(seen.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        // Over the wall it is farther than through it.
        let beyond = seen
            .iter()
            .find(|(x, ..)| (x - Vec3::new(12.5, 4.5, 2.5) * 1e-3).norm() < 1e-9);
        let straight = 8e-3;
        assert!(
            beyond.is_some_and(|(_, way, _)| *way > straight + 4e-3),
            "{beyond:?}"
        );
        assert!(seen.iter().all(|(x, ..)| solid.phi(x) > 0.0));
        let edge = |x: &Vec3| (0..3).any(|a| x[a] < 1e-3 || x[a] > sim.domain.max[a] - 1e-3);
        assert!(seen.iter().all(|(x, _, at_edge)| edge(x) == *at_edge));
    }
}
