//! Turns triangles so that neighbours agree and all face outwards, whatever the file says.
//!
//! Triangles that share an edge with exactly one other agree along it: that fixes each patch up to one turn. Which
//! of the two it is, is asked of what stands around: a patch that is open belongs to the surface of the others, whose
//! winding number falls across it from the back to the front; a closed shell that nothing surrounds faces outwards;
//! one inside another keeps to the outer one the relation that it has in the file, so that a bubble stays a bubble.

use super::edges::Edges;
use super::winding::Winding;
use super::{TriMesh, pieces::Pieces};
use crate::math::{Aabb, Real, Vec3};
use std::collections::VecDeque;

/// What was turned.
#[derive(Clone, Debug, Default)]
pub(super) struct Turned {
    /// Triangles that were turned against their neighbours.
    pub some: usize,
    /// Whether the whole was inside out.
    pub all: bool,
}

/// Turns triangles of `mesh` in place.
pub(super) fn orient(mesh: &mut TriMesh) -> Turned {
    let count = mesh.triangles.len();
    let edges = Edges::of(mesh);
    let (mut turned, patch) = agree(&edges, count);
    let patches = patch.iter().max().map_or(0, |p| *p as usize + 1);

    // The file's own way is that of the greater part of a patch.
    let mut areas = vec![[0.0; 2]; patches];
    for t in 0..count {
        let area = mesh.area_normal(t).norm();
        areas[patch[t] as usize][usize::from(turned[t])] += area;
    }
    for t in 0..count {
        let [kept, other] = areas[patch[t] as usize];
        turned[t] ^= other > kept;
    }
    apply(mesh, &turned);
    let whole = face_outwards(mesh, &patch, patches);
    for t in 0..count {
        turned[t] ^= whole.patches[patch[t] as usize];
    }
    let mut flips = whole.patches;
    for flip in &mut flips {
        *flip ^= whole.all;
    }
    let now: Vec<bool> = patch.iter().map(|p| flips[*p as usize]).collect();
    apply(mesh, &now);
    Turned {
        some: turned.iter().filter(|turned| **turned).count(),
        all: whole.all,
    }
}

fn apply(mesh: &mut TriMesh, turned: &[bool]) {
    for (triangle, turn) in mesh.triangles.iter_mut().zip(turned) {
        if *turn {
            triangle.swap(1, 2);
        }
    }
}

/// Whether each triangle is to be turned to agree with the first of its patch, and which patch it belongs to.
fn agree(edges: &Edges, count: usize) -> (Vec<bool>, Vec<u32>) {
    let mut turned = vec![false; count];
    let mut patch = vec![u32::MAX; count];
    let neighbours = edges.neighbours(count);
    let mut patches = 0;
    let mut queue = VecDeque::new();
    for seed in 0..count {
        if patch[seed] != u32::MAX {
            continue;
        }
        patch[seed] = patches;
        queue.push_back(seed);
        while let Some(t) = queue.pop_front() {
            for &(other, opposed) in &neighbours[t] {
                let other = other as usize;
                if other != usize::MAX && patch.get(other) == Some(&u32::MAX) {
                    patch[other] = patches;
                    turned[other] = turned[t] ^ opposed;
                    queue.push_back(other);
                }
            }
        }
        patches += 1;
    }
    (turned, patch)
}

struct Outwards {
    /// Patches turned against the rest.
    patches: Vec<bool>,
    /// Whether then everything is turned.
    all: bool,
}

fn face_outwards(mesh: &TriMesh, patch: &[u32], patches: usize) -> Outwards {
    // Patches that touch along an edge of three or more triangles stand together: a bubble does not touch.
    let mut parts: Vec<Part> = (0..patches).map(|_| Part::default()).collect();
    for t in 0..mesh.triangles.len() {
        parts[patch[t] as usize].add(mesh, t);
    }
    let mut order: Vec<usize> = (0..patches).collect();
    order.sort_by(|a, b| parts[*b].area.total_cmp(&parts[*a].area).then(a.cmp(b)));
    let mut flips = vec![false; patches];
    let Some(&largest) = order.first() else {
        return Outwards {
            patches: flips,
            all: false,
        };
    };
    let all = parts[largest].volume < 0.0;
    if patches > 1 {
        let mut facing = mesh.clone();
        if all {
            facing = facing.flipped();
        }
        for &p in &order[1..] {
            let others = |t: usize| patch[t] as usize != p && parts[patch[t] as usize].area > 0.0;
            // Small patches see the large ones only: those are right already.
            let larger =
                |t: usize| others(t) && parts[patch[t] as usize].area >= parts[p].area.max(1e-300);
            flips[p] = faces_back(&facing, &parts[p], p, patch, all, larger);
            if flips[p] {
                for t in 0..facing.triangles.len() {
                    if patch[t] as usize == p {
                        facing.triangles[t].swap(1, 2);
                    }
                }
            }
        }
    }
    Outwards {
        patches: flips,
        all,
    }
}

/// Whether a patch shows its back to the outside.
fn faces_back(
    facing: &TriMesh,
    part: &Part,
    p: usize,
    patch: &[u32],
    all: bool,
    larger: impl Fn(usize) -> bool,
) -> bool {
    let Some(first) = (0..patch.len()).find(|t| patch[*t] as usize == p) else {
        return false;
    };
    let volume = if all { -part.volume } else { part.volume };
    let winding = Winding::new(facing, larger);
    let middle = facing.corners(first).iter().sum::<Vec3>() / 3.0;
    let open = part.normal.norm() > 0.05 * part.area;
    if open {
        let normal = if all { -part.normal } else { part.normal };
        let step = normal.normalize() * (part.bounds.extent().norm() * 0.5).max(1e-9);
        let centre = part.bounds.centre();
        let drop = winding.at(&(centre - step)) - winding.at(&(centre + step));
        if drop.abs() > 0.02 {
            return drop < 0.0;
        }
    }
    winding.at(&middle) < 0.5 && volume < 0.0
}

/// Sums over a patch.
struct Part {
    area: Real,
    normal: Vec3,
    /// Six times the volume about the first corner [m³].
    volume: Real,
    pivot: Option<Vec3>,
    bounds: Aabb,
}

impl Default for Part {
    fn default() -> Self {
        Self {
            area: 0.0,
            normal: Vec3::zeros(),
            volume: 0.0,
            pivot: None,
            bounds: Aabb::empty(),
        }
    }
}

impl Part {
    fn add(&mut self, mesh: &TriMesh, t: usize) {
        let corners = mesh.corners(t);
        let pivot = *self.pivot.get_or_insert(corners[0]);
        let [a, b, c] = corners.map(|corner| corner - pivot);
        self.volume += a.dot(&b.cross(&c));
        let normal = mesh.area_normal(t);
        self.area += normal.norm();
        self.normal += normal;
        for corner in &corners {
            self.bounds.include(corner);
        }
    }
}

/// Pieces that share an edge, of any kind.
pub(super) fn pieces(edges: &Edges, count: usize) -> Pieces {
    let mut pieces = Pieces::new(count);
    for around in edges.iter() {
        for pair in around.windows(2) {
            pieces.join(pair[0].triangle, pair[1].triangle);
        }
    }
    pieces
}
