//! Makes the bundled recordings in `docs/book/files/servos`: the arm of `urdf/planar_2r.urdf` with a position controller in each
//! joint, recorded as hobby servos report: commands and positions at 50 Hz, positions in steps of an encoder of 12 bits.
//!
//! ```text
//! cargo run --release --example make_command_recordings
//! ```

use armident_effects::{EffectOnJoint, PositionServo};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_recording::{JointChannels, Quantity, Recording, write_csv};
use armident_simulation::{ArmState, DEFAULT_STEP_S, JointServo, SimulatedArm, closed_loop};

/// Samples per second.
const RATE_HZ: f64 = 50.0;
/// Length of a recording [s].
const DURATION_S: f64 = 12.0;
/// Steps of the encoders in a turn.
const STEPS: f64 = 4096.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = load_urdf("urdf/planar_2r.urdf".as_ref())?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let chain = DrivingAxisChain::from_chain(&chain);
    let mut effects = Vec::new();
    for (joint, viscous, coulomb, rotor) in
        [("joint_1", 9.0, 1.2, 0.35), ("joint_2", 3.0, 0.5, 0.1)]
    {
        for (effect, value) in
            [("viscous_friction", viscous), ("coulomb_friction", coulomb), ("rotor_inertia", rotor)]
        {
            effects.push(EffectOnJoint::new(effect, joint, [value]));
        }
    }
    let arm = SimulatedArm::on_chain(&chain, &effects)?;
    let servos = [120.0, 40.0].map(|stiffness| JointServo {
        servo: PositionServo { stiffness, delay_s: 0.03, dead_band: 0.0, effort_limit: None },
        gain: 1.0,
    });
    std::fs::create_dir_all("docs/book/files/servos")?;
    for (file, seed) in
        [("slow", 1.0), ("fast", 2.0), ("steps", 3.0), ("far", 4.0), ("holdout", 5.0)]
    {
        let time_s: Vec<f64> =
            (0..(DURATION_S * RATE_HZ) as usize).map(|k| k as f64 / RATE_HZ).collect();
        let command = |joint: f64| -> Vec<f64> {
            let of = |t: &f64| {
                let phase = seed + 2.0 * joint;
                let swing = 0.5 * (0.5 * seed.sqrt() * t + phase).sin()
                    + 0.2 * (1.7 * t / seed.sqrt() + 3.0 * phase).sin();
                // rests between moves in one of them
                if file == "steps" { (2.5 * swing).round() / 2.5 } else { swing }
            };
            time_s.iter().map(|t| 0.4 * (seed - 3.0) / 2.0 + of(t)).map(rounded).collect()
        };
        let joints = ["joint_1", "joint_2"].iter().enumerate().map(|(k, name)| JointChannels {
            command: Some(command(k as f64)),
            ..JointChannels::new(*name)
        });
        let mut recording = Recording::new(file, time_s.clone(), joints.collect())?;
        let start =
            recording.joints.iter().map(|joint| joint.command.as_ref().map_or(0.0, |c| c[0]));
        let start = ArmState::at_rest(start.collect());
        let motion = closed_loop(&arm, &servos, &recording, start, DEFAULT_STEP_S)?;
        for (joint, moved) in recording.joints.iter_mut().zip(&motion.joints) {
            let position = moved.channel(Quantity::Position).unwrap_or_default();
            joint.position = Some(position.iter().map(|q| on_step(*q)).collect());
        }
        write_csv(format!("docs/book/files/servos/{file}.csv"), &recording)?;
    }
    Ok(())
}

/// On a step of the encoder.
fn on_step(position: f64) -> f64 {
    let step = std::f64::consts::TAU / STEPS;
    rounded((position / step).round() * step)
}

/// To five decimals, as a log has them.
fn rounded(value: f64) -> f64 {
    (1e5 * value).round() / 1e5
}
