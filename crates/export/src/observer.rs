//! The momentum observer of the C source on recordings: its residual without contact, and thresholds for a false-alarm rate.
//!
//! The residual is that of A. De Luca, R. Mattone, Actuator failure detection and isolation using generalized momenta, ICRA 2003,
//! stepped as in `c/controller.c`.

use armident_dynamics::{RigidArm, inertia_matrix};
use armident_inference::{Tail, episodes};
use armident_model::{ArmModel, PredictError};
use armident_motion::{EvenGrid, Motion, MotionSettings};
use armident_recording::{JointChannels, Quantity, Recording, RecordingError};
use nalgebra::DVector;

use crate::controller::{controlled_arm, controller, rotor_inertias};
use crate::thresholds::{AlarmThresholds, JointThresholds, ObservedAlarms};

/// Speeds a joint has thresholds at.
pub(crate) const SPEEDS: usize = 5;
/// Residuals within this time are one alarm: the arm stops at the first \[s\].
pub const ALARM_S: f64 = 1.0;
/// Time constants of the observer after which its start has no part in the residual.
const START: f64 = 5.0;
/// Share of the residuals at a speed that are smaller than its scale: what an effort has to add to, to be detected in as many
/// samples.
const SCALE_SHARE: f64 = 0.95;
/// Least scale of a speed, as a part of the largest of the joint: a joint at rest has no residual of its motion.
const LEAST_SCALE: f64 = 0.02;
/// Step along the motion for the rate of the inertia matrix \[s\].
const STEP_S: f64 = 1e-5;
/// Most steps of the observer within its time constant that are too few: Euler's method needs more.
const FEWEST_STEPS: f64 = 3.0;

/// Why there are no thresholds.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ThresholdError {
    /// A recording without a joint's position or effort, or mostly gaps.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A motion that cannot be predicted.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A recording without the effort of a joint.
    #[error("no effort of {joint}")]
    NoEffort {
        /// The recording.
        recording: String,
        /// The joint.
        joint: String,
    },
    /// The observer is too fast for the rate of a recording.
    #[error("a gain of {gain} 1/s is too high for {rate_hz:.1} Hz: at most {most:.1} 1/s")]
    Gain {
        /// The recording.
        recording: String,
        /// Gain of the observer \[1/s\].
        gain: f64,
        /// Rate of the recording \[Hz\].
        rate_hz: f64,
        /// Highest gain \[1/s\].
        most: f64,
    },
    /// Too little to continue a tail.
    #[error("{seconds:.0} s without contact are too short for thresholds")]
    TooShort {
        /// Length of the recordings \[s\].
        seconds: f64,
    },
}

/// Residual of the observer over a recording.
#[derive(Debug, Clone)]
pub struct ObserverResidual {
    /// `[joint][sample]` \[N m or N\], after its start.
    pub residual: Vec<Vec<f64>>,
    /// Size of the velocity, likewise \[rad/s or m/s\].
    pub speed: Vec<Vec<f64>>,
    /// Samples per second.
    pub rate_hz: f64,
}

impl ObserverResidual {
    /// Of a recording without contact. Velocities are the recorded ones where all joints have them, or else those of the
    /// low-passed positions.
    ///
    /// # Errors
    /// [`ThresholdError`].
    pub fn of(model: &ArmModel, recording: &Recording, gain: f64) -> Result<Self, ThresholdError> {
        let names = model.chain.joint_names();
        let grid = EvenGrid::of(recording)?;
        let rate_hz = grid.rate_hz();
        let most = rate_hz / FEWEST_STEPS;
        if gain > most {
            let recording = recording.source.clone();
            return Err(ThresholdError::Gain { recording, gain, rate_hz, most });
        }
        let channel = |name: &str, quantity| {
            let values = recording.joint(name)?.channel(quantity)?;
            Some(grid.resample(values))
        };
        let all = |quantity| -> Option<Vec<Vec<f64>>> {
            names.iter().map(|name| channel(name, quantity)).collect()
        };
        let effort: Vec<Vec<f64>> = names
            .iter()
            .map(|name| {
                channel(name, Quantity::Effort).ok_or_else(|| ThresholdError::NoEffort {
                    recording: recording.source.clone(),
                    joint: (*name).to_owned(),
                })
            })
            .collect::<Result<_, _>>()?;
        let (position, velocity) = match (all(Quantity::Position), all(Quantity::Velocity)) {
            (Some(position), Some(velocity)) => (position, velocity),
            _ => {
                let settings =
                    MotionSettings { cutoff_hz: model.cutoff_hz, ..MotionSettings::default() };
                let motion = Motion::from_recording(recording, &names, &settings)?;
                (motion.position, motion.velocity)
            }
        };
        let residual = stepped(model, [&position, &velocity, &effort], gain, rate_hz)?;
        let start = ((START / gain * rate_hz).ceil() as usize).min(position[0].len());
        let later = |rows: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            rows.into_iter().map(|row| row[start.min(row.len())..].to_vec()).collect()
        };
        let speed = velocity.into_iter().map(|row| row.into_iter().map(f64::abs).collect());
        Ok(Self { residual: later(residual), speed: later(speed.collect()), rate_hz })
    }

    fn samples(&self) -> usize {
        self.residual.first().map_or(0, Vec::len)
    }
}

