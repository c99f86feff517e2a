//! Findings from commands: a simulated arm of known controllers and friction, and one that only lags.

#![allow(clippy::unwrap_used, reason = "a failed test may panic")]

use armident_diagnose::{Finding, diagnose_servos};
use armident_effects::{Effect, EffectOnJoint, PositionControl, PositionServo};
use armident_ident::ServoRequest;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use armident_simulation::{ArmState, SimulatedArm, closed_loop};

const JOINTS: [&str; 2] = ["joint_1", "joint_2"];
const STEP: f64 = std::f64::consts::TAU / 4096.0;

fn model() -> ArmModel {
    let urdf = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/planar_2r.urdf");
    let chain =
        SerialChain::from_description(&load_urdf(&urdf).unwrap(), &ChainSelection::default())
            .unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

fn on(slug: &str, joint: usize, parameters: impl Into<Vec<f64>>) -> EffectOnJoint {
    EffectOnJoint::new(slug, JOINTS[joint], parameters.into())
}

fn controller(joint: usize, stiffness: f64, delay_s: f64) -> EffectOnJoint {
    let servo = PositionServo { stiffness, delay_s, dead_band: 0.0, effort_limit: None };
    on(PositionControl.slug(), joint, servo.parameters())
}

/// Ten seconds at 50 Hz under these effects, positions in steps of 12 bits.
fn recording(model: &ArmModel, effects: &[EffectOnJoint], seed: f64) -> Recording {
    let arm = SimulatedArm::on_chain(&model.chain, effects).unwrap();
    let time_s: Vec<f64> = (0..500).map(|k| 0.02 * f64::from(k)).collect();
    let joints = JOINTS.iter().enumerate().map(|(k, name)| {
        let phase = seed + 2.0 * k as f64;
        let command = |t: &f64| {
            0.6 * (0.8 * seed.sqrt() * t + phase).sin() + 0.3 * (1.9 * t + 3.0 * phase).sin()
        };
        let command = time_s.iter().map(command).collect();
        JointChannels { command: Some(command), ..JointChannels::new(*name) }
    });
    let mut recording = Recording::new("run", time_s.clone(), joints.collect()).unwrap();
    let start = recording.joints.iter().map(|joint| joint.command.as_ref().unwrap()[0]).collect();
    let motion = closed_loop(&arm, 1.0, &recording, ArmState::at_rest(start), 1e-3).unwrap();
    for (joint, moved) in recording.joints.iter_mut().zip(motion.joints) {
        let on_step = |q: &f64| (q / STEP).round() * STEP;
        joint.position = moved.position.map(|q| q.iter().map(on_step).collect());
    }
    recording
}

fn findings(effects: &[EffectOnJoint]) -> Vec<Finding> {
    let model = model();
    let train: Vec<Recording> = [1.0, 2.0, 3.0].map(|s| recording(&model, effects, s)).to_vec();
    let holdout = [recording(&model, effects, 4.0)];
    diagnose_servos(&ServoRequest {
        model: &model,
        train: &train,
        train_gains: &[1.0; 3],
        holdout: &holdout,
        holdout_gains: &[1.0],
        ablations: false,
    })
    .unwrap()
    .findings
}

#[test]
fn controller_and_friction_are_named() {
    let effects = [
        controller(0, 120.0, 0.06),
        controller(1, 40.0, 0.06),
        on("viscous_friction", 0, [9.0]),
        on("viscous_friction", 1, [3.0]),
        on("coulomb_friction", 0, [2.4]),
        on("rotor_inertia", 0, [0.3]),
        on("rotor_inertia", 1, [0.1]),
    ];
    let found = findings(&effects);
    let of = |effect: &str, joint: &str| {
        found.iter().find(|f| f.effect == effect && f.joints == [joint])
    };
    let dry = of("coulomb_friction", "joint_1").unwrap();
    let level = &dry.parameters["level"];
    assert!((level.value / 2.4 - 1.0).abs() < 0.1, "{level:?}");
    assert!(dry.confidence > 0.9 && dry.confirmed == Some(true), "{dry:?}");
    // the second joint has none, and neither has any other friction or an offset
    assert!(of("coulomb_friction", "joint_2").is_none(), "{found:?}");
    let others = ["torque_offset", "stribeck_friction", "load_dependent_friction"];
    assert!(found.iter().all(|f| !others.contains(&f.effect.as_str())), "{found:?}");
    for joint in JOINTS {
        let controller = of("position_control", joint).unwrap();
        assert!(controller.confidence > 0.9, "{controller:?}");
        // the weight is carried by no controller
        assert!(controller.parameters["sag"].value > 0.02, "{controller:?}");
        let delay = &controller.parameters["delay"];
        assert!((delay.value - 0.06).abs() < 0.01, "{delay:?}");
        assert!(controller.parameters["lag"].value > delay.value, "{controller:?}");
    }
}

/// A controller that is late, without dry friction: the lag is named, and no friction but what damps.
#[test]
fn lag_alone_is_named() {
    let effects = [
        controller(0, 240.0, 0.06),
        controller(1, 80.0, 0.06),
        on("viscous_friction", 0, [4.8]),
        on("viscous_friction", 1, [1.6]),
        on("rotor_inertia", 0, [0.3]),
        on("rotor_inertia", 1, [0.1]),
    ];
    let found = findings(&effects);
    let names = ["position_control", "viscous_friction", "rotor_inertia"];
    for finding in &found {
        assert!(names.contains(&finding.effect.as_str()), "{finding:?}");
    }
    for joint in JOINTS {
        let is_its = |f: &&Finding| f.effect == "position_control" && f.joints == [joint];
        let Some(controller) = found.iter().find(is_its) else { panic!("{joint}: {found:?}") };
        let lag = &controller.parameters["lag"];
        // 60 ms of delay and 20 ms of damping
        assert!((lag.value - 0.08).abs() < 0.01, "{lag:?}");
    }
}
