//! What is seen where, and in which light, against rays.

use super::*;
use crate::math::Stream;
use crate::preview::{
    geometry::{NOTHING, Surface},
    primitive::{Primitive, Triangle},
    raster::{BAND_ROWS, Band, cover},
    shade::{Exposure, Rig},
};

/// Area of a ball's outline [pixels²]: the section of its cone of tangents with the picture.
fn exact_area(ball: &Sphere, view: &View) -> Real {
    let centre = view.place(&ball.centre);
    let sin = ball.radius / centre.norm();
    let cos_off = centre.z / centre.norm();
    let rest = cos_off * cos_off - sin * sin;
    let major = sin * (1.0 - sin * sin).sqrt() / rest;
    let minor = sin / rest.sqrt();
    core::f64::consts::PI * major * minor * view.focal * view.focal
}

/// The ball as rays show it, 64 a pixel, under the same lamps; `None` where not all of them hit.
fn exact_picture(ball: &Sphere, gloss: Real, view: &View) -> Vec<Option<[u8; 3]>> {
    let (rig, centre) = (Rig::new(view), view.place(&ball.centre));
    let pixel = |index: usize| {
        let mut sum = Colour::zeros();
        for sub in 0..64 {
            let x = (index % view.width) as Real + (f64::from(sub % 8) + 0.5) / 8.0;
            let y = (index / view.width) as Real + (f64::from(sub / 8) + 0.5) / 8.0;
            let ray = view.ray(x, y).normalize();
            let along = ray.dot(&centre);
            let chord = along * along - centre.norm_squared() + ball.radius * ball.radius;
            if chord <= 0.0 {
                return None;
            }
            let position = ray * (along - chord.sqrt());
            sum += rig.light(
                &Surface {
                    position,
                    normal: (position - centre) / ball.radius,
                    colour: ball.colour,
                    material: Material::Opaque { gloss },
                },
                &Exposure::FULL,
            );
        }
        Some(colour::to_srgb(&(sum / 64.0)))
    };
    (0..view.width * view.height).map(pixel).collect()
}

fn assert_like_exact(image: &RgbImage, exact: &[Option<[u8; 3]>]) {
    let mut inside = 0;
    for (pixel, want) in image.pixels().zip(exact) {
        if let Some(want) = want {
            inside += 1;
            for k in 0..3 {
                // 1 % of the range is 2.55 of 255.
                assert!(
                    pixel[k].abs_diff(want[k]) <= 2,
                    "{:?} is not {want:?}",
                    pixel.0
                );
            }
        }
    }
    assert!(inside > 3000, "only {inside} pixels compared");
}

#[test]
fn a_mesh_ball_has_the_outline_and_the_shade_of_the_exact_one() {
    let (positions, triangles, normals) = ball_mesh(&BALL, 160);
    let shown = |colour, material| Scene {
        meshes: vec![MeshLayer {
            normals: Some(&normals),
            material,
            ..opaque(&positions, &triangles, colour)
        }],
        camera: camera(),
        ..Scene::default()
    };

    // Black on white, the light that is missing is the outline.
    let black = render(
        &shown(Colour::zeros(), Material::Opaque { gloss: 0.0 }),
        &SMALL,
    );
    let view = camera().view(SMALL.width, SMALL.height);
    let area: Real = black.pixels().map(|p| 1.0 - colour::from_srgb(p.0).y).sum();
    let exact = exact_area(&BALL, &view);
    assert!(
        (area / exact - 1.0).abs() < 0.01,
        "{area} of {exact} pixels"
    );

    let lit = render(&shown(BALL.colour, Material::Opaque { gloss: 0.6 }), &SMALL);
    assert_like_exact(&lit, &exact_picture(&BALL, 0.6, &view));
}

#[test]
fn a_sphere_has_the_outline_and_the_shade_of_the_exact_one() {
    let balls = [BALL];
    let scene = Scene {
        spheres: &balls,
        camera: camera(),
        ..Scene::default()
    };
    let (visible, view, samples) = seen(&scene, &SMALL);
    let hits = visible.iter().filter(|s| s.number != NOTHING).count();
    let area = hits as Real / samples.count() as Real;
    let exact = exact_area(&BALL, &view);
    assert!(
        (area / exact - 1.0).abs() < 0.002,
        "{area} of {exact} pixels"
    );
    assert_like_exact(&render(&scene, &SMALL), &exact_picture(&BALL, 0.5, &view));
}

