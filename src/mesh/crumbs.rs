//! Crumbs of a surface: small closed pieces beside it and small bubbles in it, as noise at the threshold leaves them
//! in the surface of a scan.

use super::edges::Edges;
use super::{MeshDistance, TriMesh, orient};
use crate::math::Real;

/// What was dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crumbs {
    /// Pieces outside everything else.
    pub isles: usize,
    /// Their volume, in that of the mesh [1].
    pub of_isles: Real,
    /// Bubbles inside it.
    pub bubbles: usize,
    /// Their volume, in that of the mesh [1].
    pub of_bubbles: Real,
}

impl std::fmt::Display for Crumbs {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let of = |count, what, share: Real| {
            (count > 0).then(|| format!("{count} {what} ({:.2} % of the volume)", share * 100.0))
        };
        let isles = of(self.isles, "loose pieces", self.of_isles);
        let bubbles = of(self.bubbles, "bubbles", self.of_bubbles);
        let told: Vec<String> = isles.into_iter().chain(bubbles).collect();
        write!(f, "{} were dropped as noise", told.join(" and "))
    }
}

/// `mesh`, as [`super::repaired`] leaves it, without closed pieces that enclose less than `least` of its volume [1] and
/// lie wholly outside or are bubbles wholly inside. What touches the rest or passes through it stays.
pub fn without_crumbs(mesh: TriMesh, least: Real) -> (TriMesh, Crumbs) {
    let count = mesh.triangles.len();
    let edges = Edges::of(&mesh);
    let mut pieces = orient::pieces(&edges, count);
    let root: Vec<usize> = (0..count as u32).map(|t| pieces.root(t) as usize).collect();
    // By root: six times the volume, and whether every edge has its two sides.
    let mut volume = vec![0.0; count];
    let mut closed = vec![true; count];
    for t in 0..count {
        let pivot = mesh.corners(root[t])[0];
        let [a, b, c] = mesh.corners(t).map(|corner| corner - pivot);
        volume[root[t]] += a.dot(&b.cross(&c));
    }
    for around in edges.iter() {
        let whole = matches!(around, [a, b] if a.forward != b.forward);
        closed[root[around[0].triangle as usize]] &= whole;
    }
    let total = 6.0 * mesh.signed_volume();
    let small = |piece: usize| closed[piece] && volume[piece].abs() < least * total;
    if !root.iter().any(|piece| small(*piece)) {
        return (mesh, Crumbs::default());
    }
    let part = |wanted: &dyn Fn(usize) -> bool| TriMesh {
        positions: mesh.positions.clone(),
        triangles: (0..count)
            .filter(|&t| wanted(root[t]))
            .map(|t| mesh.triangles[t])
            .collect(),
    };
    let rest = MeshDistance::new(&part(&|piece| !small(piece)));
    let mut dropped: Vec<bool> = (0..count).map(small).collect();
    for t in 0..count {
        let piece = root[t];
        if dropped[piece] {
            let inside = volume[piece] < 0.0;
            dropped[piece] = (mesh.corners(t).iter()).all(|x| (rest.signed(x) < 0.0) == inside);
        }
    }
    let mut crumbs = Crumbs::default();
    for piece in (0..count).filter(|&t| root[t] == t && dropped[t]) {
        let share = volume[piece] / total;
        if share < 0.0 {
            crumbs.bubbles += 1;
            crumbs.of_bubbles -= share;
        } else {
            crumbs.isles += 1;
            crumbs.of_isles += share;
        }
    }
    (part(&|piece| !dropped[piece]), crumbs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::mesh::tests::cuboid;

    #[test]
    fn only_what_is_small_closed_and_apart_is_dropped() {
        let cube = |at: [Real; 3], edge: Real| {
            let low = Vec3::from(at);
            cuboid(low, low.add_scalar(edge))
        };
        let body = cube([0.0; 3], 1.0);
        let mut kept = body.clone();
        // Through the surface; large and apart; a large bubble; small and apart, but open.
        kept.append(&cube([0.95; 3], 0.1));
        kept.append(&cube([2.0; 3], 0.3));
        kept.append(&cube([0.6; 3], 0.25).flipped());
        let mut open = cube([-1.0; 3], 0.1);
        open.triangles.pop();
        kept.append(&open);
        let mut mesh = kept.clone();
        mesh.append(&cube([1.2, 0.5, 0.5], 0.1));
        mesh.append(&cube([0.2; 3], 0.1).flipped());
        mesh.append(&cube([0.2, 0.2, 0.7], 0.05).flipped());
        let total = mesh.signed_volume();
        let (found, crumbs) = without_crumbs(mesh, 0.01);
        assert_eq!(found.triangles, kept.triangles);
        assert_eq!((crumbs.isles, crumbs.bubbles), (1, 2));
        assert!((crumbs.of_isles * total / 1e-3 - 1.0).abs() < 1e-9);
        assert!((crumbs.of_bubbles * total / 1.125e-3 - 1.0).abs() < 1e-9);

        let told = crumbs.to_string();
        assert!(told.contains("1 loose pieces (0.") && told.contains("and 2 bubbles (0."));

        let (same, none) = without_crumbs(kept.clone(), 1e-4);
        assert_eq!((same, none), (kept, Crumbs::default()));
    }
}
