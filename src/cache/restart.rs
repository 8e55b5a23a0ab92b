//! The state of a stopped simulation on disk.

use super::CacheError;
use super::container::{self, Column, Container, Element, Finite};
use crate::fluid::{FluidParticles, PerPhase};
use crate::math::{Sym3, Vec3};
use crate::sim::{Progress, State};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

const KIND: &str = "restart";

/// What a simulation goes on from.
#[derive(Clone, Debug, PartialEq)]
pub struct Restart<T> {
    /// Of the solver.
    pub state: State,
    /// Of whoever runs it.
    pub record: T,
}

#[derive(Serialize, Deserialize)]
struct Meta<T> {
    progress: Progress,
    record: T,
}

/// Writes a restart file; once this returns, it survives a power cut.
pub fn write_restart(
    path: &Path,
    fluid: &FluidParticles,
    progress: &Progress,
    record: &impl Serialize,
) -> Result<(), CacheError> {
    let velocity = fluid.phase_velocity.iter().map(|v| {
        let PerPhase { liquid, polymer } = v;
        [
            liquid.x, liquid.y, liquid.z, polymer.x, polymer.y, polymer.z,
        ]
    });
    let conformation = fluid.conformation.iter();
    let conformation = conformation.map(|u| [u.xx, u.yy, u.zz, u.xy, u.xz, u.yz]);
    let columns = vec![
        Column::new("position", fluid.position.iter().map(|x| [x.x, x.y, x.z])),
        Column::new("phase_velocity", velocity),
        Column::new(
            "polymer_fraction",
            fluid.polymer_fraction.iter().map(|&a| [a]),
        ),
        Column::new("conformation", conformation),
        Column::new("pressure", fluid.pressure.iter().copied()),
        Column::new("change", fluid.change.iter().map(|v| [v.x, v.y, v.z])),
        Column::new("id", fluid.id.iter().map(|&id| [id])),
        Column::new("origin", fluid.origin.iter().map(|&o| [u32::from(o)])),
    ];
    let meta = Meta {
        progress: progress.clone(),
        record,
    };
    container::write(path, KIND, &meta, columns)
}

/// Reads a restart file: every array has one row a particle and holds finite numbers.
pub fn read_restart<T: DeserializeOwned>(path: &Path) -> Result<Restart<T>, CacheError> {
    let mut file = Container::read(path, KIND)?;
    let Meta { progress, record } = file.meta()?;
    let position: Vec<[f64; 3]> = file.take_points("position", None)?;
    let count = position.len();
    let velocity = rows::<f64, 6>(&mut file, "phase_velocity", count)?;
    let conformation = file.take_finite::<f64>("conformation", None)?;
    // Empty where none is held.
    let (conformation, rest) = conformation.as_chunks::<6>();
    if !rest.is_empty() || ![0, count].contains(&conformation.len()) {
        let what = "`conformation` has the wrong length";
        return Err(CacheError::damaged(path, what));
    }
    let whole = |values: Vec<u32>, what: &str| {
        if values.len() == count {
            Ok(values)
        } else {
            let what = format!("`{what}` has the wrong length");
            Err(CacheError::damaged(path, what))
        }
    };
    let id = whole(file.take("id")?, "id")?;
    let origin = whole(file.take("origin")?, "origin")?;
    let origin = origin.into_iter().map(u16::try_from);
    let origin = origin
        .collect::<Result<_, _>>()
        .map_err(|_| CacheError::damaged(path, "`origin` holds a number out of range"))?;
    let fluid = FluidParticles {
        position: position.into_iter().map(Vec3::from).collect(),
        phase_velocity: velocity
            .into_iter()
            .map(|[a, b, c, d, e, f]| PerPhase {
                liquid: Vec3::new(a, b, c),
                polymer: Vec3::new(d, e, f),
            })
            .collect(),
        polymer_fraction: file.take_finite("polymer_fraction", Some(count))?,
        conformation: conformation
            .iter()
            .map(|&[xx, yy, zz, xy, xz, yz]| Sym3 {
                xx,
                yy,
                zz,
                xy,
                xz,
                yz,
            })
            .collect(),
        pressure: rows::<f64, 2>(&mut file, "pressure", count)?,
        change: rows::<f64, 3>(&mut file, "change", count)?
            .into_iter()
            .map(Vec3::from)
            .collect(),
        id,
        origin,
    };
    Ok(Restart {
        state: State { fluid, progress },
        record,
    })
}

fn rows<T: Element + Finite, const N: usize>(
    file: &mut Container,
    name: &str,
    count: usize,
) -> Result<Vec<[T; N]>, CacheError> {
    let flat = file.take_finite::<T>(name, Some(N * count))?;
    Ok(flat.as_chunks::<N>().0.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::sim::{InletProgress, Tally};
    use proptest::prelude::*;
    use std::fs;

    fn restart(particles: usize) -> Restart<(u32, f64)> {
        let mut random = Stream::new(3, "restart");
        let mut fluid = FluidParticles::default();
        for i in 0..particles {
            fluid.push(random.cube(), random.cube(), random.unit(), i as u32, 3);
            fluid.phase_velocity[i].polymer = random.cube();
            fluid.pressure[i] = [random.unit() * 1e5, -0.0];
            fluid.change[i] = random.cube();
        }
        if particles != 1 {
            fluid.hold_conformation();
            for u in &mut fluid.conformation {
                u.xy = random.unit();
            }
        }
        let tally = Tally {
            residual: [1e-300, random.unit()],
            ..Tally::default()
        };
        let progress = Progress {
            time: 0.1 + 0.2,
            steps: 12,
            carved: 3,
            caution: Some(1.0 / 7.0),
            pace: Some(random.unit()),
            last_step: random.unit(),
            inlets: vec![InletProgress {
                travelled: random.unit(),
                pushed: random.unit(),
                emitted: 1.0 / 3.0,
                pressure: -random.unit(),
            }],
            tally,
        };
        Restart {
            state: State { fluid, progress },
            record: (7, random.unit()),
        }
    }

    fn write(path: &Path, restart: &Restart<(u32, f64)>) {
        let State { fluid, progress } = &restart.state;
        write_restart(path, fluid, progress, &restart.record).unwrap();
    }

    #[test]
    fn states_come_back_with_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/state.osf");
        for particles in [0, 1, 500] {
            let written = restart(particles);
            write(&path, &written);
            let read = read_restart::<(u32, f64)>(&path).unwrap();
            assert_eq!(read, written);
            // −0 equals 0: bits are compared where it matters.
            let bits = |r: &Restart<_>| -> Vec<u64> {
                let pressure = r.state.fluid.pressure.as_flattened();
                pressure.iter().map(|p| p.to_bits()).collect()
            };
            assert_eq!(bits(&read), bits(&written));
        }
        assert!(super::super::read_frame(&path).is_err());
    }

    proptest! {
        #[test]
        fn a_changed_or_missing_byte_never_passes(at in 0_usize..4000, change in 0_u8..) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("state.osf");
            write(&path, &restart(4));
            let mut bytes = fs::read(&path).unwrap();
            let at = at % bytes.len();
            if change == 0 {
                bytes.truncate(at);
            } else {
                bytes[at] ^= change;
            }
            fs::write(&path, bytes).unwrap();
            prop_assert!(read_restart::<(u32, f64)>(&path).is_err());
        }
    }
}
