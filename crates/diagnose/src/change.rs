//! What changed between two sets of recordings of one arm, and what a model that knows more than its links leaves out.

use crate::design::known_effort::Known;
use armident_effects::{EVERYDAY, EffectOnJoint};
use armident_model::{ArmModel, DiagnosedModel, SHARP};
use armident_recording::Recording;

use crate::checks::usable::DiagnoseError;
use crate::diagnosis::{Diagnosis, diagnose_beside, diagnose_from, model_of};
use crate::findings::placebo::Placebo;

/// The diagnosis of recordings against reference recordings of the same arm: what the reference shows
/// beyond the believed model is learned first and is no finding. The models of the diagnosis have it as well.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose_change(
    model: &ArmModel,
    reference: &[Recording],
    after: &[Recording],
) -> Result<Diagnosis, DiagnoseError> {
    let (before, band) = model_of(model, reference)?;
    let known = Known::of(before);
    let all = [reference, after].concat();
    // the reference stays in the problem: what is uncertain about the arm before is uncertain in both
    let mut difference = diagnose_from(&known, &all, reference.len(), band)?;
    known.put_back_into(&mut difference);
    Ok(difference)
}

/// What was learned before and what was learned of the change, in one model.
fn together(before: &DiagnosedModel, change: DiagnosedModel) -> DiagnosedModel {
    let mut all = change;
    let mut effects = before.arm.effects.clone();
    for change in all.arm.effects {
        // the baseline terms of a joint, seen again with the recordings after
        let same = |e: &&mut EffectOnJoint| {
            EVERYDAY.iter().any(|law| law.law().slug == e.effect)
                && e.effect == change.effect
                && e.joint == change.joint
        };
        match effects.iter_mut().find(same) {
            Some(known) => known.parameters[0] += change.parameters[0],
            None => effects.push(change),
        }
    }
    all.arm.effects = effects;
    // the first model of the arm stays what a later one is compared with
    if before.arm.prior_links.is_some() {
        all.arm.prior_links.clone_from(&before.arm.prior_links);
    }
    let (learned, earlier) = (&mut all.learned, &before.learned);
    learned.couplings = [earlier.couplings.clone(), learned.couplings.clone()].concat();
    learned.transmissions = [earlier.transmissions.clone(), learned.transmissions.clone()].concat();
    learned.flexible = [earlier.flexible.clone(), learned.flexible.clone()].concat();
    learned.delay_s += earlier.delay_s;
    // low-passes that efforts without what is known ask for would blur what is put back
    learned.rigid_cutoff_hz = earlier.rigid_cutoff_hz;
    learned.output_cutoff_hz.clone_from(&earlier.output_cutoff_hz);
    for (joint, turn) in earlier.turns().into_iter().enumerate() {
        if learned.turns()[joint] == SHARP {
            learned.fading_speed[joint] = turn.speed();
            learned.turning_travel[joint] = turn.travel();
        }
    }
    for (now, then) in learned.encoder_offset.iter_mut().zip(&earlier.encoder_offset) {
        *now += then;
    }
    for (now, then) in learned.gain.iter_mut().zip(&earlier.gain) {
        *now *= then;
    }
    all
}

impl Known {
    /// Diagnoses what the model leaves out of recordings, with so many wrong terms
    /// ([`diagnose_with_placebo`](crate::diagnosis::diagnose_with_placebo)). The models that come of it have what is known as well.
    ///
    /// # Errors
    /// [`DiagnoseError`].
    pub fn diagnose(
        &self,
        train: &[Recording],
        wrong_terms: Option<usize>,
    ) -> Result<(Diagnosis, Option<Placebo>), DiagnoseError> {
        let (mut diagnosis, placebo) = diagnose_beside(self, train, wrong_terms)?;
        self.put_back_into(&mut diagnosis);
        Ok((diagnosis, placebo))
    }

    /// What the model knows becomes part of all models of a diagnosis of such recordings.
    fn put_back_into(&self, diagnosis: &mut Diagnosis) {
        let beside = diagnosis.without.iter_mut().flatten();
        let rivals = diagnosis.rivals.iter_mut().flatten().flatten();
        let own = [&mut diagnosis.model, &mut diagnosis.rigid, &mut diagnosis.believed];
        for model in own.into_iter().chain(beside).chain(rivals) {
            *model = together(&self.model, model.clone());
        }
    }
}