#[test]
fn random_triangles_also_behind_the_eye_are_seen_where_rays_meet_them() {
    let mut random = Stream::new(7, "triangles");
    let positions: Vec<Vec3> = (0..360).map(|_| random.cube() * 0.3).collect();
    let triangles: Vec<[u32; 3]> = (0..120).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let scene = Scene {
        meshes: vec![opaque(&positions, &triangles, Colour::repeat(0.5))],
        camera: camera(),
        ..Scene::default()
    };
    let (visible, view, samples) = seen(&scene, &SMALL);

    let placed: Vec<Vec3> = positions.iter().map(|p| view.place(p)).collect();
    let crossing = placed
        .chunks(3)
        .filter(|t| t.iter().any(|p| p.z < view.near) && t.iter().any(|p| p.z > view.near));
    assert!(crossing.count() > 20);
    // Solves position = a + u (b − a) + v (c − a) along the ray.
    let meets = |ray: &Vec3, corners: &[Vec3]| {
        let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
        let system = crate::math::Mat3::from_columns(&[*ray, -ab, -ac]);
        let found = system.lu().solve(&corners[0])?;
        let (depth, u, v) = (found.x, found.y, found.z);
        (u > 0.0 && v > 0.0 && u + v < 1.0 && depth >= view.near).then_some(depth)
    };
    for (seen, [x, y]) in visible.iter().zip(places(&view, &samples)).step_by(7) {
        let ray = view.ray(x, y);
        let nearest = placed
            .chunks(3)
            .enumerate()
            .filter_map(|(i, corners)| Some((meets(&ray, corners)?, i as u32)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(
            seen.number,
            nearest.map_or(NOTHING, |(_, i)| i),
            "at {x} {y}"
        );
        if let Some((depth, _)) = nearest {
            assert!((Real::from(seen.depth) / depth - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn two_crossing_triangles_hide_each_other_on_either_side_of_their_line() {
    let corners = |tilt: Real| {
        [(-0.05, -0.03), (0.05, -0.03), (0.0, 0.05)].map(|(x, z)| Vec3::new(x, tilt * x, z))
    };
    let positions = [corners(0.8), corners(-0.8)].concat();
    let scene = Scene {
        meshes: vec![opaque(
            &positions,
            &[[0, 1, 2], [3, 4, 5]],
            Colour::repeat(0.5),
        )],
        camera: Camera {
            position: Vec3::new(0.0, -0.2, 0.0),
            ..camera()
        },
        ..Scene::default()
    };
    let (visible, view, samples) = seen(&scene, &SMALL);
    let (mut left, mut right) = (0_i32, 0_i32);
    for (seen, [x, _]) in visible.iter().zip(places(&view, &samples)) {
        if seen.number != NOTHING {
            // The first triangle comes towards the eye on the left.
            assert_eq!(seen.number, u32::from(x > view.centre[0]));
            *if x > view.centre[0] {
                &mut right
            } else {
                &mut left
            } += 1;
        }
    }
    assert!((left - right).abs() < 100);
    assert!(left > 5000);
}

#[test]
fn neighbours_share_every_sample_on_their_edge_fairly() {
    // The eye is at the middle of the picture's plane, so this square and both diagonals run through pixel corners.
    let view = Camera {
        position: Vec3::zeros(),
        target: Vec3::y(),
        up: Vec3::z(),
        field_of_view: core::f64::consts::FRAC_PI_2,
    }
    .view(32, 32);
    let corner = |x: Real, y: Real| Vec3::new(x, y, 1.0);
    let hub = corner(0.0, 0.0);
    let rim = [
        corner(-0.5, -0.5),
        corner(0.5, -0.5),
        corner(0.5, 0.5),
        corner(-0.5, 0.5),
    ];
    let at_corners = Samples {
        offset: vec![[0.0, 0.0], [0.5, 0.5]],
    };
    let mut hits = vec![0; 32 * 32 * 2];
    for k in 0..4 {
        let corners = [hub, rim[k], rim[(k + 1) % 4]];
        let shape = Triangle::new(&corners, &view).unwrap();
        let window = Triangle::window(&corners, &view).unwrap();
        for index in 0..32 / BAND_ROWS {
            let band = Band::new(index, &view);
            cover(&shape, &window, &band, &at_corners, 0.0, |at| {
                hits[band.top * 32 * 2 + at.sample] += 1;
                assert!(shape.depth(at.x, at.y).is_some());
            });
        }
    }
    assert!(hits.iter().all(|&h| h <= 1));
    assert_eq!(hits.iter().sum::<i32>(), 16 * 16 * 2);
}
