//! Joints whose effort columns leave small efforts out: a drive that is off, or rounds small currents to zero.
//!
//! What such a column repeats while the joint moves is no measurement, yet a fit finds it without noise and would
//! believe it before all others: a wrist whose column is 0 then weighs nothing.

use armident_effects::{Effect, TorqueOffset};
use armident_model::Shown;
use armident_motion::stuck_effort_shares;
use armident_recording::Recording;

use crate::batch::{BatchProblem, JointFit, LAWS, Term};
use crate::rows::JointRows;

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

impl BatchProblem<'_> {
    /// Per joint, what its column shows of the efforts of such values; none where it reports them.
    pub fn shown(&self, rows: &JointRows, values: &[f64]) -> Vec<Option<Shown>> {
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
                return Shown { share: if share.is_nan() { 0.0 } else { share }, offset: 0.0 };
            };
            let (mean, mean_modelled) = (sum / count, modelled[constant] / count);
            let varying = dot(&modelled) - count * mean_modelled * mean_modelled;
            let together = dot(&recorded) - count * mean * mean_modelled;
            let share = if varying > 0.0 { (together / varying).clamp(0.0, 1.0) } else { 0.0 };
            Shown { share, offset: mean - share * mean_modelled }
        };
        (0..self.by_joint.len()).map(|joint| self.unreported[joint].then(|| of(joint))).collect()
    }

    /// Errors of efforts as columns show them.
    pub fn fit_as_shown(
        &self,
        rows: &JointRows,
        values: &[f64],
        shown: &[Option<Shown>],
    ) -> Vec<JointFit> {
        let mut fits = self.fit(rows, values);
        for (joint, shown) in shown.iter().enumerate() {
            let Some(Shown { share, offset }) = shown else { continue };
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
