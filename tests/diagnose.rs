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
    // what is found is the same; only the proof is not
    let unproven = |of: &Value| -> Vec<Value> {
        let mut findings = list(&of["findings"]).to_vec();
        findings.iter_mut().for_each(|f| f["confirmed"] = Value::Null);
        findings
    };
    assert_eq!(unproven(&with), unproven(&without));
    assert!(list(&with["findings"]).iter().all(|f| f["confirmed"] == true));
    assert!(list(&without["findings"]).iter().all(|f| f["confirmed"].is_null()));
    assert!(string(&with["sentence"]).ends_with("the hold-out confirms it"));
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
    // on its own data every model is good
    let refused = diagnose("train.csv", &["--holdout", "./train.csv"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("for the fit and for the hold-out"), "{}", refused.stderr);
    // efforts in an order of their own belong to no motion: nothing is named with confidence
    let recorded = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let rows: Vec<Vec<String>> =
        recorded.lines().skip(1).map(|l| l.split(',').map(str::to_owned).collect()).collect();
    let count = rows.len();
    let line = std::cell::Cell::new(0);
    changed(&folder, "shuffled.csv", |h, row| {
        // a multiplier without a common divisor with the number of rows visits each once
        let from = &rows[(line.get() * 7919) % count];
        line.set(line.get() + 1);
        let of = h.iter().zip(row.iter().zip(from));
        Some(of.map(|(h, (x, y))| if h.ends_with("effort") { y } else { x }.clone()).collect())
    });
    let shuffled = diagnose("shuffled.csv", &[]).fine().json();
    let believed = list(&shuffled["findings"]).iter().filter(|f| number(&f["confidence"]) > 0.5);
    assert_eq!(believed.count(), 0, "{}", shuffled["findings"]);
}

/// A column that is not what its header says is that, and no physics.
#[test]
fn the_books_come_first() {
    let folder = recordings("diagnose_books", &["viscous_friction:elbow_joint=8"]);
    changed(&folder, "flipped.csv", |h, row| {
        let negated = |x: &String| (-x.parse::<f64>().unwrap()).to_string();
        let of = h.iter().zip(row);
        Some(
            of.map(
                |(h, x)| if *h == "shoulder_lift_joint/effort" { negated(x) } else { x.clone() },
            )
            .collect(),
        )
    });
    let urdf = urdf();
    let run = |more: &[&str]| {
        let args = ["diagnose", text(&urdf), "flipped.csv", "-q", "--json", "-"];
        run_in(&folder, &[&args, more].concat()).fine().json()
    };
    let diagnosis = run(&[]);
    assert_eq!(diagnosis["verdict"], "mismatch");
    // nothing is named on that joint; the others are diagnosed without it
    assert_eq!(named(&diagnosis), pairs(&[("viscous_friction", "elbow_joint")]));
    let faults = list(&diagnosis["books"]["faults"]);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0]["joint"], "shoulder_lift_joint");
    assert!(string(&faults[0]["message"]).contains("sign"), "{faults:?}");
    assert!(string(&diagnosis["sentence"]).starts_with("the books are wrong"));
    // with right books nothing is said of them
    assert!(list(&diagnosed(&folder)["books"]["faults"]).is_empty());
}

