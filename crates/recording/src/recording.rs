//! Time stamps and joint channels of one recording.

use crate::error::{Fault, RecordingError};
use crate::finding::QualityIssue;
use crate::limits::MIN_SAMPLES;
use crate::quantity::Quantity;

/// The channels of one joint, each as long as the time stamps. SI units: rad, N m for a revolute
/// joint; m, N for a prismatic one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointChannels {
    /// Name of the joint, as in the URDF.
    pub name: String,
    /// Position \[rad or m\].
    pub position: Option<Vec<f64>>,
    /// Velocity \[rad/s or m/s\].
    pub velocity: Option<Vec<f64>>,
    /// Acceleration \[rad/s² or m/s²\].
    pub acceleration: Option<Vec<f64>>,
    /// Torque or force on the joint side \[N m or N\].
    pub effort: Option<Vec<f64>>,
    /// Motor current \[A\].
    pub current: Option<Vec<f64>>,
    /// Motor voltage \[V\].
    pub voltage: Option<Vec<f64>>,
    /// Position of the motor's own encoder, divided by the gear ratio \[rad or m\].
    pub motor_position: Option<Vec<f64>>,
    /// Temperature of motor or drive \[°C\].
    pub temperature: Option<Vec<f64>>,
    /// Position that the joint's controller is given to reach \[rad or m\].
    pub command: Option<Vec<f64>>,
}

impl JointChannels {
    /// A joint of this name without channels.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The samples of one quantity.
    pub fn channel(&self, quantity: Quantity) -> Option<&[f64]> {
        match quantity {
            Quantity::Position => self.position.as_deref(),
            Quantity::Velocity => self.velocity.as_deref(),
            Quantity::Acceleration => self.acceleration.as_deref(),
            Quantity::Effort => self.effort.as_deref(),
            Quantity::Current => self.current.as_deref(),
            Quantity::Voltage => self.voltage.as_deref(),
            Quantity::MotorPosition => self.motor_position.as_deref(),
            Quantity::Temperature => self.temperature.as_deref(),
            Quantity::Command => self.command.as_deref(),
        }
    }

    /// Mutable samples of one quantity, to add, change or remove them.
    pub fn channel_mut(&mut self, quantity: Quantity) -> &mut Option<Vec<f64>> {
        match quantity {
            Quantity::Position => &mut self.position,
            Quantity::Velocity => &mut self.velocity,
            Quantity::Acceleration => &mut self.acceleration,
            Quantity::Effort => &mut self.effort,
            Quantity::Current => &mut self.current,
            Quantity::Voltage => &mut self.voltage,
            Quantity::MotorPosition => &mut self.motor_position,
            Quantity::Temperature => &mut self.temperature,
            Quantity::Command => &mut self.command,
        }
    }

    /// The recorded quantities with their samples, in the order of [`Quantity::ALL`].
    pub fn channels(&self) -> impl Iterator<Item = (Quantity, &[f64])> {
        Quantity::ALL
            .into_iter()
            .filter_map(|quantity| self.channel(quantity).map(|values| (quantity, values)))
    }
}

/// Time stamps and joint channels of one recording, as recorded: nothing is filtered or resampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Origin: a path, or a description.
    pub source: String,
    /// Time stamps \[s\], strictly increasing, not necessarily even, not necessarily from 0.
    pub time_s: Vec<f64>,
    /// The joints in order of first appearance.
    pub joints: Vec<JointChannels>,
    /// Notes: automatic choices and repairs, one line each.
    pub notes: Vec<String>,
    /// Ignored columns of the file.
    pub ignored_columns: Vec<String>,
    /// Defects that reading repaired or kept, with times and share; the quality report of a motion
    /// has more.
    pub findings: Vec<QualityIssue>,
}

impl Recording {
    /// A recording without notes.
    ///
    /// # Errors
    /// See [`check`](Self::check).
    pub fn new(
        source: impl Into<String>,
        time_s: Vec<f64>,
        joints: Vec<JointChannels>,
    ) -> Result<Self, RecordingError> {
        let recording = Self {
            source: source.into(),
            time_s,
            joints,
            notes: Vec::new(),
            ignored_columns: Vec::new(),
            findings: Vec::new(),
        };
        recording.check()?;
        Ok(recording)
    }

