//! Joints whose effort channels have a dead zone: a drive that is off, or rounds small currents to zero.
//!
//! What such a channel repeats while the joint moves is no measurement, yet a fit finds it without noise and would weigh it
//! above all others: a wrist whose channel is 0 would have no mass.
//!
//! Method: a channel has a dead zone where one value is repeated in over a tenth of all samples while the joint moves. Its
//! share and offset are the least-squares line of recorded over modelled effort.
//!
//! References: own.

use armident_effects::{Effect, TorqueOffset};
use armident_model::DeadZone;
use armident_motion::stuck_effort_shares;
use armident_recording::Recording;

use crate::regression::{BatchProblem, JointFit, JointRows, LAWS, Term};

/// Share of samples with one repeated value while the joint moves, beyond which a channel has a dead zone. Efforts that
/// happen to repeat do so over fewer samples than count as stuck.
const DEAD_SHARE: f64 = 0.1;

/// Per joint whose effort channel has a dead zone, the share of all samples in which it repeats a value although the joint
/// moves; none of any joint where no channel without a dead zone would remain.
pub fn dead_zone_shares(recordings: &[Recording], joints: &[&str]) -> Vec<Option<f64>> {
    let samples: usize = recordings.iter().map(Recording::len).sum();
    let mut shares = vec![0.0; joints.len()];
    for recording in recordings {
        let weight = recording.len() as f64 / samples.max(1) as f64;
        for (sum, share) in shares.iter_mut().zip(stuck_effort_shares(recording, joints)) {
            *sum += weight * share;
        }
    }
    let is_reported = |share: &f64| *share <= DEAD_SHARE;
    let any = shares.iter().any(is_reported);
    shares.into_iter().map(|share| (any && !is_reported(&share)).then_some(share)).collect()
}

impl BatchProblem {
    /// Per joint, the dead zone of its channel given the values of all terms; none where it has none.
    pub fn dead_zones(&self, rows: &JointRows, values: &[f64]) -> Vec<Option<DeadZone>> {
        let of = |joint: usize| {
            let terms = self.terms_of_joint(joint);
            let x: Vec<f64> = terms.iter().map(|&k| values[k]).collect();
            let dot = |m: &[f64]| x.iter().zip(m).map(|(x, m)| x * m).sum::<f64>();
            // products of the columns with the efforts as recorded and as the model has them
            let recorded = rows.triangles[joint].residual_moments(&vec![0.0; x.len()]);
            let left = rows.triangles[joint].residual_moments(&x);
            let modelled: Vec<f64> = recorded.iter().zip(&left).map(|(y, r)| y - r).collect();
            let (count, sum, _) = rows.effort[joint];
            let count = count as f64;
            let Some(constant) = terms.iter().position(|&k| self.is_offset(k)) else {
                let share = (dot(&recorded) / dot(&modelled)).clamp(0.0, 1.0);
                return DeadZone { share: if share.is_nan() { 0.0 } else { share }, offset: 0.0 };
            };
            let (mean, mean_modelled) = (sum / count, modelled[constant] / count);
            let varying = dot(&modelled) - count * mean_modelled * mean_modelled;
            let together = dot(&recorded) - count * mean * mean_modelled;
            let share = if varying > 0.0 { (together / varying).clamp(0.0, 1.0) } else { 0.0 };
            DeadZone { share, offset: mean - share * mean_modelled }
        };
        (0..self.by_joint.len()).map(|joint| self.has_dead_zone[joint].then(|| of(joint))).collect()
    }

    /// Effort error of given values per joint, predictions mapped through the dead zones.
    pub fn fit_through_dead_zones(
        &self,
        rows: &JointRows,
        values: &[f64],
        dead_zones: &[Option<DeadZone>],
    ) -> Vec<JointFit> {
        let mut fits = self.fit(rows, values);
        for (joint, dead_zone) in dead_zones.iter().enumerate() {
            let Some(DeadZone { share, offset }) = dead_zone else { continue };
            let mut changed = values.to_vec();
            for &k in self.terms_of_joint(joint) {
                changed[k] = share * values[k] + if self.is_offset(k) { *offset } else { 0.0 };
            }
            fits[joint] = self.fit(rows, &changed)[joint];
        }
        fits
    }

    fn is_offset(&self, term: usize) -> bool {
        let Term::Effect { effect, .. } = self.terms[term] else { return false };
        LAWS[effect].law().slug == TorqueOffset.law().slug
    }
}
