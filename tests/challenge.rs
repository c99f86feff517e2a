//! `armident challenge`: what is concealed, diagnosed unseen, scored.

use serde_json::Value;

use crate::tool::{list, number, read_json, run, run_in, scratch, text};

const CASE: [&str; 9] = [
    "challenge",
    "--cases",
    "1",
    "--seed",
    "11",
    "--effect",
    "coulomb_friction",
    "--robot",
    "urdf/planar_2r.urdf",
];

/// One case on a small arm: kept, scored again from its files, and diagnosed again from its files.
#[test]
fn memory_and_file_cases_are_equal() {
    let folder = scratch("challenge");
    let kept = folder.join("kept");
    let board =
        run(&[&CASE[..], &["--keep", text(&kept), "--json", "-", "-q"]].concat()).fine().json();
    assert_eq!(board["schema"], "armident.scoreboard/1");
    let group = &board["groups"][0];
    assert_eq!((&group["kind"], number(&group["cases"])), (&Value::from("clean"), 1.0));
    assert_eq!((number(&group["recall"]["count"]), number(&group["recall"]["of"])), (1.0, 1.0));
    assert!(list(&board["cases"][0]["false_names"]).is_empty());
    assert!(number(&group["exam_over_attainable"]["largest"]) < 1.1);
    assert_eq!(list(&board["reliability"]).len(), 5);

    let (cases, results) = (kept.join("cases"), kept.join("results"));
    let score = ["challenge", "--score", text(&cases), text(&results)];
    let again = run(&score).fine().stdout;
    assert_eq!(again, run(&CASE).fine().stdout);
    let on = |what: &str| run(&[&score[..], &["--fail-on", what]].concat()).code;
    assert_eq!((on("named-below=1"), on("named-below=2"), on("false-alarm")), (0, 3, 0));

    let case = cases.join("c0001");
    let files = ["robot.urdf", "train_1.csv", "train_2.csv", "--holdout", "holdout.csv"];
    let found =
        run_in(&case, &[&["diagnose"], &files[..], &["--json", "-", "-q"]].concat()).fine().json();
    let handed_in = read_json(&results.join("c0001/out.json"));
    assert_eq!(found["findings"], handed_in["findings"]);
    assert_eq!(found["fit"]["holdout"], handed_in["fit"]["holdout"]);
}

/// The text has the sums and the effects; without a terminal there is no progress bar.
#[test]
fn scoreboard_prints_all_groups() {
    let board = run(&CASE).fine();
    let lines: Vec<String> = board
        .stdout
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    for expected in [
        "clean cases",
        "recall 1 of 1 (100.0 %)",
        "false alarms -",
        "located 1 of 1 (100.0 %)",
        "0.8 to 1.0 1.00 1 of 1 (100.0 %)",
    ] {
        assert!(lines.iter().any(|line| line == expected), "{expected}:\n{}", board.stdout);
    }
    assert!(
        lines.iter().any(|line| line.starts_with("coulomb_friction 1/1 0 ")),
        "{}",
        board.stdout
    );
    let said: Vec<&str> = board.stderr.lines().collect();
    assert!(
        said.len() == 1 && said[0].starts_with("note: diagnosis time on one thread: "),
        "{}",
        board.stderr
    );
}

/// The resonance of this spring is narrower than the steps of the stiffnesses that are tried: at none of them is a spring of admissible
/// size fitted.
#[test]
fn spring_between_tried_stiffnesses_is_found() {
    let case = ["--kind", "hard", "--effect", "joint_elasticity", "--only", "5", "--seed", "3121"];
    let board = run(&[&["challenge"][..], &case].concat()).fine();
    let row = board.stdout.lines().find(|line| line.starts_with("joint_elasticity "));
    let words: Vec<&str> = row.unwrap_or_default().split_whitespace().collect();
    assert_eq!(words[1..3], ["1/1", "0"], "{}", board.stdout);
}

/// No effect can be hidden in an arm without masses: an error, not an empty scoreboard.
#[test]
fn arm_without_detectable_effects_is_an_error() {
    let mut urdf = std::fs::read_to_string("urdf/planar_2r.urdf").unwrap();
    while let (Some(start), Some(end)) = (urdf.find("<inertial>"), urdf.find("</inertial>")) {
        urdf.replace_range(start..end + "</inertial>".len(), "");
    }
    let file = scratch("massless").join("massless.urdf");
    std::fs::write(&file, urdf).unwrap();
    let run =
        run(&["challenge", "--robot", text(&file), "--effect", "backlash", "--cases", "1", "-q"]);
    assert_eq!((run.code, run.stdout.as_str()), (1, ""));
    let said = run.stderr.replace(text(&file), "massless.urdf");
    insta::assert_snapshot!(said, @r"
    error: no case could be generated: the effects are not detectable on any arm tried
       in: massless.urdf
     hint: give its links masses and inertias (`armident params` lists those without), or choose other effects
    ");
}

#[test]
fn wrong_command_lines_fail() {
    let code = |args: &[&str]| run(&[&["challenge"], args].concat()).code;
    assert_eq!(code(&["--effect", "magic"]), 2);
    assert_eq!(code(&["--cases", "0"]), 2);
    assert_eq!(code(&["--fail-on", "named-below"]), 2);
    assert_eq!(code(&["--study", "nulls", "--effect", "backlash"]), 2);
    assert_eq!(code(&["--score", "cases"]), 2);
    let said = |args: &[&str]| {
        let run = run(&[&["challenge"], args].concat());
        assert_eq!((run.code, run.stdout.as_str()), (1, ""), "{args:?}");
        run.stderr
    };
    insta::assert_snapshot!(said(&["--robot", "no_arm"]), @r"
    error: cannot read: No such file or directory (os error 2)
       in: no_arm
     hint: pass a URDF, or one of ur5, panda, stanford, scara, iiwa14, puma560, tx40, ur10, kinova_gen3, gantry
    ");
    insta::assert_snapshot!(said(&["--cases", "2", "--only", "3"]), @r"
    error: case 3 is out of range (1 to 2)
       in: --only
     hint: choose a number from 1 to --cases
    ");
    insta::assert_snapshot!(said(&["--kind", "null", "--effect", "backlash"]), @r"
    error: a null case has no hidden effect
       in: --effect, --kind null
     hint: omit one of the two options
    ");
    insta::assert_snapshot!(said(&["--kind", "field", "--effect", "viscous_friction", "--robot", "scara"]), @r"
    error: there is no effect `viscous_friction` to hide in a case of this kind
       in: effects of the case
     hint: give a slug of the effect library or `unlisted`; field and change cases have viscous and Coulomb friction anyway, and in a change no other friction law takes their place
    ");
    insta::assert_snapshot!(said(&["--study", "nulls", "--kind", "field"]), @r"
    error: this study defines its own kinds of cases
       in: --kind
     hint: omit --kind; only the power study accepts clean or field
    ");
    insta::assert_snapshot!(said(&["--score", "urdf", "urdf"]), @r"
    error: there is no case in this folder
       in: urdf
     hint: give a folder whose folders hold a `truth.json` each
    ");
}
