//! What was kept for later, and is read again: finished runs of studies, tables that go on, the report of a bone, good
//! pictures. Cut, changed or foreign, it is refused with a reason or made again; never a panic, never a wrong result.

mod mutated;

use mutated::{changes, mutated};
use osteoflow::cache::{CacheError, Table};
use osteoflow::flow::{Golden, Job, Stage};
use osteoflow::report::Runs;
use proptest::prelude::*;
use std::fs;
use std::path::Path;

const COLUMNS: [&str; 3] = ["frame", "time_s", "volume_m3"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// What is no longer a result is made again. Only what still reads as a whole result of this program and these
    /// settings is taken as one.
    #[test]
    fn runs_of_studies(change in changes(), bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let folder = tempfile::tempdir().expect("a folder");
        let runs = Runs::open(folder.path());
        let keep = |value: Vec<f64>| {
            runs.keep("wave", &("wave", 0.5), || Ok::<_, CacheError>(value)).map(|kept| kept.0)
        };
        keep(vec![1.0, 2.0]).expect("made");
        let path = folder.path().join("wave.json");
        let whole = fs::read(&path).expect("kept");
        let changed = mutated(&whole, &change);
        for damaged in [&changed, &bytes] {
            fs::write(&path, damaged).expect("written");
            let again = keep(vec![3.0]).expect("kept or made");
            if again == [3.0] {
                prop_assert!(damaged != &whole);
                // It is whole again.
                prop_assert_eq!(keep(vec![4.0]).expect("kept"), vec![3.0]);
            } else {
                prop_assert!(serde_json::from_slice::<serde_json::Value>(damaged).is_ok());
            }
        }
    }

    /// A table that goes on has its header and its rows, or is refused by its name.
    #[test]
    fn tables(change in changes(), bytes in proptest::collection::vec(any::<u8>(), 0..200), rows in 0_usize..5) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("stats.csv");
        let mut table = Table::create(&path, &COLUMNS).expect("made");
        for n in 0..4 {
            table.row(&[n.to_string(), "0.5".into(), "1e-7".into()]).expect("a row");
        }
        let whole = fs::read(&path).expect("readable");
        for damaged in [mutated(&whole, &change), bytes] {
            fs::write(&path, &damaged).expect("written");
            match Table::resume(&path, &COLUMNS, rows) {
                Ok(mut table) => {
                    table.row(&["9".into(), "1".into(), "0".into()]).expect("a row");
                    let text = fs::read_to_string(&path).expect("UTF-8");
                    let lines: Vec<&str> = text.lines().collect();
                    prop_assert_eq!(lines.len(), rows + 2);
                    prop_assert_eq!(lines[0], COLUMNS.join(","));
                    prop_assert_eq!(lines[rows + 1], "9,1,0");
                    let three = |line: &&str| line.split(',').count() == COLUMNS.len();
                    prop_assert!(lines.iter().all(three), "{text}");
                }
                Err(error) => {
                    prop_assert!(error.to_string().contains("stats.csv"), "{error}");
                    // Nothing is lost by being refused.
                    prop_assert_eq!(fs::read(&path).expect("there"), damaged);
                }
            }
        }
    }
}

/// A block of bone, 12 mm wide.
const BLOCK: &str = r#"
name = "Block"
spacing = "1 mm"
duration = "0.02 s"
frames_per_second = "100 1/s"

[domain]
min = ["-7 mm", "-7 mm", "-7 mm"]
max = ["7 mm", "7 mm", "7 mm"]

[bone]
mesh = "block.obj"
unit = "mm"
up = "z"
frame = "as is"
cortex = "1 mm"

[[bone.region]]
name = "all"
strut_period = "3 mm"
porosity = 0.85

[[body]]
sphere = { centre = ["0 mm", "0 mm", "0 mm"], radius = "3 mm" }
polymer_fraction = 0.5

[preview]
width = 48
height = 36

[[preview.view]]
name = "front"
"#;

fn block(folder: &Path) -> Job {
    let mut text = String::new();
    text.push_str(
        "v -6 -6 -6\nv 6 -6 -6\nv 6 6 -6\nv -6 6 -6\nv -6 -6 6\nv 6 -6 6\nv 6 6 6\nv -6 6 6\n",
    );
    text.push_str("f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    fs::write(folder.join("block.obj"), text).expect("written");
    let recipe = folder.join("block.toml");
    fs::write(&recipe, BLOCK).expect("written");
    Job::open(&recipe, &[], false, &folder.join("out"), false, &mut |_| {}).expect("opened")
}

/// The permeability is measured of the bone that its report tells of.
#[test]
fn the_report_of_a_bone() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = block(folder.path());
    job.run(Stage::Voxelise, &mut |_| {}).expect("built");
    let path = job.folder.bone_report();
    let whole = fs::read_to_string(&path).expect("a report");
    let measure = |text: &[u8]| {
        fs::write(&path, text).expect("written");
        let measured = job.measure_permeability(&mut |_| {});
        measured.map_err(|error| error.to_string())
    };
    let refused = |text: &[u8]| {
        let said = measure(text).expect_err("refused");
        assert!(said.contains("bone.json"), "{said}");
    };
    refused(b"");
    refused(b"{}");
    refused(b"{\"made\": []}");
    refused(&[0xff, 0x00, 0x7b]);
    refused(&vec![b'['; 1 << 20]);
    for end in (0..whole.trim_end().len()).step_by(97) {
        refused(&whole.as_bytes()[..end]);
    }
    // Numbers that no bone has: struts thinner than an atom or thicker than the bone still end in an answer.
    let key = "\"strut_diameter\": ";
    let at = whole.find(key).expect("a diameter") + key.len();
    let end = at + whole[at..].find([',', '\n']).expect("its end");
    for number in ["1e-300", "1e300", "-1", "0"] {
        let odd = format!("{}{number}{}", &whole[..at], &whole[end..]);
        if let Err(said) = measure(odd.as_bytes()) {
            assert!(said.len() > 10, "{number}: {said}");
        }
    }
    refused(format!("{}1e999{}", &whole[..at], &whole[end..]).as_bytes());
}

/// A picture that says it is as large as pictures can be takes no memory for it.
#[test]
fn good_pictures_of_any_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = block(folder.path());
    for stage in [Stage::Voxelise, Stage::Simulate, Stage::Preview] {
        job.run(stage, &mut |_| {}).expect("runs");
    }
    let golden = Golden {
        folder: folder.path().join("good"),
        exact: false,
    };
    job.bless(&golden).expect("blessed");
    job.compare(&golden).expect("the same");
    let path = golden.folder.join("front.0000.png");
    let mut bytes = fs::read(&path).expect("a picture");
    // Signature, length and name of the header, then width and height, and its CRC.
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let sum = crc32fast::hash(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&sum.to_be_bytes());
    fs::write(&path, bytes).expect("written");
    let said = job.compare(&golden).expect_err("refused").to_string();
    assert!(said.contains("front.0000.png"), "{said}");
}

/// Found by `tables`, once in some thousand cases.
#[test]
fn a_header_that_was_cut_short_of_its_end_does_not_take_a_row_into_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("stats.csv");
    fs::write(&path, COLUMNS.join(",")).expect("written");
    let mut table = Table::resume(&path, &COLUMNS, 0).expect("no row is missing");
    table
        .row(&["9".into(), "1".into(), "0".into()])
        .expect("a row");
    let text = fs::read_to_string(&path).expect("UTF-8");
    assert_eq!(text, "frame,time_s,volume_m3\n9,1,0\n");
}
