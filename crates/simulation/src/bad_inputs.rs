//! What is said about bad input, in one text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use armident_dynamics::RigidArm;
use armident_effects::EffectOnJoint;
use armident_kinematics::InertialParameters;
use armident_recording::{JointChannels, Recording};

use crate::test_arms::{effect, harmonic, planar};
use crate::{
    ArmState, EffortNoise, ForwardSettings, ForwardStepper, Sensors, SimulatedArm, SimulationError,
    StepEffort, TrackingGains, Trajectory, forward, inverse, track,
};

const JOINTS: [&str; 2] = ["joint_1", "joint_2"];

fn rigid() -> RigidArm {
    planar(&[]).rigid().clone()
}

/// The faults in the order in which a user meets them.
fn faults() -> Vec<(&'static str, SimulationError)> {
    let mut faults = Vec::new();
    let with = |given| SimulatedArm::new(rigid(), &JOINTS, &[given]).unwrap_err();
    let named = |names: &[&str]| SimulatedArm::new(rigid(), names, &[]).unwrap_err();
    faults.push(("one name", named(&["joint_1"])));
    faults.push(("one name twice", named(&["joint_1", "joint_1"])));
    faults.push(("misspelt joint", with(effect("viscous_friction", "jiont_1", 1.0))));
    faults.push(("other joint", with(effect("viscous_friction", "gripper", 1.0))));
    faults.push(("unknown effect", with(effect("magic", "joint_1", 1.0))));
    let mut two = effect("viscous_friction", "joint_1", 1.0);
    two.parameters.push(2.0);
    faults.push(("two parameters", with(two)));
    faults.push(("negative friction", with(effect("coulomb_friction", "joint_2", -1.5))));
    faults.push(("offset not a number", with(effect("torque_offset", "joint_2", f64::NAN))));

    let refused =
        |slug: &str, parameters: &[f64]| with(EffectOnJoint::new(slug, "joint_1", parameters));
    faults.push(("Stribeck velocity zero", refused("stribeck_friction", &[2.0, 1.0, 0.0])));
    faults.push(("motor without inertia", refused("joint_elasticity", &[500.0, 1.0, 0.0])));
    faults.push(("coupling of one joint", refused("joint_coupling", &[1.0, 1.0, 1.0])));
    faults.push(("gain zero", refused("torque_scale", &[0.0])));
    faults.push(("load without frames", refused("payload", &[1.0, 0.0, 0.0, 0.1])));
    let mut timed = effect("viscous_friction", "joint_1", 1.0);
    timed.window_s = Some([1.0, 2.0]);
    faults.push(("friction in a window", with(timed)));
    let mut paired = effect("viscous_friction", "joint_1", 1.0);
    paired.other_joint = Some("joint_2".to_owned());
    faults.push(("friction of two joints", with(paired)));

    let arm = planar(&[]);
    let trajectory = harmonic(arm.joints(), 20, 0.01);
    let plan = trajectory.recording().unwrap();
    let mut half = plan.clone();
    half.joints.pop();
    let held = |recording: &Recording, held: &[(&str, f64)]| {
        let held: BTreeMap<String, f64> =
            held.iter().map(|(joint, at)| ((*joint).to_owned(), *at)).collect();
        Trajectory::from_recording(recording, arm.joints(), &held).unwrap_err()
    };
    faults.push(("joint not recorded", held(&half, &[])));
    faults.push(("held, recorded", held(&plan, &[("joint_1", 0.5)])));
    faults.push(("held, misspelt", held(&half, &[("joint2", 0.5)])));
    faults.push(("held nowhere", held(&half, &[("joint_2", f64::INFINITY)])));
    faults.push(("rate zero", trajectory.resampled(0.0).unwrap_err()));
    faults.push(("rate too high", trajectory.resampled(1e12).unwrap_err()));

    let mut other = trajectory.clone();
    other.joints.swap(0, 1);
    faults.push(("inverse, joints swapped", inverse(&arm, &other).unwrap_err()));
    let mut short = trajectory.clone();
    short.velocity[1].pop();
    faults.push(("inverse, short column", inverse(&arm, &short).unwrap_err()));
    let mut lacking = trajectory.clone();
    lacking.acceleration.pop();
    faults.push(("inverse, column lacks", inverse(&arm, &lacking).unwrap_err()));
    let mut absurd = trajectory.clone();
    absurd.velocity[0].fill(1e200);
    faults.push(("inverse, overflow", inverse(&arm, &absurd).unwrap_err()));

    let efforts = inverse(&arm, &trajectory).unwrap();
    let rest = || ArmState::at_rest(vec![0.0; 2]);
    let run = |arm: &SimulatedArm, efforts: &Recording, start, settings: &ForwardSettings| {
        forward(arm, efforts, start, settings).unwrap_err()
    };
    let default = ForwardSettings::default();
    let no_step = ForwardSettings { step_s: 0.0, ..default };
    let slow = ForwardSettings { rate_hz: Some(5.0), ..default };
    faults.push(("forward, no efforts", run(&arm, &plan, rest(), &default)));
    faults.push(("forward, start", run(&arm, &efforts, ArmState::at_rest(vec![0.0]), &default)));
    faults.push(("forward, step zero", run(&arm, &efforts, rest(), &no_step)));
    faults.push(("forward, rate too low", run(&arm, &efforts, rest(), &slow)));
    let massless = vec![InertialParameters::zero(); 2];
    let massless = SimulatedArm::new(rigid().with_links(massless), &JOINTS, &[]).unwrap();
    faults.push(("forward, no mass", run(&massless, &efforts, rest(), &default)));
    let stiff = planar(&[effect("viscous_friction", "joint_2", 1e5)]);
    let mut kicked = rest();
    kicked.velocity[1] = 1.0;
    faults.push(("forward, runs away", run(&stiff, &efforts, kicked, &default)));

    let mut stepper = ForwardStepper::new(&arm, rest(), 0.0).unwrap();
    let effort = StepEffort::constant(&[1.0, f64::NAN]);
    faults.push(("stepper, effort", stepper.step(1e-3, &effort).unwrap_err()));
    let effort = StepEffort::constant(&[1.0, 0.0]);
    faults.push(("stepper, step", stepper.step(-1e-3, &effort).unwrap_err()));
    let gains = TrackingGains { proportional: vec![1.0], derivative: vec![1.0; 2] };
    faults.push(("track, gains", track(&arm, arm.rigid(), &trajectory, &gains).unwrap_err()));

    let sense = |noise: Option<EffortNoise>, encoder_bits, recording: &Recording| {
        let sensors = Sensors { effort_noise: noise, encoder_bits, seed: 0 };
        sensors.apply(&arm, recording).unwrap_err()
    };
    let absolute = |joint: &str, sigma| {
        Some(EffortNoise::Absolute(BTreeMap::from([(joint.to_owned(), sigma)])))
    };
    faults.push(("no encoder", sense(None, Some(0), &efforts)));
    faults.push(("negative noise", sense(Some(EffortNoise::Relative(-0.1)), None, &efforts)));
    faults.push(("noise, joint", sense(absolute("joint_9", 1.0), None, &efforts)));
    faults.push(("noise, no effort", sense(Some(EffortNoise::Relative(0.1)), None, &plan)));
    let gripper = JointChannels { effort: Some(vec![0.0; 20]), ..JointChannels::new("gripper") };
    let gripper = Recording::new("gripper.csv", efforts.time_s.clone(), vec![gripper]).unwrap();
    faults.push(("sensors, other joint", sense(None, Some(12), &gripper)));
    faults
}

#[test]
fn bad_inputs() {
    let mut text = String::new();
    for (case, error) in faults() {
        let _ = writeln!(text, "{case}\n  error: {error}\n  in: {}", error.place());
        if let Some(hint) = error.hint() {
            let _ = writeln!(text, "  hint: {hint}");
        }
    }
    insta::assert_snapshot!(text);
}
