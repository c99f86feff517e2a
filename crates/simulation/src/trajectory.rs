//! The motion that an arm is asked for.

use std::collections::BTreeMap;

use armident_motion::{EvenGrid, differentiate};
use armident_recording::{
    BRIDGED_STEPS, Interpolation, JointChannels, MIN_SAMPLES, Quantity, Recording, Timing,
};

use crate::error::SimulationError;

/// Most samples of a resampled trajectory or a simulated recording.
pub const MOST_SAMPLES: usize = 20_000_000;

/// Position, velocity and acceleration of the joints of a chain. Columns are joint-major:
/// `position[joint][sample]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Joint names from base to tip.
    pub joints: Vec<String>,
    /// Time stamps \[s\], strictly increasing.
    pub time_s: Vec<f64>,
    /// Position \[rad or m\].
    pub position: Vec<Vec<f64>>,
    /// Velocity \[rad/s or m/s\].
    pub velocity: Vec<Vec<f64>>,
    /// Acceleration \[rad/s2 or m/s2\].
    pub acceleration: Vec<Vec<f64>>,
    /// Where it comes from.
    pub source: String,
    /// Notes of the recording and what was chosen here, one sentence each.
    pub notes: Vec<String>,
}

impl Trajectory {
    /// The motion of `joints` in a recording; joints in `held` stay at the given position.
    ///
    /// Recorded velocities and accelerations are taken as they are. A velocity that is not
    /// recorded is the derivative of the position, an acceleration that is not recorded the
    /// derivative of the velocity, by differences of fourth order without a filter: right for
    /// planned motions, wrong for measured ones. Uneven stamps are kept if nothing is derived, else
    /// everything is brought to an even grid.
    ///
    /// # Errors
    /// An inconsistent recording, mostly gaps, a joint that is neither recorded nor held, a held
    /// joint that is recorded, that is not among `joints` or has no finite position.
    pub fn from_recording(
        recording: &Recording,
        joints: &[String],
        held: &BTreeMap<String, f64>,
    ) -> Result<Self, SimulationError> {
        recording.check()?;
        let recorded = |joint: &str| recording.joint(joint).filter(|j| j.position.is_some());
        for (joint, &position) in held {
            let reason = if !joints.contains(joint) {
                "the chain has no such joint"
            } else if recorded(joint).is_some() {
                "its motion is recorded"
            } else if !position.is_finite() {
                "this is no position"
            } else {
                continue;
            };
            let (joint, known) = (joint.clone(), joints.to_vec());
            return Err(SimulationError::Held { joint, position, reason, known });
        }
        let moving: Vec<&JointChannels> = joints.iter().filter_map(|j| recorded(j)).collect();
        let derives =
            moving.iter().any(|joint| joint.velocity.is_none() || joint.acceleration.is_none());
        let grid =
            if derives { Some(EvenGrid::new(&recording.time_s, &recording.source)?) } else { None };
        let (time_s, rate_hz) = match &grid {
            Some(grid) => (grid.time_s().to_vec(), grid.rate_hz()),
            None => (recording.time_s.clone(), 0.0),
        };
        let on_grid = |values: &[f64]| match &grid {
            Some(grid) => grid.resample(values),
            None => values.to_vec(),
        };
        let mut trajectory = Self {
            joints: joints.to_vec(),
            position: Vec::new(),
            velocity: Vec::new(),
            acceleration: Vec::new(),
            source: recording.source.clone(),
            notes: recording.notes.clone(),
            time_s,
        };
        let samples = trajectory.time_s.len();
        for joint in joints {
            let (position, velocity, acceleration) = match (recorded(joint), held.get(joint)) {
                (Some(channels), _) => {
                    let channel = |quantity| channels.channel(quantity).map(on_grid);
                    let position = channel(Quantity::Position).unwrap_or_default();
                    let velocity = channel(Quantity::Velocity)
                        .unwrap_or_else(|| differentiate(&position, rate_hz));
                    let acceleration = channel(Quantity::Acceleration)
                        .unwrap_or_else(|| differentiate(&velocity, rate_hz));
                    (position, velocity, acceleration)
                }
                (None, Some(&position)) => {
                    (vec![position; samples], vec![0.0; samples], vec![0.0; samples])
                }
                (None, None) => {
                    return Err(missing(recording, joint, Quantity::Position));
                }
            };
            trajectory.position.push(position);
            trajectory.velocity.push(velocity);
            trajectory.acceleration.push(acceleration);
        }
        let uneven = grid.as_ref().is_some_and(|grid| !grid.timing().is_even);
        trajectory.notes.extend(
            uneven.then(|| format!("uneven stamps: the trajectory is resampled at {rate_hz} Hz")),
        );
        trajectory.notes.extend(derivation_notes(&moving));
        trajectory
            .notes
            .extend(held.iter().map(|(joint, position)| format!("{joint} is held at {position}")));
        Ok(trajectory)
    }

