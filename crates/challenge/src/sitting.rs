//! A diagnosis of a case by this project, in memory.

use std::time::Instant;

use armident_diagnose::{Books, diagnose, diagnose_change};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use armident_report::{DiagnoseInputs, DiagnoseReport, Fits};

use crate::case::Case;

/// What a diagnosis is given of a case: not the answer, and of the exam its motion alone.
#[derive(Debug, Clone)]
pub struct Paper {
    robot_urdf: String,
    before: Vec<Recording>,
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
            before: case.before.clone(),
            train: [case.train_1.clone(), case.train_2.clone()],
            holdout: case.holdout.clone(),
            exam_motion: Recording { joints, ..case.exam.clone() },
        }
    }
}

/// What a diagnosis hands in.
#[derive(Debug, Clone)]
pub struct Sitting {
    /// What `armident diagnose --json --no-replay` writes, without the errors on the training recordings.
    pub out_json: String,
    /// What `--save-model` and `predict` of the exam write; nothing where the columns are taken for wrong.
    pub learned: Option<LearnedFromPaper>,
    /// How long the diagnosis and the prediction took \[s\].
    pub seconds: f64,
}

/// The model of a diagnosis, and what it predicts.
#[derive(Debug, Clone)]
pub struct LearnedFromPaper {
    /// What `--save-model` writes.
    pub model_json: String,
    /// What `predict` writes for the exam.
    pub predicted: Recording,
}

/// Does as `armident diagnose` and `armident predict` do: checks the books, diagnoses the training
/// recordings, judges the result on the hold-out, and predicts the exam.
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
    let as_believed = if paper.before.is_empty() { &paper.train[..] } else { &paper.before };
    let mut books = Books::of(&believed, as_believed).map_err(|e| told(&e))?;
    let in_effort = |recordings: &[Recording]| -> Vec<Recording> {
        recordings.iter().map(|r| books.in_effort(r)).collect()
    };
    let (train, before) = (in_effort(&paper.train), in_effort(&paper.before));
    let holdout = books.in_effort(&paper.holdout);
    let inputs = DiagnoseInputs {
        recordings: train.iter().map(|recording| recording.source.clone()).collect(),
        holdout_recordings: vec![holdout.source.clone()],
        reference_recordings: before.iter().map(|recording| recording.source.clone()).collect(),
        warnings: believed.chain.warnings.iter().map(ToString::to_string).collect(),
        ..DiagnoseInputs::default()
    };
    let handed_in = |report: &DiagnoseReport, learned| -> Result<Sitting, String> {
        let out_json = serde_json::to_string_pretty(report).map_err(|e| told(&e))? + "\n";
        Ok(Sitting { out_json, learned, seconds: started.elapsed().as_secs_f64() })
    };
    let heard = books.hear(believed.chain.dof(), &train, &before, |train, before| {
        if !before.is_empty() {
            return diagnose_change(&believed, before, train);
        }
        diagnose(&believed, train)
    });
    let Some(heard) = heard else {
        return handed_in(&DiagnoseReport::of_failed_checks(&believed.chain, &books, inputs), None);
    };
    let mut diagnosis = heard.map_err(|e| told(&e))?;
    diagnosis.doubt_gains(&books.drive_gains);
    let seen = diagnosis.see(std::slice::from_ref(&holdout)).map_err(|e| told(&e))?;
    diagnosis.confirm(&seen).map_err(|e| told(&e))?;
    let on_holdout = diagnosis.errors(&seen).map_err(|e| told(&e))?;
    let model_json = diagnosis.model.to_json().map_err(|e| told(&e))?;
    let efforts = diagnosis.model.predict(&paper.exam_motion, None).map_err(|e| told(&e))?.efforts;
    let channels = diagnosis
        .joints
        .iter()
        .zip(efforts)
        .map(|(name, effort)| JointChannels { effort: Some(effort), ..JointChannels::new(name) });
    let stamps = paper.exam_motion.time_s.clone();
    let predicted =
        Recording::new("prediction", stamps, channels.collect()).map_err(|e| told(&e))?;
    let fits = Fits::of(None, Some(on_holdout));
    let report =
        DiagnoseReport::new(&believed.chain, &diagnosis, inputs, fits).with_input_checks(&books);
    handed_in(&report, Some(LearnedFromPaper { model_json, predicted }))
}