/// Names do not depend on what joints and files are called, on units, on a joint beside the arm, or on
/// where a recording is cut while the arm rests.
#[test]
fn names_stay_the_same() {
    let effects = ["viscous_friction:elbow_joint=8", "coulomb_friction:wrist_1_joint=1.5"];
    let folder = recordings("diagnose_same", &effects);
    let expected = [("coulomb_friction", "wrist_1_joint"), ("viscous_friction", "elbow_joint")];
    let score = |diagnosis: &Value| -> Vec<f64> {
        list(&diagnosis["findings"]).iter().map(|f| number(&f["evidence"]["materiality"])).collect()
    };
    let recorded = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let urdf_text = std::fs::read_to_string(urdf()).unwrap();
    let run = |robot: &str, files: &[&str], more: &[&str]| {
        let args = [&["diagnose", robot], files, &["-q", "--json", "-"], more].concat();
        run_in(&folder, &args).fine().json()
    };
    let robot = urdf();
    let robot = text(&robot);
    let both = run(robot, &["train.csv", "holdout.csv"], &[]);
    assert_eq!(named(&both), pairs(&expected));
    let near = |other: &Value, limit: f64| {
        for (a, b) in score(&both).iter().zip(score(other)) {
            assert!((a - b).abs() < limit * a, "{a} {b}");
        }
    };
    // files in another order
    let reordered = run(robot, &["holdout.csv", "train.csv"], &[]);
    assert_eq!(named(&reordered), pairs(&expected));
    near(&reordered, 1e-6);
    // joints with other names
    std::fs::write(folder.join("renamed.urdf"), urdf_text.replace("_joint\"", "_axis\"")).unwrap();
    for file in ["train", "holdout"] {
        let text = std::fs::read_to_string(folder.join(format!("{file}.csv"))).unwrap();
        let text = text.replace("_joint/", "_axis/");
        std::fs::write(folder.join(format!("{file}_renamed.csv")), text).unwrap();
    }
    let renamed = run("renamed.urdf", &["train_renamed.csv", "holdout_renamed.csv"], &[]);
    let axes = expected.map(|(e, j)| (e.to_owned(), j.replace("_joint", "_axis")));
    assert_eq!(named(&renamed), BTreeSet::from(axes));
    near(&renamed, 1e-6);
    // degrees, and a joint that is not the arm's
    let degrees = |file: &str| {
        let text = std::fs::read_to_string(folder.join(format!("{file}.csv"))).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let mut content = header.join(",") + ",gripper/position,gripper/effort\n";
        for line in lines {
            let row: Vec<String> = header
                .iter()
                .zip(line.split(','))
                .map(|(h, x)| match h.ends_with("position") {
                    true => x.parse::<f64>().unwrap().to_degrees().to_string(),
                    false => x.to_owned(),
                })
                .collect();
            content += &(row.join(",") + ",0.5,0.1\n");
        }
        std::fs::write(folder.join(format!("{file}_degrees.csv")), content).unwrap();
    };
    ["train", "holdout"].iter().for_each(|file| degrees(file));
    let mapping = "[[channel]]\ncolumn = \"{joint}/position\"\nquantity = \"position\"\nunit = \"deg\"\n\
                   [[channel]]\ncolumn = \"{joint}/{quantity}\"\n";
    std::fs::write(folder.join("degrees.toml"), mapping).unwrap();
    let files = ["train_degrees.csv", "holdout_degrees.csv"];
    let mapped = run(robot, &files, &["--mapping", "degrees.toml"]);
    assert_eq!(named(&mapped), pairs(&expected));
    near(&mapped, 1e-2);
    // cut in two
    let lines: Vec<&str> = recorded.lines().collect();
    let middle = lines.len() / 2;
    let part = |from: usize, to: usize| [&lines[..1], &lines[from..to]].concat().join("\n") + "\n";
    std::fs::write(folder.join("first.csv"), part(1, middle)).unwrap();
    std::fs::write(folder.join("second.csv"), part(middle, lines.len())).unwrap();
    let cut = run(robot, &["first.csv", "second.csv", "holdout.csv"], &[]);
    assert_eq!(named(&cut), pairs(&expected));
    near(&cut, 0.2);
}

