//! Errors of a model on hold-out recordings.
//!
//! Three measures: the effort error per joint with its 95 % bands, a whiteness test of the residual, and forward replay,
//! where the recorded efforts drive the simulated arm through short windows and the motions are compared.

use std::ops::Range;

use armident_model::ArmModel;
use armident_motion::Motion;
use armident_recording::{JointChannels, Recording};
use armident_simulation::{ArmState, ForwardSettings, SimulatedArm, SimulationError, forward};
use rayon::prelude::*;

use crate::used_samples::EDGE_PERIODS;
use armident_inference::whiteness;

/// Length of a replay window \[s\]: long enough for an inertia error to show, short enough for an
/// unstable arm to stay near its recording.
pub const REPLAY_WINDOW_S: f64 = 0.5;
/// Half the width of a 95 % band in standard deviations of normal noise.
const BAND_95: f64 = 1.96;
/// Samples kept per second for the whiteness test, in cut-off frequencies: a low-passed white noise
/// is white again at twice its cut-off.
const SAMPLES_PER_CUTOFF: f64 = 2.0;

/// Effort error of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortError {
    /// RMS of measured minus predicted on the filtered effort \[N m or N\].
    pub rmse: f64,
    /// `norm(residual) / norm(effort - mean)` on the filtered effort.
    pub relative: f64,
    /// Root mean square on the effort as recorded, every sample of it \[N m or N\].
    pub rmse_raw: f64,
    /// Share of samples inside the model's 95 % band: filtered ones, or as recorded for a model that was fitted to
    /// those; NaN for a model without noise levels.
    pub band_coverage: f64,
    /// Correlation of neighbouring residuals, thinned to twice the cut-off.
    pub lag1_correlation: f64,
    /// p-value of the Ljung-Box test of whiteness over 10 lags of the thinned residual (null
    /// hypothesis: white). Small: the model is incomplete.
    pub whiteness_p: f64,
}

/// Motion error of one joint under forward replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayError {
    /// Root mean square position error over all windows \[rad or m\].
    pub position_rms: f64,
    /// Root mean square velocity error \[rad/s or m/s\].
    pub velocity_rms: f64,
}

/// Forward replay of all joints.
#[derive(Debug, Clone)]
pub struct Replay {
    /// Per joint.
    pub joints: Vec<ReplayError>,
    /// Windows that were simulated to their end.
    pub windows: usize,
    /// Windows in which the simulation diverged; not part of the errors.
    pub diverged: usize,
}

/// Effort errors per joint, pooled over recordings with efforts.
///
/// `predicted` are the efforts of the model on the grid of each motion, joint-major and not filtered.
pub fn effort_errors(
    model: &ArmModel,
    motions: &[Motion],
    predicted: &[Vec<Vec<f64>>],
) -> Vec<EffortError> {
    let n = model.chain.dof();
    let mut pools = vec![Pool::default(); n];
    for (motion, predicted) in motions.iter().zip(predicted) {
        let (Some(raw), Some(filtered)) = (&motion.effort, &motion.effort_filtered) else {
            continue;
        };
        let mut smooth = predicted.clone();
        motion.filter_columns(&mut smooth);
        let (edge, stride) = match &motion.filter {
            Some(f) => (
                ((EDGE_PERIODS * motion.rate_hz / f.cutoff_hz()).ceil() as usize)
                    .min(motion.len() / 4),
                (motion.rate_hz / (SAMPLES_PER_CUTOFF * f.cutoff_hz())).round().max(1.0) as usize,
            ),
            None => (0, 1),
        };
        for joint in 0..n {
            let kept = edge..motion.len() - edge;
            pools[joint].add(&filtered[joint][kept.clone()], &smooth[joint][kept.clone()], stride);
            let pairs = || raw[joint].iter().zip(&predicted[joint]);
            for (m, p) in pairs() {
                pools[joint].raw_squares += (m - p).powi(2);
                pools[joint].raw_count += 1.0;
            }
            let Some(noise) = &model.effort_noise else { continue };
            if model.cutoff_hz.is_some() {
                let pairs = filtered[joint][kept.clone()].iter().zip(&smooth[joint][kept]);
                pools[joint].count_inside(BAND_95 * noise[joint], pairs);
            } else {
                pools[joint].count_inside(BAND_95 * noise[joint], pairs());
            }
        }
    }
    pools.iter().map(Pool::error).collect()
}

#[derive(Debug, Clone, Default)]
struct Pool {
    count: f64,
    sum: f64,
    squares: f64,
    residual_squares: f64,
    inside: f64,
    beside_band: f64,
    raw_squares: f64,
    raw_count: f64,
    /// thinned residuals, one list per recording
    thinned: Vec<Vec<f64>>,
}

