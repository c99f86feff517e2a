//! Makes the bundled recordings in `examples/ur5`: a UR5 whose forearm is heavier than in its URDF,
//! with friction and rotor inertia on every joint, recorded with 17-bit encoders and noisy efforts.
//!
//! ```text
//! cargo run --release --example make_ur5_recordings
//! ```

#[allow(dead_code, reason = "one of its functions is used here")]
mod random_arm;

use armident_effects::EffectOnJoint;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{Recording, write_csv};
use armident_simulation::{EffortNoise, Sensors, SimulatedArm, Trajectory, inverse};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use random_arm::sum_of_sines;

/// Samples per second.
const RATE_HZ: f64 = 100.0;
/// Length of a recording [s].
const DURATION_S: f64 = 12.0;
/// Lowest frequency of the motion [Hz].
const FUNDAMENTAL_HZ: f64 = 0.1;
/// Additional mass of the forearm [kg], in the middle of the link.
const ADDED_FOREARM_KG: f64 = 0.6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = load_urdf("urdf/ur5.urdf".as_ref())?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let mut model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();

    // what the URDF does not know
    let forearm = &mut model.chain.joints[2].link;
    let middle = forearm.com_m();
    *forearm = forearm.plus(&armident_kinematics::InertialParameters::from_com(
        ADDED_FOREARM_KG,
        middle + Vector3::new(0.05, 0.0, 0.0),
        nalgebra::Matrix3::identity() * 0.002,
    ));
    let friction: [(f64, f64, f64, f64); 6] = [
        // viscous, Coulomb, offset, rotor inertia
        (3.1, 4.2, 0.10, 0.35),
        (3.4, 5.1, -0.20, 0.35),
        (1.9, 3.3, 0.15, 0.20),
        (0.55, 0.90, 0.02, 0.05),
        (0.50, 0.75, 0.00, 0.05),
        (0.45, 0.70, -0.03, 0.05),
    ];
    let mut effects = Vec::new();
    for (name, (viscous, coulomb, offset, rotor)) in names.iter().zip(friction) {
        for (effect, value) in [
            ("viscous_friction", viscous),
            ("coulomb_friction", coulomb),
            ("torque_offset", offset),
            ("rotor_inertia", rotor),
        ] {
            effects.push(EffectOnJoint::new(effect, name, [value]));
        }
    }
    let arm = SimulatedArm::new(model.rigid_arm(), &names, &effects)?;
    for (file, seed) in [("train", 1u64), ("holdout", 2)] {
        let trajectory = Trajectory::from_recording(
            &sums_of_sines(&names, seed)?,
            &names,
            &std::collections::BTreeMap::new(),
        )?;
        let sensors = Sensors {
            effort_noise: Some(EffortNoise::Relative(0.01)),
            encoder_bits: Some(17),
            seed,
        };
        let measured = sensors.apply(&arm, &inverse(&arm, &trajectory)?)?;
        write_csv(format!("examples/ur5/{file}.csv"), &short(measured))?;
    }
    Ok(())
}

/// Five harmonics with random phases around a bent arm, the same speed in each.
fn sums_of_sines(
    names: &[String],
    seed: u64,
) -> Result<Recording, armident_recording::RecordingError> {
    let mut random = Pcg64::seed_from_u64(seed);
    let samples = (DURATION_S * RATE_HZ) as usize;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / RATE_HZ).collect();
    let middle = [0.0, -1.3, 1.4, -0.8, 0.6, 0.0];
    let speed = [0.35, 0.3, 0.4, 0.55, 0.6, 0.7];
    let joints = names
        .iter()
        .enumerate()
        .map(|(j, name)| {
            let motion = [middle[j], speed[j]];
            sum_of_sines(name, &time_s, FUNDAMENTAL_HZ, motion, &mut random)
        })
        .collect();
    Recording::new("sums of sines", time_s, joints)
}

/// Position and effort only, as a robot's logger prints them.
fn short(mut recording: Recording) -> Recording {
    for joint in &mut recording.joints {
        joint.velocity = None;
        joint.acceleration = None;
        let rounded = |column: &mut Option<Vec<f64>>, scale: f64| {
            for value in column.iter_mut().flatten() {
                *value = (*value * scale).round() / scale;
            }
        };
        rounded(&mut joint.position, 1e6);
        rounded(&mut joint.effort, 1e4);
    }
    recording
}
