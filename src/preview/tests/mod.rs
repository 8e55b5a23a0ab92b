//! Pictures against exact ones: what the tests share.

mod cut_and_glass;
mod outlines;
mod whole_pictures;

use super::{camera::View, geometry::Geometry, layers::Seen, raster::Samples, *};

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
    let geometry = Geometry::new(&scene.meshes, scene.spheres, view.clone());
    let visible = layers::opaque(&geometry, 0, &samples, None);
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
