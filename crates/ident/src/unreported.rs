//! Joints whose effort columns leave small efforts out: a drive that is off, or rounds small currents to zero.
//!
//! What such a column repeats while the joint moves is no measurement, yet a fit finds it without noise and would
//! believe it before all others: a wrist whose column is 0 then weighs nothing.

use armident_recording::{Recording, stuck_effort_shares};

/// Share of samples that repeat a value while the joint moves beyond which a column is no effort to compare
/// with others. Efforts that happen to repeat do so over fewer samples than count as stuck.
const STUCK: f64 = 0.1;

/// Per joint, the share of all samples in which its effort repeats a value although the joint moves; none where
/// that is no more than a fault in passing, and none of any joint where no other column would be left to believe.
pub fn unreported(recordings: &[Recording], joints: &[&str]) -> Vec<Option<f64>> {
    let samples: usize = recordings.iter().map(Recording::len).sum();
    let mut shares = vec![0.0; joints.len()];
    for recording in recordings {
        let weight = recording.len() as f64 / samples.max(1) as f64;
        for (sum, share) in shares.iter_mut().zip(stuck_effort_shares(recording, joints)) {
            *sum += weight * share;
        }
    }
    let is_reported = |share: &f64| *share <= STUCK;
    let any = shares.iter().any(is_reported);
    shares.into_iter().map(|share| (any && !is_reported(&share)).then_some(share)).collect()
}
