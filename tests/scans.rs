//! What scanners give, as inputs of a recipe: a micro-CT's struts as they are, a CT's densities as porosity.

mod shared;

use osteoflow::bone::BoneReport;
use osteoflow::cache;
use osteoflow::grid::vdb::read_vdb;
use osteoflow::math::{Aabb, Vec3};
use osteoflow::mesh::{self, LengthUnit, ObjStyle, UpAxis};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Support radius in spacings, as it is without `support_ratio`.
const SUPPORT: f64 = 2.4;

/// From vertices of `mesh` in `bounds` to the nearest of `walls` [spacings], less what a full lattice beside the surface
/// needs: half the diagonal of a voxel.
fn widest_gap(mesh: &mesh::TriMesh, bounds: &Aabb, walls: &[Vec3], spacing: f64) -> f64 {
    let cell = |x: &Vec3| [x.x, x.y, x.z].map(|c| (c / spacing).floor() as i64);
    let mut of_cell: BTreeMap<[i64; 3], Vec<Vec3>> = BTreeMap::new();
    for x in walls {
        of_cell.entry(cell(x)).or_default().push(*x);
    }
    let nearest = |x: &Vec3| {
        let [i, j, k] = cell(x);
        let around = (0..125).map(|n| [i + n / 25 - 2, j + n / 5 % 5 - 2, k + n % 5 - 2]);
        let there = around.filter_map(|cell| of_cell.get(&cell)).flatten();
        there.map(|wall| (wall - x).norm()).fold(f64::MAX, f64::min)
    };
    let seen = mesh.positions.iter().filter(|x| bounds.contains(x));
    let farthest = seen.map(nearest).fold(0.0, f64::max);
    farthest / spacing - 0.5 * 3.0_f64.sqrt()
}

/// Runs `voxelise` on a recipe in `folder`; what it says.
fn voxelise(folder: &Path, recipe: &str) -> String {
    fs::write(folder.join("scan.toml"), recipe).expect("a folder to write to");
    let output = Command::new(env!("CARGO_BIN_EXE_osteoflow"))
        .current_dir(folder)
        .args(["voxelise", "scan.toml", "-o", "out"])
        .output()
        .expect("the program runs");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    told
}

/// A cube of 2.36 mm with 3.69 mm³ of bone, 80 564 triangles, some without area: its struts become walls of the same
/// volume, with room for cement between them, none deeper than the support radius, and none missing along the surface.
#[test]
fn a_micro_ct_is_walls_of_its_volume() {
    let Some(path) = shared::file("bones/trabecular_2p3mm_mm.obj") else {
        return;
    };
    let stored = mesh::read_obj(&path, LengthUnit::Millimetre, UpAxis::Z).expect("an OBJ");
    let bounds = stored.bounds();
    let (closed, _) = mesh::repaired(stored).expect("a closed mesh");
    let corner = |p: &Vec3| {
        let [x, y, z] = [p.x, p.y, p.z].map(|c| format!("\"{} mm\"", c * 1e3));
        format!("[{x}, {y}, {z}]")
    };
    let (low, high) = (corner(&bounds.min), corner(&bounds.max));
    let folder = tempfile::tempdir().expect("a folder");
    let recipe = format!(
        r#"
name = "Micro-CT"
spacing = "0.04 mm"
duration = "1 s"
frames_per_second = "10 1/s"

[domain]
min = {low}
max = {high}

[cement]
slip_relaxation = "1e-4 s"

[[wall]]
mesh = {{ path = "{}", unit = "mm", up = "z" }}

[[body]]
box = {{ min = {low}, max = {high} }}
polymer_fraction = 0.5
"#,
        path.display()
    );
    voxelise(folder.path(), &recipe);
    let boundary = folder.path().join("out/boundary");
    let walls = cache::read_walls(&boundary.join("walls.osf")).expect("walls");
    let solid = cache::read_solid(&boundary.join("solid.osf")).expect("a solid");
    let volume: f64 = walls.volume.iter().sum();
    let exact = closed.signed_volume();
    assert!((exact / 3.69e-9 - 1.0).abs() < 0.01, "{exact}");
    let spacing = 0.04e-3;
    let deepest = walls.position.iter().map(|x| solid.phi(x));
    let deepest = deepest.fold(0.0, f64::min);
    assert!(deepest >= -SUPPORT * spacing * (1.0 + 1e-6), "{deepest}");
    let widest = widest_gap(&closed, &bounds.grown(-spacing), &walls.position, spacing);
    assert!(widest < 0.5, "{widest}");
    let cells = 60;
    let step = bounds.extent() / f64::from(cells);
    let phi = (0..cells * cells * cells).map(|n| {
        let place = [n / (cells * cells), n / cells % cells, n % cells];
        let x = bounds.min + Vec3::from(place.map(|p| f64::from(p) + 0.5)).component_mul(&step);
        solid.phi(&x)
    });
    let phi: Vec<f64> = phi.collect();
    let within = |depth: f64| {
        let near = phi.iter().filter(|phi| **phi < 0.0 && **phi > -depth);
        near.count() as f64 * step.product()
    };
    let all = within(1.0);
    assert!((all / exact - 1.0).abs() < 0.01, "{all} {exact}");
    // Walls end 2 spacings below the surface, and a voxel reaches less than √3 further.
    let deep = [2.0, 2.0 + 3.0_f64.sqrt()].map(|depth| within(depth * 0.04e-3));
    assert!(
        deep[0] * 0.99 < volume && volume < deep[1] * 1.01,
        "{deep:?} {volume} {exact}"
    );
}

