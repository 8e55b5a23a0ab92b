//! Frames and walls → `preview/`: one picture a frame and view.

use super::{FlowError, Job, Observer, each_frame, overview, tint::Tint, turntable};
use crate::cache::{self, Frame};
use crate::ink;
use crate::math::{Aabb, Real, Vec3};
use crate::mesh::{LengthUnit, TriMesh, UpAxis, read_obj};
use crate::preview::{
    Backdrop, Camera, Cap, Chart, Colour, Colours, Cut, Lettering, Material, MeshLayer,
    PictureSettings, colour,
};
use crate::scene::{BoneLook, View};
use crate::sim::{Motion, Pose};
use crate::solid::Solid;
use crate::surface::{Surface, reconstruct};
use image::RgbImage;
use std::path::{Path, PathBuf};

/// Angle across the shorter side of a picture [rad].
const FIELD_OF_VIEW: Real = 0.5;
/// How far behind the cut face of the bone that of the cement lies, in spacings: struts stand out of it.
const STEP_BACK: Real = 0.5;
/// Cannulas, as sRGB.
const STEEL: [u8; 3] = [158, 165, 174];

pub(super) fn work(job: &Job, _: &mut Observer<'_>) -> Result<(), FlowError> {
    let props = Props::read(job)?;
    let stand = Stand::new(job, &props)?;
    let views = &job.scene.preview.views;
    let picture = &job.scene.preview.picture;
    let backdrops: Vec<Backdrop> = (views.iter())
        .map(|view| stand.backdrop(view, &stand.camera(view), picture))
        .collect();
    each_frame(job, &job.folder.frames(job.frames)?, |frame| {
        let cement = stand.cement(frame);
        for (n, (view, backdrop)) in views.iter().zip(&backdrops).enumerate() {
            let picture = stand.draw(&cement, n, backdrop);
            let path = job.folder.picture(&view.name, frame.index);
            cache::write(&path, &png(&path, &picture)?)?;
        }
        Ok(())
    })?;
    drop(backdrops);
    turntable::write(job, &stand)?;
    overview::write(job)
}

/// The first view of the start; where it lies. `work` draws it again, with colours scaled to all frames.
pub(super) fn draw_start(job: &Job) -> Result<Option<PathBuf>, FlowError> {
    let Some(view) = job.scene.preview.views.first() else {
        return Ok(None);
    };
    let props = Props::read(job)?;
    let stand = Stand::new(job, &props)?;
    let camera = stand.camera(view);
    let backdrop = stand.backdrop(view, &camera, &job.scene.preview.picture);
    let cement = stand.cement(&cache::read_frame(&job.folder.frame(0))?);
    let path = job.folder.picture(&view.name, 0);
    cache::write(&path, &png(&path, &stand.draw(&cement, 0, &backdrop))?)?;
    Ok(Some(path))
}

/// All that pictures of a job have in common.
pub(super) struct Stand<'a> {
    job: &'a Job,
    props: &'a Props,
    /// What the colours mean in each view.
    tints: Vec<Tint>,
}

/// What stands around the cement.
pub(super) struct Props {
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

    fn layer<'a>(
        &'a self,
        colour: [u8; 3],
        material: Material,
        cut: Option<Cut<'a>>,
    ) -> MeshLayer<'a> {
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
pub(super) struct Cement {
    surface: Surface,
    /// What each view shows of it: the colours of its vertices, and those of its cut face.
    colours: Vec<(Vec<Colour>, Option<Chart>)>,
    label: String,
    time: Real,
}

impl<'a> Stand<'a> {
    fn new(job: &'a Job, props: &'a Props) -> Result<Self, FlowError> {
        let tints = Tint::of_views(job)?;
        Ok(Self { job, props, tints })
    }

