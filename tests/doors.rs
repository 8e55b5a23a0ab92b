//! Random bytes and damaged files at every door: an error with a reason, or a result that makes sense; never a panic.

mod mutated;

use mutated::{changes, mutated};
use osteoflow::cache;
use osteoflow::grid::BrickGrid;
use osteoflow::math::{Stream, Vec3};
use osteoflow::mesh::{self, LengthUnit, UpAxis};
use osteoflow::scene;
use osteoflow::solid::{Shape, Solid};
use osteoflow::sph::WallParticles;
use proptest::prelude::*;
use std::fs;
use std::path::Path;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

/// A mesh that is let in holds finite points and triangles between them.
fn mesh_door(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    fs::write(&path, bytes).expect("written");
    match mesh::read_obj(&path, LengthUnit::Millimetre, UpAxis::Z) {
        Ok(mesh) => {
            assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
            let count = mesh.positions.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|v| *v < count));
            let _ = mesh::repaired(mesh).map_err(|e| e.to_string());
        }
        Err(error) => assert!(error.to_string().contains("a.obj"), "{error}"),
    }
}

fn recipe_door(text: &str, file: &str) {
    if let Err(error) = scene::read(file, text, Path::new("pipeline"), &[]) {
        assert!(!error.to_string().is_empty());
    }
}

proptest! {
    #[test]
    fn meshes(bytes in proptest::collection::vec(any::<u8>(), 0..300), change in changes()) {
        mesh_door(&bytes);
        mesh_door(&mutated(CUBE.as_bytes(), &change));
    }

    #[test]
    fn meshes_of_odd_numbers(x in "-?[0-9]{0,3}(e-?[0-9]{1,4}|nan|inf|\\.[0-9]*)?", face in "-?[0-9/]{0,12}") {
        mesh_door(format!("{CUBE}v {x} 0 0\nf 1 2 9\n").as_bytes());
        mesh_door(format!("{CUBE}f 1 2 {face}\n").as_bytes());
    }

    #[test]
    fn recipes(change in changes(), which in 0_usize..3) {
        let texts = [
            include_str!("../pipeline/vertebra.toml"),
            include_str!("../pipeline/mixing_10.toml"),
            include_str!("../pipeline/channel.toml"),
        ];
        let bytes = mutated(texts[which].as_bytes(), &change);
        recipe_door(&String::from_utf8_lossy(&bytes), "damaged.toml");
    }

    #[test]
    fn numbers_in_recipes(value in "-?[0-9]{1,3}(e-?[0-9]{1,3})?", unit in "[a-z/]{0,4}", line in any::<usize>()) {
        let text = include_str!("../pipeline/mixing_10.toml");
        let lines: Vec<&str> = text.lines().collect();
        let n = line % lines.len();
        let Some((key, _)) = lines[n].split_once(" = ") else { return Ok(()) };
        let odd = format!("{key} = \"{value} {unit}\"");
        recipe_door(&text.replacen(lines[n], &odd, 1), "odd.toml");
    }

    /// Every change is noticed, by the length or by the checksum.
    #[test]
    fn boundary_files(change in changes(), bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let folder = tempfile::tempdir().expect("a folder");
        let (walls, solid) = (folder.path().join("walls.osf"), folder.path().join("solid.osf"));
        let mut random = Stream::new(2, "doors");
        let particles = WallParticles {
            position: (0..9).map(|_| random.cube()).collect(),
            volume: (0..9).map(|_| random.unit()).collect(),
        };
        cache::write_walls(&walls, &particles).expect("written");
        let mut grid = BrickGrid::new(Vec3::zeros(), 0.5, 1.0);
        grid.set([1, 2, 3], -1.0);
        let shape = Shape::Sphere { centre: Vec3::zeros(), radius: 1.0, hollow: true };
        cache::write_solid(&solid, &Solid { shapes: vec![shape], grids: vec![grid] }).expect("written");
        for path in [walls, solid] {
            let whole = fs::read(&path).expect("readable");
            for damaged in [mutated(&whole, &change), bytes.clone()] {
                let same = damaged == whole;
                fs::write(&path, damaged).expect("written");
                prop_assert_eq!(cache::read_walls(&path).is_ok() || cache::read_solid(&path).is_ok(), same);
                prop_assert!(cache::read_frame(&path).is_err());
            }
        }
    }
}

/// What is wrong with a mesh is said with its place, and what can be done about it.
#[test]
fn meshes_that_enclose_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    let read = |text: &str| {
        fs::write(&path, text).expect("written");
        let mesh =
            mesh::read_obj(&path, LengthUnit::Millimetre, UpAxis::Z).map_err(|e| e.to_string())?;
        mesh::repaired(mesh).map_err(|e| e.to_string())
    };
    assert!(read("").expect_err("refused").contains("no faces"));
    assert!(
        read("v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n")
            .expect_err("refused")
            .contains("a.obj:3")
    );
    // A cube without one of its triangles is closed, and that is said; a sheet encloses nothing.
    let open = CUBE.lines().take(19).collect::<Vec<_>>().join("\n");
    let (mesh, notes) = read(&open).expect("can be closed");
    assert!(mesh::inspect(&mesh).is_closed() && !notes.is_empty());
    let sheet = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect_err("refused");
    assert!(sheet.contains("not closed"), "{sheet}");
    // Inside out: turned, and said.
    let turn = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["f", a, b, c] => ["f", a, c, b].join(" "),
            _ => line.to_owned(),
        }
    };
    let turned = CUBE.lines().map(turn).collect::<Vec<_>>().join("\n");
    let (mesh, notes) = read(&turned).expect("can be turned");
    assert!(mesh.signed_volume() > 0.0 && !notes.is_empty());
}
