//! Frames and walls → `preview/`: one picture a frame and view.

use super::{FlowError, Job, Observer, each_frame, overview};
use crate::cache::{self, Frame};
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{LengthUnit, TriMesh, UpAxis, read_obj};
use crate::preview::{
    Backdrop, Camera, Colour, Colours, Cut, Legend, Lettering, Material, MeshLayer, colour,
};
use crate::scene::{BoneLook, View};
use crate::sim::{Motion, Pose};
use crate::solid::Solid;
use crate::surface::{Surface, reconstruct};
use image::codecs::png::PngEncoder;
use image::{ImageEncoder, RgbImage};
use std::path::Path;

/// Angle across the shorter side of a picture [rad].
const FIELD_OF_VIEW: Real = 0.5;
/// How far behind the cut face of the bone that of the cement lies, in spacings.
const STEP_BACK: Real = 0.05;
/// Cannulas, as sRGB.
const STEEL: [u8; 3] = [158, 165, 174];

pub(super) fn work(job: &Job, _: &mut Observer<'_>) -> Result<(), FlowError> {
    let props = Props::read(job)?;
    let views = &job.scene.preview.views;
    let backdrops: Vec<Backdrop> = (views.iter())
        .map(|view| backdrop(job, &props, view, &camera(job, &props, view)))
        .collect();
    each_frame(job, |frame| {
        let cement = Cement::new(frame, &props, job);
        for (view, backdrop) in views.iter().zip(&backdrops) {
            let picture = draw(job, &props, &cement, view, backdrop);
            let path = job.folder.picture(&view.name, frame.index);
            cache::write(&path, &png(&path, &picture)?)?;
        }
        Ok(())
    })?;
    overview::write(job)
}

/// What stands around the cement.
struct Props {
    solid: Solid,
    bone: Shown,
    /// The part of the bone whose inside is not drawn.
    rest: Shown,
    inside: Shown,
    walls: Shown,
    cannulas: Shown,
    /// Walls that move, in their places at the start.
    movers: Vec<(Motion, Shown)>,
}

/// A mesh with its normals; empty if there is none.
#[derive(Default)]
struct Shown {
    mesh: TriMesh,
    normals: Vec<Vec3>,
}

impl Props {
    fn read(job: &Job) -> Result<Self, FlowError> {
        let folder = &job.folder;
        let look = |looks: &[BoneLook]| {
            let views = &job.scene.preview.views;
            views.iter().any(|view| looks.contains(&view.bone))
        };
        let bone = Shown::read(&folder.bone_mesh(), look(&[BoneLook::Glass, BoneLook::Cut]))?;
        let movers = job.scene.movers.iter().enumerate();
        Ok(Self {
            solid: cache::read_solid(&folder.solid())?,
            movers: movers
                .map(|(n, mover)| Ok((mover.motion, Shown::read(&folder.mover_mesh(n), true)?)))
                .collect::<Result<_, FlowError>>()?,
            rest: bone.outside(&job.scene.sim.domain),
            bone,
            inside: Shown::read(&folder.inside_mesh(), look(&[BoneLook::Cut]))?,
            walls: Shown::read(&folder.wall_mesh(), true)?,
            cannulas: Shown::read(&folder.cannula_mesh(), true)?,
        })
    }
}

impl Shown {
    fn read(path: &Path, wanted: bool) -> Result<Self, FlowError> {
        if !wanted || !path.exists() {
            return Ok(Self::default());
        }
        let mesh = read_obj(path, LengthUnit::Metre, UpAxis::Y)?;
        let normals = mesh.vertex_normals();
        Ok(Self { mesh, normals })
    }

    /// Where it is once it has moved.
    fn placed(&self, pose: &Pose) -> Self {
        let mut part = Self {
            mesh: self.mesh.clone(),
            normals: self.normals.clone(),
        };
        for x in &mut part.mesh.positions {
            *x = pose.place(x);
        }
        for normal in &mut part.normals {
            *normal = pose.rotation * *normal;
        }
        part
    }

    /// The triangles that reach out of `bounds`.
    fn outside(&self, bounds: &Aabb) -> Self {
        let mut part = Self {
            mesh: self.mesh.clone(),
            normals: self.normals.clone(),
        };
        let inside = |v: &u32| bounds.contains(&self.mesh.positions[*v as usize]);
        part.mesh.triangles.retain(|t| !t.iter().all(inside));
        part
    }

    fn layer(&self, colour: [u8; 3], material: Material, cut: Option<Cut>) -> MeshLayer<'_> {
        MeshLayer {
            positions: &self.mesh.positions,
            triangles: &self.mesh.triangles,
            normals: Some(&self.normals),
            colours: Colours::Uniform(colour::from_srgb(colour)),
            material,
            cut,
        }
    }
}

/// The cement of a frame, ready to be drawn.
struct Cement {
    surface: Surface,
    colours: Vec<Colour>,
    /// Where it is cut.
    inner: Colour,
    label: String,
    time: Real,
}