/// Where two laws fit alike, both are said, and the motion that tells them apart.
#[test]
fn a_load_may_be_a_wrong_link() {
    let folder = recordings("diagnose_alternatives", &["payload:wrist_3_joint=1.5,0,0.02,0.05"]);
    let run = diagnose(&folder, &["--next-motion", "next"]);
    let diagnosis = run.fine().json();
    let finding = &diagnosis["findings"][0];
    let other: Vec<&str> =
        list(&finding["alternatives"]).iter().map(|a| string(&a["effect"])).collect();
    let names = [string(&finding["effect"])].iter().chain(&other).copied().collect::<BTreeSet<_>>();
    assert!(names.is_superset(&BTreeSet::from(["payload", "link_inertia_error"])), "{names:?}");
    // no motion tells a load from its link, and that is said
    let next = &diagnosis["next_motion"];
    assert!(next.is_object());
    assert!(next["file"].is_null() == (number(&next["told_apart"]) == 0.0));
    assert_eq!(folder.join("next/next_motion.csv").exists(), !next["file"].is_null());
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

/// The minimal set beside the findings holds the truth in its intervals: the UR5 with the heavier forearm.
#[test]
fn constants_of_the_diagnosed_arm() {
    use armident_ident::{ArmModel, MinimalSet};
    use armident_kinematics::{
        ChainSelection, DrivingAxisChain, InertialParameters, SerialChain, load_urdf,
    };
    let robot = load_urdf(&urdf()).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let mut model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let set = MinimalSet::of(&model.rigid_arm()).unwrap();
    let believed = set.values(&model.rigid_arm().constants());
    // as in examples/make_ur5_recordings.rs
    let forearm = &mut model.chain.joints[2].link;
    let place = forearm.com_m() + nalgebra::Vector3::new(0.05, 0.0, 0.0);
    let added = InertialParameters::from_com(0.6, place, nalgebra::Matrix3::identity() * 0.002);
    *forearm = forearm.plus(&added);
    let truth = set.values(&model.rigid_arm().constants());

    let train = project("examples/ur5/train.csv");
    let urdf = urdf();
    let args = ["diagnose", text(&urdf), text(&train), "-q", "--json", "-"];
    let diagnosis = run(&args).fine().json();
    let constants = list(&diagnosis["constants"]);
    assert_eq!(constants.len(), set.len());
    let mut within = 0;
    for (k, constant) in constants.iter().enumerate() {
        let label = string(&constant["label"]);
        assert_eq!(label, set.labels()[k]);
        assert!((number(&constant["urdf"]) - believed[k]).abs() < 1e-9, "{label}");
        let error = number(&constant["standard_error"]);
        let off = (number(&constant["value"]) - truth[k]) / error;
        assert!(
            error > 0.0 && off.abs() < 5.0,
            "{label} is {off:.1} standard errors off the truth"
        );
        let interval: Vec<f64> = list(&constant["interval_95"]).iter().map(number).collect();
        within += usize::from(interval[0] <= truth[k] && truth[k] <= interval[1]);
        assert!((0.0..=1.0).contains(&number(&constant["from_prior"])), "{label}");
    }
    assert!(
        within * 10 >= constants.len() * 8,
        "{within} of {} intervals hold the truth",
        constants.len()
    );
    // the forearm's first moment is known from the recording, not from the URDF
    let moment = constants.iter().find(|c| c["label"] == "k3_x").unwrap();
    assert!(number(&moment["from_prior"]) < 0.05 && number(&moment["value"]) > 1.7);
}

/// A pendulum whose efforts follow a curve that no law of the library has, before and after: what is left
/// unexplained is said, and a heavier bob is found all the same. Its mass by itself is not: a pendulum shows
/// its moment.
#[test]
fn a_load_on_an_imperfect_pendulum() {
    let folder = scratch("diagnose_pendulum");
    let urdf = |mass: f64| {
        format!(
            "<robot name=\"pendulum\"><link name=\"base\"/><link name=\"arm\"><inertial>\
             <origin xyz=\"0 0 -0.5\"/><mass value=\"{mass}\"/><inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" \
             iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"/></inertial></link><joint name=\"servo\" type=\"revolute\">\
             <parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"20\"/></joint></robot>"
        )
    };
    let make = |name: &str, mass: f64, sines: [(f64, f64); 3], seed: &str| {
        std::fs::write(folder.join("made.urdf"), urdf(mass)).unwrap();
        let mut trajectory = "t,servo/position,servo/velocity\n".to_owned();
        for k in 0..4000 {
            let t = f64::from(k) / 200.0;
            let q: f64 = sines.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let v: f64 = sines.iter().map(|(a, w)| a * w * (w * t).cos()).sum();
            trajectory += &format!("{t},{q},{v}\n");
        }
        std::fs::write(folder.join("trajectory.csv"), trajectory).unwrap();
        let args =
            ["simulate", "made.urdf", "trajectory.csv", "-o", "train.csv", "-q", "--seed", seed];
        let more = ["--torque-noise", "0.05", "--effect", "coulomb_friction:servo=0.8"];
        run_in(&folder, &[&args[..], &more].concat()).fine();
        changed(&folder, &format!("{name}.csv"), |h, row| {
            let value = |name: &str| -> f64 {
                let place = h.iter().position(|x| *x == name).unwrap();
                row[place].parse().unwrap()
            };
            let (q, effort) = (value("servo/position"), value("servo/effort"));
            let bent = effort + 0.06 * effort * (4.0 * q).sin() * effort.abs().sqrt();
            Some(set(h, row, "servo/effort", &bent.to_string()))
        });
    };
    make("before", 2.0, [(0.5, 0.9), (0.4, 2.3), (0.2, 4.1)], "1");
    make("same", 2.0, [(0.6, 0.7), (0.3, 2.9), (0.2, 3.7)], "2");
    make("loaded", 2.8, [(0.6, 0.7), (0.3, 2.9), (0.2, 3.7)], "3");
    std::fs::write(folder.join("arm.urdf"), urdf(2.0)).unwrap();
    let change = |after: &str| -> Value {
        let args =
            ["diagnose", "arm.urdf", after, "--reference", "before.csv", "-q", "--json", "-"];
        run_in(&folder, &args).fine().json()
    };
    let same = change("same.csv");
    assert_eq!(named(&same), BTreeSet::new());
    let sentence = string(&same["sentence"]);
    assert!(sentence.contains("no change"), "{sentence}");
    let loaded = change("loaded.csv");
    let findings = list(&loaded["findings"]);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0]["link"], "arm");
    let parameters = &findings[0]["parameters"];
    assert!(parameters["delta_mass"].is_null(), "{parameters}");
    let moment = number(&parameters["delta_mcz"]["value"]);
    assert!((moment + 0.4).abs() < 0.1, "{moment}");
}

