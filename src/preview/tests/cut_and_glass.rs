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
