//! The door: what a diagnosis is asked, and its steps.

use armident_effects::{Effect, TorqueScale};
use armident_ident::checks::Topic;
use armident_model::ArmModel;
use armident_recording::Recording;

use crate::checks::effort_columns::InputChecks;
use crate::checks::reporting::EffortReporting;
use crate::checks::usable::without_constant_efforts;
use crate::design::known_effort::KnownModel;
use crate::design::placeholder::placeholders;
use crate::diagnosis::Diagnosis;
use crate::error::{DiagnoseError, WrongColumns};
use crate::findings::finding::Finding;
use crate::findings::residual_map::JointAtlas;
use crate::pipeline::{against_model, against_reference};

/// Relative error of all links beyond which they may be anything.
const MOST_BELIEVED: f64 = 0.2;

/// What a diagnosis is asked.
#[derive(Debug, Clone, Copy)]
pub struct DiagnoseRequest<'a> {
    /// The given model: that of a URDF, or one that holds effects, which are then no findings.
    pub model: &'a ArmModel,
    /// Recordings that are fitted.
    pub recordings: &'a [Recording],
    /// Earlier recordings of the same arm: only changes since then are findings. May be empty.
    pub reference: &'a [Recording],
    /// Recordings that are not fitted, which confirm findings or do not. May be empty.
    pub holdout: &'a [Recording],
    /// Whether columns that fail the input checks are used as they are.
    pub trust_columns: bool,
    /// Placebo terms to try, if any.
    pub placebo_terms: Option<usize>,
}

impl<'a> DiagnoseRequest<'a> {
    /// Recordings against a model, without a reference and a hold-out.
    pub fn new(model: &'a ArmModel, recordings: &'a [Recording]) -> Self {
        Self {
            model,
            recordings,
            reference: &[],
            holdout: &[],
            trust_columns: false,
            placebo_terms: None,
        }
    }

    /// Whether the given model holds more than links, so that only what it lacks is found.
    pub fn is_beyond_a_model(&self) -> bool {
        // a reference shows all that a model of the same arm knows, as it is now
        self.reference.is_empty() && !self.model.is_links_only()
    }
}

/// Finds the effects that the given model lacks, and confirms them on the hold-out.
///
/// The input is checked first: columns that physics explains pass after all, and joints whose columns do not are excluded
/// from a second fit, for what is wrong with one column is no case against the other joints.
///
/// # Errors
/// [`DiagnoseError`]; [`DiagnoseError::WrongColumns`] where the columns leave nothing to diagnose.
pub fn diagnose(request: &DiagnoseRequest<'_>) -> Result<Diagnosis, DiagnoseError> {
    let &DiagnoseRequest { model, recordings, reference, holdout, .. } = request;
    let known = request.is_beyond_a_model().then(|| KnownModel::of(model.clone()));
    // gains of drives come from recordings of the arm as it is believed to be; friction that a model has too much of,
    // taken out, would look like a sign
    let mut checks = match &known {
        Some(known) => InputChecks::of(known.body(), recordings)?,
        None => InputChecks::of(model, if reference.is_empty() { recordings } else { reference })?,
    };
    // inertias are those of a geometry: a distance that is wrong whatever they are is corrected before they are sought
    let length = checks.link_length.clone();
    let corrected = length.as_ref().map(|found| found.corrected(model));
    let known = match (&corrected, known) {
        (Some(corrected), Some(_)) => Some(KnownModel::of(corrected.clone())),
        (_, known) => known,
    };
    let given = model;
    let model = corrected.as_ref().unwrap_or(given);
    let in_effort = |recordings: &[Recording]| -> Vec<Recording> {
        recordings.iter().map(|r| checks.in_effort(r)).collect()
    };
    let measured = |recordings: Vec<Recording>| -> Vec<Recording> {
        recordings.iter().map(|r| without_constant_efforts(r, &recordings)).collect()
    };
    let [recordings, reference, holdout] =
        [recordings, reference, holdout].map(|all| measured(in_effort(all)));
    if request.trust_columns {
        checks.faults.clear();
    }
    // sign, unit and order are read off the efforts of the links, which are not measured
    if placeholders(&model.chain).contains(&true) {
        checks.faults.retain(|fault| fault.topic == Topic::Quality);
        checks.of_arm = false;
    }
    if checks.of_arm && !checks.faults.is_empty() {
        let wrong = WrongColumns { input_checks: checks, recordings };
        return Err(DiagnoseError::WrongColumns(Box::new(wrong)));
    }
    let reporting = EffortReporting::found(&checks, model);
    let of = |recordings: &[Recording], reference: &[Recording]| match reference {
        [] => {
            let given = (model, known.as_ref());
            against_model(given, recordings, reporting, request.placebo_terms)
        }
        _ => against_reference(model, reference, recordings, reporting),
    };
    let mut found = of(&recordings, &reference);
    if let Ok(diagnosis) = &found {
        checks.excuse(diagnosis);
    }
    if !checks.faults.is_empty() {
        let joints = model.chain.dof();
        let kept = |recordings: &[Recording]| -> Option<Vec<Recording>> {
            recordings.iter().map(|r| checks.without_faulty(r, joints)).collect()
        };
        let again = kept(&recordings).zip(kept(&reference)).map(|(r, before)| of(&r, &before));
        found = match again {
            Some(Ok(diagnosis)) => Ok(diagnosis),
            _ => {
                let wrong = WrongColumns { input_checks: checks, recordings };
                return Err(DiagnoseError::WrongColumns(Box::new(wrong)));
            }
        };
    }
    let mut diagnosis = Diagnosis { recordings, holdout, input_checks: checks, ..found? };
    if let (Some(length), []) = (&length, request.reference) {
        // the same with the given length, for the hold-out to judge
        let without = against_model((given, None), &diagnosis.recordings, reporting, None);
        diagnosis.report_length(length, without.ok().map(|without| without.model));
    }
    diagnosis.report_as(reporting, !request.reference.is_empty());
    if request.reference.is_empty() {
        diagnosis.weigh_low_pass_against_delay();
    }
    diagnosis.widen_by_drive_gains();
    diagnosis.confirm()?;
    Ok(diagnosis)
}

impl InputChecks {
    /// Takes back what physics explains: where the residual of the diagnosed model is little more than noise, the
    /// columns are what they are called. Only links turned inside out and gains could turn a column of
    /// another joint, sign or unit into that: where these are found, the fault stands. So do faults of what was
    /// recorded at all: a column that is 0 is soon explained.
    fn excuse(&mut self, diagnosis: &Diagnosis) {
        let turned = |f: &Finding| f.link.is_some() || f.effect == TorqueScale.slug();
        if diagnosis.findings.iter().any(turned) || diagnosis.inertial_error > MOST_BELIEVED {
            return;
        }
        let explained = |joint: Option<&String>| {
            let mut of = diagnosis.atlas.iter().filter(|a| joint.is_none_or(|j| a.joint == *j));
            of.all(JointAtlas::explained)
        };
        self.faults
            .retain(|fault| fault.topic == Topic::Quality || !explained(fault.joint.as_ref()));
    }
}
