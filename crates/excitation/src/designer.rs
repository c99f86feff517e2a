//! Motions of the parts: searched or made of moves, inside all limits, sampled.

use armident_recording::{JointChannels, Recording, RecordingError};

use crate::clearance::{Clearance, Nearest};
use crate::error::ExcitationError;
use crate::information::{Columns, Parameters};
use crate::limits::MotionLimits;
use crate::moves::{Moves, Path};
use crate::part::{Part, Split};
use crate::search::{FourierMotion, Search, effort_ratio};

/// Frequency of the fastest wave of the training motion and of the fast one \[Hz\]: links turn back in about a second, and
/// at the pace of a fast pick.
const HIGHEST_HZ: [f64; 2] = [0.6, 1.5];
/// Fewest and most waves of a joint.
pub(crate) const HARMONICS: [usize; 2] = [5, 16];
/// Speed of a rehearsal over that of the motion.
pub(crate) const REHEARSAL: f64 = 0.2;
/// How far moves go about the free pose, the first that is clear.
const REACHES: [f64; 6] = [1.0, 0.7, 0.45, 0.25, 0.12, 0.05];
/// Step of the check for contacts before intervals are halved \[s\].
const CONTACT_STEP_S: f64 = 0.05;

/// One motion of the suite.
#[derive(Debug, Clone)]
pub struct SuiteMotion {
    /// Name of its file.
    pub name: String,
    /// What it is for.
    pub purpose: &'static str,
    /// Whether a fit uses it.
    pub split: Split,
    /// The part; rehearsals have that of their motion.
    pub part: Part,
    /// Whether it is the slow rehearsal of the part.
    pub is_rehearsal: bool,
    /// Positions, velocities and accelerations of all joints.
    pub motion: Recording,
    /// Largest effort of the rigid body over what may be used of its limit, between samples too; and its joint.
    pub effort_share: (f64, String),
    /// Smallest distance of links from each other and from regions, between samples too \[m\]: a lower bound; none where
    /// nothing can touch.
    pub clearance_m: Option<f64>,
    /// Condition number of its regressor with columns of unit length.
    pub condition: f64,
}

/// A motion of waves, or one of moves.
pub(crate) enum Planned {
    Waves(FourierMotion),
    Moves(Path),
}

pub(crate) struct Designer<'a> {
    pub(crate) parameters: &'a Parameters<'a>,
    pub(crate) limits: &'a [MotionLimits],
    pub(crate) names: &'a [String],
    pub(crate) clearance: Option<&'a Clearance<'a>>,
    /// pose that is free, in which moves begin
    pub(crate) home: &'a [f64],
    pub(crate) seconds: f64,
    pub(crate) rate_hz: f64,
}

