//! `diagnose`: effects that a model lacks.

use std::path::Path;

use armident_diagnose::{
    DiagnoseError, DiagnoseRequest, Diagnosis, WrongColumns, diagnose as diagnosed,
};
use armident_ident::validation::{REPLAY_WINDOW_S, replay};
use armident_model::{ArmModel, PreparedRecording};
use armident_motion::common_cutoff_hz;
use armident_page::{Drawing, RecordingRole};
use armident_recording::{Encoded, Recording};
use armident_report::{ByJoint, DiagnoseInputs, DiagnoseReport, Fits, ReplayPair};

use crate::drawing;
use crate::failure::Failure;
use crate::next_motion::next_motion;
use crate::recordings::{joints_with_position, motions_with_effort};
use crate::robot::{GivenRobot, chain_warnings};
use crate::topics::{PredictedEfforts, as_mcap};

/// How recordings are diagnosed.
#[derive(Debug, Clone, Default)]
pub struct DiagnoseOptions<'a> {
    /// Whether columns that fail the input checks are used.
    pub trust_columns: bool,
    /// Number of placebo terms.
    pub placebo: Option<usize>,
    /// Whether forward replay is skipped.
    pub no_replay: bool,
    /// File that a motion which separates indistinguishable effects is to be written to; none: no such motion.
    pub next_motion: Option<&'a Path>,
}

/// Recordings of a diagnosis.
#[derive(Debug, Clone, Copy)]
pub struct DiagnoseRecordings<'a> {
    /// Fitted.
    pub training: &'a [Recording],
    /// Not fitted: they confirm findings or do not.
    pub holdout: &'a [Recording],
    /// Earlier recordings of the same arm: only changes since then are findings.
    pub reference: &'a [Recording],
}

/// A diagnosis, or columns that leave nothing to diagnose.
#[derive(Debug)]
pub struct Diagnosed {
    /// The result.
    pub report: DiagnoseReport,
    /// The motion that separates findings from their alternatives, where it was requested and exists.
    pub next_motion: Option<Recording>,
    found: Found,
}

#[derive(Debug)]
enum Found {
    Diagnosis(Box<Diagnosis>),
    WrongColumns { model: Box<ArmModel>, recordings: Vec<Recording> },
}

/// Diagnoses an arm.
///
/// # Errors
/// Recordings that cannot be used. Columns that fail the input checks are a result.
pub fn diagnose(
    robot: &GivenRobot,
    recordings: DiagnoseRecordings<'_>,
    options: &DiagnoseOptions<'_>,
) -> Result<Diagnosed, Failure> {
    let DiagnoseRecordings { training, holdout, reference } = recordings;
    let model = robot.arm(Some(&joints_with_position(training)))?;
    let request = DiagnoseRequest {
        model: &model,
        recordings: training,
        reference,
        holdout,
        trust_columns: options.trust_columns,
        placebo_terms: options.placebo,
    };
    let sources = |recordings: &[Recording]| recordings.iter().map(|r| r.source.clone()).collect();
    let inputs = DiagnoseInputs {
        recordings: sources(training),
        holdout_recordings: sources(holdout),
        reference_recordings: sources(reference),
        beyond_a_model: request.is_beyond_a_model(),
        warnings: chain_warnings(&model),
    };
    match diagnosed(&request) {
        Ok(diagnosis) => Diagnosed::of(diagnosis, inputs, options),
        Err(DiagnoseError::WrongColumns(wrong)) => {
            Ok(Diagnosed::of_failed_checks(model, *wrong, inputs))
        }
        Err(error) => Err(error.into()),
    }
}

impl Diagnosed {
    fn of(
        diagnosis: Diagnosis,
        inputs: DiagnoseInputs,
        options: &DiagnoseOptions<'_>,
    ) -> Result<Self, Failure> {
        let training = diagnosis.prepared(&diagnosis.recordings)?;
        let holdout = diagnosis.prepared(&diagnosis.holdout)?;
        let errors = |of: &[PreparedRecording<'_>]| {
            (!of.is_empty()).then(|| diagnosis.errors(of)).transpose()
        };
        let fits = Fits::of(errors(&training)?, errors(&holdout)?);
        let designed =
            options.next_motion.map(|file| next_motion(&diagnosis, &file.display().to_string()));
        let (of_next, motion) = designed.unzip();
        let replayed = if options.no_replay { None } else { replayed(&diagnosis) };
        let report = DiagnoseReport::new(&diagnosis.model.chain, &diagnosis, inputs, fits)
            .with_holdout_tests(diagnosis.whiteness(&holdout)?, replayed)
            .with_next_motion(of_next);
        drop((training, holdout));
        Ok(Self {
            report,
            next_motion: motion.flatten(),
            found: Found::Diagnosis(Box::new(diagnosis)),
        })
    }