/// Residual of every step.
fn stepped(
    model: &ArmModel,
    [position, velocity, effort]: [&[Vec<f64>]; 3],
    gain: f64,
    rate_hz: f64,
) -> Result<Vec<Vec<f64>>, ThresholdError> {
    let arm = controlled_arm(model);
    let rotor = rotor_inertias(model);
    let slow = without_acceleration(model, position, velocity, rate_hz)?;
    let (dof, dt_s) = (position.len(), 1.0 / rate_hz);
    let mut residual: Vec<Vec<f64>> = vec![Vec::new(); dof];
    let mut last = vec![0.0; dof];
    let mut integral: Vec<f64> = Vec::new();
    let at = |rows: &[Vec<f64>], k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    for k in 0..position[0].len() {
        let (q, v) = (at(position, k), at(velocity, k));
        let q: Vec<f64> = q.iter().zip(&model.encoder_offset).map(|(q, o)| q - o).collect();
        let momentum = momentum(&arm, &rotor, &q, &v);
        let rate = momentum_rate(&arm, &q, &v);
        if integral.is_empty() {
            integral.clone_from(&momentum);
        } else {
            for j in 0..dof {
                let by_motor = effort[j][k] / model.channel_gain[j] - slow[j][k] + rate[j];
                integral[j] += (by_motor + last[j] / model.channel_gain[j]) * dt_s;
            }
        }
        for j in 0..dof {
            last[j] = model.channel_gain[j] * gain * (momentum[j] - integral[j]);
            residual[j].push(last[j]);
        }
    }
    Ok(residual)
}

/// Efforts of the motion without its acceleration, before the gains of the channels: what the C source has of the model.
fn without_acceleration(
    model: &ArmModel,
    position: &[Vec<f64>],
    velocity: &[Vec<f64>],
    rate_hz: f64,
) -> Result<Vec<Vec<f64>>, PredictError> {
    let mut held = model.clone();
    let lost = controller(model).lost;
    held.effects.retain(|on| !lost.iter().any(|l| l.effect == on.effect && l.joint == on.joint));
    held.band = None;
    held.shown = None;
    held.chain.gravity_e0 = controlled_arm(model).gravity_e0;
    let joints = held.chain.joints.iter().enumerate().map(|(j, joint)| JointChannels {
        position: Some(position[j].iter().map(|q| q - model.encoder_offset[j]).collect()),
        velocity: Some(velocity[j].clone()),
        acceleration: Some(vec![0.0; position[j].len()]),
        ..JointChannels::new(&joint.name)
    });
    let time_s = (0..position[0].len()).map(|k| k as f64 / rate_hz).collect();
    let motion = Recording::new("motion of the observer", time_s, joints.collect())?;
    Ok(held.predict(&motion, None)?.efforts)
}

fn momentum(arm: &RigidArm, rotor: &[f64], q: &[f64], v: &[f64]) -> Vec<f64> {
    let product = inertia_matrix(arm, q) * DVector::from_column_slice(v);
    product.iter().zip(rotor).zip(v).map(|((p, rotor), v)| p + rotor * v).collect()
}

/// Rate of the inertia matrix along the motion, times the velocity.
fn momentum_rate(arm: &RigidArm, q: &[f64], v: &[f64]) -> Vec<f64> {
    let moved =
        |step_s: f64| -> Vec<f64> { q.iter().zip(v).map(|(q, v)| q + step_s * v).collect() };
    let ahead = inertia_matrix(arm, &moved(STEP_S));
    let rate = (ahead - inertia_matrix(arm, &moved(-STEP_S))) / (2.0 * STEP_S);
    (rate * DVector::from_column_slice(v)).iter().copied().collect()
}

