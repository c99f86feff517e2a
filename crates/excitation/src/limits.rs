//! What a motion must keep to.

use std::collections::BTreeMap;

use armident_kinematics::DrivingAxisChain;
use serde::{Deserialize, Serialize};

use crate::error::ExcitationError;

/// Range of a joint without position limits, to either side of its zero \[rad or m\].
const FREE_RANGE: f64 = 1.5;
/// Speed of a joint without a speed limit \[rad/s or m/s\].
const FREE_SPEED: f64 = 1.0;
/// A joint without an acceleration limit reaches its largest speed in this time \[s\].
const TO_SPEED_S: f64 = 0.5;
/// A joint without a jerk limit reaches its largest acceleration in this time \[s\].
const TO_ACCELERATION_S: f64 = 0.1;
/// Share of position range and speed that is used: a controller needs the rest.
const SHARE: f64 = 0.9;
/// Share of the effort limit: the model of the rigid body lacks friction, and may be wrong.
const SHARE_OF_EFFORT: f64 = 0.8;
/// Effort noise of a joint over its effort limit, where none is given.
const NOISE_SHARE: f64 = 0.01;

/// Limits of a joint, as a user gives them; what is absent is that of the URDF.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenLimits {
    /// Lowest position \[rad or m\].
    pub lower: Option<f64>,
    /// Highest position \[rad or m\].
    pub upper: Option<f64>,
    /// Largest speed \[rad/s or m/s\].
    pub velocity: Option<f64>,
    /// Largest acceleration \[rad/s² or m/s²\].
    pub acceleration: Option<f64>,
    /// Largest jerk \[rad/s³ or m/s³\].
    pub jerk: Option<f64>,
    /// Largest effort \[N m or N\].
    pub effort: Option<f64>,
    /// Standard deviation of one recorded effort \[N m or N\].
    pub noise: Option<f64>,
}

/// What the motion of one joint keeps to: already the share that is used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotionLimits {
    /// Lowest position \[rad or m\].
    pub lower: f64,
    /// Highest position \[rad or m\].
    pub upper: f64,
    /// Largest speed \[rad/s or m/s\].
    pub velocity: f64,
    /// Largest acceleration \[rad/s² or m/s²\].
    pub acceleration: f64,
    /// Largest jerk \[rad/s³ or m/s³\].
    pub jerk: f64,
    /// Largest effort \[N m or N\]; none where neither the URDF nor the user gives one.
    pub effort: Option<f64>,
    /// Standard deviation of one recorded effort \[N m or N\]; none where it is a share of the motion's effort.
    pub noise: Option<f64>,
}

impl MotionLimits {
    /// Middle of the range.
    pub fn middle(&self) -> f64 {
        0.5 * (self.lower + self.upper)
    }

    /// Width of the range.
    pub fn range(&self) -> f64 {
        self.upper - self.lower
    }
}