    /// The same motion at `rate_hz` from the first stamp on: positions, velocities and
    /// accelerations each by local cubic interpolation, so that between two former samples they are
    /// derivatives of one another only up to the interpolation error (for stamps at distance `h`
    /// of order `h⁴` each).
    ///
    /// # Errors
    /// A rate that is not positive and finite, or gives fewer than [`MIN_SAMPLES`] or more than
    /// [`MOST_SAMPLES`] samples.
    pub fn resampled(&self, rate_hz: f64) -> Result<Self, SimulationError> {
        self.recording()?;
        let time_s = even_times(&self.time_s, rate_hz)?;
        let longest_step_s = BRIDGED_STEPS * Timing::of(&self.time_s).median_step_s;
        let way = Interpolation::new(&self.time_s, &time_s, longest_step_s);
        let all = |columns: &[Vec<f64>]| columns.iter().map(|column| way.apply(column)).collect();
        let mut notes = self.notes.clone();
        notes.push(format!("interpolated at {rate_hz} Hz"));
        Ok(Self {
            joints: self.joints.clone(),
            position: all(&self.position),
            velocity: all(&self.velocity),
            acceleration: all(&self.acceleration),
            source: self.source.clone(),
            notes,
            time_s,
        })
    }

    /// The motion as a recording without efforts.
    ///
    /// # Errors
    /// Columns that are not one per joint, not finite or not as long as the stamps; what
    /// [`Recording::check`] refuses.
    pub fn recording(&self) -> Result<Recording, SimulationError> {
        let n = self.joints.len();
        let column = |columns: &[Vec<f64>], j: usize| columns.get(j).cloned();
        let joints = (0..n)
            .map(|j| JointChannels {
                position: column(&self.position, j),
                velocity: column(&self.velocity, j),
                acceleration: column(&self.acceleration, j),
                ..JointChannels::new(&self.joints[j])
            })
            .collect();
        let mut recording = Recording::new(&self.source, self.time_s.clone(), joints)?;
        for quantity in [Quantity::Position, Quantity::Velocity, Quantity::Acceleration] {
            if let Some(joint) = recording.joints.iter().find(|j| j.channel(quantity).is_none()) {
                return Err(missing(&recording, &joint.name, quantity));
            }
        }
        recording.notes.clone_from(&self.notes);
        Ok(recording)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }
}

/// Even times from the first to at most the last stamp.
pub(crate) fn even_times(stamps_s: &[f64], rate_hz: f64) -> Result<Vec<f64>, SimulationError> {
    let (first_s, last_s) = (stamps_s[0], stamps_s[stamps_s.len() - 1]);
    // a last sample that misses the last stamp by rounding belongs to the recording
    let steps = ((last_s - first_s) * rate_hz * (1.0 + 1e-12) + 1e-9).floor();
    if !(rate_hz > 0.0 && steps >= (MIN_SAMPLES - 1) as f64 && steps < MOST_SAMPLES as f64) {
        return Err(SimulationError::Setting {
            setting: "the sample rate [Hz]",
            value: rate_hz,
            range: format!(
                "positive and give from {MIN_SAMPLES} to {MOST_SAMPLES} samples in {} s",
                last_s - first_s
            ),
        });
    }
    Ok((0..=steps as usize).map(|k| (first_s + k as f64 / rate_hz).min(last_s)).collect())
}

/// The error that a channel of a joint is not there.
pub(crate) fn missing(recording: &Recording, joint: &str, quantity: Quantity) -> SimulationError {
    let with_channel = recording.joints.iter().filter(|j| j.channel(quantity).is_some());
    SimulationError::MissingChannel {
        joint: joint.to_owned(),
        quantity: quantity.suffix(),
        given: with_channel.map(|j| j.name.clone()).collect(),
        source_name: recording.source.clone(),
    }
}