    fn of_failed_checks(model: ArmModel, wrong: WrongColumns, inputs: DiagnoseInputs) -> Self {
        let report = DiagnoseReport::of_failed_checks(&model.chain, &wrong.input_checks, inputs);
        let found = Found::WrongColumns { model: Box::new(model), recordings: wrong.recordings };
        Self { report, next_motion: None, found }
    }

    /// The diagnosed model: the given one with findings and small terms; none where columns leave nothing to diagnose.
    pub fn model(&self) -> Option<&ArmModel> {
        match &self.found {
            Found::Diagnosis(diagnosis) => Some(&diagnosis.model),
            Found::WrongColumns { .. } => None,
        }
    }

    /// What the page shows beside the result. Without a diagnosis: efforts beside those of the given model show what the
    /// columns are.
    ///
    /// # Errors
    /// Recordings that cannot be predicted.
    pub fn drawing(&self) -> Result<Drawing, Failure> {
        match &self.found {
            Found::Diagnosis(diagnosis) => {
                let training = diagnosis.prepared(&diagnosis.recordings)?;
                let holdout = diagnosis.prepared(&diagnosis.holdout)?;
                drawing::of_diagnosis(diagnosis, &training, &holdout)
            }
            Found::WrongColumns { model, recordings } => {
                let cutoff_hz = common_cutoff_hz(recordings, &model.chain.joint_names(), None)?;
                let models: [(&str, &ArmModel); 1] = [("given", model)];
                let recorded = [(recordings.as_slice(), RecordingRole::Training)];
                drawing::of_models(&model.chain, &models, &recorded, cutoff_hz)
            }
        }
    }
}

impl Diagnosed {
    /// The recordings as topics of MCAP, with the efforts that the diagnosed model predicts, their residuals, and the findings.
    /// Without a diagnosis: with the efforts of the given model.
    ///
    /// # Errors
    /// Recordings that cannot be predicted; a build without MCAP.
    pub fn mcap(&self) -> Result<Encoded, Failure> {
        let mut predicted = Vec::new();
        let chain = match &self.found {
            Found::Diagnosis(diagnosis) => {
                for recordings in [&diagnosis.recordings, &diagnosis.holdout] {
                    for (seen, recording) in diagnosis.prepared(recordings)?.iter().zip(recordings)
                    {
                        let efforts = diagnosis.model.predict_prepared(seen)?;
                        predicted.push(PredictedEfforts { recording, efforts });
                    }
                }
                &diagnosis.model.chain
            }
            Found::WrongColumns { model, recordings } => {
                let cutoff_hz = common_cutoff_hz(recordings, &model.chain.joint_names(), None)?;
                for recording in recordings {
                    let efforts = model.predict(recording, cutoff_hz)?.efforts;
                    predicted.push(PredictedEfforts { recording, efforts });
                }
                &model.chain
            }
        };
        as_mcap(chain, predicted, Some(&self.report))
    }
}

/// Forward replay of the hold-out with the given model and the diagnosed one; none where one of the two cannot be
/// simulated.
fn replayed(diagnosis: &Diagnosis) -> Option<ReplayPair> {
    if diagnosis.holdout.is_empty() {
        return None;
    }
    let joints = diagnosis.model.chain.joint_names();
    let cutoff_hz = common_cutoff_hz(&diagnosis.holdout, &joints, None).ok()?;
    let motions = motions_with_effort(&diagnosis.holdout, &joints, cutoff_hz).ok()?;
    let of = |model: &ArmModel| -> Option<ByJoint> {
        let moved = replay(&model.simulated().0, &motions).ok().filter(|m| m.windows > 0)?;
        let errors = moved.joints.iter().map(|j| j.position_rms);
        Some(joints.iter().map(ToString::to_string).zip(errors).collect())
    };
    let (before, after) = (of(&diagnosis.believed)?, of(&diagnosis.model)?);
    Some(ReplayPair { window_s: REPLAY_WINDOW_S, before, after })
}