/// Limits of all joints: those of the user, those of the URDF, or stated defaults (in the notes).
///
/// # Errors
/// A joint that the chain does not have; a limit that is not a positive finite number; no range.
pub(crate) fn motion_limits(
    chain: &DrivingAxisChain,
    given: &BTreeMap<String, GivenLimits>,
) -> Result<(Vec<MotionLimits>, Vec<String>), ExcitationError> {
    let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
    if let Some(joint) = given.keys().find(|joint| !names.contains(joint)) {
        return Err(ExcitationError::UnknownJoint { joint: joint.clone(), known: names });
    }
    let mut free = [Vec::new(), Vec::new()];
    let mut limits = Vec::new();
    for joint in &chain.joints {
        let given = given.get(&joint.name).copied().unwrap_or_default();
        let fault = |limit: &'static str, value: f64, expected: &'static str| {
            let joint = joint.name.clone();
            Err(ExcitationError::Limit { joint, limit, value, expected })
        };
        for (limit, value) in [
            ("velocity", given.velocity),
            ("acceleration", given.acceleration),
            ("jerk", given.jerk),
            ("effort", given.effort),
            ("noise", given.noise),
        ] {
            if let Some(value) = value.filter(|x| !(x.is_finite() && *x > 0.0)) {
                return fault(limit, value, "a positive finite number");
            }
        }
        for (limit, value) in [("lower", given.lower), ("upper", given.upper)] {
            if let Some(value) = value.filter(|x| !x.is_finite()) {
                return fault(limit, value, "a finite number");
            }
        }
        let of_urdf = joint.limits;
        let (mut lower, mut upper) = match (of_urdf.lower, of_urdf.upper) {
            (Some(low), Some(high)) if high > low => (low, high),
            _ => {
                if given.lower.is_none() || given.upper.is_none() {
                    free[0].push(joint.name.clone());
                }
                (-FREE_RANGE, FREE_RANGE)
            }
        };
        lower = given.lower.unwrap_or(lower);
        upper = given.upper.unwrap_or(upper);
        if upper <= lower {
            return fault("upper", upper, "more than the lower limit");
        }
        let margin = 0.5 * (1.0 - SHARE) * (upper - lower);
        let velocity =
            given.velocity.or(of_urdf.velocity.filter(|v| *v > 0.0)).unwrap_or_else(|| {
                free[1].push(joint.name.clone());
                FREE_SPEED
            });
        let acceleration = given.acceleration.unwrap_or(velocity / TO_SPEED_S);
        let jerk = given.jerk.unwrap_or(acceleration / TO_ACCELERATION_S);
        let effort = given.effort.or(of_urdf.effort.filter(|e| *e > 0.0));
        limits.push(MotionLimits {
            lower: lower + margin,
            upper: upper - margin,
            velocity: SHARE * velocity,
            acceleration: SHARE * acceleration,
            jerk: SHARE * jerk,
            effort: effort.map(|e| SHARE_OF_EFFORT * e),
            noise: given.noise.or(effort.map(|e| NOISE_SHARE * e)),
        });
    }
    let mut notes = vec![format!(
        "used of the limits: {:.0} % of range and speed, {:.0} % of effort",
        100.0 * SHARE,
        100.0 * SHARE_OF_EFFORT
    )];
    let [no_range, no_speed] = free;
    if !no_range.is_empty() {
        notes.push(format!(
            "no position limits in the URDF: -{FREE_RANGE} to {FREE_RANGE} is used on {}",
            no_range.join(", ")
        ));
    }
    if !no_speed.is_empty() {
        notes.push(format!(
            "no speed limit in the URDF: {FREE_SPEED} is used on {}",
            no_speed.join(", ")
        ));
    }
    Ok((limits, notes))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::test_arms::chain;

    fn of(joint: &str, limits: GivenLimits) -> BTreeMap<String, GivenLimits> {
        BTreeMap::from([(joint.to_owned(), limits)])
    }

    #[test]
    fn given_limits_go_before_those_of_the_urdf() {
        let chain = chain();
        let name = chain.joints[0].name.clone();
        let given = GivenLimits { velocity: Some(0.5), ..GivenLimits::default() };
        let (limits, _) = motion_limits(&chain, &of(&name, given)).unwrap();
        assert_eq!(limits[0].velocity, SHARE * 0.5);
        let (before, _) = motion_limits(&chain, &BTreeMap::new()).unwrap();
        assert_eq!(limits[1..], before[1..]);
    }

    #[test]
    fn impossible_limits_are_refused() {
        let chain = chain();
        let name = chain.joints[0].name.clone();
        let wrong = [
            GivenLimits { velocity: Some(-1.0), ..GivenLimits::default() },
            GivenLimits { effort: Some(f64::NAN), ..GivenLimits::default() },
            GivenLimits { lower: Some(1.0), upper: Some(0.5), ..GivenLimits::default() },
        ];
        for given in wrong {
            assert!(motion_limits(&chain, &of(&name, given)).is_err(), "{given:?}");
        }
        assert!(motion_limits(&chain, &of("elbow_of_another", GivenLimits::default())).is_err());
    }
}
