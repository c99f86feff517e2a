//! Recordings of commands and positions without efforts: controllers and friction of the joints.

use std::path::{Path, PathBuf};

use armident_ident::{CommandFault, ServoError, ServoRequest, identify_servos as identified};
use armident_model::ArmModel;
use armident_recording::Recording;
use armident_report::ServosReport;

use crate::failure::Failure;
use crate::recordings::joints_with_position;
use crate::robot::{GivenRobot, chain_warnings};

/// An identification from commands.
#[derive(Debug)]
pub struct IdentifiedServos {
    /// The result.
    pub report: ServosReport,
    /// The identified model.
    pub model: ArmModel,
}

/// Whether recordings are for [`identify_servos`]: commands of all joints of the arm, efforts of none.
///
/// # Errors
/// A chain that cannot be chosen.
pub fn has_commands_only(robot: &GivenRobot, recordings: &[Recording]) -> Result<bool, Failure> {
    let Ok(model) = robot.arm(Some(&joints_with_position(recordings))) else { return Ok(false) };
    let joints: Vec<String> =
        model.chain.joint_names().into_iter().map(ToOwned::to_owned).collect();
    Ok(ServoRequest::suits(recordings, &joints))
}

/// Identifies the position controllers and the friction of an arm. `gains`: files whose controllers have another gain than
/// 1, with the gain.
///
/// # Errors
/// Recordings without commands, or with columns that are no commands; gains of no recording.
pub fn identify_servos(
    robot: &GivenRobot,
    train: &[Recording],
    holdout: &[Recording],
    gains: &[(PathBuf, f64)],
) -> Result<IdentifiedServos, Failure> {
    let (given, unused) = robot.links(Some(&joints_with_position(train)))?;
    let is_of = |file: &Path, recording: &Recording| {
        let source = Path::new(&recording.source);
        source == file || file.file_name().is_some_and(|name| source.file_name() == Some(name))
    };
    let all = || train.iter().chain(holdout);
    if let Some((file, _)) = gains.iter().find(|(file, _)| !all().any(|r| is_of(file, r))) {
        return Err(Failure::new(
            "a gain is given for a file that is not among the recordings",
            file.display(),
            Some("pass the recording as well, or correct the name in --servo-gain"),
        ));
    }
    let gain_of = |recording: &Recording| {
        gains.iter().find(|(file, _)| is_of(file, recording)).map_or(1.0, |(_, gain)| *gain)
    };
    let [train_gains, holdout_gains] =
        [train, holdout].map(|of| of.iter().map(gain_of).collect::<Vec<f64>>());
    let found = identified(&ServoRequest {
        model: &given,
        train,
        train_gains: &train_gains,
        holdout,
        holdout_gains: &holdout_gains,
    })
    .map_err(failure)?;
    let mut report = ServosReport::of(&found);
    report.recordings = train.iter().map(|r| r.source.clone()).collect();
    report.holdout_recordings = holdout.iter().map(|r| r.source.clone()).collect();
    report.notes.extend(unused);
    report.warnings = chain_warnings(&given);
    Ok(IdentifiedServos { report, model: found.model })
}

fn failure(error: ServoError) -> Failure {
    match error {
        ServoError::Recording(error) => error.into(),
        ServoError::Command { fault, ref source_name, ref joint } => {
            let hint = match fault {
                CommandFault::OtherUnit => {
                    "state the unit of the command in a mapping (unit = \"deg\"), and pass it with --mapping"
                }
                CommandFault::Ticks => {
                    "state counts_per_turn of the command in a mapping (unit = \"counts\"), and pass it with --mapping"
                }
                CommandFault::Position => {
                    "record what the controller is given, or map that column as quantity = \"command\""
                }
                CommandFault::Constant => {
                    "add a recording in which the joint moves, or lock the joint with --lock JOINT=VALUE"
                }
                _ => "check the column",
            };
            Failure::new(&error, format!("{source_name}, column `{joint}/command`"), Some(hint))
        }
        ServoError::MissingChannel { ref source_name, ref joint, quantity } => Failure::new(
            &error,
            source_name,
            Some(format!("provide {joint}/{quantity}, or lock the joint with --lock JOINT=VALUE")),
        ),
        ServoError::Gain { ref source_name, .. } => {
            Failure::new(&error, source_name, Some("correct the number in --servo-gain"))
        }
        other => Failure::new(other, "", None::<String>),
    }
}