impl<'a> Designer<'a> {
    pub(crate) fn search(&self, part: Part) -> Search<'a> {
        let (period_s, harmonics) = period_and_waves(part, self.seconds);
        Search {
            parameters: self.parameters,
            limits: self.limits,
            names: self.names,
            clearance: self.clearance,
            home: self.home,
            period_s,
            harmonics,
        }
    }

    /// Median condition number of random motions as long as the training motion.
    pub(crate) fn random_condition(&self, seed: u64, count: u64) -> Result<f64, ExcitationError> {
        let search = self.search(Part::Train);
        let mut all = Vec::new();
        for k in 0..count {
            let motion = search.random_motion(seed.wrapping_add(7919 * (k + 1)));
            let columns = motion.columns(&times(motion.period_s, self.rate_hz));
            all.push(self.parameters.information(&columns).condition()?);
        }
        all.sort_by(f64::total_cmp);
        Ok(all[all.len() / 2])
    }

    /// The smallest distance on a path, or the contact.
    fn clear(&self, path: &Path) -> Result<Option<f64>, Nearest> {
        let Some(clearance) = self.clearance else { return Ok(None) };
        let most: Vec<f64> = self.limits.iter().map(|l| l.acceleration).collect();
        let state = |t: f64| {
            let [position, velocity, _] = path.state(t);
            [position, velocity]
        };
        clearance.along(path.duration_s, CONTACT_STEP_S, &most, state).map(Some)
    }

    /// A part of moves, as far about the free pose as is clear; the contact where none is.
    pub(crate) fn moves(&self, part: Part) -> Result<Path, Nearest> {
        let mut met = None;
        for reach in REACHES {
            let moves = Moves { limits: self.limits, home: self.home, reach };
            let path = match part {
                Part::StaticHolds => moves.holds(|path| self.clear(path).is_ok()),
                Part::FrictionLadder => moves.ladder(),
                _ => moves.reversals(),
            };
            match self.clear(&path) {
                Ok(_) => return Ok(path),
                Err(contact) => met = Some(contact),
            }
        }
        Err(met.unwrap_or(Nearest { distance_m: 0.0, names: [String::new(), String::new()] }))
    }

    /// The motion as a recording; none where the rigid body exceeds an effort limit.
    pub(crate) fn motion(
        &self,
        part: Part,
        is_rehearsal: bool,
        planned: &Planned,
    ) -> Result<Option<SuiteMotion>, ExcitationError> {
        let (time_s, columns) = match planned {
            Planned::Waves(waves) => {
                let time_s = times(waves.period_s, self.rate_hz);
                let columns = waves.columns(&time_s);
                (time_s, columns)
            }
            Planned::Moves(path) => sampled(path, self.rate_hz),
        };
        let (effort_share, clearance_m) = match planned {
            Planned::Waves(waves) => {
                let search = self.search(part);
                (search.effort_ratio(waves), search.clear(waves).ok().flatten())
            }
            Planned::Moves(path) => {
                const CHECKED_HZ: f64 = 500.0;
                let (time_s, columns) = sampled(path, CHECKED_HZ);
                let jerks: Vec<f64> = self.limits.iter().map(|l| l.jerk).collect();
                let effort = effort_ratio(self.parameters, self.limits, &time_s, &columns, &jerks);
                (effort, self.clear(path).ok().flatten())
            }
        };
        if effort_share.0 > 1.0 {
            return Ok(None);
        }
        let condition = self.parameters.information(&columns).condition()?;
        let name = match is_rehearsal {
            true => format!("{}_rehearsal", part.name()),
            false => part.name().to_owned(),
        };
        let names = self.names.iter().map(String::as_str);
        let motion = planned_recording(&name, names, time_s, columns)?;
        let (purpose, split) = match is_rehearsal {
            true => ("the same path at a fifth of the speed: watch for collisions", Split::Neither),
            false => (part.purpose(), part.split()),
        };
        let effort_share = (effort_share.0, self.names[effort_share.1].clone());
        Ok(Some(SuiteMotion {
            name,
            purpose,
            split,
            part,
            is_rehearsal,
            motion,
            effort_share,
            clearance_m,
            condition,
        }))
    }
}

/// Length of the motion of a part \[s\] and its waves, for a length of the training motion.
pub(crate) fn period_and_waves(part: Part, seconds: f64) -> (f64, usize) {
    // the fast motion repeats the pace of half the length; a validation has other frequencies
    let (period_s, highest_hz) = match part {
        Part::Fast => (0.5 * seconds, HIGHEST_HZ[1]),
        Part::Validation => (0.8 * seconds, HIGHEST_HZ[0]),
        _ => (seconds, HIGHEST_HZ[0]),
    };
    let waves = (highest_hz * period_s).round() as usize;
    (period_s, waves.clamp(HARMONICS[0], HARMONICS[1]))
}

/// Positions, velocities and accelerations of joints as a recording.
pub(crate) fn planned_recording<'a>(
    name: &str,
    joints: impl Iterator<Item = &'a str>,
    time_s: Vec<f64>,
    [q, v, a]: Columns,
) -> Result<Recording, RecordingError> {
    let joints = joints
        .zip(q.into_iter().zip(v.into_iter().zip(a)))
        .map(|(name, (position, (velocity, acceleration)))| JointChannels {
            position: Some(position),
            velocity: Some(velocity),
            acceleration: Some(acceleration),
            ..JointChannels::new(name)
        })
        .collect();
    Recording::new(name, time_s, joints)
}

fn sampled(path: &Path, rate_hz: f64) -> (Vec<f64>, Columns) {
    let time_s = times(path.duration_s, rate_hz);
    let columns = path.columns(&time_s);
    (time_s, columns)
}

/// Even times from zero to the end.
pub(crate) fn times(end_s: f64, rate_hz: f64) -> Vec<f64> {
    let steps = (end_s * rate_hz).round().max(1.0) as usize;
    (0..=steps).map(|k| k as f64 / rate_hz).collect()
}
