//! Closes holes: finds their rims and spans each with the triangles of least area.
//!
//! Least area over all triangulations of a rim is found by dynamic programming over its parts [Barequet95]; a rim too
//! long for that gets a fan around its middle.

use super::TriMesh;
use super::edges::Edges;
use crate::math::{Real, Vec3};
use std::collections::BTreeMap;

/// Rims of more vertices than this get a fan: the search grows with the third power.
const LONGEST: usize = 320;

/// Adds triangles over every hole, and says how many holes there were and the area [m²] that was added.
///
/// Where rims cross, or triangles around a hole disagree, some of it may stay open.
pub(super) fn close(mesh: &mut TriMesh) -> (usize, Real) {
    let first = mesh.triangles.len();
    let mut holes = 0;
    for rim in rims(mesh) {
        holes += 1;
        if rim.len() <= LONGEST {
            span(mesh, &rim);
        } else {
            fan(mesh, &rim);
        }
    }
    let added = first..mesh.triangles.len();
    (holes, added.map(|t| 0.5 * mesh.area_normal(t).norm()).sum())
}

/// Closed walks along open edges, against the direction of the triangles there.
fn rims(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for around in Edges::of(mesh).iter() {
        if let [side] = around {
            let (from, to) = if side.forward {
                (side.high, side.low)
            } else {
                (side.low, side.high)
            };
            next.entry(from).or_default().push(to);
        }
    }
    let mut rims = Vec::new();
    while let Some((&start, _)) = next.iter().find(|(_, ways)| !ways.is_empty()) {
        let mut walk = vec![start];
        loop {
            let here = walk[walk.len() - 1];
            let Some(to) = next.get_mut(&here).and_then(Vec::pop) else {
                // A dead end: the triangles around disagree here.
                break;
            };
            if let Some(at) = walk.iter().position(|v| *v == to) {
                // A loop closes: what it leaves of the walk goes on.
                let rim = walk.split_off(at);
                if rim.len() >= 3 {
                    rims.push(rim);
                }
                if walk.is_empty() {
                    break;
                }
                walk.push(to);
            } else {
                walk.push(to);
            }
        }
        next.retain(|_, ways| !ways.is_empty());
    }
    rims
}

fn span(mesh: &mut TriMesh, rim: &[u32]) {
    let n = rim.len();
    let at: Vec<Vec3> = rim.iter().map(|v| mesh.positions[*v as usize]).collect();
    let area = |i: usize, j: usize, k: usize| (at[j] - at[i]).cross(&(at[k] - at[i])).norm();
    // Least area over the part of the rim from i to j, and the third corner over the chord i j.
    let mut least = vec![0.0; n * n];
    let mut third = vec![0_usize; n * n];
    for length in 2..n {
        for i in 0..n - length {
            let j = i + length;
            let mut best = (Real::INFINITY, i + 1);
            for k in i + 1..j {
                let sum = least[i * n + k] + least[k * n + j] + area(i, k, j);
                if sum < best.0 {
                    best = (sum, k);
                }
            }
            (least[i * n + j], third[i * n + j]) = best;
        }
    }
    let mut parts = vec![(0, n - 1)];
    while let Some((i, j)) = parts.pop() {
        if j < i + 2 {
            continue;
        }
        let k = third[i * n + j];
        mesh.triangles.push([rim[i], rim[k], rim[j]]);
        parts.extend([(i, k), (k, j)]);
    }
}

fn fan(mesh: &mut TriMesh, rim: &[u32]) {
    let sum: Vec3 = rim.iter().map(|v| mesh.positions[*v as usize]).sum();
    let middle = mesh.positions.len() as u32;
    mesh.positions.push(sum / rim.len() as Real);
    for (i, &v) in rim.iter().enumerate() {
        let after = rim[(i + 1) % rim.len()];
        mesh.triangles.push([v, after, middle]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{inspect, tests::cuboid, tests::torus};

    #[test]
    fn lids_come_back_where_they_were() {
        // Two triangles at a corner of a box: the rim is not flat, yet the least area is the box's own.
        let whole = cuboid(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0));
        for missing in [vec![0], vec![0, 1], vec![0, 5, 7]] {
            let mut mesh = whole.clone();
            for &t in missing.iter().rev() {
                mesh.triangles.remove(t);
            }
            let (_, area) = close(&mut mesh);
            assert!(area > 0.0 && inspect(&mesh).is_closed(), "{missing:?}");
            assert!((mesh.signed_volume() - 6.0).abs() < 1e-12, "{missing:?}");
        }
    }

    #[test]
    fn many_small_holes_in_a_torus_are_closed() {
        let whole = torus(2.0, 0.5, 60, 30);
        let mut mesh = whole.clone();
        let mut random = crate::math::Stream::new(1, "holes");
        mesh.triangles.retain(|_| random.unit() > 0.05);
        close(&mut mesh);
        assert!(inspect(&mesh).is_closed(), "{:?}", inspect(&mesh));
        let change = mesh.signed_volume() / whole.signed_volume() - 1.0;
        assert!(change.abs() < 2e-3, "{change}");
    }
}
