//! MuJoCo moves an arm under commands with properties that its URDF does not contain: they are found, exported, and the exported
//! arm moves as the hidden one.
//!
//! Needs a Python with `mujoco`, as `peers.rs`.

use std::process::Command;

use serde_json::Value;

use crate::peers::python;
use crate::shared::{project, skipped};
use crate::tool::{run, scratch, text};

/// What the issue of arms without efforts demands of a stiffness and of a delay \[s\].
const STIFFNESS: f64 = 0.05;
const DELAY_S: f64 = 3e-3;
/// Share of the position error that the command has.
const FOLLOWS: f64 = 0.05;

#[test]
fn arm_of_mujoco_is_diagnosed_from_commands_and_moves_again() {
    let Some(python) = python() else {
        skipped("commands", "no Python with mujoco (ARMIDENT_PEERS_PYTHON, or .ci/run)");
        return;
    };
    let folder = scratch("commands_in_mujoco");
    let urdf = project("urdf/ur5.urdf");
    let script = |stage: &str, file: &std::path::Path| -> Value {
        let mut command = Command::new(&python);
        command.arg(project("tests/commands_in_mujoco.py")).arg(stage).arg(&folder).arg(file);
        let output = command.output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let hidden = script("record", &urdf);
    let runs: Vec<_> = (0..4).map(|k| folder.join(format!("run_{k}.csv"))).collect();
    let [json, model, mjcf] = ["out.json", "model.json", "arm.xml"].map(|name| folder.join(name));
    let given = [text(&runs[0]), text(&runs[1]), text(&runs[2]), "--holdout", text(&runs[3])];
    let with = |first: &[&str], last: &[&str]| {
        let all: Vec<&str> = first.iter().chain(&given).chain(last).copied().collect();
        run(&all).fine()
    };
    with(&["diagnose", text(&urdf)], &["--json", text(&json)]);
    let found: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let findings = found["findings"].as_array().unwrap();
    let on = |effect: &str, joint: &str| {
        findings.iter().find(|f| f["effect"] == effect && f["joints"][0] == joint)
    };
    let joints: Vec<&str> =
        hidden["joints"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    for (j, joint) in joints.iter().enumerate() {
        let of = |name: &str| hidden[name][j].as_f64().unwrap();
        let dry = on("coulomb_friction", joint).or_else(|| on("stribeck_friction", joint));
        assert_eq!(dry.is_some(), of("frictionloss") > 0.0, "{joint}: {dry:?}");
        assert!(on("viscous_friction", joint).is_some(), "{joint}");
        let controller = on("position_control", joint).expect(joint);
        assert_eq!(controller["confirmed"], true, "{joint}");
        let value = |name: &str| controller["parameters"][name]["value"].as_f64();
        let late_s = value("delay").unwrap() - hidden["delay_s"].as_f64().unwrap();
        // where no weight is felt only the inertia separates the delay from damping
        if let Some(stiffness) = value("stiffness") {
            let relative = stiffness / of("stiffness") - 1.0;
            assert!(relative.abs() < STIFFNESS, "{joint}: {relative}");
            assert!(late_s.abs() < DELAY_S, "{joint}: {late_s}");
        }
    }
    with(&["identify", text(&urdf)], &["--save-model", text(&model)]);
    run(&["export", text(&model), "-o", text(&mjcf)]).fine();
    let again = script("replay", &mjcf);
    for (j, joint) in joints.iter().enumerate() {
        let [command, moved] = ["command", "model"].map(|of| again[of][j].as_f64().unwrap());
        assert!(moved < FOLLOWS * command, "{joint}: {moved} of {command}");
    }
}
