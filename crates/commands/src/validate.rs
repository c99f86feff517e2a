//! `validate`: a model on recordings that it was not fitted to.

use std::collections::BTreeMap;

use armident_ident::validation::{EffortError, REPLAY_WINDOW_S, effort_errors, replay};
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_page::{Drawing, RecordingRole};
use armident_recording::{Encoded, Recording};
use armident_report::{ByJoint, EffortErrorRow, ReplayReport, ValidateReport};

use crate::drawing;
use crate::failure::Failure;
use crate::predict::as_recording;
use crate::recordings::{joints_with_position, motions_with_effort, notes};
use crate::robot::{GivenRobot, chain_warnings};
use crate::topics::{PredictedEfforts, as_mcap};

/// A model beside recordings.
#[derive(Debug, Clone)]
pub struct Validated {
    /// The result.
    pub report: ValidateReport,
    /// The model.
    pub model: ArmModel,
    /// The recordings.
    pub recordings: Vec<Recording>,
}

/// Effort errors of a model on recordings, and forward replay where `replayed`. `cutoff_hz`: low-pass \[Hz\]; none: the
/// model's, else from the spectrum of the motion.
///
/// # Errors
/// Recordings without the joints or efforts of the arm; a low-pass that is not possible.
pub fn validate(
    robot: &GivenRobot,
    recordings: Vec<Recording>,
    cutoff_hz: Option<f64>,
    replayed: bool,
) -> Result<Validated, Failure> {
    let recorded = recordings;
    let model = robot.arm(Some(&joints_with_position(&recorded)))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz =
        armident_motion::common_cutoff_hz(&recorded, &joints, cutoff_hz.or(model.cutoff_hz))?;
    let motions: Vec<Motion> = motions_with_effort(&recorded, &joints, cutoff_hz)?
        .into_iter()
        .zip(&recorded)
        .map(|(motion, recording)| model.motion_of(motion, recording))
        .collect();

    let before = model.before();
    let (simulated, lost) = model.simulated();
    let mut warnings = chain_warnings(&model);
    let mut replay_of = |which: &str, model: &ArmModel| match replay(model, &motions) {
        Ok(replay) => Some(ReplayReport {
            window_s: REPLAY_WINDOW_S,
            windows: replay.windows,
            diverged: replay.diverged,
            position_rms: by_joint(&names, replay.joints.iter().map(|r| r.position_rms)),
            velocity_rms: by_joint(&names, replay.joints.iter().map(|r| r.velocity_rms)),
        }),
        Err(error) => {
            warnings.push(format!("forward replay skipped ({which}): {error} [no-replay]"));
            None
        }
    };
    let mut notes = notes(&motions);
    let (replay_before, replay_after) = if replayed {
        notes.extend(lost.iter().map(|what| format!("omitted from forward replay: {what}")));
        (replay_of("URDF", &before), replay_of("model", &simulated))
    } else {
        (None, None)
    };
    let without_effects: Vec<_> =
        motions.iter().map(|motion| before.predict_motion(motion)).collect::<Result<_, _>>()?;
    let whole = model.predict_on_grids(&motions, &recorded)?;
    let prismatic = model.chain.joints.iter().filter(|joint| !joint.kind.is_rotational());
    let report = ValidateReport {
        schema: ValidateReport::SCHEMA.to_owned(),
        robot: model.chain.robot.clone(),
        model: robot.source.clone(),
        recordings: recorded.iter().map(|r| r.source.clone()).collect(),
        before: errors(&before, &motions, &without_effects),
        after: errors(&model, &motions, &whole),
        replay_before,
        replay_after,
        joints: names,
        prismatic_joints: Some(prismatic.map(|joint| joint.name.clone()).collect()),
        cutoff_hz,
        warnings,
        notes,
    };
    Ok(Validated { report, model, recordings: recorded })
}

impl Validated {
    /// Predicted effort of every sample of a recording.
    ///
    /// # Errors
    /// A recording that cannot be predicted.
    pub fn prediction(&self, recording: &Recording) -> Result<Recording, Failure> {
        let efforts = self.model.predict(recording, self.report.cutoff_hz)?.efforts;
        as_recording(&self.model, recording, efforts)
    }

    /// The recordings as topics of MCAP, with the efforts that the model predicts, and their residuals.
    ///
    /// # Errors
    /// Recordings that cannot be predicted; a build without MCAP.
    pub fn mcap(&self) -> Result<Encoded, Failure> {
        let of = |recording| {
            let efforts = self.model.predict(recording, self.report.cutoff_hz)?.efforts;
            Ok(PredictedEfforts { recording, efforts })
        };
        let predicted = self.recordings.iter().map(of).collect::<Result<Vec<_>, Failure>>()?;
        as_mcap(&self.model.chain, predicted, None)
    }

    /// What the page shows beside the result.
    ///
    /// # Errors
    /// Recordings that cannot be predicted.
    pub fn drawing(&self) -> Result<Drawing, Failure> {
        let before = self.model.before();
        let recorded = [(self.recordings.as_slice(), RecordingRole::Holdout)];
        let models: [(&str, &ArmModel); 2] = [("URDF only", &before), ("model", &self.model)];
        drawing::of_models(&self.model.chain, &models, &recorded, self.report.cutoff_hz)
    }
}

fn errors(
    model: &ArmModel,
    motions: &[Motion],
    efforts: &[Vec<Vec<f64>>],
) -> BTreeMap<String, EffortErrorRow> {
    let known = |x: f64| x.is_finite().then_some(x);
    let row = |e: &EffortError| EffortErrorRow {
        rmse: e.rmse,
        relative: e.relative,
        rmse_raw: e.rmse_raw,
        band_coverage: known(e.band_coverage),
        lag1_correlation: known(e.lag1_correlation),
        whiteness_p: known(e.whiteness_p),
    };
    let all = effort_errors(model, motions, efforts);
    let names = model.chain.joints.iter().map(|j| j.name.clone());
    names.zip(all.iter().map(row)).collect()
}

fn by_joint(names: &[String], values: impl Iterator<Item = f64>) -> ByJoint {
    names.iter().cloned().zip(values).collect()
}
