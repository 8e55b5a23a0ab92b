//! Same bits on any number of threads, and no harm from bad input.

use super::*;
use crate::math::{Aabb, Stream};

/// Something of everything.
fn crowded<'a>(
    mesh: &'a (Vec<Vec3>, Vec<[u32; 3]>, Vec<Vec3>),
    colours: &'a [Colour],
    spheres: &'a [Sphere],
) -> Scene<'a> {
    let solid = MeshLayer {
        normals: Some(&mesh.2),
        colours: Colours::Vertex(colours),
        cut: Some(Cut {
            point: Vec3::new(0.0, 0.0, 0.01),
            normal: Vec3::new(0.2, -1.0, 0.3),
            cap: Cap::Uniform(Colour::repeat(0.3)),
        }),
        ..opaque(&mesh.0, &mesh.1, Colour::zeros())
    };
    let glass = MeshLayer {
        material: Material::Glass {
            facing: 0.1,
            edge: 0.7,
        },
        cut: None,
        ..solid
    };
    Scene {
        meshes: vec![solid, glass],
        spheres,
        camera: camera(),
        lettering: Lettering {
            label: Some("t = 0.25 s".into()),
            legend: Some(Legend {
                title: "polymer fraction".into(),
                low: 0.0,
                high: 1.0,
                map: colour::scale,
                position: |share| share,
            }),
            scale_bar: true,
        },
    }
}

#[test]
fn a_picture_has_the_same_bits_on_any_number_of_threads() {
    let mesh = ball_mesh(&BALL, 60);
    let colours: Vec<Colour> = mesh
        .2
        .iter()
        .map(|n| colour::scale(0.5 + 0.5 * n.z))
        .collect();
    let mut random = Stream::new(5, "spheres");
    let spheres: Vec<Sphere> = (0..300)
        .map(|_| Sphere {
            centre: random.cube() * 0.03,
            radius: random.between(0.001, 0.003),
            colour: colour::scale(random.unit()),
        })
        .collect();
    let scene = crowded(&mesh, &colours, &spheres);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut png = std::io::Cursor::new(Vec::new());
        let image = pool.install(|| render(&scene, &SMALL));
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        png.into_inner()
    };
    let one = on(1);
    assert!(one.len() > 10_000);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn what_stands_still_may_be_drawn_before_and_changes_no_bit() {
    let large = Sphere {
        radius: 0.028,
        centre: Vec3::new(-0.004, 0.012, 0.002),
        ..BALL
    };
    let (still, shell) = (ball_mesh(&BALL, 24), ball_mesh(&large, 30));
    let mut bone = crowded(&still, &[], &[]).meshes;
    bone[0].colours = Colours::Uniform(Colour::repeat(0.6));
    bone[1] = MeshLayer {
        positions: &shell.0,
        triangles: &shell.1,
        normals: Some(&shell.2),
        colours: Colours::Uniform(Colour::repeat(0.7)),
        ..bone[1]
    };
    let lit = Aabb::around(still.0.iter().chain(&shell.0));
    let backdrop = Backdrop::new(&bone, &camera(), &lit, &SMALL);
    let empty = Backdrop::new(&[], &camera(), &lit, &SMALL);
    let lettering = Lettering::default();
    let mut before = backdrop.draw(&[], &[], &lettering);
    assert!(before == empty.draw(&bone, &[], &lettering));
    for step in 0..4 {
        // It rolls out of the solid, past its cut and through the glass.
        let moved = Sphere {
            centre: Vec3::new(0.012 - 0.011 * f64::from(step), -0.012, 0.018),
            radius: 0.006,
            ..BALL
        };
        let cement = ball_mesh(&moved, 16);
        let pane = [0, 1, 2].map(|k| moved.centre + Vec3::ith(k, 0.02));
        let drops = [Sphere {
            centre: moved.centre + Vec3::new(0.0, -0.01, 0.004),
            radius: 0.002,
            ..BALL
        }];
        let moving = [
            opaque(&cement.0, &cement.1, Colour::new(0.2, 0.3, 0.5)),
            MeshLayer {
                material: Material::GLASS_BONE,
                ..opaque(&pane, &[[0, 1, 2], [0, 2, 1]], Colour::repeat(0.5))
            },
        ];
        let picture = backdrop.draw(&moving, &drops, &lettering);
        let all = [&bone[..], &moving].concat();
        assert!(picture == empty.draw(&all, &drops, &lettering), "{step}");
        assert!(picture != before);
        before = picture;
    }
}

