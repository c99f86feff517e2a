//! `validate`: a model on recordings that it was not fitted to.

use std::collections::BTreeMap;
use std::path::PathBuf;

use armident_ident::validation::{EffortError, REPLAY_WINDOW_S, effort_errors, replay};
use armident_ident::{COMMAND_WINDOW_S, CommandReplayError, ServoRequest, replay_commands};
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_page::{Drawing, RecordingRole};
use armident_recording::{Encoded, Recording};
use armident_report::{
    ByJoint, EffortErrorRow, PositionsUnderCommands, ReplayReport, ValidateReport,
};

use crate::drawing;
use crate::failure::Failure;
use crate::predict::as_recording;
use crate::recordings::{joints_with_position, motions_with_effort, notes};
use crate::robot::{GivenRobot, chain_warnings};
use crate::servos::{Gains, failure};
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
    /// Gain of the controllers in each of them, over those of the model.
    pub gains: Vec<f64>,
}

/// Effort errors of a model on recordings, and forward replay where `replayed`. `cutoff_hz`: low-pass \[Hz\]; none: the
/// model's, else from the spectrum of the motion. With commands instead of efforts, and a model with controllers: position errors
/// under the commands; `gains` as in [`identify_servos`](crate::identify_servos).
///
/// # Errors
/// Recordings without the joints or efforts of the arm; a low-pass that is not possible; gains of no recording.
pub fn validate(
    robot: &GivenRobot,
    recordings: Vec<Recording>,
    cutoff_hz: Option<f64>,
    replayed: bool,
    gains: &[(PathBuf, f64)],
) -> Result<Validated, Failure> {
    let recorded = recordings;
    let model = robot.arm(Some(&joints_with_position(&recorded)))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    if model.servo_of_each_joint().is_some() && ServoRequest::suits(&recorded, &names) {
        let gains = Gains::of(&recorded, &[], gains)?.train;
        return under_commands(robot, model, recorded, gains);
    }
    if !gains.is_empty() {
        return Err(Failure::new(
            "a gain of controllers is given, and the recordings or the model have none",
            "--servo-gain",
            Some("pass recordings of commands and positions, and the model of --save-model"),
        ));
    }
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
        positions: None,
        joints: names,
        prismatic_joints: Some(prismatic.map(|joint| joint.name.clone()).collect()),
        cutoff_hz,
        warnings,
        notes,
    };
    Ok(Validated { report, model, gains: vec![1.0; recorded.len()], recordings: recorded })
}

/// Positions under commands, of a model whose joints have controllers.
fn under_commands(
    robot: &GivenRobot,
    model: ArmModel,
    recordings: Vec<Recording>,
    gains: Vec<f64>,
) -> Result<Validated, Failure> {
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let found = replay_commands(&model, &recordings, &gains).map_err(failure)?;
    let of = |error: &dyn Fn(&CommandReplayError) -> f64| {
        by_joint(&names, found.joints.iter().map(error))
    };
    let prismatic = model.chain.joints.iter().filter(|joint| !joint.kind.is_rotational());
    let report = ValidateReport {
        schema: ValidateReport::SCHEMA.to_owned(),
        robot: model.chain.robot.clone(),
        model: robot.source.clone(),
        recordings: recordings.iter().map(|r| r.source.clone()).collect(),
        positions: Some(PositionsUnderCommands {
            command: of(&|e| e.command),
            whole: of(&|e| e.whole),
            in_windows: of(&|e| e.windows),
            window_s: COMMAND_WINDOW_S,
            windows: found.windows,
            diverged: found.diverged,
        }),
        prismatic_joints: Some(prismatic.map(|joint| joint.name.clone()).collect()),
        warnings: chain_warnings(&model),
        joints: names,
        ..ValidateReport::default()
    };
    Ok(Validated { report, model, gains, recordings })
}

impl Validated {
    /// Predicted effort of every sample of a recording.
    ///
    /// # Errors
    /// A recording that cannot be predicted.
    pub fn prediction(&self, recording: &Recording) -> Result<Recording, Failure> {
        self.need_efforts("--predictions", "use `armident predict --closed-loop`")?;
        let efforts = self.model.predict(recording, self.report.cutoff_hz)?.efforts;
        as_recording(&self.model, recording, efforts)
    }

    /// The recordings as topics of MCAP, with the efforts that the model predicts, and their residuals.
    ///
    /// # Errors
    /// Recordings that cannot be predicted; a build without MCAP.
    pub fn mcap(&self) -> Result<Encoded, Failure> {
        self.need_efforts("--mcap", "leave it out")?;
        let of = |recording| {
            let efforts = self.model.predict(recording, self.report.cutoff_hz)?.efforts;
            Ok(PredictedEfforts { recording, efforts })
        };
        let predicted = self.recordings.iter().map(of).collect::<Result<Vec<_>, Failure>>()?;
        as_mcap(&self.model.chain, predicted, None)
    }

    fn need_efforts(&self, option: &str, instead: &str) -> Result<(), Failure> {
        if self.report.positions.is_none() {
            return Ok(());
        }
        let problem = "efforts are predicted, and the recordings have commands and no efforts";
        Err(Failure::new(problem, option, Some(instead)))
    }

    /// What the page shows beside the result.
    ///
    /// # Errors
    /// Recordings that cannot be predicted.
    pub fn drawing(&self) -> Result<Drawing, Failure> {
        if self.report.positions.is_some() {
            let recorded = [(&self.recordings[..], &self.gains[..], RecordingRole::Holdout)];
            return drawing::of_positions(&self.model, &recorded);
        }
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