    /// The cement of a frame.
    pub fn cement(&self, frame: &Frame) -> Cement {
        let surface = reconstruct(frame, Some(&self.props.solid), &self.job.scene.surface);
        let tints = self.tints.iter();
        let views = &self.job.scene.preview.views;
        let colours = tints.zip(views).map(|(tint, view)| {
            let reach = self.job.scene.surface.smoothing * frame.spacing;
            let plane = cement_plane(view, frame.spacing);
            let face = plane.map(|[point, normal]| tint.chart(frame, [&point, &normal], reach));
            (tint.colours(&surface), face)
        });
        let volume = frame.position.len() as Real * frame.rest_volume;
        Cement {
            colours: colours.collect(),
            label: format!("t = {:.2} s   {}", frame.time, amount(volume)),
            surface,
            time: frame.time,
        }
    }

    /// What the camera has to hold: what does not move, so that it does not move either.
    pub fn points(&self) -> Vec<Vec3> {
        let bone = &self.props.bone.mesh.positions;
        if bone.is_empty() {
            corners(&self.job.scene.sim.domain)
        } else {
            bone.clone()
        }
    }

    /// Where a view looks from.
    pub fn camera(&self, view: &View) -> Camera {
        let picture = &self.job.scene.preview.picture;
        let aspect = Real::from(picture.width) / Real::from(picture.height);
        let (azimuth, elevation) = (view.azimuth, view.elevation);
        let mut camera = Camera::fitting(&self.points(), aspect, azimuth, elevation, FIELD_OF_VIEW);
        let to_eye = (camera.position - camera.target) / view.zoom;
        camera.target = view.target.unwrap_or(camera.target);
        camera.position = camera.target + to_eye;
        camera
    }

    /// What stands still in a view.
    pub fn backdrop(
        &self,
        view: &View,
        camera: &Camera,
        picture: &PictureSettings,
    ) -> Backdrop<'a> {
        let props = self.props;
        let bone_cap = colour::from_srgb(colour::CUT_BONE);
        let cut = view.cut.map(|plane| Cut {
            point: plane.point,
            normal: plane.normal,
            cap: Cap::Uniform(bone_cap),
        });
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
        Backdrop::new(&still, camera, &self.job.scene.sim.domain, picture)
    }

    /// The picture of a frame in the n-th view.
    pub fn draw(&self, cement: &Cement, n: usize, backdrop: &Backdrop<'_>) -> RgbImage {
        let (job, view) = (self.job, &self.job.scene.preview.views[n]);
        let (colours, face) = &cement.colours[n];
        let plane = cement_plane(view, job.scene.sim.spacing);
        let cut = plane.zip(face.as_ref());
        let cut = cut.map(|([point, normal], face)| Cut {
            point,
            normal,
            cap: Cap::Chart(face),
        });
        let mut moving = vec![MeshLayer {
            positions: &cement.surface.mesh.positions,
            triangles: &cement.surface.mesh.triangles,
            normals: Some(&cement.surface.normal),
            colours: Colours::Vertex(colours),
            material: Material::CEMENT,
            cut,
        }];
        let movers: Vec<Shown> = self
            .props
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
            legend: Some(self.tints[n].legend()),
            scale_bar: true,
        };
        backdrop.draw(&moving, &[], &lettering)
    }
}

/// Where a view cuts the cement: a point of the plane, and its normal.
///
/// A surface drawn through particles closes over thin struts: behind their cut faces it leaves them to be seen.
fn cement_plane(view: &View, spacing: Real) -> Option<[Vec3; 2]> {
    let plane = view.cut.filter(|_| view.cut_cement)?;
    let back = plane.normal * (STEP_BACK * spacing);
    Some([plane.point - back, plane.normal])
}

/// A volume [m³] as it is written on a picture.
fn amount(volume: Real) -> String {
    match volume {
        small if small < 0.01 => format!("{:.2} ml", small * 1e6),
        large => format!("{:.1} litres", large * 1e3),
    }
}

fn corners(bounds: &Aabb) -> Vec<Vec3> {
    let ends = [bounds.min, bounds.max];
    (0..8_usize)
        .map(|c| Vec3::new(ends[c & 1].x, ends[c >> 1 & 1].y, ends[c >> 2].z))
        .collect()
}

pub(super) fn png(path: &Path, picture: &RgbImage) -> Result<Vec<u8>, FlowError> {
    ink::png(picture).map_err(|e| FlowError::io(path)(std::io::Error::other(e)))
}
