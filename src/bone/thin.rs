//! Thins a network as ageing does: struts go missing, vertical ones last, and what is left still hangs together.

use crate::math::Real;

/// A strut before it is one.
pub(super) struct Joint {
    /// Its two nodes.
    pub nodes: [usize; 2],
    /// Square of the vertical component of its direction [1].
    pub upright: Real,
    /// Whether it would be lost.
    pub doomed: bool,
}

/// The joints that stay: those not doomed, and of the doomed as many as it takes to hold together what hung together
/// before, the most upright first. Nodes that are `anchored` hold each other.
pub(super) fn thinned(joints: Vec<Joint>, anchored: &[bool]) -> Vec<Joint> {
    if joints.iter().all(|joint| !joint.doomed) {
        return joints;
    }
    let mut parent: Vec<usize> = (0..=anchored.len()).collect();
    let ground = anchored.len();
    for (node, &anchored) in anchored.iter().enumerate() {
        if anchored {
            parent[node] = ground;
        }
    }
    let mut join = |[a, b]: [usize; 2]| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.min(b)] = a.max(b);
        a != b
    };
    for joint in joints.iter().filter(|joint| !joint.doomed) {
        join(joint.nodes);
    }
    let mut order: Vec<usize> = (0..joints.len()).filter(|j| joints[*j].doomed).collect();
    order.sort_by(|a, b| {
        joints[*b]
            .upright
            .total_cmp(&joints[*a].upright)
            .then(a.cmp(b))
    });
    let mut kept: Vec<bool> = joints.iter().map(|joint| !joint.doomed).collect();
    for j in order {
        kept[j] = join(joints[j].nodes);
    }
    let mut kept = kept.into_iter();
    let stays = |_: &Joint| kept.next().unwrap_or(false);
    joints.into_iter().filter(stays).collect()
}

fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_keeps_its_hold_and_loses_its_flattest_strut() {
        let joint = |a: usize, b: usize, upright| Joint {
            nodes: [a, b],
            upright,
            doomed: true,
        };
        let ring = vec![
            joint(0, 1, 0.9),
            joint(1, 2, 0.1),
            joint(2, 3, 0.8),
            joint(3, 0, 0.2),
        ];
        let kept: Vec<[usize; 2]> = thinned(ring, &[false; 4]).iter().map(|j| j.nodes).collect();
        assert_eq!(kept, [[0, 1], [2, 3], [3, 0]]);
        // Two of them in the shell: the struts between those are needed no more.
        let ring = vec![
            joint(0, 1, 0.9),
            joint(1, 2, 0.1),
            joint(2, 3, 0.8),
            joint(3, 0, 0.2),
        ];
        let kept = thinned(ring, &[true, false, true, false]);
        assert_eq!(kept.len(), 2);
    }
}
