//! Temperatures of the drives of an arm that is simulated: those of a recording, on lines between its samples.

use armident_recording::{Quantity, Recording};

use crate::lines;

/// Temperatures of the joints of an arm over time.
#[derive(Debug)]
pub(crate) struct DriveTemperatures {
    time_s: Vec<f64>,
    /// of each joint \[°C\], where it is recorded
    by_joint: Vec<Option<Vec<f64>>>,
}

impl DriveTemperatures {
    pub(crate) fn of(recording: &Recording, joints: &[String]) -> Self {
        let of_joint =
            |name: &String| Some(recording.joint(name)?.channel(Quantity::Temperature)?.to_vec());
        Self { time_s: recording.time_s.clone(), by_joint: joints.iter().map(of_joint).collect() }
    }

    /// The temperature of a joint at an instant \[°C\], where it is known.
    pub(crate) fn at(&self, joint: usize, time_s: f64) -> Option<f64> {
        Some(lines::at(&self.time_s, self.by_joint[joint].as_ref()?, time_s))
    }

    /// Puts the temperatures into what was recorded of the arm.
    pub(crate) fn record_in(&self, recording: &mut Recording) {
        for (j, joint) in recording.joints.iter_mut().enumerate() {
            let course = recording.time_s.iter().map(|t| self.at(j, *t));
            joint.temperature = course.collect();
        }
    }
}
