//! `armident diagnose`: what was concealed is named, where it is, and nothing else is.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shared::{project, shared};
use crate::tool::{Run, list, number, read_json, run, run_in, scratch, string, text};

const JOINTS: [&str; 6] = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
];

fn urdf() -> PathBuf {
    project("urdf/ur5.urdf")
}

/// Simulates the UR5 of `urdf/` along a trajectory, with effort noise of 0.1 N m.
fn simulate(trajectory: &Path, to: &Path, seed: &str, effects: &[&str]) {
    let urdf = urdf();
    let mut args = vec!["simulate", text(&urdf), text(trajectory), "-o", text(to), "-q"];
    args.extend(["--torque-noise", "0.1", "--encoder-bits", "19", "--seed", seed]);
    args.extend(effects.iter().flat_map(|effect| ["--effect", effect]));
    run(&args).fine();
}

/// A folder with `train.csv` and `holdout.csv` of an arm with these effects.
fn recordings(test: &str, effects: &[&str]) -> PathBuf {
    let folder = scratch(test);
    for (k, name) in ["train", "holdout"].iter().enumerate() {
        let trajectory = project(&format!("examples/ur5/{name}.csv"));
        simulate(&trajectory, &folder.join(format!("{name}.csv")), &k.to_string(), effects);
    }
    folder
}

/// Runs the diagnosis of `train.csv` in a folder, with more arguments.
fn diagnose(folder: &Path, more: &[&str]) -> Run {
    let urdf = urdf();
    let args = ["diagnose", text(&urdf), "train.csv", "-q", "--json", "-"];
    run_in(folder, &[&args, more].concat())
}

/// The diagnosis with the hold-out.
fn diagnosed(folder: &Path) -> Value {
    diagnose(folder, &["--holdout", "holdout.csv"]).fine().json()
}

/// Effect and joints of each finding.
fn named(diagnosis: &Value) -> BTreeSet<(String, String)> {
    list(&diagnosis["findings"])
        .iter()
        .map(|f| {
            let joints: Vec<&str> = list(&f["joints"]).iter().map(string).collect();
            (string(&f["effect"]).to_owned(), joints.join(" "))
        })
        .collect()
}

fn pairs(expected: &[(&str, &str)]) -> BTreeSet<(String, String)> {
    expected.iter().map(|(effect, joint)| ((*effect).to_owned(), (*joint).to_owned())).collect()
}

fn holdout_error(diagnosis: &Value, of: &str, joint: &str) -> f64 {
    number(&diagnosis["fit"]["holdout"][of][joint])
}

