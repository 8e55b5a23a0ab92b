//! Cut faces against exact sections, glass against the order it is laid in.

use super::*;
use crate::preview::geometry::NOTHING;

#[test]
fn a_cut_through_the_eye_leaves_exactly_half_of_the_outline() {
    let ball = Sphere {
        centre: Vec3::zeros(),
        ..BALL
    };
    let (positions, triangles, _) = ball_mesh(&ball, 40);
    let whole = opaque(&positions, &triangles, ball.colour);
    let cut = Cut {
        point: Vec3::zeros(),
        normal: Vec3::x(),
        cap: Cap::Uniform(Colour::repeat(0.2)),
    };
    let show = |cut| Scene {
        meshes: vec![MeshLayer { cut, ..whole }],
        camera: camera(),
        ..Scene::default()
    };
    let (all, view, samples) = seen(&show(None), &SMALL);
    let (half, ..) = seen(&show(Some(cut)), &SMALL);
    for ((all, half), [x, _]) in all.iter().zip(&half).zip(places(&view, &samples)) {
        assert_eq!(
            *half,
            if x < view.centre[0] {
                *all
            } else {
                Seen::NOTHING
            }
        );
    }
}

#[test]
fn a_cut_towards_the_eye_shows_a_flat_face_as_large_as_the_section() {
    let camera = Camera {
        position: Vec3::new(0.0, -0.12, 0.0),
        ..camera()
    };
    let ball = Sphere {
        centre: Vec3::zeros(),
        ..BALL
    };
    let (positions, triangles, _) = ball_mesh(&ball, 120);
    let depth_of_cut = 0.005;
    let scene = Scene {
        meshes: vec![MeshLayer {
            cut: Some(Cut {
                point: Vec3::new(0.3, depth_of_cut, 0.1),
                normal: -Vec3::y(),
                cap: Cap::Uniform(Colour::repeat(0.2)),
            }),
            ..opaque(&positions, &triangles, ball.colour)
        }],
        camera,
        ..Scene::default()
    };
    let (visible, view, samples) = seen(&scene, &SMALL);
    let plane = 0.12 + depth_of_cut;
    let mut area = 0.0;
    for seen in visible.iter().filter(|seen| seen.number != NOTHING) {
        assert_eq!(seen.number, NOTHING - 1, "only the cut face is seen");
        assert!((Real::from(seen.depth) - plane).abs() < 1e-8);
        area += 1.0 / samples.count() as Real;
    }
    let section = ball.radius * ball.radius - depth_of_cut * depth_of_cut;
    let exact = core::f64::consts::PI * section * (view.focal / plane) * (view.focal / plane);
    assert!(
        (area / exact - 1.0).abs() < 0.01,
        "{area} of {exact} pixels"
    );
}

#[test]
fn a_cut_face_has_the_colours_of_its_chart_where_they_belong() {
    let ball = Sphere {
        centre: Vec3::zeros(),
        ..BALL
    };
    let (positions, triangles, _) = ball_mesh(&ball, 60);
    // Points through the ball, 1 mm apart, whose values rise to the right or upwards.
    let side = || (-22..=22).map(|n| n as f32 * 1e-3);
    let points: Vec<[f32; 3]> = side()
        .flat_map(|x| side().flat_map(move |z| [-1e-3, 0.0, 1e-3].map(|y| [x, y, z])))
        .collect();
    let chart = |axis: usize| {
        let values: Vec<f32> = points.iter().map(|p| p[axis]).collect();
        let grey = |v: f32| Colour::repeat(0.3 + 10.0 * Real::from(v));
        let plane = [&Vec3::zeros(), &-Vec3::y()];
        Chart::new(plane, &points, &values, 2e-3, grey, Colour::zeros())
    };
    let camera = Camera {
        position: Vec3::new(0.0, -0.12, 0.0),
        ..camera()
    };
    for (axis, step) in [(0, [1, 0]), (2, [0, -1])] {
        let chart = chart(axis);
        let scene = Scene {
            meshes: vec![MeshLayer {
                cut: Some(Cut {
                    point: Vec3::zeros(),
                    normal: -Vec3::y(),
                    cap: Cap::Chart(&chart),
                }),
                ..opaque(&positions, &triangles, ball.colour)
            }],
            camera,
            ..Scene::default()
        };
        let picture = render(&scene, &SMALL);
        let at = |n: i32| {
            picture
                .get_pixel((100 + n * step[0]) as u32, (75 + n * step[1]) as u32)
                .0[1]
        };
        let along = [-12, -6, 0, 6, 12].map(at);
        assert!(along.is_sorted_by(|a, b| a + 5 < *b), "{axis}: {along:?}");
        // Across, nothing changes.
        let across = |n: i32| {
            picture
                .get_pixel((100 + n * step[1]) as u32, (75 + n * step[0]) as u32)
                .0[1]
        };
        assert!(across(-10).abs_diff(across(10)) <= 3, "{axis}");
    }
}

#[test]
fn glass_is_laid_from_far_to_near_whatever_its_order_and_only_over_what_is_behind() {
    let pane =
        |y: Real| [(-0.09, -0.09), (0.09, -0.09), (0.0, 0.2)].map(|(x, z)| Vec3::new(x, y, z));
    let (near, far, behind) = (pane(-0.03), pane(0.0), pane(0.05));
    let wall = pane(0.02);
    let face = [[0, 1, 2]];
    let glass = |positions, colour| MeshLayer {
        material: Material::Glass {
            facing: 0.3,
            edge: 0.8,
        },
        ..opaque(positions, &face, colour)
    };
    let red = glass(&near, Colour::new(0.6, 0.1, 0.1));
    let blue = glass(&far, Colour::new(0.1, 0.1, 0.6));
    let green = glass(&behind, Colour::new(0.1, 0.6, 0.1));
    let wall = opaque(&wall, &face, Colour::repeat(0.4));
    let picture = |meshes: Vec<MeshLayer>| {
        let scene = Scene {
            meshes,
            camera: camera(),
            ..Scene::default()
        };
        render(&scene, &SMALL)
    };
    let ordered = picture(vec![wall, red, blue]);
    assert_eq!(
        compare(&ordered, &picture(vec![blue, red, green, wall])),
        Comparison::Same
    );

    let at = |image: &RgbImage| colour::from_srgb(image.get_pixel(100, 75).0);
    let alone = |layer: MeshLayer| at(&picture(vec![layer]));
    // What a pane adds and leaves, from its picture on white and on the wall.
    let (white, grey) = (Colour::repeat(1.0), alone(wall));
    let left = |layer: MeshLayer| {
        (alone(layer) - at(&picture(vec![layer, wall]))).component_div(&(white - grey))
    };
    let over =
        |layer: MeshLayer, base: Colour| alone(layer) - left(layer).component_mul(&(white - base));
    let expected = over(red, over(blue, grey));
    assert!(
        (at(&ordered) - expected).amax() < 0.01,
        "{} {expected}",
        at(&ordered)
    );
    assert!(
        left(red).iter().all(|l| (0.5..=0.71).contains(l)),
        "{}",
        left(red)
    );
}
