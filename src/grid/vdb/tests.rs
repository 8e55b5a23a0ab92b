//! Files of every codec, written here bit by bit or by OpenVDB itself, and damaged ones.

use super::codec::{Input, Packing};
use super::*;

/// Packs values as OpenVDB would: the inverse of what is tested, by the libraries' own compressors.
fn packed(values: &[f32], flags: u32, half: bool) -> Vec<u8> {
    use std::io::Write;
    let raw: Vec<u8> = if half {
        // Of small whole numbers only.
        let to_half = |v: f32| {
            if v == 0.0 {
                0_u16
            } else {
                (v.to_bits() >> 13) as u16 - (112 << 10)
            }
        };
        values
            .iter()
            .flat_map(|v| to_half(*v).to_le_bytes())
            .collect()
    } else {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    };
    let each = if half { 2 } else { 4 };
    let payload = match flags & 5 {
        0 => return raw,
        1 => {
            let mut stream =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            stream.write_all(&raw).unwrap();
            stream.finish().unwrap()
        }
        _ => {
            let count = raw.len() / each;
            let mut shuffled = raw.clone();
            for i in 0..count {
                for b in 0..each {
                    shuffled[b * count + i] = raw[i * each + b];
                }
            }
            let lz4 = lz4_flex::block::compress(&shuffled);
            let mut frame = vec![2, 1, 0x31, each as u8];
            for word in [raw.len(), raw.len(), 24 + lz4.len(), 20, lz4.len()] {
                frame.extend((word as u32).to_le_bytes());
            }
            frame.extend(lz4);
            frame
        }
    };
    let mut out = (payload.len() as i64).to_le_bytes().to_vec();
    out.extend(payload);
    out
}

#[test]
fn every_way_of_packing_unpacks() {
    let mut active = [0_u64; 8];
    for i in (0..512).filter(|i| i % 3 == 0) {
        active[i >> 6] |= 1 << (i & 63);
    }
    let all: Vec<f32> = (0..512).map(|i| (i % 40) as f32).collect();
    let stored: Vec<f32> = all.iter().step_by(3).copied().collect();
    for codec in [0, 1, 4] {
        for half in [false, true] {
            let packing = |flags| Packing {
                flags,
                half,
                double: false,
                background: 7.0,
            };
            let whole = packed(&all, codec, half);
            assert_eq!(
                packing(codec)
                    .values(&mut Input::new(&whole), &active)
                    .unwrap(),
                all
            );

            let selected = [0xaaaa_aaaa_aaaa_aaaa_u64; 8];
            for flag in 0..=6_u8 {
                let mut bytes = vec![flag];
                let [mut first, mut second] = if flag == 0 { [7.0; 2] } else { [-7.0_f32, 7.0] };
                if [2, 4, 5].contains(&flag) {
                    first = 3.0;
                    bytes.extend(first.to_le_bytes());
                }
                if flag == 5 {
                    second = 9.0;
                    bytes.extend(second.to_le_bytes());
                }
                if (3..=5).contains(&flag) {
                    bytes.extend(selected.iter().flat_map(|w| w.to_le_bytes()));
                }
                bytes.extend(if flag == 6 {
                    whole.clone()
                } else {
                    packed(&stored, codec, half)
                });
                let mut input = Input::new(&bytes);
                let values = packing(codec | 2).values(&mut input, &active).unwrap();
                assert_eq!(input.left(), 0);
                for (i, value) in values.iter().enumerate() {
                    let chosen = (3..=5).contains(&flag) && i % 2 == 1;
                    let expected = if i % 3 == 0 || flag == 6 {
                        all[i]
                    } else if chosen {
                        second
                    } else {
                        first
                    };
                    assert_eq!(*value, expected, "{codec} {half} {flag} {i}");
                }
            }
        }
    }
}

fn shared(name: &str) -> Option<Vec<u8>> {
    let Some(folder) = std::env::var_os("OSTEOFLOW_SHARED") else {
        eprintln!("skipped: OSTEOFLOW_SHARED is not set, so there is no {name}");
        return None;
    };
    Some(std::fs::read(std::path::Path::new(&folder).join("vdb").join(name)).unwrap())
}

#[test]
fn volumes_from_elsewhere_are_read_as_another_reader_does() {
    for (name, active) in [
        ("ct_L3_bvtv_zip.vdb", Some(17_698)),
        ("oiio_sphere.vdb", None),
    ] {
        let Some(bytes) = shared(name) else { return };
        let file = parse_vdb(&bytes, name).unwrap();
        let grid = &file.grids[0];
        if let Some(active) = active {
            assert_eq!(grid.active, active);
            assert!(
                (grid.voxel_size() - crate::math::Vec3::repeat(grid.voxel_size().x)).norm() < 1e-9
            );
            assert!(grid.range[0] >= 0.0 && grid.range[2] <= 1.0);
        }
        let (_, theirs) = OpenVDB_rs::io::read_stream(std::io::Cursor::new(&bytes)).unwrap();
        assert_eq!(theirs.len(), file.grids.len() + file.passed_over.len());
        // Of the two readers at hand, vdb-rs panics at an affine map.
        let theirs = theirs
            .iter()
            .find(|other| other.name() == grid.name)
            .unwrap();
        let corner = theirs
            .transform()
            .index_to_world(OpenVDB_rs::Vec3d::new(10.0, 20.0, -30.0));
        let mine = grid
            .to_world
            .there(&crate::math::Vec3::new(10.0, 20.0, -30.0));
        let corner = crate::math::Vec3::new(corner.x(), corner.y(), corner.z());
        assert!((corner - mine).norm() < 1e-9 * corner.norm().max(1.0));
        assert!(
            (grid.to_world.back(&mine) - crate::math::Vec3::new(10.0, 20.0, -30.0)).norm() < 1e-6
        );
        let mut count = 0;
        for (at, value) in theirs.as_float().unwrap().tree().active_voxels() {
            let index = [at.x(), at.y(), at.z()];
            assert_eq!(grid.values.get(index), value, "{index:?}");
            count += 1;
        }
        assert!(count > 1000, "{count}");
    }
}

#[test]
fn damaged_files_are_refused_and_nothing_hangs() {
    let Some(whole) = shared("ct_L3_bvtv_zip.vdb") else {
        return;
    };
    for name in [
        "bitflip_seed0.vdb",
        "empty.vdb",
        "truncated_half.vdb",
        "wrong_magic.vdb",
    ] {
        let bytes = shared(&format!("damaged/{name}")).unwrap();
        let error = parse_vdb(&bytes, name).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
    let mut random = crate::math::Stream::new(7, "damage");
    for round in 0..300 {
        let mut bytes = whole.clone();
        for _ in 0..=round % 5 {
            let at = (random.unit()
                * if round % 2 == 0 {
                    3000.0
                } else {
                    whole.len() as Real
                }) as usize;
            bytes[at] = (random.unit() * 256.0) as u8;
        }
        bytes.truncate(
            whole.len()
                - if round % 7 == 0 {
                    (random.unit() * 60_000.0) as usize
                } else {
                    0
                },
        );
        // Whatever comes out: no panic, and no more than the bound.
        if let Ok(file) = parse_vdb(&bytes, "f") {
            assert!(
                file.grids
                    .iter()
                    .all(|grid| grid.values.brick_count() <= MAX_BRICKS)
            );
        }
    }
}
