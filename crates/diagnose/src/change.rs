//! What changed between two sets of recordings of one arm, and what a model that knows more than its links leaves out.

use crate::design::known_effort::Known;
use armident_model::ArmModel;
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
            *model = self.model.with_change(model.clone());
        }
    }
}
