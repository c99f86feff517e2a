//! `predict`: the efforts of a motion.

use armident_model::{ArmModel, Prediction};
use armident_recording::{JointChannels, Recording};
use serde::Serialize;

use crate::failure::Failure;
use crate::recordings::joints_with_position;
use crate::robot::{GivenRobot, chain_warnings};

/// What was predicted, in short; the numbers are in the recording.
#[derive(Debug, Clone, Serialize)]
pub struct PredictReport {
    pub(crate) schema: &'static str,
    pub(crate) robot: String,
    pub(crate) motion: String,
    /// Number of stamps.
    pub samples: usize,
    /// Joints of the arm in order.
    pub joints: Vec<String>,
    pub(crate) cutoff_hz: Option<f64>,
    pub(crate) effects: Vec<armident_effects::EffectOnJoint>,
    /// Notes on how the motion was formed.
    pub notes: Vec<String>,
    /// Warnings on the arm.
    pub warnings: Vec<String>,
}

/// A prediction.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// The result.
    pub report: PredictReport,
    /// `t` and the effort or, in closed loop, the position of every joint at every stamp of the motion.
    pub channels: Recording,
}

/// Predicts the efforts of a motion. `cutoff_hz`: low-pass of the positions \[Hz\]; none: the model's, else from the
/// spectrum of the motion.
///
/// # Errors
/// A motion without the positions of the joints; a low-pass that is not possible.
pub fn predict(
    robot: &GivenRobot,
    motion: &Recording,
    cutoff_hz: Option<f64>,
) -> Result<Predicted, Failure> {
    let motions = std::slice::from_ref(motion);
    let model = robot.arm(Some(&joints_with_position(motions)))?;
    // a diagnosed model has its own low-pass
    let cutoff_hz = match model.band {
        Some(_) => None,
        None => armident_motion::common_cutoff_hz(
            motions,
            &model.chain.joint_names(),
            cutoff_hz.or(model.cutoff_hz),
        )?,
    };
    let Prediction { efforts, notes } = model.predict(motion, cutoff_hz)?;
    let efforts = as_recording(&model, motion, efforts)?;
    let report = PredictReport {
        schema: "armident.predict/1",
        robot: model.chain.robot.clone(),
        motion: motion.source.clone(),
        samples: efforts.len(),
        joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
        cutoff_hz,
        effects: model.effects.clone(),
        notes,
        warnings: chain_warnings(&model),
    };
    Ok(Predicted { report, channels: efforts })
}

/// `t` and the effort of every joint at every stamp of a motion.
pub(crate) fn as_recording(
    model: &ArmModel,
    motion: &Recording,
    efforts: Vec<Vec<f64>>,
) -> Result<Recording, Failure> {
    let of_joint = |(name, effort): (&str, Vec<f64>)| JointChannels {
        effort: Some(effort),
        ..JointChannels::new(name)
    };
    let channels = model.chain.joint_names().into_iter().zip(efforts).map(of_joint).collect();
    Ok(Recording::new("prediction", motion.time_s.clone(), channels)?)
}
