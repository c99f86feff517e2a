//! From recordings to a diagnosis: design, selection, findings and models, in this order.

use crate::checks::effort_columns::InputChecks;
use crate::checks::reporting::EffortReporting;
use crate::checks::usable::usable_signals;
use crate::design::known_effort::KnownModel;
use crate::design::linear_problem::LinearProblem;
use crate::design::placeholder::placeholders;
use crate::design::training::Design;
use crate::diagnosis::Diagnosis;
use crate::error::DiagnoseError;
use crate::findings::finding::{DoubtfulChange, Finding, reported_findings};
use crate::findings::fitted_model::{Links, choose_outputs, fitted_model, links_only_fit};
use crate::findings::placebo::placebo;
use crate::findings::residual_map::{atlas, character};
use crate::findings::size::with_size;
use crate::regression::elimination::{INFLATIONS, InflatedLink};
use crate::regression::fit_set::{Estimate, fit_any_sign, fit_set};
use crate::selection::bandwidth_test::{NARROW_HZ, is_off_in};
use crate::selection::cross_validation::{Predictor, predictor};
use crate::selection::iterate::select;
use crate::selection::materiality::joints_of_inertial_errors;
use crate::selection::prior_scale::CAD_SCALE;
use crate::selection::solution::{Selection, Solution};
use crate::selection::sublinear::with_sublinear_friction;
use crate::uncertainty::jackknife::Jackknife;
use crate::uncertainty::minimal_constants::{ConstantEstimates, constants};
use armident_model::ArmModel;
use armident_motion::BAND_HZ;
use armident_recording::Recording;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What recordings show that a model lacks, and what the selection makes of so many placebo terms. Efforts are those before a
/// low-pass of the drives of this time constant \[s\]; 0 where there is none.
///
/// # Errors
/// [`DiagnoseError`].
pub(crate) fn against_model(
    (model, known): (&ArmModel, Option<&KnownModel>),
    recordings: &[Recording],
    reporting: EffortReporting,
    placebo_terms: Option<usize>,
) -> Result<Diagnosis, DiagnoseError> {
    let compared = known.map_or(model, KnownModel::body);
    let names = names_of(compared);
    let mut selected = selected(known, compared, &names, (recordings, reporting))?;
    let mut diagnosis = selected.diagnosis(compared, &names)?;
    let Selected { design, selection, .. } = &mut selected;
    diagnosis.placebo = placebo_terms.map(|terms| placebo(design, selection, terms));
    if let Some(known) = known {
        diagnosis.put_back(known);
    }
    Ok(diagnosis)
}

/// What recordings show against reference recordings of the same arm: what the reference shows beyond the given model is
/// found first and is no finding. The models of the diagnosis hold it as well.
///
/// # Errors
/// [`DiagnoseError`].
pub(crate) fn against_reference(
    model: &ArmModel,
    reference: &[Recording],
    recordings: &[Recording],
    reporting: EffortReporting,
) -> Result<Diagnosis, DiagnoseError> {
    let (before, narrowed_to_hz) = model_of(model, reference, reporting)?;
    let known = KnownModel::of(before);
    let body = known.body();
    let names = names_of(body);
    let band_hz = narrowed_to_hz.unwrap_or(BAND_HZ);
    // the reference stays in the problem: what is uncertain about the arm before is uncertain in both
    let all = [reference, recordings].concat();
    let (design, beyond_reference) =
        design_of(Some(&known), body, &names, (&all, reporting), band_hz)?
            .against_reference(reference.len());
    let (design, selection) = select(&design).ok_or(DiagnoseError::Unsolvable)?;
    let best = predictor(&selection.metric(), &selection.estimate);
    let (selection, best, errors) = with_size(&design, selection, best);
    let selected = Selected { design, selection, best, errors, sublinear: None, narrowed_to_hz };
    let mut diagnosis = selected.diagnosis(body, &names)?;
    diagnosis.beyond_reference = beyond_reference;
    diagnosis.placeholder_links = placeholder_links(model);
    diagnosis.put_back(&known);
    Ok(diagnosis)
}

