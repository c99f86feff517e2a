//! The diagnosis of a case by this project, in memory.

use std::time::Instant;

use armident_diagnose::{DiagnoseError, DiagnoseRequest, diagnose};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use armident_report::{DiagnoseInputs, DiagnoseReport, Fits};

use crate::contract::case::Case;

/// The part of a case that a diagnosis is given: not the truth, and only the motion of the exam.
#[derive(Debug, Clone)]
pub struct SubmissionTask {
    robot_urdf: String,
    before: Vec<Recording>,
    train: [Recording; 2],
    holdout: Recording,
    exam_motion: Recording,
}

impl SubmissionTask {
    /// Of a case.
    pub fn of(case: &Case) -> Self {
        let motion = |joint: &JointChannels| JointChannels { effort: None, ..joint.clone() };
        let joints = case.exam.joints.iter().map(motion).collect();
        Self {
            robot_urdf: case.robot_urdf.clone(),
            before: case.before.clone(),
            train: [case.train_1.clone(), case.train_2.clone()],
            holdout: case.holdout.clone(),
            exam_motion: Recording { joints, ..case.exam.clone() },
        }
    }
}

/// The result of a diagnosis.
#[derive(Debug, Clone)]
pub struct Submission {
    /// What `armident diagnose --json --no-replay` writes, without the errors on the training recordings.
    pub out_json: String,
    /// What `--save-model` and `predict` of the exam write; nothing where columns fail the input checks.
    pub model: Option<SubmittedModel>,
    /// How long the diagnosis and the prediction took \[s\].
    pub seconds: f64,
}

/// The diagnosed model and its prediction of the exam.
#[derive(Debug, Clone)]
pub struct SubmittedModel {
    /// What `--save-model` writes.
    pub model_json: String,
    /// What `predict` writes for the exam.
    pub predicted: Recording,
}

/// Does as `armident diagnose` and `armident predict` do: checks the input, diagnoses the training
/// recordings, judges the result on the hold-out, and predicts the exam.
///
/// # Errors
/// Why there is no answer, in words.
pub fn solve(task: &SubmissionTask) -> Result<Submission, String> {
    let started = Instant::now();
    let reason = |error: &dyn std::error::Error| error.to_string();
    let description = parse_urdf(&task.robot_urdf, "robot.urdf").map_err(|e| reason(&e))?;
    let recorded = task.train[0].joint_names().into_iter().map(ToOwned::to_owned).collect();
    let selection = ChainSelection { recorded_joints: Some(recorded), ..ChainSelection::default() };
    let chain = SerialChain::from_description(&description, &selection).map_err(|e| reason(&e))?;
    let given = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let holdout = std::slice::from_ref(&task.holdout);
    let request = DiagnoseRequest {
        reference: &task.before,
        holdout,
        ..DiagnoseRequest::new(&given, &task.train)
    };
    let sources = |recordings: &[Recording]| recordings.iter().map(|r| r.source.clone()).collect();
    let inputs = DiagnoseInputs {
        recordings: sources(&task.train),
        holdout_recordings: sources(holdout),
        reference_recordings: sources(&task.before),
        warnings: given.chain.warnings.iter().map(ToString::to_string).collect(),
        ..DiagnoseInputs::default()
    };
    let submission = |report: &DiagnoseReport, model| -> Result<Submission, String> {
        let out_json = serde_json::to_string_pretty(report).map_err(|e| reason(&e))? + "\n";
        Ok(Submission { out_json, model, seconds: started.elapsed().as_secs_f64() })
    };
    let diagnosis = match diagnose(&request) {
        Err(DiagnoseError::WrongColumns(wrong)) => {
            let checks = &wrong.input_checks;
            return submission(
                &DiagnoseReport::of_failed_checks(&given.chain, checks, inputs),
                None,
            );
        }
        found => found.map_err(|e| reason(&e))?,
    };
    let prepared = diagnosis.prepared(&diagnosis.holdout).map_err(|e| reason(&e))?;
    let on_holdout = diagnosis.errors(&prepared).map_err(|e| reason(&e))?;
    let model_json = diagnosis.model.to_json().map_err(|e| reason(&e))?;
    let efforts = diagnosis.model.predict(&task.exam_motion, None).map_err(|e| reason(&e))?.efforts;
    let channels = diagnosis
        .joints
        .iter()
        .zip(efforts)
        .map(|(name, effort)| JointChannels { effort: Some(effort), ..JointChannels::new(name) });
    let stamps = task.exam_motion.time_s.clone();
    let predicted =
        Recording::new("prediction", stamps, channels.collect()).map_err(|e| reason(&e))?;
    let fits = Fits::of(None, Some(on_holdout));
    let report = DiagnoseReport::new(&given.chain, &diagnosis, inputs, fits);
    submission(&report, Some(SubmittedModel { model_json, predicted }))
}
