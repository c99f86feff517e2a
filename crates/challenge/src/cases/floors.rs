//! What is reachable on a recording, from nothing but noise to a careful user.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_motion::{DerivativeSource, Motion, MotionSettings};
use armident_recording::Recording;
use armident_simulation::{SimulatedArm, Trajectory, inverse};

use crate::cases::exact_motion::{Exact, rms};
use crate::contract::truth::{EDGE_S, Floors, PerJoint};
use crate::error::ChallengeError;

/// Cut-offs that are tried \[Hz\]; the best counts for each joint.
const CUTOFFS_HZ: [f64; 6] = [6.0, 10.0, 16.0, 25.0, 40.0, 60.0];
/// Speeds that count as rest, over the RMS speed; the best counts for each joint.
const RESTING_SHARES: [f64; 3] = [0.0, 0.005, 0.02];
/// Largest cut-off over the sample rate.
const HIGHEST_SHARE: f64 = 0.4;

/// A recording with the motion that it was taken of.
pub(crate) struct Taken<'a> {
    pub(crate) exact: &'a Exact,
    pub(crate) recorded: &'a Recording,
    /// Samples that are judged.
    judged: Vec<usize>,
    /// Samples away from the ends, where a filter of the position has both sides.
    inside: Vec<usize>,
}

impl<'a> Taken<'a> {
    /// A recording that is judged as a whole, or without its ends.
    pub(crate) fn new(exact: &'a Exact, recorded: &'a Recording, whole: bool) -> Self {
        let time_s = &exact.time_s;
        let (first, last) = (time_s[0] + EDGE_S, time_s[time_s.len() - 1] - EDGE_S);
        let inside: Vec<usize> =
            (0..time_s.len()).filter(|&k| (first..=last).contains(&time_s[k])).collect();
        let judged = if whole { (0..time_s.len()).collect() } else { inside.clone() };
        Self { exact, recorded, judged, inside }
    }

    /// RMS of the recorded effort minus that of an arm on the true motion, by joint.
    pub(crate) fn rmse_of(&self, given: &RigidArm, names: &[String]) -> PerJoint {
        let Exact { position, velocity, acceleration, .. } = self.exact;
        let effort = inverse_dynamics_of_motion(given, position, velocity, acceleration);
        names.iter().cloned().zip(self.rmse(names, &effort, &self.judged)).collect()
    }

    /// RMS of the recorded effort minus another, by joint.
    fn rmse(&self, names: &[String], effort: &[Vec<f64>], samples: &[usize]) -> Vec<f64> {
        (0..names.len())
            .map(|j| {
                let recorded = self.recorded.joints[j].effort.as_deref().unwrap_or_default();
                let square = |&k: &usize| (recorded[k] - effort[j][k]).powi(2);
                let sum: f64 = samples.iter().map(square).sum();
                (sum / samples.len().max(1) as f64).sqrt()
            })
            .collect()
    }
}

/// All floors of a recording. Those by the recorded position leave its ends out, where a low-pass
/// shows less of it.
pub(crate) fn floors(
    taken: &Taken<'_>,
    arm: &SimulatedArm,
    given: &RigidArm,
    names: &[String],
) -> Result<Floors, ChallengeError> {
    let Exact { position, velocity, acceleration, effort, .. } = taken.exact;
    let named = |values: Vec<f64>| -> PerJoint { names.iter().cloned().zip(values).collect() };
    let rigid_exact = inverse_dynamics_of_motion(arm.rigid(), position, velocity, acceleration);
    let endless = vec![f64::INFINITY; names.len()];
    let (mut practical, mut attainable) = (endless.clone(), endless.clone());
    let mut urdf_practical = endless;
    let rate_hz = taken.exact.time_s.len() as f64 / taken.exact.time_s.last().unwrap_or(&1.0);
    for cutoff_hz in CUTOFFS_HZ.into_iter().filter(|hz| *hz < HIGHEST_SHARE * rate_hz) {
        let settings = MotionSettings {
            cutoff_hz: Some(cutoff_hz),
            derivatives: DerivativeSource::FromPosition,
            ..MotionSettings::default()
        };
        let joints: Vec<&str> = names.iter().map(String::as_str).collect();
        let motion = Motion::from_recording(taken.recorded, &joints, &settings)?;
        let at_stamps = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            columns.iter().map(|column| motion.at_stamps(column)).collect()
        };
        let rigid = |arm: &RigidArm| {
            let (q, v, a) = (&motion.position, &motion.velocity, &motion.acceleration);
            at_stamps(&inverse_dynamics_of_motion(arm, q, v, a))
        };
        // the rest of the law on the true motion
        let mut careful = rigid(arm.rigid());
        for j in 0..names.len() {
            for (k, value) in careful[j].iter_mut().enumerate() {
                *value += effort[j][k] - rigid_exact[j][k];
            }
        }
        lower(&mut practical, taken.rmse(names, &careful, &taken.inside));
        lower(&mut urdf_practical, taken.rmse(names, &rigid(given), &taken.inside));
        // each share is an integration of links, whose floor does not depend on it
        let shares = if arm.has_transmissions() { &RESTING_SHARES[1..2] } else { &RESTING_SHARES };
        for &share in shares {
            let trajectory = Trajectory {
                joints: names.to_vec(),
                time_s: motion.time_s.clone(),
                position: motion.position.clone(),
                velocity: motion.velocity.iter().map(|v| at_rest_below(share, v)).collect(),
                acceleration: motion.acceleration.clone(),
                source: String::new(),
                notes: Vec::new(),
            };
            let lawful = inverse(arm, &trajectory)?;
            let lawful: Vec<Vec<f64>> = lawful
                .joints
                .iter()
                .map(|joint| joint.effort.clone().unwrap_or_default())
                .collect();
            lower(&mut attainable, taken.rmse(names, &at_stamps(&lawful), &taken.inside));
        }
    }
    Ok(Floors {
        oracle_rmse: named(taken.rmse(names, effort, &taken.judged)),
        practical_rmse: named(practical),
        attainable_rmse: named(attainable),
        urdf_rmse: taken.rmse_of(given, names),
        urdf_rmse_practical: named(urdf_practical),
    })
}

/// Velocities without those below a share of their RMS: noise of resting joints has no direction.
fn at_rest_below(share: f64, velocity: &[f64]) -> Vec<f64> {
    let least = share * rms(velocity);
    velocity.iter().map(|v| if v.abs() < least { 0.0 } else { *v }).collect()
}

fn lower(best: &mut [f64], found: Vec<f64>) {
    best.iter_mut().zip(found).for_each(|(best, found)| *best = best.min(found));
}
