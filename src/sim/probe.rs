//! Probes: what a gauge, a flow meter or a row of velocity meters would read; no part of the state.

use crate::math::{Aabb, Real, Vec3};
use serde::{Deserialize, Serialize};

/// A gauge with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// What its columns begin with.
    pub name: String,
    /// What it measures.
    pub gauge: Gauge,
}

/// What a probe measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gauge {
    /// Mean pressure of the fluid in a ball [Pa].
    Pressure {
        /// Its centre [m].
        centre: Vec3,
        /// Its radius [m].
        radius: Real,
    },
    /// Volume per time through a disc, along its normal [m³/s]: Σ V v·n / w over a slab w thick.
    Flux {
        /// Its centre [m].
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
        /// Its radius [m].
        radius: Real,
    },
    /// The box around the fluid, and its centre of volume [m].
    Extents,
    /// Mean velocity [m/s] along `direction`, in equal parts of a line from one point to another.
    Profile {
        /// Where the line begins [m].
        from: Vec3,
        /// Where it ends [m].
        to: Vec3,
        /// How far off the line fluid counts [m].
        radius: Real,
        /// Unit vector.
        direction: Vec3,
        /// How many parts.
        parts: usize,
    },
}

/// Thickness of a flow meter, in spacings: fewer do not hold a particle at all times, more smear.
const SLAB: Real = 2.0;

/// The fluid that probes look at.
#[derive(Clone, Copy)]
pub struct Sample<'a> {
    /// x_i [m].
    pub position: &'a [Vec3],
    /// v_mix [m/s].
    pub velocity: &'a [Vec3],
    /// Pressure [Pa].
    pub pressure: &'a [Real],
    /// V₀ [m³].
    pub rest_volume: Real,
    /// Between particles at rest [m].
    pub spacing: Real,
}

impl Probe {
    /// Names of its columns, with units.
    pub fn columns(&self) -> Vec<String> {
        let name = |what: &str| format!("{}_{what}", self.name.replace(' ', "_"));
        match &self.gauge {
            Gauge::Pressure { .. } => vec![name("pressure_Pa")],
            Gauge::Flux { .. } => vec![name("flux_m3_s")],
            Gauge::Extents => ["min", "max", "centre"]
                .iter()
                .flat_map(|end| ["x", "y", "z"].map(|axis| name(&format!("{end}_{axis}_m"))))
                .collect(),
            Gauge::Profile { parts, .. } => {
                (0..*parts).map(|n| name(&format!("{n:03}_m_s"))).collect()
            }
        }
    }

    /// Its readings, one a column; none where there is no fluid to read.
    pub fn read(&self, fluid: Sample<'_>) -> Vec<Option<Real>> {
        let all = 0..fluid.position.len();
        match &self.gauge {
            Gauge::Pressure { centre, radius } => {
                let near = all.filter(|&i| (fluid.position[i] - centre).norm() <= *radius);
                vec![mean(near.map(|i| fluid.pressure[i]))]
            }
            Gauge::Flux {
                point,
                normal,
                radius,
            } => {
                let thickness = SLAB * fluid.spacing;
                let flux: Real = all
                    .filter(|&i| {
                        let x = fluid.position[i] - point;
                        let along = x.dot(normal);
                        along.abs() <= 0.5 * thickness && (x - normal * along).norm() <= *radius
                    })
                    .map(|i| fluid.velocity[i].dot(normal))
                    .sum();
                vec![Some(flux * fluid.rest_volume / thickness)]
            }
            Gauge::Extents => {
                if fluid.position.is_empty() {
                    return vec![None; 9];
                }
                let Aabb { min, max } = Aabb::around(fluid.position);
                let sum: Vec3 = fluid.position.iter().sum();
                let centre = sum / fluid.position.len() as Real;
                let ends = [min, max, centre];
                ends.iter()
                    .flat_map(|x| [x.x, x.y, x.z].map(Some))
                    .collect()
            }
            Gauge::Profile {
                from,
                to,
                radius,
                direction,
                parts,
            } => {
                let line = to - from;
                let mut found = vec![Vec::new(); *parts];
                for i in all {
                    let x = fluid.position[i] - from;
                    let share = x.dot(&line) / line.norm_squared();
                    let part = (share * *parts as Real).floor();
                    let beside = (x - line * share).norm() <= *radius;
                    if beside && (0.0..*parts as Real).contains(&part) {
                        found[part as usize].push(fluid.velocity[i].dot(direction));
                    }
                }
                found
                    .into_iter()
                    .map(|part| mean(part.into_iter()))
                    .collect()
            }
        }
    }
}

fn mean(values: impl Iterator<Item = Real>) -> Option<Real> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), v| (sum + v, count + 1));
    (count > 0).then(|| sum / Real::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(gauge: Gauge) -> Probe {
        Probe {
            name: "a b".into(),
            gauge,
        }
    }

    /// A lattice in which v_z = 1 + 2 x and p = 1000 z.
    #[test]
    fn readings_of_a_known_flow() {
        let dx = 0.05;
        let mut position = Vec::new();
        for x in 0..20 {
            for y in 0..20 {
                for z in 0..20 {
                    let cell = Vec3::new(f64::from(x), f64::from(y), f64::from(z));
                    position.push(cell.add_scalar(0.5) * dx);
                }
            }
        }
        let velocity: Vec<Vec3> = position
            .iter()
            .map(|x| Vec3::z() * (1.0 + 2.0 * x.x))
            .collect();
        let pressure: Vec<Real> = position.iter().map(|x| 1000.0 * x.z).collect();
        let fluid = Sample {
            position: &position,
            velocity: &velocity,
            pressure: &pressure,
            rest_volume: dx * dx * dx,
            spacing: dx,
        };
        let middle = Vec3::repeat(0.5);
        let read = |gauge| probe(gauge).read(fluid);
        let gauge = read(Gauge::Pressure {
            centre: middle,
            radius: 0.2,
        });
        assert!((gauge[0].unwrap() - 500.0).abs() < 1e-9);
        // Through the whole cross-section of a unit box: mean of 1 + 2x is 2.
        let flux = read(Gauge::Flux {
            point: middle,
            normal: -Vec3::z(),
            radius: 1.0,
        });
        assert!((flux[0].unwrap() + 2.0).abs() < 1e-9, "{flux:?}");
        let extents = read(Gauge::Extents);
        assert!((extents[0].unwrap() - 0.025).abs() < 1e-12);
        assert!((extents[8].unwrap() - 0.5).abs() < 1e-12);
        let profile = Gauge::Profile {
            from: Vec3::new(0.0, 0.5, 0.5),
            to: Vec3::new(1.2, 0.5, 0.5),
            radius: 0.1,
            direction: Vec3::z(),
            parts: 12,
        };
        let columns = probe(profile.clone()).columns();
        assert_eq!((columns.len(), columns[3].as_str()), (12, "a_b_003_m_s"));
        for (n, v) in read(profile).into_iter().enumerate() {
            let exact = 1.0 + 2.0 * (n as Real + 0.5) * 0.1;
            match v {
                Some(v) => assert!((v - exact).abs() < 1e-9, "{n}: {v}"),
                None => assert!(n >= 10),
            }
        }
        let none = Sample {
            position: &[],
            ..fluid
        };
        assert_eq!(probe(Gauge::Extents).read(none), vec![None; 9]);
    }
}
