//! Files read back by two other implementations.

use super::*;
use crate::cache::Frame;
use crate::export::{ExportSettings, grids};
use crate::math::{Stream, Vec3};
use std::collections::BTreeMap;
use std::io::Cursor;

/// Leaves of random voxels on both sides of the root's borders, in no order.
fn scattered<T: Copy>(zero: T, mut value: impl FnMut(&mut Stream) -> T) -> Vec<Leaf<T>> {
    let mut random = Stream::new(7, "voxels");
    [
        [0, 0, 0],
        [8000, -16, 24],
        [-8, -8, -8],
        [-4096, 0, 0],
        [-4104, 8, 0],
        [0, 128, 0],
        [0, 0, 1024],
        [8, 0, 0],
    ]
    .map(|first| {
        let mut leaf = Leaf {
            first,
            active: [0; 8],
            values: Box::new([zero; 512]),
        };
        for i in 0..512 {
            if random.unit() < 0.3 {
                leaf.active[i >> 6] |= 1 << (i & 63);
                leaf.values[i] = value(&mut random);
            }
        }
        leaf
    })
    .into()
}

fn active<T: Copy>(leaves: &[Leaf<T>]) -> BTreeMap<[i32; 3], T> {
    let mut voxels = BTreeMap::new();
    for leaf in leaves {
        for i in 0..512_i32 {
            if leaf.active[i as usize >> 6] >> (i & 63) & 1 == 1 {
                let [x, y, z] = leaf.first;
                let voxel = [x + (i >> 6), y + (i >> 3 & 7), z + (i & 7)];
                voxels.insert(voxel, leaf.values[i as usize]);
            }
        }
    }
    voxels
}

fn sample() -> Vec<Grid> {
    let grid = |name: &str, leaves| Grid {
        name: name.into(),
        class: Class::Fog,
        origin: Vec3::new(0.5, -0.25, 2.0),
        voxel: 0.3e-3,
        leaves,
    };
    vec![
        grid(
            "density",
            Leaves::Float(scattered(0.0, |r| r.between(-1.0, 1.0) as f32)),
        ),
        grid(
            "velocity",
            Leaves::Vec3(scattered([0.0; 3], |r| {
                let v = r.cube();
                [v.x as f32, v.y as f32, v.z as f32]
            })),
        ),
        grid("nothing", Leaves::Float(Vec::new())),
    ]
}

fn bytes(grids: &[Grid]) -> Vec<u8> {
    stored(grids, Storage::default())
}

fn stored(grids: &[Grid], storage: Storage) -> Vec<u8> {
    let mut file = Vec::new();
    write(&mut file, grids, storage).unwrap();
    file
}

/// Every float grid through vdb-rs, every grid through OpenVDB-rs: same voxels, same values, same place.
fn assert_read_back(grids: &[Grid]) {
    for codec in [Codec::Blosc, Codec::Zip, Codec::None] {
        assert_read_back_from(grids, &stored(grids, Storage { codec, half: false }));
    }
}

fn assert_read_back_from(grids: &[Grid], file: &[u8]) {
    let mut reader = vdb_rs::VdbReader::new(Cursor::new(file)).unwrap();
    let (_, read) = OpenVDB_rs::io::read_stream(Cursor::new(file)).unwrap();
    assert_eq!(read.len(), grids.len());
    for (grid, read) in grids.iter().zip(&read) {
        assert_eq!(read.name(), grid.name);
        let corner = read
            .transform()
            .index_to_world(OpenVDB_rs::Vec3d::new(1.0, 2.0, -3.0));
        let expected = grid.origin + Vec3::new(1.0, 2.0, -3.0) * grid.voxel;
        assert!((Vec3::new(corner.x(), corner.y(), corner.z()) - expected).norm() < 1e-12);
        let mut found = BTreeMap::new();
        match &grid.leaves {
            Leaves::Float(leaves) => {
                let expected = active(leaves);
                for (at, value) in read.as_float().unwrap().tree().active_voxels() {
                    found.insert([at.x(), at.y(), at.z()], value);
                }
                assert_eq!(found, expected);
                let other = reader.read_grid::<f32>(&grid.name).unwrap();
                let count = other.descriptor.voxel_count().unwrap();
                assert_eq!(count, expected.len() as i64);
                found.clear();
                for (at, value, level) in other.iter() {
                    assert!(level == vdb_rs::VdbLevel::Voxel);
                    found.insert([at.x as i32, at.y as i32, at.z as i32], value);
                }
                assert_eq!(found, expected);
            }
            Leaves::Vec3(leaves) => {
                let expected = active(leaves);
                let read = read.as_vec3s().unwrap();
                assert_eq!(
                    read.vector_type(),
                    OpenVDB_rs::VecType::ContravariantRelative
                );
                let mut found = BTreeMap::new();
                for (at, v) in read.tree().active_voxels() {
                    found.insert([at.x(), at.y(), at.z()], [v.x(), v.y(), v.z()]);
                }
                assert_eq!(found, expected);
            }
        }
    }
}