impl Pool {
    fn count_inside<'a>(&mut self, band: f64, pairs: impl Iterator<Item = (&'a f64, &'a f64)>) {
        for (measured, predicted) in pairs {
            if (measured - predicted).abs() <= band {
                self.inside += 1.0;
            } else {
                self.beside_band += 1.0;
            }
        }
    }

    fn add(&mut self, measured: &[f64], predicted: &[f64], stride: usize) {
        let residual: Vec<f64> = measured.iter().zip(predicted).map(|(m, p)| m - p).collect();
        self.count += measured.len() as f64;
        self.sum += measured.iter().sum::<f64>();
        self.squares += measured.iter().map(|m| m * m).sum::<f64>();
        self.residual_squares += residual.iter().map(|r| r * r).sum::<f64>();
        self.thinned.push(residual.iter().step_by(stride).copied().collect());
    }

    fn error(&self) -> EffortError {
        let varying = self.squares - self.sum * self.sum / self.count;
        let (lag1_correlation, whiteness_p) = whiteness(&self.thinned);
        EffortError {
            rmse: (self.residual_squares / self.count).sqrt(),
            relative: (self.residual_squares / varying).sqrt(),
            rmse_raw: (self.raw_squares / self.raw_count).sqrt(),
            band_coverage: self.inside / (self.inside + self.beside_band),
            lag1_correlation,
            whiteness_p,
        }
    }
}

/// Drives the simulated arm with the recorded efforts from the recorded state, window by window.
///
/// # Errors
/// [`SimulationError`] when the model cannot be simulated at all (an effect of the wrong sign, an
/// inertia matrix that is not positive definite at the start of every window).
pub fn replay(model: &ArmModel, motions: &[Motion]) -> Result<Replay, SimulationError> {
    let names: Vec<&str> = model.chain.joint_names();
    let arm = SimulatedArm::on_chain(&model.chain, &model.effects)?;
    let n = names.len();
    // squares of the errors of position and velocity, by joint; none where the arm diverged
    let replayed = |(motion, effort, span): (&Motion, &Vec<Vec<f64>>, Range<usize>)| {
        let joints = (0..n)
            .map(|j| JointChannels {
                effort: Some(effort[j][span.clone()].to_vec()),
                ..JointChannels::new(names[j])
            })
            .collect();
        let time: Vec<f64> = motion.time_s[span.clone()].to_vec();
        let efforts = Recording::new(&motion.source, time, joints)?;
        let state = ArmState {
            position: (0..n).map(|j| motion.position[j][span.start]).collect(),
            velocity: (0..n).map(|j| motion.velocity[j][span.start]).collect(),
        };
        let moved = match forward(&arm, &efforts, state, &ForwardSettings::default()) {
            Ok(moved) => moved,
            Err(SimulationError::Diverged { .. }) => return Ok(None),
            Err(other) => return Err(other),
        };
        let off = |moved: &Option<Vec<f64>>, recorded: &[f64]| -> f64 {
            let pairs = moved.iter().flatten().zip(&recorded[span.clone()]);
            pairs.map(|(x, recorded)| (x - recorded).powi(2)).sum()
        };
        let of_joint = |(j, joint): (usize, &JointChannels)| {
            let (position, velocity) = (&motion.position[j], &motion.velocity[j]);
            [off(&joint.position, position), off(&joint.velocity, velocity)]
        };
        let squares: Vec<[f64; 2]> = moved.joints.iter().enumerate().map(of_joint).collect();
        Ok(Some((span.len(), squares)))
    };
    let mut spans = Vec::new();
    for motion in motions {
        let Some(effort) = &motion.effort else { continue };
        let length = ((REPLAY_WINDOW_S * motion.rate_hz).round() as usize).max(8);
        let starts = (0..motion.len().saturating_sub(length)).step_by(length);
        spans.extend(starts.map(|start| (motion, effort, start..start + length)));
    }
    let tried = spans.len();
    let of_windows =
        spans.into_par_iter().map(replayed).collect::<Result<Vec<_>, SimulationError>>()?;
    let mut squares = vec![(0.0, 0.0); n];
    let (mut count, mut windows) = (0.0, 0);
    for (length, of_window) in of_windows.into_iter().flatten() {
        windows += 1;
        count += length as f64;
        for (sum, [position, velocity]) in squares.iter_mut().zip(of_window) {
            *sum = (sum.0 + position, sum.1 + velocity);
        }
    }
    let joints = squares
        .iter()
        .map(|(q, v)| ReplayError {
            position_rms: (q / count).sqrt(),
            velocity_rms: (v / count).sqrt(),
        })
        .collect();
    Ok(Replay { joints, windows, diverged: tried - windows })
}
