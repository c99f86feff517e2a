//! Recordings with currents instead of efforts: the drive gains, and the efforts that they give.

use armident_motion::Motion;
use armident_recording::{Quantity, Recording};

use super::error::IdentifyError;
use super::motions::motions_with_effort;
use super::request::IdentifyRequest;
use crate::calibration::{DriveGain, DriveGains};
use crate::regression::BatchProblem;

/// Recordings with efforts in all joints.
#[derive(Debug, Clone)]
pub(super) struct Converted {
    pub(super) gains: DriveGains,
    pub(super) train: Vec<Recording>,
    pub(super) holdout: Vec<Recording>,
}

/// Efforts that a known load requires over the recorded ones, and the relative standard error; none without a load, or
/// where currents are recorded.
pub(super) fn efforts_of_known_load(
    problem: &BatchProblem,
    request: &IdentifyRequest<'_>,
    joints: &[&str],
    cutoff_hz: Option<f64>,
) -> Result<Option<(f64, f64)>, IdentifyError> {
    if request.loads.iter().all(|load| load.mass_kg == 0.0) {
        return Ok(None);
    }
    let motions = motions_with_effort(request.train, joints, cutoff_hz)?;
    let motions: Vec<Motion> = motions.into_iter().map(Motion::thinned).collect();
    let motions: Vec<&Motion> = motions.iter().collect();
    let mut problem = problem.clone();
    problem.choose_reversal_speeds(&motions)?;
    Ok(problem.drive_gains(&motions, &vec![true; joints.len()], request.loads)?.common())
}

/// Where joints have currents only: the drive gains, and the recordings with efforts. None where all joints have efforts.
///
/// The reversal speeds of `problem` are chosen on the way.
pub(super) fn efforts_of_currents(
    problem: &mut BatchProblem,
    request: &IdentifyRequest<'_>,
    joints: &[&str],
    cutoff_hz: Option<f64>,
) -> Result<Option<Converted>, IdentifyError> {
    let IdentifyRequest { train, holdout, loads, .. } = *request;
    let current_only = |recording: &Recording, joint: &str| {
        recording.joint(joint).is_some_and(|channels| {
            channels.channel(Quantity::Effort).is_none()
                && channels.channel(Quantity::Current).is_some()
        })
    };
    let is_current: Vec<bool> =
        joints.iter().map(|joint| train.iter().any(|r| current_only(r, joint))).collect();
    if !is_current.contains(&true) {
        return Ok(None);
    }
    for recording in train.iter().chain(holdout) {
        for (joint, is_current) in joints.iter().zip(&is_current) {
            let has = recording.joint(joint).is_some_and(|channels| channels.effort.is_some());
            if *is_current && has {
                return Err(IdentifyError::MixedChannels {
                    source_name: recording.source.clone(),
                    joint: (*joint).to_owned(),
                });
            }
        }
    }
    let fill = |recordings: &mut [Recording], gain: &dyn Fn(usize) -> f64| {
        for recording in recordings {
            for (j, name) in joints.iter().enumerate().filter(|(j, _)| is_current[*j]) {
                let Some(channels) = recording.joints.iter_mut().find(|c| c.name == *name) else {
                    continue;
                };
                let current = channels.channel(Quantity::Current);
                let effort = current.map(|c| c.iter().map(|i| gain(j) * i).collect());
                *channels.channel_mut(Quantity::Effort) = effort;
            }
        }
    };
    let (mut train, mut holdout) = (train.to_vec(), holdout.to_vec());
    fill(&mut train, &|_| 1.0);
    let motions: Vec<Motion> =
        motions_with_effort(&train, joints, cutoff_hz)?.into_iter().map(Motion::thinned).collect();
    let motions: Vec<&Motion> = motions.iter().collect();
    problem.choose_reversal_speeds(&motions)?;
    // a known load tells more than what an earlier fit has left
    let kept = request.model.drive_gains.as_ref().filter(|_| loads.is_empty());
    let gains = match kept.and_then(|known| DriveGains::of_model(known, joints, &is_current)) {
        Some(gains) => gains,
        None => problem.drive_gains(&motions, &is_current, loads)?,
    };
    let undetermined: Vec<String> = (joints.iter().zip(&gains.joints))
        .filter(|(_, gain)| gain.is_some_and(|gain| !gain.is_determined()))
        .map(|(joint, _)| (*joint).to_owned())
        .collect();
    if !undetermined.is_empty() {
        return Err(IdentifyError::GainsNotDetermined {
            sources: train.iter().map(|r| r.source.clone()).collect(),
            joints: undetermined,
        });
    }
    let of_joint = |j: usize| {
        gains.joints[j].map_or(1.0, |gain: DriveGain| gain.value * gains.scale_of_description)
    };
    fill(&mut train, &of_joint);
    fill(&mut holdout, &of_joint);
    Ok(Some(Converted { gains, train, holdout }))
}
