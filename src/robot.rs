//! Loads the arm from a URDF or model file and the chain options.

use std::path::Path;

use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::{ArmModel, DiagnosedModel, Learned};
use armident_motion::{Motion, MotionSettings};
use armident_recording::Recording;

use crate::args::ChainArgs;
use crate::failure::Failure;

/// Loads the arm; `recorded` are the joints of the recordings at hand.
pub(crate) fn load(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<ArmModel, Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return load_model(path, chain);
    }
    let robot = load_urdf(path)?;
    let default = ChainSelection::default();
    let selection = ChainSelection {
        base: chain.base.clone(),
        tip: chain.tip.clone(),
        recorded_joints: recorded.map(<[String]>::to_vec),
        locked: chain.lock.iter().cloned().collect(),
        gravity_base: chain.gravity.unwrap_or(default.gravity_base),
        snap_rpy_rad: chain.snap_rpy,
    };
    let serial = SerialChain::from_description(&robot, &selection)?;
    Ok(ArmModel::from_chain(DrivingAxisChain::from_chain(&serial)))
}

/// Notes on a chain, in addition to its warnings.
pub(crate) fn notes(model: &ArmModel) -> Vec<String> {
    model.chain.ignored_note().into_iter().collect()
}

fn load_model(path: &Path, chain: &ChainArgs) -> Result<ArmModel, Failure> {
    let chosen = [
        ("--base", chain.base.is_some()),
        ("--tip", chain.tip.is_some()),
        ("--lock", !chain.lock.is_empty()),
        ("--gravity", chain.gravity.is_some()),
    ];
    if let Some((option, _)) = chosen.iter().find(|(_, given)| *given) {
        return Err(Failure::new(
            format!("{option} cannot be used with a model file"),
            path.display(),
            Some("pass the URDF instead, or omit the option"),
        ));
    }
    ArmModel::load(path).map_err(|error| Failure::model(path, &error))
}

/// The arm with everything in its file, including the findings of a diagnosed model.
pub(crate) struct Robot {
    /// Links, and effects on joints.
    pub(crate) arm: ArmModel,
    /// Findings of a diagnosed model; `None` for a URDF and for an identified model.
    pub(crate) learned: Option<Learned>,
}

/// Predicted efforts.
pub(crate) struct Predicted {
    /// Effort of every joint at every time stamp of the recording \[N m or N\].
    pub(crate) efforts: Vec<Vec<f64>>,
    /// Notes on the motion.
    pub(crate) notes: Vec<String>,
}

/// A model that predicts the efforts of a motion.
pub(crate) trait Predicts {
    /// Efforts of a recorded motion. `cutoff_hz` is the low-pass of the positions; a diagnosed model has
    /// its own.
    fn efforts(&self, recording: &Recording, cutoff_hz: Option<f64>) -> Result<Predicted, Failure>;
}

impl Predicts for ArmModel {
    fn efforts(&self, recording: &Recording, cutoff_hz: Option<f64>) -> Result<Predicted, Failure> {
        let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
        let motion = Motion::from_recording(recording, &self.chain.joint_names(), &settings)?;
        let motion = self.motion_of(motion, recording);
        let efforts = self.predict(&motion)?.iter().map(|e| motion.at_stamps(e)).collect();
        Ok(Predicted { efforts, notes: motion.notes })
    }
}

impl Predicts for DiagnosedModel {
    fn efforts(&self, recording: &Recording, _: Option<f64>) -> Result<Predicted, Failure> {
        Ok(Predicted { efforts: self.predict(recording)?, notes: recording.notes.clone() })
    }
}

impl Predicts for Robot {
    fn efforts(&self, recording: &Recording, cutoff_hz: Option<f64>) -> Result<Predicted, Failure> {
        match self.diagnosed() {
            Some(diagnosed) => diagnosed.efforts(recording, cutoff_hz),
            None => self.arm.efforts(recording, cutoff_hz),
        }
    }
}

impl Robot {
    /// Efforts of recordings on the grids of their given motions.
    pub(crate) fn on_grids(
        &self,
        motions: &[Motion],
        recordings: &[Recording],
    ) -> Result<Vec<Vec<Vec<f64>>>, Failure> {
        let Some(diagnosed) = self.diagnosed() else {
            return Ok(motions.iter().map(|m| self.arm.predict(m)).collect::<Result<_, _>>()?);
        };
        let on_grid = |(motion, recording): (&Motion, &Recording)| {
            let at_stamps = diagnosed.predict(recording)?;
            Ok(at_stamps.iter().map(|effort| motion.on_grid(effort)).collect())
        };
        motions.iter().zip(recordings).map(on_grid).collect()
    }

    fn diagnosed(&self) -> Option<DiagnosedModel> {
        let learned = self.learned.clone()?;
        Some(DiagnosedModel { arm: self.arm.clone(), learned })
    }

    /// The arm with all findings as effects, and a list of those that a simulated arm does not support.
    pub(crate) fn as_simulated(&self) -> (ArmModel, Vec<String>) {
        match self.diagnosed() {
            Some(diagnosed) => diagnosed.as_simulated(),
            None => (self.arm.clone(), self.arm.of_predictions_alone()),
        }
    }
}

/// Loads the links of the arm, with a note on the other content of its file.
pub(crate) fn load_links(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<(ArmModel, Option<String>), Failure> {
    let robot = load_whole(path, chain, recorded)?;
    let (simulated, mut beside) = robot.as_simulated();
    let tilted = robot.learned.as_ref().is_some_and(|l| l.tilt_rad.iter().any(|x| *x != 0.0));
    beside.extend(tilted.then(|| "base tilt".to_owned()));
    let mut slugs: Vec<String> = simulated.effects.into_iter().map(|e| e.effect).collect();
    slugs.sort();
    slugs.dedup();
    slugs.extend(beside);
    let note = (!slugs.is_empty()).then(|| {
        format!("using only the links of {}; ignoring {}", path.display(), slugs.join(", "))
    });
    Ok((robot.arm, note))
}

/// Loads the arm with the whole content of its file.
pub(crate) fn load_whole(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<Robot, Failure> {
    let arm = load(path, chain, recorded)?;
    let learned = learned(path, &arm)?;
    Ok(Robot { arm, learned })
}

/// The findings of a diagnosed model; `None` for other files.
fn learned(path: &Path, model: &ArmModel) -> Result<Option<Learned>, Failure> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::model(path, &armident_model::ModelError::Unreadable(error)))?;
    Learned::in_model_file(&text, &model.chain.joint_names()).map_err(|error| {
        Failure::new(
            error,
            path.display(),
            Some("create the model again with `armident diagnose --save-model`"),
        )
    })
}