/// The fitted model alone, and the narrow band if it was fitted there.
fn model_of(
    model: &ArmModel,
    train: &[Recording],
    reporting: EffortReporting,
) -> Result<(ArmModel, Option<f64>), DiagnoseError> {
    let selected = selected(None, model, &names_of(model), (train, reporting))?;
    let Selected { design, selection, narrowed_to_hz, .. } = &selected;
    let (problem, predicting) = selected.predicting();
    let rigid = rigid_model(model, design)?;
    let (fitted, _) = sound_model(model, design, selection, (problem, predicting), &rigid)?;
    Ok((fitted, *narrowed_to_hz))
}

/// Links of a model whose inertials are placeholders.
fn placeholder_links(model: &ArmModel) -> Vec<String> {
    let joints = model.chain.joints.iter().zip(placeholders(&model.chain));
    joints.filter(|(_, is_one)| *is_one).map(|(joint, _)| joint.child_link.clone()).collect()
}

fn names_of(model: &ArmModel) -> Vec<String> {
    model.chain.joints.iter().map(|j| j.name.clone()).collect()
}

/// A selection, what predicts best, and the recordings they are of.
struct Selected<'a> {
    design: Design<'a>,
    selection: Selection,
    best: Predictor,
    /// of what predicts best
    errors: Jackknife,
    /// with friction that bends over the speed, where joints show that
    sublinear: Option<(LinearProblem, Predictor)>,
    narrowed_to_hz: Option<f64>,
}

/// The selection in the band, or in the narrow one where what it found does not hold there.
fn selected<'a>(
    known: Option<&'a KnownModel>,
    compared: &'a ArmModel,
    names: &[String],
    train: (&[Recording], EffortReporting),
) -> Result<Selected<'a>, DiagnoseError> {
    let design = design_of(known, compared, names, train, BAND_HZ)?;
    let (selection, narrow) =
        rayon::join(|| select(&design), || design_of(known, compared, names, train, NARROW_HZ));
    let (design, selection) = selection.ok_or(DiagnoseError::Unsolvable)?;
    let best = predictor(&selection.metric(), &selection.estimate);
    // longer kernels want longer recordings: without them the band stays
    if let Ok(narrow) = narrow
        && is_off_in(&narrow, &selection, &best)
        && let Some((design, selection)) = select(&narrow)
    {
        let best = predictor(&selection.metric(), &selection.estimate);
        return Ok(Selected::with_sublinear_where_shown(design, selection, best, Some(NARROW_HZ)));
    }
    Ok(Selected::with_sublinear_where_shown(design, selection, best, None))
}

impl<'a> Selected<'a> {
    fn with_sublinear_where_shown(
        design: Design<'a>,
        selection: Selection,
        best: Predictor,
        narrowed_to_hz: Option<f64>,
    ) -> Self {
        let (selection, best, errors) = with_size(&design, selection, best);
        let sublinear = with_sublinear_friction(&design, &selection, &best);
        Self { design, selection, best, errors, sublinear, narrowed_to_hz }
    }

    /// What the model is made of.
    fn predicting(&self) -> (&LinearProblem, &Predictor) {
        match &self.sublinear {
            Some((problem, predictor)) => (problem, predictor),
            None => (&self.selection.problem, &self.best),
        }
    }

    /// The constants where single links are named and all others are exact: with the named ones free and the others known as
    /// well as from CAD. None where no link is named: inertias were not in question.
    fn constants_of_named_links(
        &self,
        given: &ArmModel,
        fitted: &ArmModel,
    ) -> Option<ConstantEstimates> {
        let (problem, predicting) = self.predicting();
        let (links, laws): (Vec<usize>, Vec<usize>) =
            predicting.estimate.set.iter().partition(|g| problem.candidates[**g].is_of_link());
        if links.is_empty() {
            return None;
        }
        let times = INFLATIONS.into_iter().fold(1.0, f64::max);
        let named = |g: &usize| {
            let link = problem.candidates[*g].location.joints.first()?;
            Some(InflatedLink { link: *link, times })
        };
        let inflated: Vec<InflatedLink> = links.iter().filter_map(named).collect();
        let metric = problem.marginalised(CAD_SCALE, &inflated);
        let estimate = fit_set(&metric, laws)?;
        constants(given, fitted, &metric, &estimate)
    }