#[test]
fn broken_input_is_left_out() {
    let (mut mesh, nan) = (ball_mesh(&BALL, 12), Real::NAN);
    let colours = vec![Colour::repeat(0.5); 3];
    mesh.2.truncate(5);
    let clean = render(&crowded(&mesh, &colours, &[]), &SMALL);
    let first = mesh.0.len() as u32;
    mesh.0.extend([
        Vec3::new(nan, 0.0, 0.0),
        Vec3::repeat(Real::INFINITY),
        Vec3::repeat(1e300),
    ]);
    mesh.1.extend([
        [0, 1, first],
        [0, first + 1, 1],
        [5, 5, 5],
        [0, 1, u32::MAX],
        [3, 3, 9],
    ]);
    let odd = |centre, radius| Sphere {
        centre,
        radius,
        colour: Colour::repeat(nan),
    };
    let spheres = [
        odd(Vec3::repeat(nan), 1.0),
        odd(Vec3::zeros(), nan),
        odd(Vec3::zeros(), -1.0),
        odd(Vec3::zeros(), Real::INFINITY),
        odd(camera().position, 0.01),
    ];
    let broken = render(&crowded(&mesh, &colours, &spheres), &SMALL);
    assert_eq!(compare(&clean, &broken), Comparison::Same);
}

#[test]
fn empty_scenes_and_impossible_cameras_still_give_a_picture() {
    let mesh = ball_mesh(&BALL, 12);
    let spheres = [BALL];
    for (width, height) in [(0, 0), (0, 9), (9, 0), (1, 1), (3, 40), (70, 17)] {
        let settings = PictureSettings {
            width,
            height,
            samples: 0,
            background: Background::Dark,
        };
        assert_eq!(
            render(&Scene::default(), &settings).dimensions(),
            (width, height)
        );
        render(&crowded(&mesh, &[], &spheres), &settings);
    }
    for (low, high) in [
        (1.0, 1.0),
        (2.0, -1.0),
        (Real::NAN, 1.0),
        (0.0, Real::INFINITY),
    ] {
        let mut scene = crowded(&mesh, &[], &spheres);
        let legend = scene.lettering.legend.take();
        scene.lettering.legend = legend.map(|legend| Legend {
            low,
            high,
            ..legend
        });
        render(&scene, &SMALL);
    }
    let good = camera();
    let cameras = [
        Camera {
            position: Vec3::repeat(Real::NAN),
            ..good
        },
        Camera {
            position: good.target,
            ..good
        },
        Camera {
            up: good.target - good.position,
            ..good
        },
        Camera {
            up: Vec3::zeros(),
            ..good
        },
        Camera {
            field_of_view: 0.0,
            ..good
        },
        Camera {
            field_of_view: core::f64::consts::PI,
            ..good
        },
        Camera {
            field_of_view: Real::NAN,
            ..good
        },
        Camera::framing(&Aabb::around(&[BALL.centre]), 0.0, 0.0, 0.5),
        Camera::framing(&Aabb::empty(), 0.0, 0.0, 0.5),
    ];
    for camera in cameras {
        let scene = Scene {
            camera,
            ..crowded(&mesh, &[], &spheres)
        };
        assert_eq!(render(&scene, &SMALL).dimensions(), (200, 150));
    }
}
