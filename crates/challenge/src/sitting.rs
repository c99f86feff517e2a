//! A diagnosis of a case by this project, in memory.

use std::time::Instant;

use armident_diagnose::{DiagnosedModel, diagnose};
use armident_ident::ArmModel;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_recording::{JointChannels, Recording};
use armident_report::DiagnoseReport;

use crate::case::Case;

/// What a diagnosis is given of a case: not the answer, and of the exam its motion alone.
#[derive(Debug, Clone)]
pub struct Paper {
    robot_urdf: String,
    train: [Recording; 2],
    holdout: Recording,
    exam_motion: Recording,
}

impl Paper {
    /// Of a case.
    pub fn of(case: &Case) -> Self {
        let motion = |joint: &JointChannels| JointChannels { effort: None, ..joint.clone() };
        let joints = case.exam.joints.iter().map(motion).collect();
        Self {
            robot_urdf: case.robot_urdf.clone(),
            train: [case.train_1.clone(), case.train_2.clone()],
            holdout: case.holdout.clone(),
            exam_motion: Recording { joints, ..case.exam.clone() },
        }
    }
}

/// What a diagnosis hands in.
#[derive(Debug, Clone)]
pub struct Sitting {
    /// What `armident diagnose --json` writes, without the errors on the training recordings.
    pub out_json: String,
    /// What `--save-model` writes.
    pub model_json: String,
    /// What `predict` writes for the exam.
    pub predicted: Recording,
    /// How long the diagnosis and the prediction took \[s\].
    pub seconds: f64,
}

/// Diagnoses the training recordings, judges the result on the hold-out, and predicts the exam.
///
/// # Errors
/// Why there is no answer, in words.
pub fn sit(paper: &Paper) -> Result<Sitting, String> {
    let started = Instant::now();
    let told = |error: &dyn std::error::Error| error.to_string();
    let description = parse_urdf(&paper.robot_urdf, "robot.urdf").map_err(|e| told(&e))?;
    let recorded = paper.train[0].joint_names().into_iter().map(ToOwned::to_owned).collect();
    let selection = ChainSelection { recorded_joints: Some(recorded), ..ChainSelection::default() };
    let chain = SerialChain::from_description(&description, &selection).map_err(|e| told(&e))?;
    let believed = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let diagnosis = diagnose(&believed, &paper.train).map_err(|e| told(&e))?;
    let before = DiagnosedModel::believed(&believed);
    let on_holdout = diagnosis.errors(&before, &paper.holdout).map_err(|e| told(&e))?;
    let model_json = diagnosis.model.to_json().map_err(|e| told(&e))?;
    let efforts = diagnosis.model.predict(&paper.exam_motion).map_err(|e| told(&e))?;
    let channels = diagnosis
        .joints
        .iter()
        .zip(efforts)
        .map(|(name, effort)| JointChannels { effort: Some(effort), ..JointChannels::new(name) });
    let stamps = paper.exam_motion.time_s.clone();
    let predicted =
        Recording::new("prediction", stamps, channels.collect()).map_err(|e| told(&e))?;
    let warnings = believed.chain.warnings.iter().map(ToString::to_string).collect();
    let report = DiagnoseReport::new(
        &believed.chain,
        &diagnosis,
        paper.train.iter().map(|recording| recording.source.clone()).collect(),
        vec![paper.holdout.source.clone()],
        None,
        Some(on_holdout),
        warnings,
    );
    let out_json = serde_json::to_string_pretty(&report).map_err(|e| told(&e))? + "\n";
    Ok(Sitting { out_json, model_json, predicted, seconds: started.elapsed().as_secs_f64() })
}