/// Links that are all off by a few per cent are no single effect, and no match.
#[test]
fn links_that_are_all_a_little_off() {
    let folder = recordings("diagnose_all_links", &[]);
    let mut made = String::new();
    let mut off = [1.1, 0.92, 1.12].iter().cycle();
    for line in std::fs::read_to_string(urdf()).unwrap().lines() {
        let mass = line.split_once("<mass value=\"").and_then(|(_, rest)| rest.split_once('"'));
        match mass {
            Some((mass, _)) => {
                let changed = mass.parse::<f64>().unwrap() * off.next().unwrap();
                made += &line.replace(mass, &changed.to_string());
            }
            None => made += line,
        }
        made.push('\n');
    }
    std::fs::write(folder.join("off.urdf"), made).unwrap();
    let args = ["diagnose", "off.urdf", "train.csv", "-q", "--json", "-"];
    let diagnosis = run_in(&folder, &args).fine().json();
    assert_eq!(named(&diagnosis), BTreeSet::new());
    assert_eq!(diagnosis["verdict"], "mismatch");
    let sentence = string(&diagnosis["sentence"]);
    assert!(sentence.contains("no single effect"), "{sentence}");
    let on: Vec<&str> = list(&diagnosis["inertias_matter_on"]).iter().map(string).collect();
    assert!(on.contains(&"shoulder_lift_joint"), "{on:?}");
    // whose masses carry no more effort than the noise
    assert!(!on.contains(&"wrist_3_joint"), "{on:?}");
}

