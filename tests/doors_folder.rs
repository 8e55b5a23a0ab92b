//! An output folder in which any file may be damaged: every stage, the comparison with good pictures and the sheet of
//! runs read it with an error that says something, or do without it; never a panic.

use osteoflow::flow::{self, Golden, Job, Stage};
use osteoflow::math::Stream;
use std::fs;
use std::path::{Path, PathBuf};

/// A few particles that fall, drawn small.
const RECIPE: &str = r#"
name = "Damaged"
spacing = "1 mm"
duration = "0.02 s"
frames_per_second = "100 1/s"

[domain]
min = ["-2 mm", "-2 mm", "-2 mm"]
max = ["8 mm", "8 mm", "8 mm"]

[[body]]
box = { min = ["1 mm", "1 mm", "1 mm"], max = ["5 mm", "5 mm", "4 mm"] }
polymer_fraction = 0.5

[[wall]]
box = { min = ["0 mm", "0 mm", "0 mm"], max = ["6 mm", "6 mm", "6 mm"] }
hollow = true

[[probe]]
name = "drop"
extents = true

[preview]
width = 48
height = 36

[[preview.view]]
name = "front"
"#;

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path);
        }
    }
}

fn copy(from: &Path, to: &Path) {
    let mut found = Vec::new();
    files(from, &mut found);
    for path in found {
        let there = to.join(path.strip_prefix(from).expect("inside"));
        fs::create_dir_all(there.parent().expect("a folder")).expect("made");
        fs::copy(&path, there).expect("copied");
    }
}

/// Flipped bits, a cut, foreign bytes, huge counts in place of numbers, or nothing at all.
fn damaged(whole: &[u8], random: &mut Stream) -> Vec<u8> {
    let mut below = |n: usize| (random.unit() * n as f64) as usize;
    let mut bytes = whole.to_vec();
    match below(6) {
        0 => bytes.truncate(below(whole.len() + 1)),
        1 => bytes.clear(),
        2 => bytes = (0..below(400)).map(|_| below(256) as u8).collect(),
        3 => {
            let digits: Vec<usize> = (0..bytes.len())
                .filter(|&i| bytes[i].is_ascii_digit())
                .collect();
            if !digits.is_empty() {
                let at = digits[below(digits.len())];
                bytes.splice(at..=at, *b"99999999999999999999");
            }
        }
        4 => {
            // Eight bytes of a count or of a number that is not one.
            let at = below(bytes.len().saturating_sub(8).max(1));
            let end = bytes.len().min(at + 8);
            bytes[at..end].fill(0xff);
        }
        _ => {
            for _ in 0..=below(8) {
                if !bytes.is_empty() {
                    let at = below(bytes.len());
                    bytes[at] ^= 1 << below(8);
                }
            }
        }
    }
    bytes
}

/// Everything that reads the folder; what it says where it fails.
fn use_all(recipe: &Path, out: &Path, good: &Path, resume: bool) -> Vec<String> {
    let mut said = Vec::new();
    let mut job = match Job::open(recipe, &[], false, out, false, &mut |_| {}) {
        Ok(job) => job,
        Err(error) => return vec![error.to_string()],
    };
    job.resume = resume;
    let golden = Golden {
        folder: good.to_owned(),
        exact: false,
    };
    said.extend(job.compare(&golden).err().map(|e| e.to_string()));
    let sheet = flow::sheet(&[out.to_owned()], None, 3, &good.join("../sheet.png"));
    said.extend(sheet.err().map(|e| e.to_string()));
    for stage in Stage::ALL {
        said.extend(job.run(stage, &mut |_| {}).err().map(|e| e.to_string()));
    }
    said
}

#[test]
fn any_file_of_a_folder_may_be_damaged() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let recipe = at("damaged.toml");
    fs::write(&recipe, RECIPE).expect("written");
    let (whole, out, good) = (at("whole"), at("out"), at("good"));
    let job = Job::open(&recipe, &[], false, &whole, false, &mut |_| {}).expect("opened");
    for stage in Stage::ALL {
        job.run(stage, &mut |_| {}).expect("runs");
    }
    let golden = Golden {
        folder: good.clone(),
        exact: false,
    };
    job.bless(&golden).expect("blessed");
    let kept = at("kept");
    copy(&good, &kept);

    let mut names = Vec::new();
    files(&whole, &mut names);
    // What is only written, and large: damage to it tells nothing.
    let unread = |path: &PathBuf| {
        let name = path.display().to_string();
        ["/vdb/", "/ply/", "/vtp/", "/usd/", ".py", ".txt", ".usda"]
            .iter()
            .any(|part| name.contains(part))
    };
    names.retain(|path| !unread(path));
    let mut pictures = Vec::new();
    files(&good, &mut pictures);
    let mut random = Stream::new(11, "damaged folder");
    let (mut failed, mut rounds) = (0, 0);
    for path in names.iter().chain(&pictures) {
        for round in 0..3 {
            for fresh in [&out, &good] {
                let _ = fs::remove_dir_all(fresh);
            }
            copy(&whole, &out);
            copy(&kept, &good);
            let target = match path.strip_prefix(&whole) {
                Ok(inside) => out.join(inside),
                Err(_) => path.clone(),
            };
            let bytes = fs::read(&target).expect("readable");
            fs::write(&target, damaged(&bytes, &mut random)).expect("written");
            // Stages that lost their stamp run again, and read what is there.
            if round > 0 {
                let stages = [Stage::Surface, Stage::Simulate];
                let stamp = out.join(format!("stamps/{}.json", stages[round - 1]));
                fs::remove_file(stamp).expect("removed");
            }
            let said = use_all(&recipe, &out, &good, round == 2);
            assert!(said.iter().all(|s| s.len() > 10), "{path:?}: {said:?}");
            failed += usize::from(!said.is_empty());
            rounds += 1;
        }
    }
    // Some damage must be told, and some does no harm.
    assert!(
        failed > 3 && failed < rounds,
        "{failed} of {rounds} rounds failed"
    );
}
