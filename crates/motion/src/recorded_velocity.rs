//! Recorded velocities in the place of differentiated positions.

use armident_recording::{Quantity, Recording};

use crate::Motion;

/// A motion whose velocity is the recorded one through the motion's low-pass, and whose acceleration is
/// the derivative of that.
///
/// Stamps that are off by some share of a step put that share of the change of speed into a
/// differentiated position, and twice so into accelerations; a velocity that the drive measured is
/// spared one of the two differentiations. Recorded velocities can lag, though: which one explains the
/// efforts better is to be tried.
///
/// None unless the motion is low-passed and the recording has velocities of all its joints.
pub fn with_recorded_velocity(motion: &Motion, recording: &Recording) -> Option<Motion> {
    let thinned = !std::ptr::eq(motion.fine(), motion);
    let motion = motion.fine();
    let filter = motion.filter.as_ref()?;
    let recorded: Vec<Vec<f64>> = motion
        .joints
        .iter()
        .map(|name| {
            let recorded = recording.joint(name)?.channel(Quantity::Velocity)?;
            Some(motion.on_grid(recorded))
        })
        .collect::<Option<_>>()?;
    let mut moved = motion.clone();
    (moved.velocity, moved.acceleration) =
        filter.with_derivatives(&recorded).into_iter().map(|[dq, ddq]| (dq, ddq)).unzip();
    Some(if thinned { moved.thinned() } else { moved })
}
