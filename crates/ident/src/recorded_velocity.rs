//! Recorded velocities instead of differentiated positions.

use armident_motion::Motion;
use armident_recording::{Quantity, Recording};

/// A motion whose velocity is the recorded one through the motion's low-pass, and whose acceleration is
/// the derivative of that.
///
/// Jitter of the stamps puts its share of the change of speed into a
/// differentiated position, and twice so into accelerations; a velocity that the drive measured is
/// needs only one of the two differentiations. Recorded velocities can lag, though: try which one explains the
/// efforts better.
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
