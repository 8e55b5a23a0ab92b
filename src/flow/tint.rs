//! What the colours of the cement mean in a view, the same in all its pictures.

use super::{FlowError, Job};
use crate::cache::{self, Frame};
use crate::math::{Real, Vec3};
use crate::preview::{Chart, Colour, Legend, colour};
use crate::scene::Shows;
use crate::surface::Surface;

/// Share of the particles whose value the scale reaches. The few at the tip of a needle are under ten times the pressure of
/// those that are seen, and ten times as fast.
const REACHED: Real = 0.95;

/// A quantity, and the value of the last colour; the first stands for 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tint {
    shows: Shows,
    high: Real,
}

impl Tint {
    /// One a view, each scaled to all frames that there are.
    pub fn of_views(job: &Job) -> Result<Vec<Self>, FlowError> {
        let views = &job.scene.preview.views;
        let mut tints: Vec<Self> = (views.iter())
            .map(|view| Self {
                shows: view.colour,
                high: if view.colour == Shows::Polymer {
                    1.0
                } else {
                    0.0
                },
            })
            .collect();
        if tints.iter().any(|tint| tint.high == 0.0) {
            let mut scales = vec![Scale::default(); tints.len()];
            for n in job.folder.frames(None)? {
                job.heed(None)?;
                let frame = cache::read_frame(&job.folder.frame(n))?;
                for (tint, scale) in tints.iter().zip(&mut scales) {
                    if tint.shows != Shows::Polymer {
                        scale.add(of_particles(tint.shows, &frame));
                    }
                }
            }
            for (tint, scale) in tints.iter_mut().zip(&scales) {
                match tint.shows {
                    Shows::Polymer => {}
                    Shows::Age => tint.high = scale.most,
                    Shows::Pressure | Shows::Speed => tint.high = scale.mean(),
                }
            }
        }
        for tint in &mut tints {
            if tint.high <= 0.0 {
                tint.high = 1.0;
            }
        }
        Ok(tints)
    }

    /// The key to the colours.
    pub fn legend(&self) -> Legend {
        let (title, scale) = match self.shows {
            Shows::Polymer => ("polymer fraction", 1.0),
            Shows::Pressure if self.high >= 1000.0 => ("pressure [kPa]", 1e-3),
            Shows::Pressure => ("pressure [Pa]", 1.0),
            Shows::Speed if self.high < 0.1 => ("speed [mm/s]", 1e3),
            Shows::Speed => ("speed [m/s]", 1.0),
            Shows::Age => ("which millilitre", 1.0),
        };
        Legend {
            title: title.to_owned(),
            low: 0.0,
            high: self.high * scale,
            map: self.map(),
            position: self.position(),
        }
    }

    /// Where a share of the highest value lies on the scale. Pressures and speeds fall off within a few millimetres of a
    /// needle: by their roots, those farther on are told apart as well.
    fn position(&self) -> fn(Real) -> Real {
        match self.shows {
            Shows::Polymer | Shows::Age => |share| share,
            Shows::Pressure | Shows::Speed => |share| share.max(0.0).sqrt(),
        }
    }

    /// The colour of a position. Most of the cement is under no pressure, and hardly moves: there the darkest colours,
    /// on which no shape is to be seen, are left out.
    fn map(&self) -> fn(Real) -> Colour {
        match self.shows {
            Shows::Polymer | Shows::Age => colour::scale,
            Shows::Pressure | Shows::Speed => |position| colour::scale(0.3 + 0.7 * position),
        }
    }

    /// Colours of the vertices.
    pub fn colours(&self, surface: &Surface) -> Vec<Colour> {
        let speed;
        let values = match self.shows {
            Shows::Polymer => &surface.polymer_fraction,
            Shows::Pressure => &surface.pressure,
            Shows::Age => &surface.millilitre,
            Shows::Speed => {
                speed = surface.speed();
                &speed
            }
        };
        values.iter().map(|&v| self.colour(v)).collect()
    }

