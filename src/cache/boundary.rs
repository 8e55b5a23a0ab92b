//! Walls on disk: wall particles, and the solid that they stand for.
//!
//! Distances are kept as whole steps of a 32 767th of the greatest of their grid: half a micrometre of a centimetre,
//! and half the bytes.

use super::CacheError;
use super::container::{self, Column, Container};
use crate::grid::BrickGrid;
use crate::math::Vec3;
use crate::solid::{Shape, Solid};
use crate::sph::WallParticles;
use serde::{Deserialize, Serialize};
use std::path::Path;

const WALLS: &str = "walls";
const SOLID: &str = "solid";
const NODES: usize = 512;

#[derive(Serialize, Deserialize)]
struct SolidMeta {
    shapes: Vec<Shape>,
    grids: Vec<GridMeta>,
}

#[derive(Serialize, Deserialize)]
struct GridMeta {
    origin: Vec3,
    voxel: f64,
    background: f32,
    /// Distance that one step stands for [m].
    step: f32,
}

/// Writes wall particles.
pub fn write_walls(path: &Path, walls: &WallParticles) -> Result<(), CacheError> {
    let columns = vec![
        Column::new("position", walls.position.iter().map(|x| [x.x, x.y, x.z])),
        Column::new("volume", walls.volume.iter().map(|&v| [v])),
    ];
    container::write(path, WALLS, &(), columns)
}

/// Reads wall particles.
pub fn read_walls(path: &Path) -> Result<WallParticles, CacheError> {
    let mut file = Container::read(path, WALLS)?;
    let position = file.take_points::<f64>("position", None)?;
    let volume = file.take_finite("volume", Some(position.len()))?;
    Ok(WallParticles {
        position: position.into_iter().map(Vec3::from).collect(),
        volume,
    })
}

/// Writes a solid: its shapes in the header, its grids as bricks.
pub fn write_solid(path: &Path, solid: &Solid) -> Result<(), CacheError> {
    let grids = solid.grids.iter().map(|grid| GridMeta {
        origin: grid.origin,
        voxel: grid.voxel,
        background: grid.background,
        step: step_of(grid),
    });
    let meta = SolidMeta {
        shapes: solid.shapes.clone(),
        grids: grids.collect(),
    };
    let names: Vec<_> = (0..solid.grids.len()).map(names).collect();
    let mut columns = Vec::new();
    for (grid, (first, values)) in solid.grids.iter().zip(&names) {
        let places: Vec<[i32; 3]> = grid.bricks().map(|b| b.0).collect();
        columns.push(Column::new(first, places.into_iter()));
        columns.push(Column::new(values, steps_of(grid).into_iter().map(|s| [s])));
    }
    container::write(path, SOLID, &meta, columns)
}

/// Reads a solid.
pub fn read_solid(path: &Path) -> Result<Solid, CacheError> {
    let damaged = |what: &str| CacheError::damaged(path, what);
    let mut file = Container::read(path, SOLID)?;
    let meta: SolidMeta = file.meta()?;
    let mut grids = Vec::new();
    for (n, grid) in meta.grids.into_iter().enumerate() {
        if !(grid.voxel > 0.0 && grid.voxel.is_finite()) {
            return Err(damaged("a grid's voxel is not above zero"));
        }
        let (first, values) = names(n);
        let first = file.take::<i32>(&first)?;
        let (first, rest) = first.as_chunks::<3>();
        let values = file.take::<i16>(&values)?;
        if values.len() != NODES * first.len() || !grid.step.is_finite() {
            return Err(damaged("its values do not fit its bricks"));
        }
        if !rest.is_empty() || first.iter().flatten().any(|f| f % 8 != 0) {
            return Err(damaged("a brick starts between bricks"));
        }
        let mut bricks = BrickGrid::new(grid.origin, grid.voxel, grid.background);
        for (first, values) in first.iter().zip(values.as_chunks::<NODES>().0) {
            let values = values.map(|steps| f32::from(steps) * grid.step);
            bricks.insert_brick(*first, Box::new(values));
        }
        grids.push(bricks);
    }
    Ok(Solid {
        shapes: meta.shapes,
        grids,
    })
}

/// The step with which the greatest value still fits.
fn step_of(grid: &BrickGrid) -> f32 {
    let values = grid.bricks().flat_map(|brick| brick.1.iter());
    let greatest = values.fold(0.0_f32, |most, value| most.max(value.abs()));
    greatest.max(f32::MIN_POSITIVE) / f32::from(i16::MAX)
}

fn steps_of(grid: &BrickGrid) -> Vec<i16> {
    let step = step_of(grid);
    let values = grid.bricks().flat_map(|brick| brick.1.iter());
    values.map(|value| (value / step).round() as i16).collect()
}

fn names(grid: usize) -> (String, String) {
    (format!("grid{grid}.first"), format!("grid{grid}.values"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn walls_and_solids_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walls.osf");
        let mut random = Stream::new(1, "boundary");
        let walls = WallParticles {
            position: (0..100).map(|_| random.cube()).collect(),
            volume: (0..100).map(|_| random.unit()).collect(),
        };
        write_walls(&path, &walls).unwrap();
        let read = read_walls(&path).unwrap();
        assert_eq!((read.position, read.volume), (walls.position, walls.volume));
        assert!(
            read_solid(&path)
                .unwrap_err()
                .to_string()
                .contains("it holds a walls")
        );

        let mut grid = BrickGrid::new(random.cube(), 0.1 + 0.2, 3.5);
        for _ in 0..200 {
            let node = random.cube() * 40.0;
            grid.set(
                [node.x as i32, node.y as i32, node.z as i32],
                random.unit() as f32,
            );
        }
        let solid = Solid {
            shapes: vec![Shape::Sphere {
                centre: random.cube(),
                radius: random.unit(),
                hollow: true,
            }],
            grids: vec![grid, BrickGrid::new(Vec3::zeros(), 1.0, 0.0)],
        };
        write_solid(&path, &solid).unwrap();
        let read = read_solid(&path).unwrap();
        assert_eq!(read.shapes, solid.shapes);
        assert_eq!(read.grids.len(), 2);
        for (a, b) in read.grids.iter().zip(&solid.grids) {
            assert_eq!(
                (a.origin, a.voxel, a.background),
                (b.origin, b.voxel, b.background)
            );
            assert_eq!(a.brick_count(), b.brick_count());
            for ((place, values), (same, exact)) in a.bricks().zip(b.bricks()) {
                assert_eq!(place, same);
                let near = |(v, e): (&f32, &f32)| (v - e).abs() < 3.5 / 65_000.0;
                assert!(values.iter().zip(exact).all(near));
            }
        }
        // What was read once is not changed by being written again.
        write_solid(&path, &read).unwrap();
        let again = read_solid(&path).unwrap();
        for (a, b) in again.grids.iter().zip(&read.grids) {
            assert!(a.bricks().eq(b.bricks()));
        }
    }
}