/// Which columns are differences.
fn derivation_notes(moving: &[&JointChannels]) -> Vec<String> {
    let list = |wanted: &dyn Fn(&JointChannels) -> bool, what: &str| {
        let names: Vec<&str> =
            moving.iter().filter(|j| wanted(j)).map(|j| j.name.as_str()).collect();
        (!names.is_empty()).then(|| {
            format!("{what} by differences of fourth order, not filtered: {}", names.join(", "))
        })
    };
    [
        list(&|j| j.velocity.is_none(), "velocity from the position"),
        list(&|j| j.acceleration.is_none(), "acceleration from the velocity"),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(time_s: Vec<f64>, with_velocity: bool, with_acceleration: bool) -> Recording {
        let column = |f: fn(f64) -> f64| time_s.iter().map(|t| f(3.0 * t)).collect::<Vec<_>>();
        let joint = JointChannels {
            position: Some(column(f64::sin)),
            velocity: with_velocity.then(|| column(|x| 3.0 * x.cos())),
            acceleration: with_acceleration.then(|| column(|x| -9.0 * x.sin())),
            ..JointChannels::new("a")
        };
        Recording::new("plan.csv", time_s, vec![joint]).unwrap()
    }

    fn even(rate_hz: f64) -> Vec<f64> {
        (0..=rate_hz as usize).map(|k| k as f64 / rate_hz).collect()
    }

    fn joints() -> Vec<String> {
        vec!["a".to_owned(), "b".to_owned()]
    }

    fn held() -> BTreeMap<String, f64> {
        BTreeMap::from([("b".to_owned(), 0.4)])
    }

    #[test]
    fn takes_what_is_recorded_and_holds_the_rest() {
        let uneven: Vec<f64> = even(50.0).iter().map(|t| t + 0.003 * (40.0 * t).sin()).collect();
        let recording = recording(uneven, true, true);
        let trajectory = Trajectory::from_recording(&recording, &joints(), &held()).unwrap();
        assert_eq!(trajectory.time_s, recording.time_s);
        assert_eq!(Some(&trajectory.acceleration[0]), recording.joints[0].acceleration.as_ref());
        assert_eq!(trajectory.position[1], vec![0.4; 51]);
        assert_eq!(trajectory.velocity[1], vec![0.0; 51]);
        assert_eq!(trajectory.notes, ["b is held at 0.4"]);
        assert_eq!(trajectory.recording().unwrap().joints.len(), 2);
    }

    #[test]
    fn derives_what_is_not_recorded_and_says_so() {
        for (with_velocity, tolerance) in [(true, 2e-5), (false, 4e-4)] {
            let recording = recording(even(100.0), with_velocity, false);
            let trajectory = Trajectory::from_recording(&recording, &joints(), &held()).unwrap();
            for (t, (v, a)) in trajectory
                .time_s
                .iter()
                .zip(trajectory.velocity[0].iter().zip(&trajectory.acceleration[0]))
            {
                assert!((v - 3.0 * (3.0 * t).cos()).abs() < tolerance);
                assert!((a + 9.0 * (3.0 * t).sin()).abs() < tolerance, "{a} at {t}");
            }
            let note = "acceleration from the velocity by differences of fourth order, not \
                        filtered: a";
            assert!(trajectory.notes.iter().any(|n| n == note), "{:?}", trajectory.notes);
        }
        let uneven: Vec<f64> = even(50.0).iter().map(|t| t + 0.003 * (40.0 * t).sin()).collect();
        let recording = recording(uneven, false, false);
        let trajectory = Trajectory::from_recording(&recording, &joints(), &held()).unwrap();
        assert!(trajectory.notes[0].starts_with("uneven stamps: the trajectory is resampled at"));
    }

    #[test]
    fn interpolates_each_column_to_fourth_order() {
        let error = |rate_hz: f64| {
            let recording = recording(even(rate_hz), true, true);
            let trajectory = Trajectory::from_recording(&recording, &joints(), &held()).unwrap();
            let fine = trajectory.resampled(1000.0).unwrap();
            assert_eq!(fine.len(), 1001);
            let from_to = (0.2, 0.8);
            (0..fine.len())
                .filter(|&k| fine.time_s[k] > from_to.0 && fine.time_s[k] < from_to.1)
                .map(|k| (fine.acceleration[0][k] + 9.0 * (3.0 * fine.time_s[k]).sin()).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(20.0) / error(40.0);
        assert!((ratio - 16.0).abs() < 2.0, "{ratio}");
    }
}