    /// The diagnosis: findings, models and where the residual is.
    fn diagnosis(&self, model: &ArmModel, names: &[String]) -> Result<Diagnosis, DiagnoseError> {
        let Self { design, selection, best, errors, narrowed_to_hz, .. } = self;
        let (problem, predicting) = self.predicting();
        let metric = selection.metric();
        let best_metric = selection.problem.marginalised(best.scale, &selection.inflated);
        let best_solution = Solution::new(design, &best_metric, &best.estimate, &selection.point);
        let model_metric = problem.marginalised(predicting.scale, &selection.inflated);
        let rigid = rigid_model(model, design)?;
        let (fitted, links_off) =
            sound_model(model, design, selection, (problem, predicting), &rigid)?;
        let constants = if predicting.scale > 0.0 {
            constants(model, &fitted, &model_metric, &predicting.estimate)
        } else {
            self.constants_of_named_links(model, &fitted)
        };
        let reported_findings = reported_findings(design, selection, &best_solution, errors);
        // the model of another estimate, all that is not in question as in the model learned
        let model_of = |estimate: &Estimate, inflated: &[InflatedLink]| {
            let metric = problem.marginalised(predicting.scale, inflated);
            let estimate = predicting.beside(&metric, &selection.estimate, estimate)?;
            let solution = Solution::new(design, &metric, &estimate, &selection.point);
            let (mut model, _) = fitted_model(model, &solution, Links::Consistent);
            model.band.clone_from(&fitted.band);
            Some(model)
        };
        let without = reported_findings
            .par_iter()
            .map(|reported| {
                reported
                    .without
                    .as_ref()
                    .and_then(|(estimate, inflated)| model_of(estimate, inflated))
            })
            .collect();
        let rivals = reported_findings
            .par_iter()
            .map(|reported| {
                reported
                    .rivals
                    .iter()
                    .map(|(estimate, inflated)| model_of(estimate, inflated))
                    .collect()
            })
            .collect();
        let mut believed = model.links_in_band();
        believed.band.clone_from(&fitted.band);
        let mut findings: Vec<Finding> =
            reported_findings.into_iter().map(|reported| reported.finding).collect();
        let has_no_name = |f: &Finding| f.effect == crate::UNMODELLED;
        for finding in findings.iter_mut().filter(|f| has_no_name(f)) {
            let index = |name: &str| names.iter().position(|n| n == name);
            let Some(joint) = finding.joints.first().and_then(|name| index(name)) else { continue };
            let terms = fitted.smooth_terms.iter().filter(|t| t.joint == names[joint]);
            let at = best_solution.at();
            let mut effort: Vec<Vec<f64>> =
                at.iter().map(|at| vec![0.0; at.signals.len()]).collect();
            for term in terms {
                for (sum, at) in effort.iter_mut().zip(at) {
                    for (sum, x) in sum.iter_mut().zip(term.effort(at, index)) {
                        *sum += x;
                    }
                }
            }
            finding.evidence.character = Some(character(design, at, joint, &effort));
        }
        let atlas = atlas(design, &believed, &rigid, &fitted)?;
        Ok(Diagnosis {
            atlas,
            constants,
            findings,
            model: fitted,
            rigid,
            believed,
            without,
            rivals,
            effort_noise: names
                .iter()
                .cloned()
                .zip(design.observations.sample_deviation.clone())
                .collect(),
            joints: names.to_vec(),
            inertial_error: selection.scale,
            links_off,
            narrowed_to_hz: *narrowed_to_hz,
            beyond_reference: BTreeMap::new(),
            input_checks: InputChecks::default(),
            placeholder_links: placeholder_links(model),
            placebo: None,
            recordings: Vec::new(),
            holdout: Vec::new(),
            doubtful_changes: selection
                .inconclusive
                .iter()
                .map(|inconclusive| DoubtfulChange::of(design, inconclusive))
                .collect(),
            inertias_matter_on: joints_of_inertial_errors(&metric, &selection.estimate)
                .into_iter()
                .map(|j| names[j].clone())
                .collect(),
        })
    }
}

