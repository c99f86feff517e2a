//! One recording with the predictions of the models, on an even grid.

use std::ops::Range;

use armident_motion::{HIGHEST_CUTOFF_SHARE, Motion, MotionSettings, default_cutoff_hz};
use armident_recording::{Quantity, Recording, RecordingError};

use crate::drawing::{DrawnQuantity, RecordingRole};

/// Lowest cut-off for the speeds and accelerations that residuals are sorted by \[Hz\].
const LEAST_CUTOFF_HZ: f64 = 10.0;

/// A recording with the efforts or positions that the models predict for it.
#[derive(Debug)]
pub struct Compared<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Whether it was fitted.
    pub role: RecordingRole,
    /// What is compared.
    pub quantity: DrawnQuantity,
    /// `predicted[model][joint]`, at the stamps of the recording, in the unit of the quantity.
    pub predicted: Vec<Vec<Vec<f64>>>,
    /// Time at both ends in which the predictions are those of a low-pass that lacks the samples before
    /// and after \[s\]: not counted in residuals.
    pub edge_s: f64,
}

/// One recording on its even grid.
pub(crate) struct Sheet {
    pub(crate) motion: Motion,
    pub(crate) role: RecordingRole,
    pub(crate) quantity: DrawnQuantity,
    /// samples that count in residuals
    pub(crate) kept: Range<usize>,
    /// empty for a joint without the recorded quantity
    pub(crate) measured: Vec<Vec<f64>>,
    /// model, joint
    pub(crate) residual: Vec<Vec<Vec<f64>>>,
    /// model, joint
    pub(crate) predicted: Vec<Vec<Vec<f64>>>,
}

impl Sheet {
    pub(crate) fn new(joints: &[&str], compared: &Compared<'_>) -> Result<Self, RecordingError> {
        let recording = compared.recording;
        let grid = armident_motion::EvenGrid::of(recording)?;
        let positions: Vec<Vec<f64>> = joints
            .iter()
            .filter_map(|j| recording.joint(j)?.channel(Quantity::Position))
            .map(|q| grid.resample(q))
            .collect();
        let rate_hz = grid.rate_hz();
        let cutoff_hz = default_cutoff_hz(&positions, rate_hz)
            .max(LEAST_CUTOFF_HZ)
            .min(HIGHEST_CUTOFF_SHARE * rate_hz);
        let settings = MotionSettings { cutoff_hz: Some(cutoff_hz), ..MotionSettings::default() };
        let motion = Motion::from_recording(recording, joints, &settings)?;
        let measured_quantity = match compared.quantity {
            DrawnQuantity::Effort => Quantity::Effort,
            DrawnQuantity::Position => Quantity::Position,
        };
        let measured: Vec<Vec<f64>> = joints
            .iter()
            .map(|j| {
                let column = recording.joint(j).and_then(|j| j.channel(measured_quantity));
                column.map(|e| motion.on_grid(e)).unwrap_or_default()
            })
            .collect();
        let predicted: Vec<Vec<Vec<f64>>> = compared
            .predicted
            .iter()
            .map(|model| model.iter().map(|effort| motion.on_grid(effort)).collect())
            .collect();
        let residual = predicted
            .iter()
            .map(|model| measured.iter().zip(model).map(|(m, p)| less(m, p)).collect())
            .collect();
        let edge = ((compared.edge_s * rate_hz).ceil() as usize).min(motion.len() / 4);
        let kept = edge..motion.len() - edge;
        let (role, quantity) = (compared.role, compared.quantity);
        Ok(Self { motion, role, quantity, kept, measured, residual, predicted })
    }
}

impl Sheet {
    /// What counts of a column; nothing of an empty one.
    pub(crate) fn of<'s>(&self, column: &'s [f64]) -> &'s [f64] {
        column.get(self.kept.clone()).unwrap_or_default()
    }
}

/// `a - b`, empty where `a` is.
pub(crate) fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
