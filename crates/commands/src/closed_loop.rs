//! `predict --closed-loop`: the positions that commands cause.

use armident_model::ArmModel;
use armident_recording::{JointChannels, Quantity, Recording};
use armident_simulation::{ArmState, DEFAULT_STEP_S, SimulatedArm, closed_loop};

use crate::failure::Failure;
use crate::predict::{PredictReport, Predicted};
use crate::robot::{GivenRobot, chain_warnings};

/// Predicts the positions of all joints at every stamp of a recording from its commands. The arm starts at rest at the first
/// position of the recording, where there is one, else at the first command. `gain` is that of the controllers over the gain
/// of the model.
///
/// # Errors
/// A model without controllers, a recording without commands of the joints, a simulation that diverges.
pub fn predict_closed_loop(
    robot: &GivenRobot,
    commands: &Recording,
    gain: f64,
) -> Result<Predicted, Failure> {
    let model = robot.arm(None)?;
    if model.servo_of_each_joint().is_none() {
        return Err(Failure::new(
            "no position controller for every joint of the model",
            &robot.source,
            Some(
                "identify recordings with <joint>/command and <joint>/position, and pass the model of --save-model",
            ),
        ));
    }
    let joints = model.chain.joint_names();
    let first = |quantity, joint: &str| {
        commands.joint(joint).and_then(|channels| channels.channel(quantity)).map(|x| x[0])
    };
    let missing: Vec<&str> =
        joints.iter().copied().filter(|joint| first(Quantity::Command, joint).is_none()).collect();
    if !missing.is_empty() {
        return Err(Failure::new(
            format!("no command column for {}", missing.join(", ")),
            &commands.source,
            Some("provide <joint>/command in rad or m for every joint of the model"),
        ));
    }
    let mut notes = Vec::new();
    let without: Vec<&str> =
        joints.iter().copied().filter(|joint| first(Quantity::Position, joint).is_none()).collect();
    if !without.is_empty() {
        notes.push(format!("{} start at their first command: no position", without.join(", ")));
    }
    let motion = motion_under(&model, commands, gain)?;
    let positions = motion
        .joints
        .into_iter()
        .map(|joint| JointChannels { position: joint.position, ..JointChannels::new(joint.name) });
    let positions = Recording::new("prediction", commands.time_s.clone(), positions.collect())?;
    notes.extend(motion.notes);
    let report = PredictReport {
        schema: "armident.predict/1",
        robot: model.chain.robot.clone(),
        motion: commands.source.clone(),
        samples: positions.len(),
        joints: joints.into_iter().map(ToOwned::to_owned).collect(),
        cutoff_hz: None,
        effects: model.effects.clone(),
        notes,
        warnings: chain_warnings(&model),
    };
    Ok(Predicted { report, channels: positions })
}

/// The motion of an arm behind its controllers, from rest at the first position, or else the first command.
fn motion_under(model: &ArmModel, commands: &Recording, gain: f64) -> Result<Recording, Failure> {
    let start = model.chain.joint_names().into_iter().map(|joint| {
        let first = |quantity| commands.joint(joint)?.channel(quantity)?.first().copied();
        first(Quantity::Position).or_else(|| first(Quantity::Command)).unwrap_or(0.0)
    });
    let start = ArmState::at_rest(start.collect());
    let (simulated, _) = model.simulated();
    let arm = SimulatedArm::on_chain_in(&simulated.library, &simulated.chain, &simulated.effects)?;
    Ok(closed_loop(&arm, gain, commands, start, DEFAULT_STEP_S)?)
}

/// The positions of that motion, by joint, at the stamps of the commands \[rad or m\].
pub(crate) fn positions_under(
    model: &ArmModel,
    commands: &Recording,
    gain: f64,
) -> Result<Vec<Vec<f64>>, Failure> {
    let motion = motion_under(model, commands, gain)?;
    Ok(motion.joints.into_iter().map(|joint| joint.position.unwrap_or_default()).collect())
}
