//! Positions of a model under commands beside recorded ones: over whole recordings, and over windows that start in the recorded
//! state, so that the memory of friction does not carry an error to the end.

use std::ops::Range;

use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_numeric::order_statistic;
use armident_recording::{Quantity, Recording};
use armident_simulation::{
    ArmState, DEFAULT_STEP_S, SimulatedArm, SimulationError, closed_loop_over,
};
use rayon::prelude::*;

use super::error::ServoError;
use super::request::ServoRequest;

/// Length of a window \[s\]: several lags of a slow servo (a quarter of a second).
pub const COMMAND_WINDOW_S: f64 = 2.0;

/// RMS position errors of a joint \[rad or m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandReplayError {
    /// Of the command itself.
    pub command: f64,
    /// Of the model from the first sample of each recording on.
    pub whole: f64,
    /// Of the model in windows, each from the recorded state on.
    pub windows: f64,
}

/// Position errors of an arm behind its controllers.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandReplay {
    /// One a joint, from base to tip.
    pub joints: Vec<CommandReplayError>,
    /// Windows simulated to their end.
    pub windows: usize,
    /// Windows that diverged.
    pub diverged: usize,
}

/// Moves a model under the commands of recordings; `gains` of its controllers in each of them, over those of the model.
///
/// # Errors
/// Recordings without commands or positions of the joints; a model without controllers, or one that cannot be simulated; a
/// whole recording in which it diverges.
pub fn replay_commands(
    model: &ArmModel,
    recordings: &[Recording],
    gains: &[f64],
) -> Result<CommandReplay, ServoError> {
    let request = ServoRequest {
        model,
        train: recordings,
        train_gains: gains,
        holdout: &[],
        holdout_gains: &[],
        ablations: false,
    };
    request.check()?;
    let names = model.chain.joint_names();
    let (simulated, _) = model.simulated();
    let arm = SimulatedArm::on_chain_in(&simulated.library, &simulated.chain, &simulated.effects)?;
    let mut spans = Vec::new();
    let mut recorded = Vec::new();
    for (recording, gain) in recordings.iter().zip(gains) {
        let motion = Motion::from_recording(recording, &names, &MotionSettings::default())?;
        let velocity: Vec<Vec<f64>> = motion.velocity.iter().map(|v| motion.at_stamps(v)).collect();
        let channels = |quantity| -> Vec<&[f64]> {
            let of = |joint: &&str| recording.joint(joint).and_then(|c| c.channel(quantity));
            names.iter().map(|joint| of(joint).unwrap_or(&[])).collect()
        };
        let stamps = recording.time_s.len();
        let mut steps: Vec<f64> = recording.time_s.windows(2).map(|t| t[1] - t[0]).collect();
        let middle = steps.len() / 2;
        let step_s = order_statistic(&mut steps, middle).unwrap_or(COMMAND_WINDOW_S);
        let samples = ((COMMAND_WINDOW_S / step_s).round() as usize).max(2);
        spans.push((recorded.len(), true, 0..stamps));
        let starts = (0..stamps).step_by(samples);
        spans
            .extend(starts.map(|from| (recorded.len(), false, from..(from + samples).min(stamps))));
        recorded.push(Recorded {
            recording,
            gain: *gain,
            command: channels(Quantity::Command),
            position: channels(Quantity::Position),
            velocity,
        });
    }
    let moved = |(k, is_whole, span): &(usize, bool, Range<usize>)| {
        let of: &Recorded<'_> = &recorded[*k];
        let state = of.state(span.start, *is_whole);
        match closed_loop_over(&arm, of.gain, of.recording, span.clone(), state, DEFAULT_STEP_S) {
            Ok(moved) => {
                let squares = moved.joints.iter().zip(&of.position).map(|(joint, position)| {
                    let simulated = joint.position.as_deref().unwrap_or(&[]);
                    sum_of_squares(simulated, &position[span.clone()])
                });
                Ok(Some(squares.collect::<Vec<f64>>()))
            }
            Err(SimulationError::Diverged { .. }) if !is_whole => Ok(None),
            Err(other) => Err(other),
        }
    };
    let all = spans.par_iter().map(moved).collect::<Result<Vec<_>, SimulationError>>()?;
    let mut sums = vec![[0.0; 2]; names.len()];
    let mut counts = [0.0; 2];
    let (mut windows, mut diverged) = (0, 0);
    for (squares, (_, is_whole, span)) in all.iter().zip(&spans) {
        let kind = usize::from(!is_whole);
        let Some(squares) = squares else {
            diverged += 1;
            continue;
        };
        windows += kind;
        counts[kind] += span.len() as f64;
        for (sum, squares) in sums.iter_mut().zip(squares) {
            sum[kind] += squares;
        }
    }
    let of_command = |j: usize| {
        let squares = recorded.iter().map(|of| sum_of_squares(of.command[j], of.position[j]));
        (squares.sum::<f64>() / counts[0]).sqrt()
    };
    let joints = sums
        .iter()
        .enumerate()
        .map(|(j, [whole, windows])| CommandReplayError {
            command: of_command(j),
            whole: (whole / counts[0]).sqrt(),
            windows: (windows / counts[1]).sqrt(),
        })
        .collect();
    Ok(CommandReplay { joints, windows, diverged })
}

/// The channels of a recording, by joint.
struct Recorded<'a> {
    recording: &'a Recording,
    gain: f64,
    command: Vec<&'a [f64]>,
    position: Vec<&'a [f64]>,
    /// low-passed
    velocity: Vec<Vec<f64>>,
}

impl Recorded<'_> {
    fn state(&self, at: usize, is_at_rest: bool) -> ArmState {
        let position: Vec<f64> = self.position.iter().map(|position| position[at]).collect();
        if is_at_rest {
            return ArmState::at_rest(position);
        }
        ArmState { position, velocity: self.velocity.iter().map(|velocity| velocity[at]).collect() }
    }
}

fn sum_of_squares(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}