/// A drop of 500 particles that turns about the world's z axis.
fn frame() -> Frame {
    let mut random = Stream::new(9, "drop");
    let position: Vec<[f32; 3]> = (0..500)
        .map(|_| (random.cube() * 4e-3).map(|x| x as f32).into())
        .collect();
    Frame {
        spacing: 1e-3,
        rest_volume: 1e-9,
        support_radius: 2e-3,
        velocity: position.iter().map(|[x, y, _]| [-y, *x, 0.5]).collect(),
        polymer_fraction: vec![0.7; 500],
        position,
        ..Frame::default()
    }
}

#[test]
fn two_other_readers_find_the_same_voxels() {
    assert_read_back(&sample());
    assert_read_back(&[]);
    assert_read_back(&grids::from_frame(&frame(), &ExportSettings::default()));
    let empty = grids::from_frame(&Frame::default(), &ExportSettings::default());
    assert_eq!(empty.len(), 3);
    assert_read_back(&empty);
}

#[test]
fn the_same_frame_gives_the_same_bytes_on_any_number_of_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bytes(&grids::from_frame(&frame(), &ExportSettings::default())))
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3) && one == on(1));
    let mut moved = frame();
    moved.position[3][0] += 1e-4;
    let other = bytes(&grids::from_frame(&moved, &ExportSettings::default()));
    assert_ne!(one[UUID], other[UUID], "the identity follows the content");
}

#[test]
fn two_grids_of_one_name_are_refused() {
    let mut grids = sample();
    grids[1].name = "density".into();
    let error = write(&mut Vec::new(), &grids, Storage::default()).unwrap_err();
    assert!(error.to_string().contains("density"), "{error}");
}

#[test]
fn halves_are_the_nearest_there_are() {
    let grids = sample();
    let nearest = |x: f32| half::f16::from_f32(x).to_f32();
    for codec in [Codec::Blosc, Codec::Zip, Codec::None] {
        let file = stored(&grids, Storage { codec, half: true });
        assert!(file.len() < stored(&grids, Storage { codec, half: false }).len());
        let (_, read) = OpenVDB_rs::io::read_stream(Cursor::new(&file)).unwrap();
        for (grid, read) in grids.iter().zip(&read) {
            match &grid.leaves {
                Leaves::Float(leaves) => {
                    let expected = active(leaves);
                    let voxels = read.as_float().unwrap().tree().active_voxels();
                    let found: BTreeMap<_, _> = voxels
                        .map(|(at, v)| ([at.x(), at.y(), at.z()], v))
                        .collect();
                    let expected: BTreeMap<_, _> = expected
                        .into_iter()
                        .map(|(at, v)| (at, nearest(v)))
                        .collect();
                    assert_eq!(found, expected);
                }
                Leaves::Vec3(leaves) => {
                    let voxels = read.as_vec3s().unwrap().tree().active_voxels();
                    let found: BTreeMap<_, _> = voxels
                        .map(|(at, v)| ([at.x(), at.y(), at.z()], [v.x(), v.y(), v.z()]))
                        .collect();
                    let expected: BTreeMap<_, _> = active(leaves)
                        .into_iter()
                        .map(|(at, v)| (at, v.map(nearest)))
                        .collect();
                    assert_eq!(found, expected);
                }
            }
        }
    }
}

#[test]
fn a_level_set_keeps_its_sides() {
    let background = 0.3;
    let mut leaves = scattered(0.0, |r| r.between(-0.3, 0.3) as f32);
    for (n, leaf) in leaves.iter_mut().enumerate() {
        for i in 0..512 {
            if leaf.active[i >> 6] >> (i & 63) & 1 == 0 {
                let inside = n % 3 == 1 || n % 3 == 2 && i % 5 == 0;
                leaf.values[i] = if inside { -background } else { background };
            }
        }
    }
    let grid = Grid {
        name: "surface".into(),
        class: Class::LevelSet { background },
        origin: Vec3::zeros(),
        voxel: 0.1,
        leaves: Leaves::Float(leaves.clone()),
    };
    for codec in [Codec::Blosc, Codec::Zip, Codec::None] {
        let file = stored(std::slice::from_ref(&grid), Storage { codec, half: false });
        let (_, read) = OpenVDB_rs::io::read_stream(Cursor::new(&file)).unwrap();
        let read = read[0].as_float().unwrap();
        for leaf in &leaves {
            for i in 0..512_i32 {
                let [x, y, z] = leaf.first;
                let at = OpenVDB_rs::Coord::new(x + (i >> 6), y + (i >> 3 & 7), z + (i & 7));
                assert_eq!(read.tree().get_value(&at), leaf.values[i as usize]);
            }
        }
    }
}
