//! The program as it is typed: output, messages, exit codes.

mod program;

use program::osteoflow;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

#[test]
fn check_says_what_a_recipe_means() {
    let output = osteoflow(&["check", "--brief", "pipeline/vertebra.toml"]);
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{err}");
    assert!(
        out.contains("left pedicle: 1.300 ml in 6.50 s, 55.0 % polymer"),
        "{out}"
    );
    assert_eq!(err, "", "the main job leaves no doubt");

    let narrow = ["check", "--brief", "pipeline/injection_15_85.toml", "--set"];
    let narrow = [&narrow[..], &["bone.crack[0].aperture=1 mm"]].concat();
    let err = text(&osteoflow(&narrow).stderr);
    assert!(
        err.contains("bone.crack[0].aperture: is 2.0 spacings wide"),
        "{err}"
    );
    assert!(
        osteoflow(&[&narrow[..], &["-q"]].concat())
            .stderr
            .is_empty()
    );

    let json = osteoflow(&[
        "check",
        "--json",
        "--brief",
        "pipeline/vertebra.toml",
        "--set",
        "spacing=0.4 mm",
    ]);
    let report: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(report["scene"]["sim"]["spacing"], 0.4e-3);
}

/// What `check -v` prints after the summary is a recipe again.
#[test]
fn the_filled_in_recipe_can_be_checked_again() {
    let first = osteoflow(&["check", "-v", "--brief", "pipeline/periodic_box.toml"]);
    let printed = text(&first.stdout);
    let (summary, recipe) = printed.split_once("\n\n").expect("summary, then recipe");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("again.toml");
    std::fs::write(&path, recipe).expect("written");
    let again = osteoflow(&["check", "--brief", &path.display().to_string()]);
    assert_eq!(text(&again.stdout).trim_end(), summary);
}

#[test]
fn failures_have_their_exit_codes_and_one_message() {
    for (arguments, code, message) in [
        (&["check"][..], 2, "error: "),
        (&["fly"][..], 2, "error: "),
        (
            &["check", "nowhere.toml"][..],
            3,
            "error: cannot read the recipe nowhere.toml: ",
        ),
        (
            &["check", "pipeline/vertebra.toml", "--set", "spacing=0.5"][..],
            3,
            "error: --set spacing=0.5: spacing: expected a length such as \"0.5 mm\", found 0.5",
        ),
        (&["check", "Cargo.toml"][..], 3, "error: Cargo.toml:"),
    ] {
        let output = osteoflow(arguments);
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {err}");
        assert!(err.starts_with(message), "{arguments:?}: {err}");
        assert_eq!(err.matches("error: ").count(), 1, "{err}");
        assert!(output.stdout.is_empty());
    }
}
