//! Recorded velocities in the place of differentiated positions.

use armident_recording::{Motion, Quantity, Recording, differentiate};

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
    motion.filter.as_ref()?;
    let mut velocity: Vec<Vec<f64>> = motion
        .joints
        .iter()
        .map(|name| {
            let recorded = recording.joint(name)?.channel(Quantity::Velocity)?;
            Some(motion.on_grid(recorded))
        })
        .collect::<Option<_>>()?;
    if let Some(filter) = &motion.filter {
        filter.filter_columns_in_parallel(&mut velocity);
    }
    let mut moved = motion.clone();
    moved.acceleration = velocity.iter().map(|v| differentiate(v, motion.rate_hz)).collect();
    moved.velocity = velocity;
    Some(if thinned { moved.thinned() } else { moved })
}
