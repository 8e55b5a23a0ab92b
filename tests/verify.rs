//! `verify` as it is typed: the cases that take seconds, against the project's own record.

mod program;

use program::osteoflow;
use std::fs;

#[test]
fn cheap_cases_are_no_worse_than_recorded_and_leave_a_table_and_plots() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("verify");
    let place = out.to_str().expect("UTF-8");
    let cases = ["conformation", "bonding", "phases", "ledger"];
    let mut typed = vec!["verify", "--level", "quick", "-o", place];
    typed.extend(cases);
    let first = osteoflow(&typed);
    let said = String::from_utf8_lossy(&first.stderr).into_owned();
    assert_eq!(first.status.code(), Some(0), "{said}");
    for case in cases {
        let picture = image::open(out.join(format!("{case}.png"))).expect("a picture");
        assert!(picture.width() > 100);
    }
    let text = fs::read(out.join("verify.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    let figures = report["figures"].as_array().expect("figures");
    assert!(figures.len() >= 20);
    assert!(
        figures.iter().all(|f| f["recorded"].is_number()),
        "{report:#}"
    );
    // What is there is not made again, and gives the same figures.
    let again = osteoflow(&typed);
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(
        said.contains("kept, took") && !said.contains(": took"),
        "{said}"
    );
    assert_eq!(again.stdout, first.stdout);
}

#[test]
fn names_that_there_are_not_and_folders_of_others_are_refused() {
    let wrong = osteoflow(&["verify", "nothing"]);
    assert_eq!(wrong.status.code(), Some(2));
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("mine.txt"), "mine").expect("written");
    let place = folder.path().to_str().expect("UTF-8");
    let occupied = osteoflow(&["study", "thinning", "-o", place]);
    assert_eq!(occupied.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&occupied.stderr).contains("holds no runs"));
    assert_eq!(osteoflow(&["study", "nothing"]).status.code(), Some(2));
}