    /// Colours of the face that a plane, by a point and its normal, cuts through the cement: means over the particles
    /// within `reach` [m].
    pub fn chart(&self, frame: &Frame, plane: [&Vec3; 2], reach: Real) -> Chart {
        let values = of_particles(self.shows, frame);
        let sum: Real = values.iter().map(|&v| Real::from(v)).sum();
        let mean = self.colour((sum / values.len().max(1) as Real) as f32);
        let colour = |value| self.colour(value);
        Chart::new(plane, &frame.position, &values, reach, colour, mean)
    }

    fn colour(&self, value: f32) -> Colour {
        self.map()(self.position()(Real::from(value) / self.high))
    }
}

fn of_particles(shows: Shows, frame: &Frame) -> Vec<f32> {
    match shows {
        Shows::Polymer => frame.polymer_fraction.clone(),
        Shows::Pressure => frame.pressure.clone(),
        Shows::Speed => {
            let length = |[u, v, w]: &[f32; 3]| (u * u + v * v + w * w).sqrt();
            frame.velocity.iter().map(length).collect()
        }
        Shows::Age => {
            let each = frame.rest_volume * 1e6;
            let age = |&id: &u32| (Real::from(id) * each) as f32;
            frame.id.iter().map(age).collect()
        }
    }
}

/// What the values of frames come to.
#[derive(Clone, Copy, Debug, Default)]
struct Scale {
    /// The largest.
    most: Real,
    /// Sum over frames of the value reached, times the particles: the first frames are all needle, and hold few.
    sum: Real,
    count: Real,
}

impl Scale {
    fn add(&mut self, mut values: Vec<f32>) {
        let count = values.len() as Real;
        self.most = values.iter().fold(self.most, |m, &v| m.max(v.into()));
        self.sum += count * reached(&mut values);
        self.count += count;
    }

    fn mean(&self) -> Real {
        if self.count > 0.0 {
            self.sum / self.count
        } else {
            0.0
        }
    }
}

fn reached(values: &mut [f32]) -> Real {
    let Some(last) = values.len().checked_sub(1) else {
        return 0.0;
    };
    let at = (REACHED * last as Real) as usize;
    let (_, value, _) = values.select_nth_unstable_by(at, f32::total_cmp);
    Real::from(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_leaves_out_the_highest_twentieth_and_its_legend_has_units_to_read() {
        let mut values: Vec<f32> = (0..=1000).map(|n| n as f32).collect();
        values.reverse();
        assert_eq!(reached(&mut values), 950.0);
        assert_eq!(reached(&mut []), 0.0);
        // A small frame of high values moves the scale of pressures little, that of ages to its end.
        let mut scale = Scale::default();
        scale.add(values);
        scale.add(vec![1950.0; 1001 / 13]);
        scale.add(Vec::new());
        assert!((scale.mean() - (950.0 + 1000.0 / 14.0)).abs() < 0.1);
        assert_eq!((scale.most, Scale::default().mean()), (1950.0, 0.0));
        for (shows, high, title, top) in [
            (Shows::Pressure, 3400.0, "pressure [kPa]", 3.4),
            (Shows::Pressure, 340.0, "pressure [Pa]", 340.0),
            (Shows::Speed, 0.05, "speed [mm/s]", 50.0),
            (Shows::Speed, 2.0, "speed [m/s]", 2.0),
        ] {
            let legend = Tint { shows, high }.legend();
            assert_eq!(legend.title, title);
            assert!((legend.high - top).abs() < 1e-12 * top);
        }
        let surface = Surface {
            velocity: vec![[0.0, 0.03, 0.04], [0.0; 3]],
            pressure: vec![7.0, 2.0],
            ..Surface::default()
        };
        let tint = |shows| Tint { shows, high: 0.1 };
        let colour = |shows| tint(shows).colours(&surface);
        let half = colour(Shows::Speed)[0] - colour::scale(0.3 + 0.7 * 0.5_f64.sqrt());
        assert!(half.amax() < 1e-6);
        // What is seen beside the legend is what it says.
        let legend = tint(Shows::Speed).legend();
        assert_eq!(
            colour(Shows::Speed)[1],
            (legend.map)((legend.position)(0.0))
        );
        assert_eq!(
            tint(Shows::Pressure).colours(&surface)[1],
            colour::scale(1.0)
        );
    }
}
