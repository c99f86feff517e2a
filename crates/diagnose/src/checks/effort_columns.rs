//! Input checks: a column in another unit, of another joint or with another sign is no physics.

use armident_dynamics::inverse_dynamics_of_motion;
use armident_ident::checks::{
    ChannelEvidence, ChannelKind, Check, EffortClock, EffortLowPass, LinkLength, LowPassOrDelay,
    Topic, Verdict, check, with_drive_signals,
};
use armident_model::ArmModel;
use armident_motion::{BAND_HZ, Motion, MotionSettings, common_cutoff_hz};
use armident_recording::{Quantity, Recording};
use serde::Serialize;

use crate::checks::usable::{Unusable, usable_signals, without_constant_efforts};

/// Gain of a joint whose effort is recorded as a current or voltage only.
#[derive(Debug, Clone, Serialize)]
pub struct InferredDriveGain {
    /// Joint.
    pub joint: String,
    /// What was recorded: `current` or `voltage`.
    pub quantity: &'static str,
    /// Effort over what was recorded \[N m/A, N/A, N m/V or N/V\], by the masses of the given arm.
    pub gain: f64,
    /// Its 95 % interval.
    pub interval_95: [f64; 2],
    /// Whether the recordings determine it at all: an interval of less than a factor of ten. Without it
    /// nothing is reported about the joint.
    pub determined: bool,
    /// Whether the model knew it; else it follows from the masses of the given arm.
    pub of_model: bool,
}

/// A probability that excludes chance.
const SURE: f64 = 0.99;
/// Share of the believed effort that must be gravity for a gain to be distinguished from an inertia.
const GRAVITY_SHARE: f64 = 0.5;
/// Ends of an interval whose ratio is larger mean nothing.
const NOT_DETERMINED: f64 = 10.0;

impl InferredDriveGain {
    /// Relative standard error.
    pub fn relative_stderr(&self) -> f64 {
        (self.interval_95[1] / self.interval_95[0]).abs().ln().abs() / (2.0 * 1.96)
    }
}

/// Whether the effort columns of recordings are what their headers state.
#[derive(Debug, Clone, Default)]
pub struct InputChecks {
    /// Columns that are wrong beyond a thousand to one, with what to do.
    pub faults: Vec<Check>,
    /// Joints of which only a drive signal is recorded.
    pub drive_gains: Vec<InferredDriveGain>,
    /// The low-pass through which the efforts are reported; none where there is none.
    pub effort_low_pass: Option<EffortLowPass>,
    /// The clock of the efforts; none where it is that of the positions.
    pub effort_clock: Option<EffortClock>,
    /// A low-pass that explains late efforts as well as a delay.
    pub low_pass_or_delay: Option<LowPassOrDelay>,
    /// A distance between two axes that is not the given one; none where there is none.
    pub link_length: Option<LinkLength>,
    /// Why nothing was checked.
    pub unchecked: Option<String>,
    /// Whether a fault is of the arm as a whole: gravity, or joints that are exchanged or mirrored. Nothing that is fitted to
    /// such recordings means anything.
    pub of_arm: bool,
}

