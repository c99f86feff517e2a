//! Public recordings of real arms (the shared data; `dataset.toml` of each folder holds a baseline).

use std::path::Path;

use crate::shared::shared;
use crate::tool::{list, number, run, string, text};

/// The errors may be at most this times the baseline's.
const ALLOWANCE: f64 = 1.1;

struct Case {
    folder: &'static str,
    training: &'static str,
    holdout: Option<&'static str>,
    /// constants, effects estimated, effects merged into constants, and their sum
    minimal: usize,
    effects: usize,
    merged: usize,
}

/// Four effect parameters a joint: viscous, Coulomb, offset, rotor inertia. Rotor inertia of joint 1 is
/// part of `U1_33`, and that of joint 2 part of `U2_33` where axis 2 is level and axis 1 upright.
const CASES: [Case; 5] = [
    Case {
        folder: "ur10-unisa",
        training: "train.csv",
        holdout: None,
        minimal: 36,
        effects: 4 * 6 - 2,
        merged: 2,
    },
    Case {
        folder: "panda-unisa",
        training: "train.csv",
        holdout: None,
        minimal: 43,
        effects: 4 * 7 - 2,
        merged: 2,
    },
    // no velocity column
    Case {
        folder: "staubli-tx40",
        training: "train.csv",
        holdout: None,
        minimal: 36,
        effects: 4 * 6 - 2,
        merged: 2,
    },
    Case {
        folder: "dfki-double-pendulum",
        training: "train.csv",
        holdout: None,
        minimal: 6,
        effects: 4 * 2 - 1,
        merged: 1,
    },
    Case {
        folder: "dfki-simple-pendulum",
        training: "ddp.csv",
        holdout: Some("direct_collocation.csv"),
        minimal: 3,
        effects: 4 - 1,
        merged: 1,
    },
];

fn dataset(folder: &Path) -> toml::Table {
    std::fs::read_to_string(folder.join("dataset.toml")).unwrap().parse().unwrap()
}

fn numbers(value: &toml::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect()
}

fn check(case: &Case, worse: &mut Vec<String>) {
    let name = case.folder;
    let Some(folder) = shared("real_data", &format!("data/{name}")) else { return };
    let dataset = dataset(&folder);
    let baseline = &dataset["baseline"];
    let urdf = folder.join(dataset["urdf"].as_str().unwrap());
    let training = folder.join(case.training);
    let cutoff = baseline["filter_hz"].as_integer().unwrap().to_string();
    let mut args = vec!["identify", text(&urdf), text(&training), "--cutoff-hz", &cutoff];
    let holdout = case.holdout.map(|file| folder.join(file));
    if let Some(holdout) = &holdout {
        args.extend(["--holdout", text(holdout)]);
    }
    args.extend(["--json", "-"]);
    let found = run(&args).fine().json();

    let joints: Vec<&str> =
        dataset["joints"].as_array().unwrap().iter().map(|j| j.as_str().unwrap()).collect();
    assert_eq!(found["joints"], serde_json::json!(joints), "{name}");
    assert_eq!(list(&found["constants"]).len(), case.minimal, "{name}");
    assert_eq!(list(&found["effects"]).len(), case.effects, "{name}");
    assert_eq!(list(&found["merged"]).len(), case.merged, "{name}");
    for merged in list(&found["merged"]) {
        assert!(string(&merged["term"]).starts_with("rotor_inertia("), "{name}: {merged}");
    }
    assert_eq!(found["unknowns"], case.minimal + case.effects, "{name}");
    assert_eq!(found["rank"], found["unknowns"], "{name}: everything is determined");
    assert!(number(&found["condition"]) < 1e3, "{name}: {}", found["condition"]);

    let compare = |found: &serde_json::Value, key: &str, worse: &mut Vec<String>| {
        for (joint, expected) in joints.iter().zip(numbers(&baseline[key])) {
            let rmse = number(&found["rmse"][joint]);
            if rmse > ALLOWANCE * expected {
                let ratio = rmse / expected;
                worse.push(format!("{name} {key} {joint}: {rmse:.4} / {expected} = {ratio:.2}"));
            }
        }
    };
    compare(&found["fit"]["train"], "rmse_train", worse);
    if case.holdout.is_some() {
        compare(&found["fit"]["holdout"], "rmse_heldout", worse);
    } else {
        assert!(found["fit"].get("holdout").is_none(), "{name}");
    }
    // a fit is worth more than the URDF without friction
    for joint in joints {
        let rmse = |of: &str| number(&found["fit"][of]["rmse"][joint]);
        assert!(rmse("train") < rmse("urdf"), "{name} {joint}");
    }
}

#[test]
fn fits_no_worse_than_the_baseline() {
    let mut worse = Vec::new();
    for case in &CASES {
        check(case, &mut worse);
    }
    assert!(worse.is_empty(), "worse than {ALLOWANCE} x baseline:\n{}", worse.join("\n"));
}

/// Currents and voltages are no efforts: said in words, with what to do.
#[test]
fn recordings_without_efforts_are_refused() {
    for (folder, training, joint) in
        [("tiago-arm", "train.csv", "arm_1_joint"), ("bam-xl330", "sin_sin_kp100.csv", "servo")]
    {
        let Some(folder) = shared("real_data", &format!("data/{folder}")) else { return };
        let urdf = folder.join(dataset(&folder)["urdf"].as_str().unwrap());
        let ran = run(&["identify", text(&urdf), text(&folder.join(training))]);
        assert_eq!(ran.code, 1, "{}", ran.stderr);
        let said = ran.stderr.lines().find(|line| line.starts_with("error: ")).unwrap();
        assert!(said.contains("no effort column") && said.contains(joint), "{said}");
        assert!(ran.stderr.contains(" hint: ") && ran.stderr.contains("/effort"), "{}", ran.stderr);
    }
}