    /// Checks the invariants of a recording.
    ///
    /// # Errors
    /// Fewer than [`MIN_SAMPLES`] samples; stamps that do not increase strictly; values that are
    /// not finite; a channel with another length than the stamps; a joint without a channel, a
    /// duplicate joint, or one whose name a header cannot hold.
    pub fn check(&self) -> Result<(), RecordingError> {
        let fault = |fault| RecordingError::new(fault, &self.source);
        let expected = self.time_s.len();
        if expected < MIN_SAMPLES {
            return Err(fault(Fault::TooFewSamples { found: expected, required: MIN_SAMPLES }));
        }
        self.check_finite("t", &self.time_s)?;
        if let Some(pair) = self.time_s.windows(2).find(|pair| pair[1] <= pair[0]) {
            let count = self.time_s.windows(2).filter(|pair| pair[1] <= pair[0]).count();
            let (previous_s, found_s) = (pair[0], pair[1]);
            let fault = fault(Fault::TimeBackwards { previous_s, found_s, count, total: expected });
            return Err(fault.in_column("t"));
        }
        if self.joints.is_empty() {
            return Err(fault(Fault::NoJointColumns { rename: None, columns: vec!["t".into()] }));
        }
        for (index, joint) in self.joints.iter().enumerate() {
            let name = &joint.name;
            if name.is_empty() || name.trim() != name || name.contains(['\r', '\n']) {
                return Err(fault(Fault::BadJointName { name: name.clone() }));
            }
            if self.joints[..index].iter().any(|earlier| earlier.name == *name) {
                return Err(fault(Fault::DuplicateJoint { joint: name.clone() }));
            }
            if joint.channels().next().is_none() {
                return Err(fault(Fault::NoChannels { joint: name.clone() }));
            }
            for (quantity, values) in joint.channels() {
                let column = format!("{name}/{quantity}");
                if values.len() != expected {
                    let found = values.len();
                    return Err(fault(Fault::LengthMismatch { expected, found }).in_column(&column));
                }
                self.check_finite(&column, values)?;
            }
        }
        Ok(())
    }

    fn check_finite(&self, column: &str, values: &[f64]) -> Result<(), RecordingError> {
        let Some(first) = values.iter().find(|value| !value.is_finite()) else { return Ok(()) };
        let count = values.iter().filter(|value| !value.is_finite()).count();
        let fault = Fault::NotFinite { text: first.to_string(), count, total: values.len() };
        Err(RecordingError::new(fault, &self.source).in_column(column))
    }

    /// The channels of the joint of this name.
    pub fn joint(&self, name: &str) -> Option<&JointChannels> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// The joint names in order.
    pub fn joint_names(&self) -> Vec<&str> {
        self.joints.iter().map(|joint| joint.name.as_str()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64 * 0.01).collect()
    }

    fn joint(name: &str, n: usize) -> JointChannels {
        JointChannels { position: Some(ramp(n)), ..JointChannels::new(name) }
    }

    #[test]
    fn joints_keep_their_order() {
        let recording = Recording::new("x", ramp(9), vec![joint("b", 9), joint("a", 9)]).unwrap();
        assert_eq!(recording.joint_names(), ["b", "a"]);
        assert!(recording.joint("a").is_some());
        assert!(recording.joint("c").is_none());
        assert_eq!(recording.len(), 9);
    }

    #[test]
    fn inconsistent_recordings_are_refused() {
        let place = |time_s, joints| {
            let error = Recording::new("x", time_s, joints).unwrap_err();
            (error.to_string(), error.place())
        };
        assert_eq!(
            place(ramp(9), vec![joint("a", 8)]),
            (
                "channel has 8 samples, expected 9 as time stamps".to_owned(),
                "x, column `a/position`".to_owned()
            )
        );
        let mut broken = joint("a", 9);
        broken.effort = Some(vec![f64::NAN; 9]);
        assert_eq!(
            place(ramp(9), vec![broken]).0,
            "value is NaN; 9 of 9 values in the recording are NaN or infinite"
        );
        assert_eq!(place(vec![0.0; 9], vec![joint("a", 9)]).1, "x, column `t`");
        assert_eq!(place(ramp(9), vec![joint("a", 9), joint("a", 9)]).1, "x");
        for name in ["", " a", "a\nb"] {
            assert!(place(ramp(9), vec![joint(name, 9)]).0.contains("is not a valid joint name"));
        }
        assert!(place(ramp(9), vec![JointChannels::new("a")]).0.contains("no channels"));
        assert!(place(ramp(3), vec![joint("a", 3)]).0.contains("at least 8 required"));
        assert!(place(ramp(9), vec![]).0.contains("no joint columns"));
    }
}
