//! `identify` and `diagnose` on recordings of commands and positions without efforts: controllers and friction of the joints.

use std::path::{Path, PathBuf};

use armident_diagnose::diagnose_servos as diagnosed;
use armident_ident::{ServoError, ServoRequest, identify_servos as identified};
use armident_model::ArmModel;
use armident_page::{Drawing, RecordingRole};
use armident_recording::Recording;
use armident_report::{DiagnoseInputs, DiagnoseReport, ServosReport};

use crate::drawing;
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
    let gains = Gains::of(train, holdout, gains)?;
    let found = identified(&gains.request(&given, train, holdout)).map_err(failure)?;
    let mut report = ServosReport::of(&found);
    report.recordings = sources(train);
    report.holdout_recordings = sources(holdout);
    report.notes.extend(unused);
    report.warnings = chain_warnings(&given);
    Ok(IdentifiedServos { report, model: found.model })
}

/// A diagnosis from commands.
#[derive(Debug)]
pub struct DiagnosedServos {
    /// The result.
    pub report: DiagnoseReport,
    /// The diagnosed model.
    pub model: ArmModel,
    gains: Gains,
}

impl DiagnosedServos {
    /// What its page draws: commands, recorded and simulated positions.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn drawing(&self, train: &[Recording], holdout: &[Recording]) -> Result<Drawing, Failure> {
        let recorded = [
            (train, self.gains.train.as_slice(), RecordingRole::Training),
            (holdout, self.gains.holdout.as_slice(), RecordingRole::Holdout),
        ];
        drawing::of_positions(&self.model, &recorded)
    }
}

/// Diagnoses an arm from commands and positions; `gains` as in [`identify_servos`].
///
/// # Errors
/// As [`identify_servos`].
pub fn diagnose_servos(
    robot: &GivenRobot,
    train: &[Recording],
    holdout: &[Recording],
    gains: &[(PathBuf, f64)],
) -> Result<DiagnosedServos, Failure> {
    let (given, _) = robot.links(Some(&joints_with_position(train)))?;
    let gains = Gains::of(train, holdout, gains)?;
    let found = diagnosed(&gains.request(&given, train, holdout)).map_err(failure)?;
    let inputs = DiagnoseInputs {
        recordings: sources(train),
        holdout_recordings: sources(holdout),
        reference_recordings: Vec::new(),
        beyond_a_model: false,
        warnings: chain_warnings(&given),
    };
    let report = DiagnoseReport::of_commands(&found, inputs);
    Ok(DiagnosedServos { report, model: found.identification.model, gains })
}

fn sources(recordings: &[Recording]) -> Vec<String> {
    recordings.iter().map(|recording| recording.source.clone()).collect()
}

/// Gain of the controllers in each recording.
#[derive(Debug)]
pub(crate) struct Gains {
    pub(crate) train: Vec<f64>,
    holdout: Vec<f64>,
}

impl Gains {
    pub(crate) fn of(
        train: &[Recording],
        holdout: &[Recording],
        gains: &[(PathBuf, f64)],
    ) -> Result<Self, Failure> {
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
        let [train, holdout] =
            [train, holdout].map(|of| of.iter().map(gain_of).collect::<Vec<f64>>());
        Ok(Self { train, holdout })
    }

    fn request<'a>(
        &'a self,
        model: &'a ArmModel,
        train: &'a [Recording],
        holdout: &'a [Recording],
    ) -> ServoRequest<'a> {
        ServoRequest {
            model,
            train,
            train_gains: &self.train,
            holdout,
            holdout_gains: &self.holdout,
            ablations: false,
        }
    }
}

pub(crate) fn failure(error: ServoError) -> Failure {
    match error {
        ServoError::Recording(error) => error.into(),
        ServoError::Simulation(error) => error.into(),
        ServoError::Command { fault, ref source_name, ref joint } => Failure::new(
            &error,
            format!("{source_name}, column `{joint}/command`"),
            Some(fault.advice()),
        ),
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