/// One effect: named, on its joint, with its parameter; the hold-out error falls to the noise.
#[track_caller]
fn one_effect(slug: &str, joint: &str, parameters: &str, parameter: &str, truth: f64) {
    let effect = format!("{slug}:{joint}={parameters}");
    let folder = recordings(&format!("diagnose_{slug}"), &[&effect]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(diagnosis["verdict"], "mismatch", "{slug}");
    assert_eq!(named(&diagnosis), pairs(&[(slug, joint)]));
    let finding = &diagnosis["findings"][0];
    assert!(number(&finding["confidence"]) > 0.9, "{slug}");
    let estimate = &finding["parameters"][parameter];
    let off = (number(&estimate["value"]) - truth).abs();
    assert!(off < 0.03 * truth.abs(), "{slug}: {estimate}, true {truth}");
    let [before, rigid, after] =
        ["before", "rigid", "after"].map(|of| holdout_error(&diagnosis, of, joint));
    assert!(after < 0.5 * before && after < 0.5 * rigid, "{slug}: {before} {rigid} {after}");
    let noise = number(&diagnosis["effort_noise"][joint]);
    assert!(after < 1.5 * noise, "{slug}: {after} left, noise {noise}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_spring_is_named() {
    one_effect("joint_spring", "elbow_joint", "6,1.0", "stiffness", 6.0);
}

#[test]
fn a_drag_is_named() {
    one_effect("quadratic_drag", "wrist_1_joint", "2", "coefficient", 2.0);
}

#[test]
fn friction_is_named() {
    one_effect("coulomb_friction", "shoulder_pan_joint", "3", "level", 3.0);
}

#[test]
fn a_rotor_is_named() {
    one_effect("rotor_inertia", "wrist_2_joint", "0.4", "inertia", 0.4);
}

/// What belongs to the whole robot is not put on a joint, what belongs to a link is put on the link.
#[test]
fn places() {
    let folder = recordings("diagnose_delay", &["time_delay:wrist_1_joint=0.015"]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(named(&diagnosis), pairs(&[("time_delay", "")]));
    let delay = number(&diagnosis["findings"][0]["parameters"]["delay"]["value"]);
    assert!((delay - 0.015).abs() < 1e-3, "{delay}");

    let folder = recordings("diagnose_payload", &["payload:wrist_3_joint=1.5,0,0.02,0.05"]);
    let diagnosis = diagnosed(&folder);
    let findings = list(&diagnosis["findings"]);
    assert_eq!(findings.len(), 1, "{findings:?}");
    // the same thing: a load is an inertial error of the last link
    assert!(["payload", "link_inertia_error"].contains(&string(&findings[0]["effect"])));
    assert!(findings[0]["link"].is_string());
    assert_eq!(findings[0]["joints"][0], "wrist_3_joint");
}

/// Nothing concealed, nothing found; and the fields are those of the contract.
#[test]
fn nothing_is_found_in_nothing() {
    let folder = recordings("diagnose_clean", &[]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(diagnosis["schema"], "armident.diagnosis/1");
    assert_eq!(diagnosis["verdict"], "match");
    assert!(list(&diagnosis["findings"]).is_empty());
    for joint in JOINTS {
        let [before, after] = ["before", "after"].map(|of| holdout_error(&diagnosis, of, joint));
        assert!(after < 1.1 * before, "{joint}: {before} {after}");
    }
}

/// The hold-out proves and does nothing else; a model stands alone; fields are those of the contract.
#[test]
fn holdout_model_and_fields() {
    let effects = ["torque_offset:wrist_2_joint=0.5", "viscous_friction:elbow_joint=8"];
    let folder = recordings("diagnose_flow", &effects);
    let with = diagnose(&folder, &["--holdout", "holdout.csv", "--save-model", "with.json"]);
    let with = with.fine().json();
    let without = diagnose(&folder, &["--save-model", "without.json"]).fine().json();
    let expected = [("torque_offset", "wrist_2_joint"), ("viscous_friction", "elbow_joint")];
    assert_eq!(named(&with), pairs(&expected));
    assert_eq!(with["findings"], without["findings"]);
    assert_eq!(with["verdict"], without["verdict"]);
    assert_eq!(with["fit"]["train"], without["fit"]["train"]);
    assert!(without["fit"]["holdout"].is_null());
    let model = std::fs::read(folder.join("with.json")).unwrap();
    assert!(model == std::fs::read(folder.join("without.json")).unwrap());

    for finding in list(&with["findings"]) {
        assert!(finding["link"].is_null() && finding["window"].is_null());
        assert!(finding["recording"].is_null() && finding["evidence"].is_object());
        assert!((0.5..=1.0).contains(&number(&finding["confidence"])));
        list(&finding["alternatives"]);
        for (name, parameter) in finding["parameters"].as_object().unwrap() {
            assert!(number(&parameter["value"]).is_finite(), "{name}");
            assert!(parameter["stderr"].is_null() || number(&parameter["stderr"]) > 0.0);
            string(&parameter["unit"]);
        }
    }
    for of in ["before", "rigid", "after"] {
        assert_eq!(with["fit"]["holdout"][of].as_object().unwrap().len(), JOINTS.len());
    }

    // nothing but the model and the motion, whose efforts are taken away
    let alone = scratch("diagnose_alone");
    std::fs::write(alone.join("model.json"), model).unwrap();
    let recorded = std::fs::read_to_string(folder.join("holdout.csv")).unwrap();
    let rows: Vec<Vec<&str>> = recorded.lines().map(|line| line.split(',').collect()).collect();
    let kept: Vec<usize> =
        (0..rows[0].len()).filter(|k| !rows[0][*k].ends_with("effort")).collect();
    let motion: Vec<String> = rows
        .iter()
        .enumerate()
        // some samples are lost
        .filter(|(line, _)| line % 50 != 7)
        .map(|(_, row)| kept.iter().map(|k| row[*k]).collect::<Vec<_>>().join(","))
        .collect();
    std::fs::write(alone.join("motion.csv"), motion.join("\n") + "\n").unwrap();
    run_in(&alone, &["predict", "model.json", "motion.csv", "-o", "predicted.csv", "-q"]).fine();
    let predicted = std::fs::read_to_string(alone.join("predicted.csv")).unwrap();
    let lines: Vec<&str> = predicted.lines().collect();
    assert_eq!(lines.len(), motion.len());
    let header: Vec<&str> = lines[0].split(',').collect();
    for joint in JOINTS {
        assert!(header.contains(&format!("{joint}/effort").as_str()), "{joint}");
    }
    let column = header.iter().position(|h| *h == "elbow_joint/effort").unwrap();
    let recorded = rows[0].iter().position(|h| *h == "elbow_joint/effort").unwrap();
    let given = rows.iter().enumerate().filter(|(line, _)| line % 50 != 7).map(|(_, row)| row);
    let mut squares = 0.0;
    for (line, given) in lines.iter().zip(given).skip(1) {
        let values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        assert!(values.iter().all(|x| x.is_finite()), "{line}");
        assert_eq!(values[0], given[0].parse::<f64>().unwrap());
        squares += (values[column] - given[recorded].parse::<f64>().unwrap()).powi(2);
    }
    let error = (squares / (lines.len() - 1) as f64).sqrt();
    assert!(error < 1.3 * holdout_error(&with, "after", "elbow_joint"), "{error}");
}

/// The bundled recordings: the heavier forearm among friction and rotors on every joint.
#[test]
fn bundled_example() {
    let (urdf, folder) = (urdf(), project("examples/ur5"));
    let args = ["diagnose", text(&urdf), "train.csv", "--holdout", "holdout.csv", "--json", "-"];
    let diagnosis = run_in(&folder, &args).fine().json();
    let findings = list(&diagnosis["findings"]);
    let wrong: Vec<&Value> = findings.iter().filter(|f| !f["link"].is_null()).collect();
    assert_eq!(wrong.len(), 1, "{wrong:?}");
    assert_eq!(wrong[0]["joints"][0], "elbow_joint");
    assert!((number(&wrong[0]["parameters"]["delta_mass"]["value"]) - 0.6).abs() < 0.05);
    // nothing that is not there: friction, its offset and rotors are all the rest
    let there = ["viscous_friction", "coulomb_friction", "torque_offset", "rotor_inertia"];
    let same_as_two = "asymmetric_coulomb_friction";
    for finding in findings.iter().filter(|f| f["link"].is_null()) {
        let slug = string(&finding["effect"]);
        assert!(there.contains(&slug) || slug == same_as_two, "{finding}");
    }
    for joint in JOINTS {
        let [before, after] = ["before", "after"].map(|of| holdout_error(&diagnosis, of, joint));
        assert!(after < 0.1 * before, "{joint}: {before} {after}");
    }
}

/// A development case with its answer: all of it, and nothing that is neither there nor tolerated.
#[track_caller]
fn development_case(name: &str) {
    let Some(case) = shared(&format!("diagnose, {name}"), &format!("challenge/dev/{name}")) else {
        return;
    };
    let args = ["diagnose", "robot.urdf", "train_1.csv", "train_2.csv", "--holdout", "holdout.csv"];
    let diagnosis = run_in(&case, &[&args[..], &["--json", "-", "-q"]].concat()).fine().json();
    let truth = read_json(&case.join("truth.json"));
    let pair = |e: &Value| (string(&e["effect"]).to_owned(), string(&e["joints"][0]).to_owned());
    let effects = list(&truth["effects"]);
    let expected: BTreeSet<_> = effects.iter().map(pair).collect();
    let tolerated: BTreeSet<_> = effects
        .iter()
        .flat_map(|e| list(&e["tolerate"]))
        .chain(truth["everyday"].as_array().into_iter().flatten())
        .map(pair)
        .collect();
    let named = named(&diagnosis);
    assert!(expected.is_subset(&named), "{name}: {named:?}");
    let wrong: Vec<_> =
        named.iter().filter(|n| !expected.contains(n) && !tolerated.contains(n)).collect();
    assert!(wrong.is_empty(), "{name}: {wrong:?}");
    assert_eq!(diagnosis["verdict"] == "match", named.is_empty());
}

#[test]
fn development_case_without_effect() {
    development_case("d01");
}

#[test]
fn development_case_friction() {
    development_case("d05");
}

#[test]
fn development_case_rotor() {
    development_case("d12");
}

#[test]
fn development_case_field() {
    development_case("f03");
}

/// A copy of `train.csv` with every row changed, or left out.
fn changed(folder: &Path, to: &str, change: impl Fn(&[&str], &[String]) -> Option<Vec<String>>) {
    let recorded = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let mut lines = recorded.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut content = header.join(",") + "\n";
    for line in lines {
        let row: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Some(row) = change(&header, &row) {
            content += &(row.join(",") + "\n");
        }
    }
    std::fs::write(folder.join(to), content).unwrap();
}

/// The row with the columns whose names end like this set to one number.
fn set(header: &[&str], row: &[String], ending: &str, to: &str) -> Vec<String> {
    let of = header.iter().zip(row);
    of.map(|(h, x)| if h.ends_with(ending) { to.to_owned() } else { x.clone() }).collect()
}

#[test]
fn recordings_that_tell_little() {
    let folder = recordings("diagnose_little", &[]);
    let urdf = urdf();
    let diagnose = |file: &str, more: &[&str]| {
        run_in(&folder, &[&["diagnose", text(&urdf), file, "-q", "--json", "-"], more].concat())
    };
    let until = |end: f64| {
        move |_: &[&str], row: &[String]| {
            (row[0].parse::<f64>().unwrap() < end).then(|| row.to_vec())
        }
    };
    // two seconds: an answer, and not an invented one
    changed(&folder, "two_seconds.csv", until(2.0));
    assert_eq!(diagnose("two_seconds.csv", &[]).fine().json()["verdict"], "match");
    // half a second: refused
    changed(&folder, "half_a_second.csv", until(0.5));
    let refused = diagnose("half_a_second.csv", &[]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("long enough"), "{}", refused.stderr);
    // efforts of one number
    changed(&folder, "constant.csv", |h, row| Some(set(h, row, "elbow_joint/effort", "3")));
    let refused = diagnose("constant.csv", &[]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("effort of elbow_joint is the same number"));
    assert!(refused.stderr.contains("hint"), "{}", refused.stderr);
    // positions of one number
    changed(&folder, "at_rest.csv", |h, row| {
        Some(set(h, &set(h, row, "/position", "0.5"), "/velocity", "0"))
    });
    let refused = diagnose("at_rest.csv", &[]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("no joint moves"), "{}", refused.stderr);
    // the training recording is no hold-out, but no accident either
    let same = diagnose("train.csv", &["--holdout", "train.csv"]).fine().json();
    assert_eq!(same["verdict"], "match");
    assert_eq!(same["fit"]["train"], same["fit"]["holdout"]);
}

/// A joint that really rests hides its own friction, and nothing of the others.
#[test]
fn a_joint_at_rest() {
    let folder = recordings("diagnose_rest", &[]);
    changed(&folder, "trajectory.csv", |h, row| {
        let row = set(h, row, "wrist_2_joint/position", "0.6");
        let row = set(h, &row, "wrist_2_joint/velocity", "0");
        Some(row)
    });
    let effects = ["viscous_friction:elbow_joint=8"];
    simulate(&folder.join("trajectory.csv"), &folder.join("train.csv"), "5", &effects);
    let diagnosis = diagnose(&folder, &[]).fine().json();
    assert_eq!(named(&diagnosis), pairs(&[("viscous_friction", "elbow_joint")]));
}

/// What the reference shows too is no finding; what came after it is.
#[test]
fn only_the_change_is_diagnosed() {
    let before = recordings("diagnose_before", &["viscous_friction:elbow_joint=3"]);
    let after = recordings(
        "diagnose_after",
        &["viscous_friction:elbow_joint=3", "coulomb_friction:wrist_1_joint=1.5"],
    );
    let elbow = ("viscous_friction".to_owned(), "elbow_joint".to_owned());
    let wrist = ("coulomb_friction".to_owned(), "wrist_1_joint".to_owned());
    assert_eq!(named(&diagnosed(&after)), BTreeSet::from([elbow, wrist.clone()]));
    let reference = before.join("train.csv");
    let more = ["--reference", text(&reference), "--holdout", "holdout.csv"];
    let change = diagnose(&after, &more).fine().json();
    assert_eq!(named(&change), BTreeSet::from([wrist]));
    let error = |key: &str, joint: &str| number(&change["fit"]["holdout"][key][joint]);
    // the elbow's friction is known before; the wrist's is not
    assert!(error("before", "elbow_joint") < 0.3, "{}", error("before", "elbow_joint"));
    assert!(error("after", "wrist_1_joint") < 0.3 * error("before", "wrist_1_joint"));
}
