//! The recording that grows while an arm moves.

use armident_recording::{JointChannels, Recording};

use crate::error::SimulationError;
use crate::simulated_arm::SimulatedArm;
use crate::stepper::ArmState;

/// Samples of all joints, one after another.
#[derive(Debug)]
pub(crate) struct MotionLog {
    time_s: Vec<f64>,
    /// `[quantity][joint][sample]`: position, velocity, acceleration, effort
    columns: [Vec<Vec<f64>>; 4],
}

impl MotionLog {
    pub(crate) fn new(dof: usize, samples: usize) -> Self {
        let empty = || (0..dof).map(|_| Vec::with_capacity(samples)).collect();
        Self { time_s: Vec::with_capacity(samples), columns: std::array::from_fn(|_| empty()) }
    }

    pub(crate) fn push(
        &mut self,
        time_s: f64,
        state: &ArmState,
        acceleration: &[f64],
        effort: &[f64],
    ) {
        self.time_s.push(time_s);
        let sample = [&state.position[..], &state.velocity, acceleration, effort];
        for (columns, values) in self.columns.iter_mut().zip(sample) {
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(*value);
            }
        }
    }

    /// The recording, with the efforts as their channels show them.
    pub(crate) fn into_recording(
        self,
        source: String,
        arm: &SimulatedArm,
        notes: Vec<String>,
    ) -> Result<Recording, SimulationError> {
        let mut columns = self.columns;
        arm.to_recorded(&self.time_s, &mut columns[3]);
        let mut columns = columns.map(Vec::into_iter);
        let joints = arm.joints().iter().map(|name| {
            let [position, velocity, acceleration, effort] = columns.each_mut().map(Iterator::next);
            JointChannels { position, velocity, acceleration, effort, ..JointChannels::new(name) }
        });
        let mut recording = Recording::new(source, self.time_s, joints.collect())?;
        recording.notes = notes;
        if let Some(temperatures) = arm.temperatures() {
            temperatures.record_in(&mut recording);
        }
        Ok(recording)
    }
}
