//! `--mcap`: recordings beside predictions, for viewers of MCAP.
//!
//! The readers of MCAP and ROS 2 messages from PyPI judge the file: `mcap` and `mcap-ros2-support` in the Python of
//! [`peers`](crate::peers). Without them that test is skipped.

use std::path::Path;
use std::process::Command;

use armident_recording::{Quantity, ReadSettings, Recording, read_recording};
use serde_json::Value;

use crate::peers::python;
use crate::shared::{project, skipped};
use crate::tool::{list, number, read_json, run, scratch, string, text};

fn topic(path: &Path, topic: &str) -> Recording {
    let settings = ReadSettings { mapping: None, topic: Some(topic) };
    read_recording(path, &settings).unwrap()
}

fn efforts(recording: &Recording, joint: &str) -> Vec<f64> {
    let joint = recording.joint(joint).unwrap();
    joint.channel(Quantity::Effort).unwrap_or_else(|| panic!("{}", joint.name)).to_vec()
}

/// Measured is predicted and residual, at the stamps of the recording, and predicted is what `predict` gives.
#[test]
fn residual_is_measured_minus_predicted() {
    let folder = scratch("topics");
    let (urdf, holdout) = (project("urdf/ur5.urdf"), project("examples/ur5/holdout.csv"));
    let (file, predicted) = (folder.join("topics.mcap"), folder.join("predicted.csv"));
    let args = ["validate", text(&urdf), text(&holdout), "--no-replay", "--mcap", text(&file)];
    run(&[&args[..], &["--predictions", text(&predicted)]].concat()).fine();
    let measured = topic(&file, "/joint_states");
    let [by_model, residual] = ["/predicted", "/residual"].map(|name| topic(&file, name));
    let predicted = read_recording(&predicted, &ReadSettings::default()).unwrap();
    let given = read_recording(&holdout, &ReadSettings::default()).unwrap();
    for joint in given.joint_names() {
        let [m, p, r] = [&measured, &by_model, &residual].map(|of| efforts(of, joint));
        assert_eq!(m, efforts(&given, joint));
        assert_eq!(p, efforts(&predicted, joint));
        assert!(r.iter().any(|r| r.abs() > 0.1), "{joint}");
        for k in 0..m.len() {
            assert_eq!(m[k] - p[k], r[k], "{joint} {k}");
        }
    }
    for (found, given) in residual.time_s.iter().zip(&given.time_s) {
        assert!((found - given).abs() < 1e-9);
    }
}

#[test]
fn file_that_cannot_be_written_is_refused_first() {
    let (urdf, holdout) = (project("urdf/ur5.urdf"), project("examples/ur5/holdout.csv"));
    let ran = run(&["validate", text(&urdf), text(&holdout), "--mcap", "-"]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("topics cannot be written to stdout"), "{}", ran.stderr);
}

/// What the readers of PyPI find in a file.
fn judged(file: &Path) -> Option<Value> {
    let python = python().filter(|python| {
        let found = Command::new(python).args(["-c", "import mcap_ros2"]).output();
        found.is_ok_and(|ran| ran.status.success())
    });
    let Some(python) = python else {
        skipped(
            "topics",
            "no Python with mcap and mcap-ros2-support (ARMIDENT_PEERS_PYTHON, or .ci/run)",
        );
        return None;
    };
    let ran = Command::new(python).arg(project("tests/topics.py")).arg(file).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    Some(serde_json::from_slice(&ran.stdout).unwrap())
}

#[test]
fn other_readers_find_recordings_and_findings() {
    let folder = scratch("topics_judged");
    let urdf = project("urdf/ur5.urdf");
    let [train, holdout] =
        ["train", "holdout"].map(|name| project(&format!("examples/ur5/{name}.csv")));
    let (file, json) = (folder.join("topics.mcap"), folder.join("result.json"));
    let args = ["diagnose", text(&urdf), text(&train), "--holdout", text(&holdout), "--no-replay"];
    run(&[&args[..], &["--mcap", text(&file), "--json", text(&json)]].concat()).fine();
    let Some(found) = judged(&file) else { return };
    let result = read_json(&json);
    for (name, path) in [("train", &train), ("holdout", &holdout)] {
        let given = read_recording(path, &ReadSettings::default()).unwrap();
        for (topic, schema, messages) in [
            ("joint_states", "sensor_msgs/msg/JointState", given.len()),
            ("predicted", "sensor_msgs/msg/JointState", given.len()),
            ("residual", "sensor_msgs/msg/JointState", given.len()),
            ("findings", "diagnostic_msgs/msg/DiagnosticArray", 1),
        ] {
            let topic = &found["topics"][format!("/{name}/{topic}")];
            assert_eq!(topic["schema"], schema);
            assert_eq!(topic["messages"], messages);
            assert_eq!(topic["in_order"], true);
        }
        let of = |topic: &str, joint: &str| -> Vec<f64> {
            list(&found["efforts"][format!("/{name}/{topic}")][joint]).iter().map(number).collect()
        };
        for joint in given.joint_names() {
            let [m, p, r] = ["joint_states", "predicted", "residual"].map(|t| of(t, joint));
            // numbers come through JSON, whose reader may change their last digit
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            let own = efforts(&given, joint);
            assert!(m.len() == own.len() && m.iter().zip(&own).all(|(m, own)| near(*m, *own)));
            assert!(m.iter().zip(&p).zip(&r).all(|((m, p), r)| near(m - p, *r)), "{joint}");
        }
        let statuses = list(&found["statuses"][format!("/{name}/findings")]);
        let findings = list(&result["findings"]);
        assert!(!findings.is_empty());
        assert_eq!(statuses.len(), 1 + findings.len());
        assert_eq!(statuses[0][2], "verdict");
        assert_eq!(statuses[0][3], result["sentence"]);
        for (status, finding) in statuses[1..].iter().zip(findings) {
            assert_eq!(status[1], 1, "{status}");
            let location =
                finding["link"].as_str().unwrap_or_else(|| string(&finding["joints"][0]));
            assert!(string(&status[2]).ends_with(location), "{status} {finding}");
            let confidence = format!("{:.2}", number(&finding["confidence"]));
            assert_eq!(status[5]["confidence"], confidence);
        }
    }
}