/// The bone fraction of a CT, 1.5 mm voxels and axes that are flipped, becomes porosity voxel by voxel.
#[test]
fn a_ct_is_the_porosity_of_its_bone() {
    let Some(path) = shared::file("vdb/ct_L3_bvtv_zip.vdb") else {
        return;
    };
    let grid = read_vdb(&path).expect("a volume").grids.remove(0);
    let mut bounds = grid.world_bounds();
    bounds.min *= 1e-3;
    bounds.max *= 1e-3;
    // What is scanned is where there is bone at all; the surface is taken from there.
    let outer = mesh::surface_nets(&bounds, 1e-3, |x| {
        let found = grid.value(&(x * 1e3));
        if found > 0.02 { -1e-3 } else { 1e-3 }
    });
    let folder = tempfile::tempdir().expect("a folder");
    let style = ObjStyle {
        groups: &[],
        unit: LengthUnit::Millimetre,
        up: UpAxis::Z,
        comments: &[],
    };
    let mut text = Vec::new();
    mesh::write_obj_with(&mut text, &style, &outer, None, None).expect("text");
    fs::write(folder.path().join("outer.obj"), text).expect("a folder to write to");
    let corner = |p: Vec3| {
        let [x, y, z] = [p.x, p.y, p.z].map(|c| format!("\"{} mm\"", c * 1e3));
        format!("[{x}, {y}, {z}]")
    };
    let recipe = format!(
        r#"
name = "CT"
spacing = "0.8 mm"
duration = "1 s"
frames_per_second = "10 1/s"

[domain]
min = {}
max = {}

[cement]
slip_relaxation = "1e-4 s"

[bone]
mesh = "outer.obj"
unit = "mm"
up = "z"
frame = "as is"
cortex = "0.8 mm"
volume = {{ path = "{}", holds = "bone fraction", unit = "mm", up = "z" }}

[[bone.region]]
name = "as scanned"
strut_period = "3 mm"
volume = [0.6, 0.97]

[[body]]
box = {{ min = {}, max = {} }}
polymer_fraction = 0.5
"#,
        corner(bounds.min),
        corner(bounds.max),
        path.display(),
        corner(bounds.centre().add_scalar(-2e-3)),
        corner(bounds.centre().add_scalar(2e-3)),
    );
    let told = voxelise(folder.path(), &recipe);
    assert!(!told.contains("covers"), "{told}");
    let report = fs::read(folder.path().join("out/boundary/bone.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let report: BoneReport = serde_json::from_value(report["made"].clone()).expect("a report");
    let region = &report.regions[0];
    let asked = region.asked_porosity.expect("asked by the volume");
    assert!((region.porosity - asked).abs() < 0.01, "{region:?}");
    assert!(region.classes.len() >= 4, "{region:?}");
    for [asked, made] in &region.classes {
        assert!((asked - made).abs() < 0.01, "{region:?}");
    }
    assert!(region.resolvable_porosity <= region.porosity);
    // Voxels without bone within are no cavities with a cortex.
    assert!(told.contains("bubbles"), "{told}");
    assert!(report.struts_connected > 0.99, "{report:?}");
    assert!(
        report.bone_connected > 0.99 && report.pores_connected > 0.99,
        "{report:?}"
    );
    // In thin processes the shell leaves pockets, and those are bone.
    assert!(
        report.pockets_closed > 0.0 && report.pockets_closed < 0.06,
        "{report:?}"
    );
}
