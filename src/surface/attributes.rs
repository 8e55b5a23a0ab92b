//! What the vertices of a surface carry: means of what the particles around them carry, and the direction outwards.

use super::cubes::Cut;
use super::field::Field;
use crate::cache::Frame;
use crate::grid::NearPoints;
use crate::math::{Real, Vec3};

/// Channels of the table: polymer fraction, velocity (3), pressure, shear rate, age, neighbours.
const CHANNELS: usize = 8;

/// Everything on a vertex but its place.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carried {
    pub normal: Vec3,
    pub polymer_fraction: f32,
    pub velocity: [f32; 3],
    pub pressure: f32,
    pub shear_rate: f32,
    pub millilitre: f32,
    pub neighbours: f32,
}

/// What each sorted particle carries.
pub(super) struct Table(Vec<[f32; CHANNELS]>);

impl Table {
    pub fn new(frame: &Frame, velocity: &[[f32; 3]], field: &Field) -> Self {
        let shear = shear_rates(frame, field);
        let rows = field.points.order.iter().enumerate().map(|(row, &i)| {
            let i = i as usize;
            let [u, v, w] = velocity[i];
            // Particles are numbered as they enter.
            let entered = frame.id.get(i).map_or(0.0, |&id| Real::from(id) + 0.5);
            [
                frame.polymer_fraction[i],
                u,
                v,
                w,
                frame.pressure.get(i).copied().unwrap_or(0.0),
                shear[row],
                (entered * frame.rest_volume * 1e6) as f32,
                field.neighbours[row],
            ]
        });
        Self(rows.collect())
    }
}

/// √(2 D:D) of each sorted particle [1/s], D the symmetric part of the velocity gradient.
fn shear_rates(frame: &Frame, field: &Field) -> Vec<f32> {
    let velocity = |row: usize| frame.velocity[field.points.order[row] as usize];
    field.points.map_points(
        |near| [0, 1, 2].map(|axis| near.pick(|row| velocity(row)[axis])),
        |near, around, at, row| {
            let gradient = near.gradient(at, velocity(row), around);
            let d = (gradient + gradient.transpose()) * (0.5 / field.cube);
            (2.0 * d.norm_squared()).sqrt() as f32
        },
    )
}

/// The particles around a brick, ready to be asked.
pub(super) struct Surroundings {
    near: NearPoints,
    volume: Vec<f32>,
    channels: [Vec<f32>; CHANNELS],
}

impl Surroundings {
    pub fn new(field: &Field, table: &Table, brick: usize) -> Self {
        let near = field.points.near(field.keys[brick]);
        Self {
            volume: near.pick(|j| field.volume[j]),
            channels: std::array::from_fn(|c| near.pick(|j| table.0[j][c])),
            near,
        }
    }

    /// What is carried at a cut.
    pub fn at(&self, cut: Cut) -> Carried {
        let mut sums = self
            .near
            .place_sums(cut.place(), &self.volume, &self.channels);
        if sums.weight <= 0.0 {
            // A wide cube may be cut where no particle reaches; its inside end is always in reach.
            let mut inside = cut.node().map(|n| n as f32);
            inside[cut.axis()] += if cut.rising { 0.0 } else { 1.0 };
            sums = self.near.place_sums(inside, &self.volume, &self.channels);
        }
        let outwards = if cut.rising { 1.0 } else { -1.0 };
        let gradient = Vec3::from(sums.gradient.map(Real::from));
        let mean = sums.channels.map(|sum| sum / sums.weight);
        Carried {
            normal: (-gradient)
                .try_normalize(1e-9)
                .unwrap_or_else(|| Vec3::ith(cut.axis(), outwards)),
            polymer_fraction: mean[0],
            velocity: [mean[1], mean[2], mean[3]],
            pressure: mean[4],
            shear_rate: mean[5],
            millilitre: mean[6],
            neighbours: mean[7],
        }
    }
}
