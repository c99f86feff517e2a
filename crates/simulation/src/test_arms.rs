//! Arms and motions of the tests.

use std::path::Path;

use armident_effects::EffectOnJoint;
use armident_kinematics::{
    ChainSelection, DrivingAxisChain, RobotDescription, SerialChain, load_urdf, parse_urdf,
};

use crate::simulated_arm::SimulatedArm;
use crate::trajectory::Trajectory;

fn simulated(robot: &RobotDescription, effects: &[EffectOnJoint]) -> SimulatedArm {
    let chain = SerialChain::from_description(robot, &ChainSelection::default()).unwrap();
    let chain = DrivingAxisChain::from_chain(&chain);
    SimulatedArm::on_chain(&chain, effects).unwrap()
}

fn from_file(name: &str, effects: &[EffectOnJoint]) -> SimulatedArm {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf");
    simulated(&load_urdf(&folder.join(name)).unwrap(), effects)
}

/// Two rotational joints in a vertical plane.
pub(crate) fn planar(effects: &[EffectOnJoint]) -> SimulatedArm {
    from_file("planar_2r.urdf", effects)
}

/// The Stanford arm, RRPRRR.
pub(crate) fn stanford(effects: &[EffectOnJoint]) -> SimulatedArm {
    from_file("stanford.urdf", effects)
}

/// A mass of 2 kg on a level slider called `rail`.
pub(crate) fn slider(effects: &[EffectOnJoint]) -> SimulatedArm {
    let urdf = r#"<robot name="slider"><link name="base"/>
      <link name="cart"><inertial><mass value="2"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
      <joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/>
        <axis xyz="1 0 0"/><limit effort="100" velocity="10"/></joint></robot>"#;
    simulated(&parse_urdf(urdf, "slider.urdf").unwrap(), effects)
}

/// An effect with one parameter.
pub(crate) fn effect(slug: &str, joint: &str, value: f64) -> EffectOnJoint {
    EffectOnJoint::new(slug, joint, [value])
}

/// Position, velocity and acceleration of joint `j` at a time \[s\]: one harmonic per joint.
pub(crate) fn harmonic_at(j: usize, t: f64) -> [f64; 3] {
    let (amplitude, frequency) = (0.3 + 0.02 * j as f64, 1.5 + 0.4 * j as f64);
    let (sin, cos) = (frequency * t + 0.7 * j as f64 + 0.2).sin_cos();
    [amplitude * sin, amplitude * frequency * cos, -amplitude * frequency * frequency * sin]
}

/// The harmonics as a trajectory.
pub(crate) fn harmonic(joints: &[String], samples: usize, step_s: f64) -> Trajectory {
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * step_s).collect();
    let columns = |derivative: usize| -> Vec<Vec<f64>> {
        (0..joints.len())
            .map(|j| time_s.iter().map(|&t| harmonic_at(j, t)[derivative]).collect())
            .collect()
    };
    Trajectory {
        joints: joints.to_vec(),
        position: columns(0),
        velocity: columns(1),
        acceleration: columns(2),
        source: "harmonics".to_owned(),
        notes: Vec::new(),
        time_s,
    }
}
