//! Pictures against exact ones.

use super::{
    camera::View,
    geometry::{Geometry, NOTHING, Surface},
    layers::Seen,
    primitive::{Primitive, Triangle},
    raster::{BAND_ROWS, Band, Samples, cover},
    shade::{Exposure, Rig},
    *,
};
use crate::math::{Aabb, Stream};

const SMALL: PictureSettings = PictureSettings {
    width: 200,
    height: 150,
    samples: 4,
    background: Background::White,
};
/// Off the axis, so that its outline is an ellipse.
const BALL: Sphere = Sphere {
    centre: Vec3::new(0.012, 0.004, 0.009),
    radius: 0.02,
    colour: Vec3::new(0.5, 0.3, 0.2),
};

fn camera() -> Camera {
    Camera {
        position: Vec3::new(0.0, -0.12, 0.02),
        target: Vec3::zeros(),
        up: Vec3::z(),
        field_of_view: 0.7,
    }
}

/// A ball of many triangles, with exact normals.
fn ball_mesh(ball: &Sphere, rings: u32) -> (Vec<Vec3>, Vec<[u32; 3]>, Vec<Vec3>) {
    let around = 2 * rings;
    let mut normals = Vec::new();
    let mut triangles = Vec::new();
    for ring in 0..=rings {
        for spoke in 0..around {
            let (polar, turn) = (
                core::f64::consts::PI * f64::from(ring) / f64::from(rings),
                core::f64::consts::PI * f64::from(spoke) / f64::from(rings),
            );
            let level = libm::sin(polar);
            normals.push(Vec3::new(
                level * libm::cos(turn),
                level * libm::sin(turn),
                libm::cos(polar),
            ));
            let (a, b) = (ring * around + spoke, ring * around + (spoke + 1) % around);
            if ring < rings {
                triangles.push([a, a + around, b]);
                triangles.push([b, a + around, b + around]);
            }
        }
    }
    let positions = normals
        .iter()
        .map(|n| ball.centre + n * ball.radius)
        .collect();
    (positions, triangles, normals)
}

fn opaque<'a>(positions: &'a [Vec3], triangles: &'a [[u32; 3]], colour: Colour) -> MeshLayer<'a> {
    MeshLayer {
        positions,
        triangles,
        normals: None,
        colours: Colours::Uniform(colour),
        material: Material::Opaque { gloss: 0.0 },
        cut: None,
    }
}

fn seen(scene: &Scene, settings: &PictureSettings) -> (Vec<Seen>, View, Samples) {
    let view = scene.camera.view(settings.width, settings.height);
    let samples = Samples::new(settings.samples);
    let visible = layers::opaque(&Geometry::new(scene, view.clone()), &samples);
    (visible, view, samples)
}

/// Position in the picture of every sample, in the order of the buffer.
fn places(view: &View, samples: &Samples) -> Vec<[Real; 2]> {
    (0..view.width * view.height)
        .flat_map(|pixel| {
            let corner = [(pixel % view.width) as Real, (pixel / view.width) as Real];
            samples
                .offset
                .iter()
                .map(move |o| [corner[0] + o[0], corner[1] + o[1]])
        })
        .collect()
}

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
        cap: Colour::repeat(0.2),
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
                cap: Colour::repeat(0.2),
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
            cap: Colour::repeat(0.3),
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
        label: Some("t = 0.25 s".into()),
        legend: Some(Legend {
            title: "polymer fraction".into(),
            low: 0.0,
            high: 1.0,
            map: colour::polymer,
        }),
        scale_bar: true,
    }
}

#[test]
fn a_picture_has_the_same_bits_on_any_number_of_threads() {
    let mesh = ball_mesh(&BALL, 60);
    let colours: Vec<Colour> = mesh
        .2
        .iter()
        .map(|n| colour::polymer(0.5 + 0.5 * n.z))
        .collect();
    let mut random = Stream::new(5, "spheres");
    let spheres: Vec<Sphere> = (0..300)
        .map(|_| Sphere {
            centre: random.cube() * 0.03,
            radius: random.between(0.001, 0.003),
            colour: colour::polymer(random.unit()),
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
