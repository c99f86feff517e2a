//! Recordings that tell little, wrong columns, and what must change nothing.

use std::collections::BTreeSet;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};

use serde_json::Value;

use super::{changed, diagnose, diagnosed, named, pairs, recordings, set, simulate, urdf};
use crate::tool::{list, number, run_in, string, text};

#[test]
fn uninformative_recordings_have_no_findings() {
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
    assert!(refused.stderr.contains("too short"), "{}", refused.stderr);
    // efforts of one number
    changed(&folder, "constant.csv", |h, row| Some(set(h, row, "elbow_joint/effort", "3")));
    let constant = diagnose("constant.csv", &[]).fine().json();
    let faults = list(&constant["input_checks"]["faults"]);
    assert!(faults.iter().all(|fault| fault["joint"] == "elbow_joint"), "{faults:?}");
    let is_said = |fault: &Value| string(&fault["message"]).contains("constant in 100 %");
    assert!(faults.iter().any(is_said), "{faults:?}");
    assert!(named(&constant).iter().all(|(_, joint)| joint != "elbow_joint"));
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
    assert!(refused.stderr.contains("used for training and hold-out"), "{}", refused.stderr);
    // efforts in an order of their own belong to no motion: nothing is named with confidence
    let recorded = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let rows: Vec<Vec<String>> =
        recorded.lines().skip(1).map(|l| l.split(',').map(str::to_owned).collect()).collect();
    let mut order: Vec<usize> = (0..rows.len()).collect();
    // without a seed of its own this hasher is the same in every run
    order.sort_by_cached_key(|k| BuildHasherDefault::<DefaultHasher>::default().hash_one(k));
    let line = std::cell::Cell::new(0);
    changed(&folder, "shuffled.csv", |h, row| {
        let from = &rows[order[line.get()]];
        line.set(line.get() + 1);
        let of = h.iter().zip(row.iter().zip(from));
        Some(of.map(|(h, (x, y))| if h.ends_with("effort") { y } else { x }.clone()).collect())
    });
    let shuffled = diagnose("shuffled.csv", &[]).fine().json();
    let said = string(&shuffled["sentence"]);
    assert!(said.starts_with("input check failed"), "{said}");
    let believed = list(&shuffled["findings"]).iter().filter(|f| number(&f["confidence"]) > 0.5);
    assert_eq!(believed.count(), 0, "{}", shuffled["findings"]);
}

/// A column that is not what its header says is that, and no physics.
#[test]
fn input_checks_come_first() {
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
    let faults = list(&diagnosis["input_checks"]["faults"]);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0]["joint"], "shoulder_lift_joint");
    assert!(string(&faults[0]["message"]).contains("sign"), "{faults:?}");
    assert!(string(&diagnosis["sentence"]).starts_with("input check failed"));
    // with right books nothing is said of them
    assert!(list(&diagnosed(&folder)["input_checks"]["faults"]).is_empty());
}

/// Names do not depend on what joints and files are called, on units, on a joint beside the arm, or on
/// where a recording is cut while the arm rests.
#[test]
fn findings_are_reproducible() {
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

/// A joint that really rests hides its own friction, and nothing of the others.
#[test]
fn accepts_a_joint_at_rest() {
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

/// One of two recordings without the effort of a joint: it says what it can of the others.
#[test]
fn accepts_missing_effort_in_one_recording() {
    let folder = recordings("diagnose_missing", &["viscous_friction:elbow_joint=8"]);
    let whole = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let names = whole.lines().next().unwrap();
    let place = names.split(',').position(|n| n == "elbow_joint/effort").unwrap();
    let less: Vec<String> = whole
        .lines()
        .map(|line| {
            let mut row: Vec<&str> = line.split(',').collect();
            row.remove(place);
            row.join(",")
        })
        .collect();
    std::fs::write(folder.join("less.csv"), less.join("\n") + "\n").unwrap();
    let urdf = urdf();
    let args = ["diagnose", text(&urdf), "less.csv", "holdout.csv", "-q", "--json", "-"];
    let diagnosis = run_in(&folder, &args).fine().json();
    assert_eq!(named(&diagnosis), pairs(&[("viscous_friction", "elbow_joint")]));
    assert!(string(&diagnosis["input_checks"]["unchecked"]).contains("elbow_joint"));
}
