//! Controllers and friction from commands: an arm of known stiffness, delay and friction, and columns that are no commands.

#![allow(clippy::unwrap_used, reason = "a failed test may panic")]

use armident_effects::{Effect, EffectOnJoint, PositionControl, PositionServo};
use armident_ident::{ServoError, ServoParameter, ServoRequest, identify_servos};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use armident_simulation::{ArmState, SimulatedArm, closed_loop};

const STIFFNESS: [f64; 2] = [120.0, 40.0];
const DELAY_S: f64 = 0.03;
const JOINTS: [&str; 2] = ["joint_1", "joint_2"];

fn model() -> ArmModel {
    let urdf = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/planar_2r.urdf");
    let robot = load_urdf(&urdf).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

/// Ten seconds at 50 Hz, positions in steps of 12 bits.
fn recording(model: &ArmModel, seed: f64) -> Recording {
    let mut effects = Vec::new();
    for (joint, viscous, coulomb, rotor) in
        [("joint_1", 9.0, 1.2, 0.35), ("joint_2", 3.0, 0.5, 0.1)]
    {
        effects.push(EffectOnJoint::new("viscous_friction", joint, [viscous]));
        effects.push(EffectOnJoint::new("coulomb_friction", joint, [coulomb]));
        effects.push(EffectOnJoint::new("rotor_inertia", joint, [rotor]));
    }
    for (joint, stiffness) in JOINTS.into_iter().zip(STIFFNESS) {
        let servo =
            PositionServo { stiffness, delay_s: DELAY_S, dead_band: 0.0, effort_limit: None };
        effects.push(EffectOnJoint::new(PositionControl.slug(), joint, servo.parameters()));
    }
    let arm = SimulatedArm::on_chain(&model.chain, &effects).unwrap();
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
    let step = std::f64::consts::TAU / 4096.0;
    for (joint, moved) in recording.joints.iter_mut().zip(motion.joints) {
        let on_step = |q: &f64| (q / step).round() * step;
        joint.position = moved.position.map(|q| q.iter().map(on_step).collect());
    }
    recording
}

#[test]
fn stiffness_delay_and_friction_are_recovered() {
    let model = model();
    let train: Vec<Recording> = [1.0, 2.0, 3.0].map(|seed| recording(&model, seed)).to_vec();
    let holdout = [recording(&model, 4.0)];
    let found = identify_servos(&ServoRequest {
        model: &model,
        train: &train,
        train_gains: &[1.0; 3],
        holdout: &holdout,
        holdout_gains: &[1.0],
        ablations: true,
    })
    .unwrap();
    for (j, fit) in found.joints.iter().enumerate() {
        let value = |p| fit.values.iter().find(|v| v.parameter == p).unwrap().value;
        assert!(fit.is_determined, "{}", fit.joint);
        let stiffness = 1.0 / value(ServoParameter::Compliance);
        assert!((stiffness / STIFFNESS[j] - 1.0).abs() < 0.05, "{}: {stiffness}", fit.joint);
        let delay_s = value(ServoParameter::Delay);
        // a quarter of a sample
        assert!((delay_s - DELAY_S).abs() < 5e-3, "{}: {delay_s}", fit.joint);
        let step = std::f64::consts::TAU / 4096.0;
        // rounding alone makes 0.289 of a step
        let [with, _] = fit.ablations[0].train;
        assert!(with < 0.35 * step, "{}: {with}", fit.joint);
        // predicted from the recorded start, whose velocity is known from one side only
        assert!(fit.holdout[0] < 0.8 * step, "{fit:?}");
    }
    assert_eq!(found.model.servos.len(), 2);
    let again = ArmModel::parse(&found.model.to_json().unwrap(), "model.json").unwrap();
    assert_eq!(again.servos, found.model.servos);
}

#[test]
fn columns_that_are_no_commands_are_refused() {
    let model = model();
    let refused = |change: &dyn Fn(&mut JointChannels)| {
        let mut run = recording(&model, 1.0);
        change(&mut run.joints[1]);
        let found = identify_servos(&ServoRequest {
            model: &model,
            train: &[run],
            train_gains: &[1.0],
            holdout: &[],
            holdout_gains: &[],
            ablations: false,
        });
        match found {
            Err(error @ ServoError::Command { .. }) => error.to_string(),
            other => panic!("{other:?}"),
        }
    };
    let scaled = |joint: &mut JointChannels, by: f64| {
        joint.command.iter_mut().flatten().for_each(|c| *c *= by);
    };
    assert!(refused(&|joint| scaled(joint, 180.0 / std::f64::consts::PI)).contains("degrees"));
    assert!(refused(&|joint| scaled(joint, 4096.0 / std::f64::consts::TAU)).contains("steps"));
    assert!(refused(&|joint| joint.command = joint.position.clone()).contains("equals"));
    assert!(refused(&|joint| scaled(joint, 0.0)).contains("constant"));
}
