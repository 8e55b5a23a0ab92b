//! A turntable: the last picture of a view, from all around.

use super::{FlowError, Job, overview::WIDEST, preview::Stand};
use crate::cache;
use crate::math::{Mat3, Real, Vec3};
use crate::preview::{Camera, PictureSettings, animation};
use image::RgbImage;

/// Pictures a second: 36 of them take three seconds.
const PACE: Real = 12.0;

/// Draws those that the recipe asks for, out of the last of the chosen frames.
pub(super) fn write(job: &Job, stand: &Stand<'_>) -> Result<(), FlowError> {
    let asked = |view: &crate::scene::View| view.turntable > 0;
    let last = job.folder.frames(job.frames)?.last().copied();
    let Some(last) = last.filter(|_| job.scene.preview.views.iter().any(asked)) else {
        return Ok(());
    };
    let frame = cache::read_frame(&job.folder.frame(last))?;
    let picture = smaller(&job.scene.preview.picture);
    for (n, view) in job.scene.preview.views.iter().enumerate() {
        if !asked(view) {
            continue;
        }
        let cement = stand.cement(&frame);
        let camera = around(&stand.camera(view), &stand.points());
        let pictures = (0..view.turntable)
            .map(|k| {
                job.heed(None)?;
                let turn = std::f64::consts::TAU * Real::from(k) / Real::from(view.turntable);
                let backdrop = stand.backdrop(view, &turned(&camera, turn), &picture);
                Ok(stand.draw(&cement, n, &backdrop))
            })
            .collect::<Result<Vec<RgbImage>, FlowError>>()?;
        let path = job.folder.turntable(&view.name);
        let bytes = animation(&pictures.iter().collect::<Vec<_>>(), PACE);
        cache::write(&path, &bytes.map_err(FlowError::io(&path))?)?;
    }
    Ok(())
}

/// As small as pictures of an animation are.
fn smaller(picture: &PictureSettings) -> PictureSettings {
    let times = picture.width.div_ceil(WIDEST[1]).max(1);
    PictureSettings {
        width: (picture.width / times).max(1),
        height: (picture.height / times).max(1),
        ..*picture
    }
}

/// Far enough back that `points` stay in the picture from all sides: as far as it has to be for the widest of them,
/// which the view itself may have seen end-on.
fn around(camera: &Camera, points: &[Vec3]) -> Camera {
    let across = |p: &Vec3| (p - camera.target).xy().norm();
    let reach = |along: &dyn Fn(&Vec3) -> Real| {
        points
            .iter()
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .map(along)
            .fold(0.0, Real::max)
    };
    let away = camera.position - camera.target;
    let side = Vec3::z().cross(&away).try_normalize(1e-12);
    let Some(side) = side else {
        return *camera;
    };
    let seen = reach(&|p| side.dot(&(p - camera.target)).abs());
    let widest = reach(&across);
    let back = if seen > 0.0 {
        (widest / seen).max(1.0)
    } else {
        1.0
    };
    Camera {
        position: camera.target + away * back,
        ..*camera
    }
}

/// Turned about the upright axis through the target.
fn turned(camera: &Camera, angle: Real) -> Camera {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let turn = Mat3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    Camera {
        position: camera.target + turn * (camera.position - camera.target),
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plank_seen_end_on_stays_in_the_picture_all_around() {
        let plank: Vec<Vec3> = [-1.0, 1.0]
            .into_iter()
            .flat_map(|y| [-0.1, 0.1].map(|x| Vec3::new(x, y, 0.2 * x)))
            .collect();
        let camera = around(&Camera::fitting(&plank, 1.0, 0.0, 0.3, 0.5), &plank);
        for k in 0..12 {
            let now = turned(&camera, std::f64::consts::TAU * f64::from(k) / 12.0);
            let forward = (now.target - now.position).normalize();
            let right = forward.cross(&Vec3::z()).normalize();
            for p in &plank {
                let to = p - now.position;
                let slope = to.dot(&right).abs() / to.dot(&forward);
                assert!(slope < libm::tan(0.25), "{k}: {slope}");
            }
        }
        let whole = turned(&camera, std::f64::consts::TAU);
        assert!((whole.position - camera.position).norm() < 1e-12);
    }
}
