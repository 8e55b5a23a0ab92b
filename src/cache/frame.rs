//! Frames on disk.

use super::container::{self, Column, Container};
use super::{CacheError, Frame};
use serde::{Deserialize, Serialize};
use std::path::Path;

const KIND: &str = "frame";

#[derive(Serialize, Deserialize)]
struct Meta {
    index: u32,
    time: f64,
    spacing: f64,
    support_radius: f64,
    rest_volume: f64,
    particles: usize,
}

/// Writes a frame.
pub fn write_frame(path: &Path, frame: &Frame) -> Result<(), CacheError> {
    let meta = Meta {
        index: frame.index,
        time: frame.time,
        spacing: frame.spacing,
        support_radius: frame.support_radius,
        rest_volume: frame.rest_volume,
        particles: frame.position.len(),
    };
    let columns = vec![
        Column::new("position", frame.position.iter().copied()),
        Column::new("velocity", frame.velocity.iter().copied()),
        Column::new(
            "polymer_fraction",
            frame.polymer_fraction.iter().map(|&a| [a]),
        ),
        Column::new("pressure", frame.pressure.iter().map(|&p| [p])),
        Column::new("id", frame.id.iter().map(|&id| [id])),
    ];
    container::write(path, KIND, &meta, columns)
}

/// Reads a frame: every array has one row a particle and holds finite numbers.
pub fn read_frame(path: &Path) -> Result<Frame, CacheError> {
    let mut file = Container::read(path, KIND)?;
    let meta: Meta = file.meta()?;
    for (name, value) in [
        ("spacing", meta.spacing),
        ("support_radius", meta.support_radius),
        ("rest_volume", meta.rest_volume),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(CacheError::damaged(path, format!("{name} is {value}")));
        }
    }
    let count = Some(meta.particles);
    let frame = Frame {
        index: meta.index,
        time: meta.time,
        spacing: meta.spacing,
        support_radius: meta.support_radius,
        rest_volume: meta.rest_volume,
        position: file.take_points("position", count)?,
        velocity: file.take_points("velocity", count)?,
        polymer_fraction: file.take_finite("polymer_fraction", count)?,
        pressure: file.take_finite("pressure", count)?,
        id: file.take("id")?,
    };
    if frame.id.len() != frame.position.len() {
        return Err(CacheError::damaged(path, "`id` has the wrong length"));
    }
    Ok(frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    fn frame(particles: usize) -> Frame {
        let f = |i: usize| (i as f32).mul_add(0.37, -1.0);
        Frame {
            index: 7,
            time: 0.1 + 0.2,
            spacing: 5e-4,
            support_radius: 1.2e-3,
            rest_volume: 1.25e-10,
            position: (0..particles).map(|i| [f(i), f(2 * i), f(3 * i)]).collect(),
            velocity: (0..particles).map(|i| [f(i + 1), 0.0, -0.0]).collect(),
            polymer_fraction: (0..particles).map(|i| f(i).fract().abs()).collect(),
            pressure: (0..particles).map(|i| f(i) * 1e5).collect(),
            id: (0..particles as u32).rev().collect(),
        }
    }

    #[test]
    fn frames_come_back_with_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        for particles in [0, 1, 1000] {
            let path = folder.path().join("deep/000007.osf");
            write_frame(&path, &frame(particles)).unwrap();
            let read = read_frame(&path).unwrap();
            assert_eq!(read, frame(particles));
            assert_eq!(read.time.to_bits(), (0.1_f64 + 0.2).to_bits());
        }
        let names: Vec<_> = fs::read_dir(folder.path().join("deep")).unwrap().collect();
        assert_eq!(names.len(), 1, "no temporary is left behind");
    }

    #[test]
    fn what_is_wrong_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.osf");
        write_frame(&path, &frame(10)).unwrap();
        let good = fs::read(&path).unwrap();
        let message = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            read_frame(&path).unwrap_err().to_string()
        };
        let with = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            bytes
        };
        assert!(message(b"").contains("too few"));
        assert!(message(&[b'x'; 100]).contains("not one of our files"));
        assert!(message(&good[..good.len() - 1]).contains("bytes long"));
        assert!(message(&[&good[..], &[0]].concat()).contains("bytes long"));
        assert!(message(&with(8, 9)).contains("version 9"));
        assert!(message(&with(15, 255)).contains("inside its header"));
        assert!(message(&with(good.len() - 30, !good[good.len() - 30])).contains("checksum"));
        fs::remove_file(&path).unwrap();
        assert!(read_frame(&path).unwrap_err().to_string().contains("a.osf"));

        let mut broken = frame(3);
        broken.velocity[1][2] = f32::NAN;
        write_frame(&path, &broken).unwrap();
        assert!(
            read_frame(&path)
                .unwrap_err()
                .to_string()
                .contains("`velocity` holds")
        );
        broken = frame(3);
        broken.pressure.pop();
        write_frame(&path, &broken).unwrap();
        assert!(
            read_frame(&path)
                .unwrap_err()
                .to_string()
                .contains("`pressure` has the wrong length")
        );
    }

    /// A header that claims more than memory holds is refused by the length of the file, whatever its checksum.
    #[test]
    fn a_boastful_header_allocates_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.osf");
        write_frame(&path, &frame(4)).unwrap();
        let text = fs::read(&path).unwrap();
        for boast in ["18446744073709551615", "4611686018427387904", "99999999999"] {
            let length = u32::from_le_bytes(text[12..16].try_into().unwrap()) as usize;
            let header = String::from_utf8(text[16..16 + length].to_vec()).unwrap();
            let header = header.replace("\"length\":12", &format!("\"length\":{boast}"));
            let mut bytes = text[..12].to_vec();
            bytes.extend((header.len() as u32).to_le_bytes());
            bytes.extend(header.as_bytes());
            bytes.extend(&text[16 + length..text.len() - 4]);
            bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
            fs::write(&path, bytes).unwrap();
            let message = read_frame(&path).unwrap_err().to_string();
            assert!(message.contains("its header describes"), "{message}");
        }
    }

    proptest! {
        #[test]
        fn a_changed_byte_never_passes_and_never_panics(at in 0_usize..2000, change in 1_u8..) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.osf");
            write_frame(&path, &frame(5)).unwrap();
            let mut bytes = fs::read(&path).unwrap();
            let at = at % bytes.len();
            bytes[at] ^= change;
            fs::write(&path, bytes).unwrap();
            prop_assert!(read_frame(&path).is_err());
        }

        #[test]
        fn random_bytes_never_panic(tail in proptest::collection::vec(any::<u8>(), 0..200), ours in any::<bool>()) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.osf");
            let mut bytes = if ours { b"osteoflo\x01\0\0\0".to_vec() } else { Vec::new() };
            bytes.extend(tail);
            fs::write(&path, bytes).unwrap();
            prop_assert!(read_frame(&path).is_err());
        }
    }
}
