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

/// A rotating column with two arms of boxes.
fn boxes() -> String {
    let link = |name: &str, length: f64| {
        let half = 0.5 * length;
        format!(
            r#"<link name="{name}"><inertial><origin xyz="0 0 {half}"/><mass value="4"/>
            <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.01"/></inertial>
            <collision><origin xyz="0 0 {half}"/><geometry><box size="0.08 0.08 {length}"/></geometry></collision>
            <collision><geometry><mesh filename="{name}.stl"/></geometry></collision></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str, z: f64, axis: &str, most: f64| {
        format!(
            r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
            <origin xyz="0 0 {z}"/><axis xyz="{axis}"/>
            <limit lower="-{most}" upper="{most}" velocity="2" effort="120"/></joint>"#
        )
    };
    let links = [link("column", 0.4), link("upper_arm", 0.5), link("forearm", 0.4)].concat();
    let joints = [
        joint("turn", "base", "column", 0.0, "0 0 1", 3.0),
        joint("shoulder", "column", "upper_arm", 0.4, "0 1 0", 2.0),
        joint("elbow", "upper_arm", "forearm", 0.5, "0 1 0", 2.6),
    ]
    .concat();
    format!(r#"<robot name="boxes"><link name="base"/>{links}{joints}</robot>"#)
}

/// Regions are read, kept clear of, and written down; formats beside CSV hold the same motion.
#[test]
fn keep_outs_and_formats_are_written() {
    let folder = scratch("excite_keep_out");
    std::fs::write(folder.join("boxes.urdf"), boxes()).unwrap();
    let table = "[table]\ncentre = [0.45, 0.0, 0.25]\nsize = [0.6, 2.0, 0.1]\n";
    std::fs::write(folder.join("cell.toml"), table).unwrap();
    let design = ["excite", "boxes.urdf", "-o", "suite", "--budget", "1", "--seconds", "6"];
    let with = ["--keep-out", "cell.toml", "--only", "train", "--format", "csv,ros2,json"];
    let ran = run_in(&folder, &[&design[..], &with, &["--json", "suite.json"]].concat()).fine();
    assert!(ran.stderr.contains("not considered"), "{}", ran.stderr);
    assert!(ran.stderr.contains("forearm (mesh)"), "{}", ran.stderr);
    assert!(ran.stderr.contains("and keep-outs keep 10 mm apart"), "{}", ran.stderr);
    for motion in list(&read_json(&folder.join("suite.json"))["motions"]) {
        assert!(number(&motion["clearance_m"]) >= 0.01, "{motion}");
    }
    let json = read_json(&folder.join("suite/train.json"));
    let samples = list(&json["time_s"]).len();
    assert_eq!(list(&json["joints"]).len(), 3);
    assert_eq!(list(&list(&json["position"])[2]).len(), samples);
    let yaml = std::fs::read_to_string(folder.join("suite/train.yaml")).unwrap();
    assert!(yaml.contains("joint_names: [\"turn\", \"shoulder\", \"elbow\"]"), "{yaml}");
    assert_eq!(yaml.matches("time_from_start: {sec: ").count(), samples);
    let csv = std::fs::read_to_string(folder.join("suite/train.csv")).unwrap();
    assert_eq!(csv.lines().count(), samples + 1);

    let failed =
        run_in(&folder, &[&design[..], &["--only", "train", "--format", "urscript"]].concat());
    assert_eq!(failed.code, 1);
    assert!(
        failed.stderr.contains("expected six rotational joints, found RRR"),
        "{}",
        failed.stderr
    );
}

/// What leaves no motion names itself, the region and by how much; a region that is none names its key.
#[test]
fn impossible_keep_outs_are_refused() {
    let folder = scratch("excite_impossible");
    std::fs::write(folder.join("boxes.urdf"), boxes()).unwrap();
    let refused = |urdf: &str, region: &str, expected: &str| {
        std::fs::write(folder.join("cell.toml"), region).unwrap();
        let args = ["excite", urdf, "-o", "s", "--budget", "0.2", "-q", "--keep-out", "cell.toml"];
        let ran = run_in(&folder, &args);
        assert_eq!(ran.code, 1, "{}", ran.stdout);
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
        assert!(ran.stderr.contains(" hint: "), "{}", ran.stderr);
    };
    let cell = "[cell]\ncentre = [0.0, 0.0, 0.0]\nsize = [5.0, 5.0, 5.0]\n";
    refused(
        "boxes.urdf",
        cell,
        "no pose inside the limits keeps clear: keep-out `cell` and link `",
    );
    refused("boxes.urdf", "[cell]\ncentre = [0.0, 0.0, 0.0]\n", "keep-out `cell`, keys: expected");
    refused("boxes.urdf", "[cell]\nsize = [1.0, 0.0]\n", "cell.toml");
    let urdf = project("urdf/irb140.urdf");
    refused(text(&urdf), cell, "no link has a `<collision>`");
}

/// Swings of one joint leave a gain of the effort channel and a rotor inertia open, and so do the same swings again. The
/// motion designed for the diagnosis decides it.
#[test]
fn separating_motion_decides_between_look_alikes() {
    let folder = scratch("excite_for");
    let urdf = project("urdf/planar_3r.urdf");
    let mut first = "t,joint_1/position,joint_2/position,joint_3/position\n".to_owned();
    for k in 0..=1200 {
        let t = f64::from(k) / 100.0;
        let rise = 0.5 - 0.5 * (std::f64::consts::PI * t.min(12.0 - t).min(1.0)).cos();
        let swing = 0.4 + rise * 0.8 * (0.8 * std::f64::consts::PI * t).sin();
        first += &format!("{t:.3},0.2,{swing:.9},0.3\n");
    }
    std::fs::write(folder.join("first.csv"), first).unwrap();
    let record = |motion: &str, out: &str, seed: &str| {
        let simulate = ["simulate", text(&urdf), motion, "-o", out, "--torque-noise", "0.1"];
        let more =
            ["--encoder-bits", "20", "--seed", seed, "--effect", "torque_scale:joint_2=1.15", "-q"];
        run_in(&folder, &[&simulate[..], &more].concat()).fine();
    };
    let diagnosed = |recordings: &[&str], out: &str| {
        let all = [&["diagnose", text(&urdf)], recordings, &["--json", out, "-q"]].concat();
        run_in(&folder, &all).fine();
        read_json(&folder.join(out))
    };
    record("first.csv", "a.csv", "1");
    record("first.csv", "again.csv", "2");
    let is_open = |found: &serde_json::Value| {
        list(&found["findings"]).iter().any(|f| !list(&f["alternatives"]).is_empty())
    };
    assert!(is_open(&diagnosed(&["a.csv"], "open.json")));
    assert!(is_open(&diagnosed(&["a.csv", "again.csv"], "again.json")));

    let design = ["excite", text(&urdf), "-o", "next", "--for", "open.json", "--seconds", "10"];
    let ran = run_in(&folder, &[&design[..], &["--budget", "3", "--json", "next.json"]].concat());
    let ran = ran.fine();
    assert!(ran.stdout.contains("residual after the best imitation"), "{}", ran.stdout);
    let designed = read_json(&folder.join("next.json"));
    let names: Vec<&str> = list(&designed["motions"]).iter().map(|m| string(&m["name"])).collect();
    assert_eq!(names, ["separation_rehearsal", "separation"]);
    for pair in list(&designed["separations"]) {
        assert!(number(&pair["standard_errors"]) > 4.0, "{pair}");
    }
    record("next/separation.csv", "b.csv", "3");
    let found = diagnosed(&["a.csv", "b.csv"], "decided.json");
    let findings = list(&found["findings"]);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0]["effect"], "torque_scale");
    assert!(!is_open(&found), "{findings:?}");

    // a diagnosis without alternatives leaves nothing to separate
    let design = ["excite", text(&urdf), "-o", "none", "--for", "decided.json", "-q"];
    let refused = run_in(&folder, &design);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("found 1 finding without one"), "{}", refused.stderr);
}
