//! The suite of motions of `excite`, recorded in simulation and identified.

use std::collections::BTreeMap;

use crate::shared::project;
use crate::tool::{list, number, read_json, run, run_in, scratch, string, text};

/// Effort noise of every joint \[N m\], and the limits file that states it.
const NOISE: f64 = 0.3;

fn limits(joints: usize) -> String {
    (1..=joints).map(|k| format!("[joint_{k}]\nnoise = {NOISE}\n")).collect()
}

/// Standard errors before the motion are those after it: the spread of estimates from simulated recordings of the training
/// motion, over the constants, is that of the prediction.
#[test]
fn predicted_errors_are_those_of_the_estimate() {
    let folder = scratch("excite");
    let urdf = project("urdf/irb140.urdf");
    std::fs::write(folder.join("limits.toml"), limits(6)).unwrap();
    let design = ["--limits", "limits.toml", "--only", "train,validation", "--seconds", "12"];
    let args =
        [&["excite", text(&urdf), "-o", "suite", "--budget", "4s", "-q"][..], &design].concat();
    run_in(&folder, &[&args[..], &["--json", "suite.json"]].concat()).fine();
    let suite = read_json(&folder.join("suite.json"));
    assert_eq!(suite["schema"], "armident.excite/1");
    let files = std::fs::read_to_string(folder.join("suite/suite.toml")).unwrap();
    for name in ["train", "validation", "train_rehearsal", "validation_rehearsal"] {
        assert!(files.contains(&format!("file = \"{name}.csv\"")), "{files}");
        assert!(folder.join(format!("suite/{name}.csv")).exists());
    }
    let train = list(&suite["motions"]).iter().find(|m| m["name"] == "train").unwrap();
    assert!(number(&train["condition"]) < number(&suite["random_condition"]));

    let predicted: BTreeMap<&str, (f64, f64)> = list(&suite["errors"])
        .iter()
        .filter(|e| !e["value"].is_null())
        .map(|e| (string(&e["name"]), (number(&e["value"]), number(&e["from_train"]))))
        .collect();
    let mut squares = Vec::new();
    for seed in ["1", "2", "3"] {
        let noise = NOISE.to_string();
        let simulate = ["simulate", text(&urdf), "suite/train.csv", "-o", "run.csv", "-q"];
        let noisy = ["--torque-noise", &noise, "--encoder-bits", "24", "--seed", seed];
        run_in(&folder, &[&simulate[..], &noisy].concat()).fine();
        let found = run_in(
            &folder,
            &[
                "identify",
                text(&urdf),
                "run.csv",
                "--prior",
                "none",
                "--method",
                "ols",
                "--raw-estimate",
                "--json",
                "-",
                "-q",
            ],
        )
        .fine()
        .json();
        for constant in list(&found["constants"]) {
            let (value, error) = predicted[string(&constant["label"])];
            squares.push(((number(&constant["value"]) - value) / error).powi(2));
        }
    }
    assert_eq!(squares.len(), 3 * predicted.len());
    // 1.17 to 1.43 on a Panda: the estimator forms velocities and accelerations from positions
    let spread = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((0.7..1.6).contains(&spread), "{spread}");
}

/// Limits that leave no motion are refused, with the joint and what would help.
#[test]
fn weak_arm_is_refused() {
    let folder = scratch("excite_weak");
    std::fs::write(folder.join("weak.toml"), "[joint_2]\neffort = 1.0\n").unwrap();
    let urdf = project("urdf/irb140.urdf");
    let args =
        ["excite", text(&urdf), "-o", "suite", "--limits", "weak.toml", "--budget", "0.2", "-q"];
    let ran = run_in(&folder, &args);
    assert_eq!(ran.code, 1, "{}", ran.stdout);
    assert!(ran.stderr.contains("joint `joint_2` needs"), "{}", ran.stderr);
    assert!(ran.stderr.contains(" hint: raise `effort`"), "{}", ran.stderr);
    assert!(!folder.join("suite").exists());
}

/// A part that is named is written alone.
#[test]
fn parts_are_designed_singly() {
    let folder = scratch("excite_parts");
    let urdf = project("urdf/scara.urdf");
    let out = folder.join("suite");
    let args =
        ["excite", text(&urdf), "-o", text(&out), "--budget", "0.3", "--only", "static_holds"];
    let printed = run(&[&args[..], &["-q"]].concat()).fine();
    assert!(printed.stdout.contains("static_holds"), "{}", printed.stdout);
    let files: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(files.len(), 2, "{files:?}");
}

/// A folder of recordings with the list of the suite: its hold-out is held out, what is for neither is not used.
#[test]
fn recordings_are_split_as_the_suite_says() {
    let folder = scratch("excite_split");
    let urdf = project("urdf/scara.urdf");
    let design = ["excite", text(&urdf), "-o", "suite", "--budget", "0.5", "--seconds", "8", "-q"];
    run_in(&folder, &[&design[..], &["--only", "train,fast,validation"]].concat()).fine();
    let planned = ["suite/train.csv", "suite/validation.csv", "suite/train_rehearsal.csv"];
    let simulate = ["-o", "runs", "--torque-noise", "1%", "-q"];
    run_in(&folder, &[&["simulate", text(&urdf)], &planned[..], &simulate].concat()).fine();
    std::fs::copy(folder.join("suite/suite.toml"), folder.join("runs/suite.toml")).unwrap();
    let ran = run_in(&folder, &["identify", text(&urdf), "runs", "--json", "-"]).fine();
    assert!(ran.stderr.contains("runs/suite.toml: not recorded: fast"), "{}", ran.stderr);
    let found = ran.json();
    let names = |key: &str| -> Vec<String> {
        list(&found[key]).iter().map(|file| string(file).to_owned()).collect()
    };
    assert_eq!(names("recordings"), ["runs/train.csv"]);
    assert_eq!(names("holdout_recordings"), ["runs/validation.csv"]);
}
