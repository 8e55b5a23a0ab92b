//! The house rules of `src/lib.rs`, held: floors, first lines, lengths, citations, nothing left lying about.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const LONGEST: usize = 450;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files under `folder` with this ending, sorted, with their text.
fn files(folder: &str, ending: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of ours") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == ending) {
                let text = fs::read_to_string(&path).expect("UTF-8");
                found.push((path, text));
            }
        }
    }
    found.sort();
    found
}

fn sources() -> Vec<(PathBuf, String)> {
    files("src", "rs")
}

fn lib() -> String {
    fs::read_to_string(root().join("src/lib.rs")).expect("lib.rs")
}

/// First cells of the rows of the tables in the crate documentation.
fn rows(lib: &str) -> impl Iterator<Item = Vec<&str>> {
    lib.lines()
        .filter_map(|line| line.strip_prefix("//! | "))
        .map(|row| row.split(" | ").map(str::trim).collect())
}

/// Room → floor, as the crate documentation has it.
fn floors(lib: &str) -> BTreeMap<&str, u32> {
    rows(lib)
        .filter_map(|row| {
            let floor = row[0].parse().ok()?;
            let room = row.get(1)?.strip_prefix("[`")?.strip_suffix("`]")?;
            Some((room, floor))
        })
        .collect()
}

/// What is compiled into the program: without comments, and without the tests at the end.
fn code(path: &Path, text: &str) -> String {
    if path.file_name().is_some_and(|name| name == "tests.rs") {
        return String::new();
    }
    let starts = [
        "#[cfg(test)]\nmod tests",
        "#[cfg(test)]\npub(crate) mod tests",
    ];
    let end = starts.iter().find_map(|start| text.find(start));
    let end = end.unwrap_or(text.len());
    let lines = text[..end].lines();
    let code: Vec<&str> = lines
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect();
    code.join("\n")
}

/// The rooms named after `crate::`, alone or in braces.
fn imports(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for after in code.split("crate::").skip(1) {
        let name = |text: &str| -> String {
            let text = text.trim_start();
            text.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        };
        let Some(group) = after.strip_prefix('{') else {
            rooms.push(name(after));
            continue;
        };
        let mut depth = 0;
        let mut start = 0;
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => {
                    rooms.push(name(&group[start..at]));
                    break;
                }
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    rooms.push(name(&group[start..at]));
                    start = at + 1;
                }
                _ => {}
            }
        }
    }
    rooms.retain(|room| !room.is_empty());
    rooms
}

fn room_of(path: &Path) -> Option<String> {
    let inside = path.strip_prefix(root().join("src")).ok()?;
    let first = inside.components().next()?.as_os_str().to_str()?;
    (!first.contains('.')).then(|| first.to_owned())
}