/// A narrow detent far above the noise of its joint, beside everyday friction: what no law explains must not
/// make its joint unimportant before it is described.
#[test]
fn a_detent_is_described() {
    let friction: Vec<String> = JOINTS
        .iter()
        .flat_map(|j| [format!("coulomb_friction:{j}=1.5"), format!("viscous_friction:{j}=1.2")])
        .collect();
    let folder =
        recordings("diagnose_detent", &friction.iter().map(String::as_str).collect::<Vec<_>>());
    changed(&folder, "train.csv", |h, row| {
        let value = |name: &str| -> f64 {
            row[h.iter().position(|x| *x == name).unwrap()].parse().unwrap()
        };
        let (q, effort) = (value("elbow_joint/position"), value("elbow_joint/effort"));
        let detent = 4.0 * (-((q - 1.5) / 0.2).powi(2)).exp() * (25.0 * (q - 1.5)).sin();
        Some(set(h, row, "elbow_joint/effort", &(effort + detent).to_string()))
    });
    let diagnosis = diagnose(&folder, &[]).fine().json();
    let described = ("unmodelled".to_owned(), "elbow_joint".to_owned());
    assert!(named(&diagnosis).contains(&described), "{:?}", named(&diagnosis));
    let finding =
        list(&diagnosis["findings"]).iter().find(|f| f["effect"] == "unmodelled").unwrap();
    assert_eq!(finding["evidence"]["variables"], serde_json::json!(["elbow_joint/position"]));
    let left = number(&diagnosis["fit"]["train"]["after"]["elbow_joint"]);
    assert!(left < 0.5, "{left}");
}

/// A hold-out of another arm than the one trained on: the finding is not confirmed, and the joint is said on
/// which the model is worse than the robot as given.
#[test]
fn a_holdout_that_contradicts() {
    let folder = recordings("diagnose_contradicted", &["coulomb_friction:elbow_joint=4"]);
    simulate(&project("examples/ur5/holdout.csv"), &folder.join("holdout.csv"), "7", &[]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(named(&diagnosis), pairs(&[("coulomb_friction", "elbow_joint")]));
    assert_eq!(diagnosis["findings"][0]["confirmed"], false);
    assert_eq!(diagnosis["worse_on_holdout"], serde_json::json!(["elbow_joint"]));
    let sentence = string(&diagnosis["sentence"]);
    assert!(sentence.ends_with("worse than by the robot as given on elbow_joint"), "{sentence}");
}

/// What is said of a finding is what the saved model has: a friction without the smaller one beside it, too small
/// to be named, would be too large by it.
#[test]
fn numbers_are_those_of_the_model() {
    let effects = ["coulomb_friction:elbow_joint=4", "viscous_friction:elbow_joint=0.3"];
    let folder = recordings("diagnose_numbers", &effects);
    let diagnosis = diagnose(&folder, &["--save-model", "model.json"]).fine().json();
    assert_eq!(named(&diagnosis), pairs(&[("coulomb_friction", "elbow_joint")]));
    let level = &diagnosis["findings"][0]["parameters"]["level"];
    let model = read_json(&folder.join("model.json"));
    let of_model = |effect: &str| {
        let term = list(&model["effects"])
            .iter()
            .find(|e| e["effect"] == effect && e["joint"] == "elbow_joint");
        term.map(|e| number(&e["parameters"][0]))
    };
    let said = number(&level["value"]);
    assert!((said / of_model("coulomb_friction").unwrap() - 1.0).abs() < 1e-9, "{said}");
    let viscous = of_model("viscous_friction").expect("the small term helps to predict");
    assert!((viscous - 0.3).abs() < 0.1, "{viscous}");
    assert!((said - 4.0).abs() < 3.0 * number(&level["stderr"]), "{said}");
}