/// The given model with its links fitted again and nothing else.
fn rigid_model(model: &ArmModel, design: &Design<'_>) -> Result<ArmModel, DiagnoseError> {
    let mut rigid = links_only_fit(model, design).unwrap_or_else(|| model.links_in_band());
    choose_outputs(&mut rigid, design)?;
    Ok(rigid)
}

/// The model of an estimate, which is not worse on its training recordings than links alone fitted to them. Where it is, its
/// links were held: by a prior about links that are none, or by the projection. Then these are opened.
fn sound_model(
    model: &ArmModel,
    design: &Design<'_>,
    selection: &Selection,
    (problem, predicting): (&LinearProblem, &Predictor),
    rigid: &ArmModel,
) -> Result<(ArmModel, Option<f64>), DiagnoseError> {
    let of = |scale: f64, links: Links| -> Result<Option<(ArmModel, Option<f64>)>, DiagnoseError> {
        let metric = problem.marginalised(scale, &selection.inflated);
        let same = scale == predicting.scale;
        let again = (!same).then(|| fit_any_sign(&metric, predicting.estimate.set.clone()));
        let estimate = match again {
            None => predicting.estimate.clone(),
            Some(None) => return Ok(None),
            Some(Some((estimate, _))) => estimate,
        };
        let solution = Solution::new(design, &metric, &estimate, &selection.point);
        let (mut fitted, off) = fitted_model(model, &solution, links);
        choose_outputs(&mut fitted, design)?;
        Ok(Some((fitted, off)))
    };
    let first = of(predicting.scale, Links::Consistent)?.ok_or(DiagnoseError::Unsolvable)?;
    // of a change only the part after it is compared, and the links of the reference are the reference's
    if design.observations.comparison.seeks_change() {
        return Ok(first);
    }
    let is_worse = |model: &ArmModel| worse_on(model, rigid);
    if !is_worse(&first.0) {
        return Ok(first);
    }
    let open = predicting.scale.max(OPEN_SCALE);
    for (scale, links) in
        [(open, Links::Consistent), (predicting.scale, Links::AsFitted), (open, Links::AsFitted)]
    {
        if let Some(found) = of(scale, links)?
            && !is_worse(&found.0)
        {
            return Ok(found);
        }
    }
    Ok(first)
}

/// Prior scale at which links are anything.
const OPEN_SCALE: f64 = 3.2;
/// Error on a joint over that of links alone from which on a model is worse there: twice the relative standard error of the
/// deviation of 200 independent samples.
const WORSE: f64 = 1.1;

/// Whether a model leaves clearly more than another on a joint of its training recordings.
fn worse_on(model: &ArmModel, than: &ArmModel) -> bool {
    let left = |model: &ArmModel| model.effort_noise.clone().unwrap_or_default();
    left(model).iter().zip(left(than)).any(|(own, other)| *own > WORSE * other)
}

/// The recordings without what is known, and the arm they are compared with.
fn design_of<'a>(
    known: Option<&'a KnownModel>,
    compared: &'a ArmModel,
    names: &[String],
    (recordings, reporting): (&[Recording], EffortReporting),
    band_hz: f64,
) -> Result<Design<'a>, DiagnoseError> {
    let mut signals = usable_signals(names, recordings, band_hz)?;
    signals = signals.into_iter().map(|s| reporting.undone_in(s)).collect::<Result<_, _>>()?;
    let design = |signals| Design::new(&compared.chain, signals).with_library(&compared.library);
    let Some(known) = known else { return Ok(design(signals)) };
    signals = signals.into_iter().map(|s| known.taken_out_of(s)).collect::<Result<_, _>>()?;
    Ok(design(signals).beside(known.effects()))
}