impl AlarmThresholds {
    /// For a rate of the whole arm, from recordings without contact. At each speed a joint has a scale, the 95 % quantile of its
    /// residuals; the level of the largest residual in its scale is that which the arm exceeds at the rate.
    ///
    /// # Errors
    /// [`ThresholdError`].
    pub fn of(
        model: &ArmModel,
        recordings: &[Recording],
        false_alarms_per_hour: f64,
        gain: f64,
    ) -> Result<Self, ThresholdError> {
        let residuals: Vec<ObserverResidual> = recordings
            .iter()
            .map(|recording| ObserverResidual::of(model, recording, gain))
            .collect::<Result<_, _>>()?;
        let seconds: f64 = residuals.iter().map(|r| r.samples() as f64 / r.rate_hz).sum();
        let too_short = ThresholdError::TooShort { seconds };
        let Some(rate_hz) = residuals.first().map(|residual| residual.rate_hz) else {
            return Err(too_short);
        };
        let mut joints: Vec<JointThresholds> = (model.chain.joint_names().into_iter().enumerate())
            .map(|(j, name)| scales(j, name, &residuals))
            .collect();
        let levels: Vec<Vec<f64>> =
            residuals.iter().map(|residual| in_scales(residual, &joints)).collect();
        let series: Vec<&[f64]> = levels.iter().map(Vec::as_slice).collect();
        let apart = apart(rate_hz);
        let rate = false_alarms_per_hour / 3600.0 / rate_hz;
        let tail = Tail::of(&series, apart, rate).ok_or(too_short)?;
        let level = tail.level(rate);
        for joint in &mut joints {
            joint.detectable = joint.threshold.iter().map(|scale| scale * (level + 1.0)).collect();
            joint.threshold.iter_mut().for_each(|scale| *scale *= level);
        }
        let alarms = episodes(&series, level, apart).len();
        let hours = seconds / 3600.0;
        Ok(Self {
            false_alarms_per_hour,
            gain,
            rate_hz,
            joints,
            observed: ObservedAlarms { alarms, hours, per_hour: alarms as f64 / hours },
            expected_alarms: false_alarms_per_hour * hours,
            shape: tail.shape,
        })
    }

    /// Alarms in other recordings without contact.
    ///
    /// # Errors
    /// [`ThresholdError`].
    pub fn observed_on(
        &self,
        model: &ArmModel,
        recordings: &[Recording],
    ) -> Result<ObservedAlarms, ThresholdError> {
        let (mut alarms, mut seconds) = (0, 0.0);
        for recording in recordings {
            let residual = ObserverResidual::of(model, recording, self.gain)?;
            let levels = in_scales(&residual, &self.joints);
            alarms += episodes(&[&levels], 1.0, apart(residual.rate_hz)).len();
            seconds += residual.samples() as f64 / residual.rate_hz;
        }
        let hours = seconds / 3600.0;
        Ok(ObservedAlarms { alarms, hours, per_hour: alarms as f64 / hours })
    }
}

/// Samples of one alarm.
fn apart(rate_hz: f64) -> usize {
    (ALARM_S * rate_hz).ceil() as usize
}

/// Speeds of a joint, each with the 95 % quantile of the residuals near it as its threshold.
fn scales(joint: usize, name: &str, residuals: &[ObserverResidual]) -> JointThresholds {
    let mut pairs: Vec<(f64, f64)> = residuals
        .iter()
        .flat_map(|of| of.speed[joint].iter().zip(&of.residual[joint]))
        .map(|(speed, residual)| (*speed, residual.abs()))
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut speed, mut threshold): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for part in pairs.chunks(pairs.len().div_ceil(SPEEDS).max(1)) {
        let mut sizes: Vec<f64> = part.iter().map(|pair| pair.1).collect();
        sizes.sort_by(f64::total_cmp);
        let middle = part[part.len() / 2].0;
        let size = sizes[((sizes.len() - 1) as f64 * SCALE_SHARE) as usize];
        // a joint that rests has one speed
        match (speed.last(), threshold.last_mut()) {
            (Some(before), Some(known)) if middle <= *before => *known = size.max(*known),
            _ => {
                speed.push(middle);
                threshold.push(size);
            }
        }
    }
    let largest = threshold.iter().fold(0.0_f64, |m, x| m.max(*x));
    let least = (LEAST_SCALE * largest).max(f64::MIN_POSITIVE);
    threshold.iter_mut().for_each(|size| *size = size.max(least));
    JointThresholds { joint: name.to_owned(), speed, threshold, detectable: Vec::new() }
}

/// The largest residual of all joints at each sample, in thresholds.
fn in_scales(of: &ObserverResidual, joints: &[JointThresholds]) -> Vec<f64> {
    let at = |k: usize| {
        let sizes = joints
            .iter()
            .enumerate()
            .map(|(j, joint)| of.residual[j][k].abs() / joint.at(of.speed[j][k]));
        sizes.fold(0.0, f64::max)
    };
    (0..of.samples()).map(at).collect()
}