impl Cement {
    fn new(frame: &Frame, props: &Props, job: &Job) -> Self {
        let surface = reconstruct(frame, Some(&props.solid), &job.scene.surface);
        let alpha = &surface.polymer_fraction;
        let colours = alpha.iter().map(|&a| colour::polymer(a.into())).collect();
        let sum: Real = frame.polymer_fraction.iter().map(|&a| Real::from(a)).sum();
        let mean = sum / frame.polymer_fraction.len().max(1) as Real;
        let millilitres = frame.position.len() as Real * frame.rest_volume * 1e6;
        Self {
            colours,
            inner: colour::polymer(mean),
            label: format!("t = {:.2} s   {millilitres:.2} ml", frame.time),
            surface,
            time: frame.time,
        }
    }
}

/// Holds what does not move, so that the camera does not either.
fn camera(job: &Job, props: &Props, view: &View) -> Camera {
    let points = if props.bone.mesh.positions.is_empty() {
        corners(&job.scene.sim.domain)
    } else {
        props.bone.mesh.positions.clone()
    };
    let picture = &job.scene.preview.picture;
    let aspect = Real::from(picture.width) / Real::from(picture.height);
    let mut camera = Camera::fitting(&points, aspect, view.azimuth, view.elevation, FIELD_OF_VIEW);
    let to_eye = (camera.position - camera.target) / view.zoom;
    camera.target = view.target.unwrap_or(camera.target);
    camera.position = camera.target + to_eye;
    camera
}

fn corners(bounds: &Aabb) -> Vec<Vec3> {
    let ends = [bounds.min, bounds.max];
    (0..8_usize)
        .map(|c| Vec3::new(ends[c & 1].x, ends[c >> 1 & 1].y, ends[c >> 2].z))
        .collect()
}

/// What stands still in a view.
fn backdrop<'a>(job: &Job, props: &'a Props, view: &View, camera: &Camera) -> Backdrop<'a> {
    let bone_cap = colour::from_srgb(colour::CUT_BONE);
    let cut = cut(view, bone_cap);
    // The part that is taken away stays as glass, and so does what has no inside to show.
    let removed = cut.map(|cut| Cut {
        normal: -cut.normal,
        ..cut
    });
    let mut still = vec![props.cannulas.layer(STEEL, Material::CEMENT, None)];
    match view.bone {
        BoneLook::Glass => {
            for shown in [&props.bone, &props.walls] {
                still.push(shown.layer(colour::BONE, Material::GLASS_BONE, None));
            }
        }
        BoneLook::Cut => {
            for shown in [&props.inside, &props.walls] {
                still.push(shown.layer(colour::BONE, Material::BONE, cut));
            }
            for (shown, cut) in [(&props.bone, removed), (&props.rest, cut)] {
                still.push(shown.layer(colour::BONE, Material::GLASS_BONE, cut));
            }
        }
        BoneLook::Hidden => {}
    }
    Backdrop::new(
        &still,
        camera,
        &job.scene.sim.domain,
        &job.scene.preview.picture,
    )
}

fn cut(view: &View, cap: Colour) -> Option<Cut> {
    view.cut.map(|plane| Cut {
        point: plane.point,
        normal: plane.normal,
        cap,
    })
}

fn draw(
    job: &Job,
    props: &Props,
    cement: &Cement,
    view: &View,
    backdrop: &Backdrop<'_>,
) -> RgbImage {
    // A surface drawn through particles closes over thin struts: behind their cut faces it leaves them to be seen.
    let cement_cut = cut(view, cement.inner).map(|cut| Cut {
        point: cut.point - cut.normal * (STEP_BACK * job.scene.sim.spacing),
        ..cut
    });
    let mut moving = vec![MeshLayer {
        positions: &cement.surface.mesh.positions,
        triangles: &cement.surface.mesh.triangles,
        normals: Some(&cement.surface.normal),
        colours: Colours::Vertex(&cement.colours),
        material: Material::CEMENT,
        cut: cement_cut.filter(|_| view.cut_cement),
    }];
    let movers: Vec<Shown> = props
        .movers
        .iter()
        .map(|(motion, shown)| shown.placed(&motion.pose(cement.time)))
        .collect();
    let steel = movers
        .iter()
        .map(|shown| shown.layer(STEEL, Material::CEMENT, None));
    moving.extend(steel);
    let lettering = Lettering {
        label: Some(cement.label.clone()),
        legend: Some(Legend {
            title: "polymer fraction".to_owned(),
            low: 0.0,
            high: 1.0,
            map: colour::polymer,
        }),
        scale_bar: true,
    };
    backdrop.draw(&moving, &[], &lettering)
}

pub(super) fn png(path: &Path, picture: &RgbImage) -> Result<Vec<u8>, FlowError> {
    let mut bytes = Vec::new();
    let (width, height) = picture.dimensions();
    PngEncoder::new(&mut bytes)
        .write_image(picture, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| FlowError::io(path)(std::io::Error::other(e)))?;
    Ok(bytes)
}