impl InputChecks {
    /// Checks the effort columns of recordings against an arm ([`armident_ident::checks`]).
    ///
    /// # Errors
    /// Recordings that a diagnosis refuses.
    pub fn of(model: &ArmModel, recordings: &[Recording]) -> Result<Self, Unusable> {
        let (filled, signals) = with_drive_signals(recordings);
        let joints = model.chain.joint_names();
        let joints_of_model: Vec<String> = joints.iter().map(ToString::to_string).collect();
        let measured: Vec<Recording> =
            filled.iter().map(|r| without_constant_efforts(r, &filled)).collect();
        usable_signals(&joints_of_model, &measured, BAND_HZ)?;
        let cutoff_hz = common_cutoff_hz(&filled, &joints, model.cutoff_hz)?;
        let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
        let motions: Vec<Motion> = filled
            .iter()
            .map(|recording| Motion::from_recording(recording, &joints, &settings))
            .collect::<Result<_, _>>()?;
        if motions.iter().any(|m| m.effort.is_none()) {
            let without: Vec<&str> = joints
                .into_iter()
                .filter(|j| filled.iter().any(|r| r.joint(j).is_none_or(|c| c.effort.is_none())))
                .collect();
            return Ok(Self {
                unchecked: Some(format!("no effort of {} is recorded", without.join(", "))),
                ..Self::default()
            });
        }
        let found = match check(model, &filled, &motions, &signals) {
            Ok(found) => found,
            Err(error) => {
                return Ok(Self { unchecked: Some(error.to_string()), ..Self::default() });
            }
        };
        // a log has its gravity taken off as a whole: where one joint clearly has it, another that seems not to
        // has something else
        let kind = |c: &ChannelEvidence, kind: ChannelKind| {
            ChannelKind::ALL.iter().position(|k| *k == kind).map_or(0.0, |k| c.probability[k])
        };
        let gravity_is_there = found.channels.iter().any(|c| {
            kind(c, ChannelKind::JointEffort) > SURE
                && kind(c, ChannelKind::WithoutGravity) < 1.0 - SURE
        });
        let seems_without_gravity = |name: &str| {
            let place = joints_of_model.iter().position(|j| j == name);
            place.is_some_and(|j| kind(&found.channels[j], ChannelKind::WithoutGravity) > 0.5)
        };
        // a gain that only inertia shows may be the inertia of a rotor
        let of_gravity = gravity_deviation(model, &motions);
        let only_inertia = |name: &str| {
            joints_of_model.iter().position(|j| j == name).is_some_and(|j| {
                let gains = [ChannelKind::OtherGain, ChannelKind::OtherGainFlipped];
                let is_gain = gains.iter().map(|k| kind(&found.channels[j], *k)).sum::<f64>() > 0.5;
                is_gain && of_gravity[j] < GRAVITY_SHARE * found.channels[j].urdf_sd
            })
        };
        let of_columns = |c: &Check| {
            let joint = c.joint.as_deref();
            let drive_signal = joint.is_some_and(|j| signals.contains_key(j));
            let by_physics = joint.is_some_and(only_inertia)
                || (gravity_is_there && joint.is_some_and(seems_without_gravity));
            c.verdict == Verdict::Wrong
                && match c.topic {
                    // a current is a multiple of the effort, and that is no fault
                    Topic::Channel => !drive_signal && !by_physics,
                    Topic::Order => !by_physics,
                    Topic::Quality | Topic::Gravity | Topic::JointSign => true,
                    _ => false,
                }
        };
        let gain = |(joint, channel): (&&str, &ChannelEvidence)| {
            let quantity = signals.get(*joint)?;
            let quantity = if *quantity == Quantity::Current { "current" } else { "voltage" };
            // known from a load: that the masses here indicate another gain is for the diagnosis to explain
            let known = model.drive_gains.as_ref().filter(|_| quantity == "current");
            let known = known.and_then(|gains| gains.of(joint).zip(gains.interval_95(joint)));
            if let Some(((gain, _), interval_95)) = known {
                return Some(InferredDriveGain {
                    joint: (*joint).to_owned(),
                    quantity,
                    gain,
                    interval_95,
                    determined: true,
                    of_model: true,
                });
            }
            let [low, high] = channel.gain_95.map(|g| 1.0 / g);
            Some(InferredDriveGain {
                joint: (*joint).to_owned(),
                quantity,
                gain: 1.0 / channel.gain,
                interval_95: [low.min(high), low.max(high)],
                determined: (low / high).abs().ln().abs() < NOT_DETERMINED.ln(),
                of_model: false,
            })
        };
        let of_arm = found.checks.iter().any(|c| {
            c.verdict == Verdict::Wrong && matches!(c.topic, Topic::Gravity | Topic::JointSign)
        }) || !found.recorded_as.is_sorted();
        Ok(Self {
            of_arm,
            drive_gains: model
                .chain
                .joint_names()
                .iter()
                .zip(&found.channels)
                .filter_map(gain)
                .collect(),
            faults: found.checks.into_iter().filter(of_columns).collect(),
            effort_low_pass: found.effort_low_pass,
            effort_clock: found.effort_clock,
            low_pass_or_delay: found.low_pass_or_delay,
            link_length: found.link_length,
            unchecked: None,
        })
    }

    /// The recording without the efforts of joints whose columns are wrong, so that the others can be
    /// diagnosed; none where a fault is of the robot as a whole, or half the joints are at fault.
    pub(crate) fn without_faulty(&self, recording: &Recording, joints: usize) -> Option<Recording> {
        let mut faulty: Vec<&String> = Vec::new();
        for fault in &self.faults {
            let joint = fault.joint.as_ref()?;
            if !faulty.contains(&joint) {
                faulty.push(joint);
            }
        }
        if 2 * faulty.len() >= joints {
            return None;
        }
        let mut kept = recording.clone();
        for joint in kept.joints.iter_mut().filter(|j| faulty.contains(&&j.name)) {
            joint.effort = None;
        }
        Some(kept)
    }

    /// A recording with efforts in the place of currents and voltages, where gains are determined.
    pub fn in_effort(&self, recording: &Recording) -> Recording {
        let mut converted = recording.clone();
        for joint in &mut converted.joints {
            let Some(gain) = self.drive_gains.iter().find(|g| g.joint == joint.name) else {
                continue;
            };
            let signal = [Quantity::Current, Quantity::Voltage]
                .into_iter()
                .find_map(|quantity| joint.channel(quantity).map(<[f64]>::to_vec));
            if joint.effort.is_none() && gain.determined {
                joint.effort = signal.map(|values| values.iter().map(|x| x * gain.gain).collect());
            }
        }
        converted
    }
}

/// Standard deviation of the believed effort of gravity on every joint.
fn gravity_deviation(model: &ArmModel, motions: &[Motion]) -> Vec<f64> {
    let arm = model.rigid_arm();
    let n = arm.dof();
    let mut efforts: Vec<Vec<f64>> = vec![Vec::new(); n];
    for motion in motions {
        let rest = vec![vec![0.0; motion.len()]; n];
        let effort = inverse_dynamics_of_motion(&arm, &motion.position, &rest, &rest);
        for (all, effort) in efforts.iter_mut().zip(effort) {
            all.extend(effort);
        }
    }
    efforts
        .iter()
        .map(|effort| {
            let count = effort.len().max(1) as f64;
            let mean = effort.iter().sum::<f64>() / count;
            (effort.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt()
        })
        .collect()
}