#[test]
fn rooms_use_only_rooms_on_lower_floors() {
    let lib = lib();
    let floors = floors(&lib);
    assert!(
        floors.len() >= 16,
        "the table of floors is read: {floors:?}"
    );
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        let Some(room) = room_of(&path) else { continue };
        let floor = floors.get(room.as_str());
        let floor = floor.unwrap_or_else(|| panic!("{room} stands on no floor in lib.rs"));
        for used in imports(&code(&path, &text)) {
            let lower = floors.get(used.as_str()).is_some_and(|below| below < floor);
            if used != room && !lower {
                wrong.push(format!("{}: {room} uses {used}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    for room in floors.keys() {
        assert!(
            root().join("src").join(room).join("mod.rs").exists(),
            "{room} is listed only"
        );
    }
}

#[test]
fn imports_are_found_in_every_form() {
    let code = "use crate::math::{Real, Vec3};\nuse crate::{grid, sim::{A, B}, units::C};\nlet x = crate::sph::W;";
    assert_eq!(imports(code), ["math", "grid", "sim", "units", "sph"]);
    let text = "//! says crate::flow\nuse crate::math::Real;\n#[cfg(test)]\nmod tests {\n    use crate::cli;\n}\n";
    assert_eq!(imports(&self::code(Path::new("a.rs"), text)), ["math"]);
}

#[test]
fn every_file_says_first_what_it_is_and_is_one_idea_long() {
    for (path, text) in sources().into_iter().chain(files("tests", "rs")) {
        let first = text.lines().next().unwrap_or_default();
        assert!(
            first.starts_with("//! ") && first.len() > 10,
            "{}: {first}",
            path.display()
        );
        let lines = text.lines().count();
        assert!(lines <= LONGEST, "{}: {lines} lines", path.display());
    }
}

#[test]
fn nothing_unfinished_unchecked_or_noisy() {
    // Written in halves, so that this file does not find itself.
    let anywhere = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("to", "do!("),
        concat!("unimpl", "emented!("),
        concat!("#[ig", "nore"),
    ];
    for (path, text) in sources().into_iter().chain(files("tests", "rs")) {
        for mark in anywhere {
            assert!(!text.contains(mark), "{}: {mark}", path.display());
        }
    }
    for (path, text) in sources() {
        if path.components().any(|part| part.as_os_str() == "tests") {
            continue;
        }
        let code = code(&path, &text);
        assert!(!code.contains(".unwrap()"), "{}: unwrap", path.display());
        let prints = ["print!(", "println!("].iter().any(|p| code.contains(p));
        let console = room_of(&path).is_some_and(|room| room == "cli");
        assert!(console || !prints, "{}: prints", path.display());
    }
}

/// `[Morris97]`, `[IMM-CT]`: starts with a capital, and ends in a year or is all capitals.
fn citations(text: &str) -> Vec<&str> {
    let comments = text
        .lines()
        .filter(|line| line.trim_start().starts_with("//"));
    let brackets =
        comments.flat_map(|line| line.split('[').skip(1).filter_map(|b| b.split(']').next()));
    brackets
        .filter(|key| {
            let plain = key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
            let year = key.len() > 4 && key.ends_with(|c: char| c.is_ascii_digit());
            let capitals = key.len() > 3 && !key.contains(|c: char| c.is_ascii_lowercase());
            plain && key.starts_with(|c: char| c.is_ascii_uppercase()) && (year || capitals)
        })
        .collect()
}

#[test]
fn every_citation_is_listed() {
    assert_eq!(
        citations("/// a [IMM-CT] (Eq. 3), [Morris97], [Pa], [m], [`Vec3`]\nlet a = [Foo12];"),
        ["IMM-CT", "Morris97"]
    );
    let lib = lib();
    let listed: Vec<&str> = rows(&lib)
        .filter_map(|row| row[0].strip_prefix('[')?.strip_suffix(']'))
        .collect();
    assert!(listed.contains(&"IMM-CT"), "the list is read: {listed:?}");
    for (path, text) in sources() {
        for key in citations(&text) {
            assert!(
                listed.contains(&key),
                "{}: [{key}] is not listed in lib.rs",
                path.display()
            );
        }
    }
}

/// An absolute path that exists on somebody's machine only.
fn machine_path(text: &str) -> Option<&str> {
    text.lines().find(|line| {
        ["work", "root", "home", "tmp", "Users"].iter().any(|top| {
            let path = format!("/{top}/");
            line.match_indices(&path).any(|(at, _)| {
                let before = line[..at].chars().next_back();
                !before.is_some_and(|c| c.is_alphanumeric() || matches!(c, '.' | '_' | '-'))
            })
        })
    })
}

#[test]
fn no_path_of_one_machine() {
    assert!(machine_path(concat!("open(\"/ho", "me/me/x\")")).is_some());
    assert!(machine_path("see ../work/notes and framework/root/x").is_none());
    let mut texts = sources();
    for (folder, ending) in [("tests", "rs"), ("pipeline", "toml")] {
        texts.extend(files(folder, ending));
    }
    for name in ["README.md", "Cargo.toml", ".ci/run"] {
        texts.push((
            name.into(),
            fs::read_to_string(root().join(name)).expect(name),
        ));
    }
    for (path, text) in texts {
        let found = machine_path(&text);
        assert!(found.is_none(), "{}: {found:?}", path.display());
    }
}
