//! The diagnosis: findings, model, proof.

use crate::checks::usable::{DiagnoseError, usable_signals};
use std::collections::BTreeMap;

use armident_ident::validate::whiteness;
use armident_kinematics::DrivingAxisChain;
use armident_model::{ArmModel, PreparedRecording};
use armident_recording::{Recording, RecordingError};
use rayon::prelude::*;
use serde::Serialize;

use crate::checks::effort_columns::DriveGain;
use crate::design::design::Design;
use crate::design::known_effort::Known;
use crate::design::linear_problem::LinearProblem;
use crate::findings::finding::{DoubtfulChange, Finding, reported_findings};
use crate::findings::fitted_model::{choose_outputs, fitted_model, rigid_alone};
use crate::findings::next_experiment::{NextMotion, Rivals, next_motion};
use crate::findings::placebo::{Placebo, placebo};
use crate::findings::residual_map::{JointAtlas, atlas, character};
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::Estimate;
use crate::selection::bandwidth_test::{NARROW_HZ, is_off_in};
use crate::selection::cross_validation::{Predictor, predictor};
use crate::selection::iterate::select;
use crate::selection::materiality::joints_of_inertial_errors;
use crate::selection::solution::{Selection, Solution};
use crate::selection::sublinear::with_sublinear_friction;
use crate::uncertainty::minimal_constants::{ConstantEstimates, constants};
use armident_motion::BAND_HZ;

/// Root mean square errors of the raw recorded effort, by joint.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Errors {
    /// The believed model.
    pub before: BTreeMap<String, f64>,
    /// The rigid body identified again, nothing else.
    pub rigid: BTreeMap<String, f64>,
    /// The diagnosed model.
    pub after: BTreeMap<String, f64>,
}

/// The result.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Most material first.
    pub findings: Vec<Finding>,
    /// The model with what was learned.
    pub model: ArmModel,
    /// The believed model with its rigid body identified again.
    pub rigid: ArmModel,
    /// The model before: the believed one, with what is known of a reference or of a model, and the low-passes of the
    /// diagnosed one: what these take of the noise of encoders is no physics.
    pub believed: ArmModel,
    /// for each finding, the model that does without it
    pub(crate) without: Vec<Option<ArmModel>>,
    /// for each finding, the models with its alternatives in its place, in their order; none where there is no such model
    pub(crate) rivals: Vec<Vec<Option<ArmModel>>>,
    /// Joints of the chain.
    pub joints: Vec<String>,
    /// Noise of one recorded effort sample \[N m or N\].
    pub effort_noise: BTreeMap<String, f64>,
    /// The minimal set of the diagnosed arm; none where the recordings ask for no error of the inertias.
    pub constants: Option<ConstantEstimates>,
    /// Relative error of the believed inertias that the recordings ask for.
    pub inertial_error: f64,
    /// By how many standard errors the links of the model are off what was found, where no real bodies have that;
    /// none where they are what was found.
    pub links_off: Option<f64>,
    /// Frequency below which all was compared \[Hz\], where the usual band does not hold; none where it does.
    pub narrowed_to_hz: Option<f64>,
    /// With a reference: joints that now move faster than there, and their speed there \[rad/s or m/s\]. What is
    /// clearly faster is not compared: the friction there, the reference does not say.
    pub beyond_reference: BTreeMap<String, f64>,
    /// With a reference: changes that are not certain enough to be named.
    pub doubtful_changes: Vec<DoubtfulChange>,
    /// Joints on which these errors of all links together matter, whether or not a single link is named.
    pub inertias_matter_on: Vec<String>,
    /// Where the mismatch is, joint by joint, on the recordings fitted.
    pub atlas: Vec<JointAtlas>,
}

/// Diagnoses the difference between a believed arm and recordings.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose(model: &ArmModel, train: &[Recording]) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with_placebo(model, train, None).map(|(diagnosis, _)| diagnosis)
}

/// The same of what a known model leaves out.
pub(crate) fn diagnose_beside(
    known: &Known,
    train: &[Recording],
    wrong_terms: Option<usize>,
) -> Result<(Diagnosis, Option<Placebo>), DiagnoseError> {
    told(Some(known), known.arm(), train, wrong_terms)
}

fn told(
    known: Option<&Known>,
    model: &ArmModel,
    train: &[Recording],
    wrong_terms: Option<usize>,
) -> Result<(Diagnosis, Option<Placebo>), DiagnoseError> {
    let names = names_of(model);
    let mut selected = selected(known, &model.chain, &names, train)?;
    let diagnosis = selected.told(model, &names)?;
    let Selected { design, selection, .. } = &mut selected;
    Ok((diagnosis, wrong_terms.map(|terms| placebo(design, selection, terms))))
}

/// The diagnosis, and what its selection makes of so many wrong terms beside what it found
/// ([`Placebo`]).
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose_with_placebo(
    model: &ArmModel,
    train: &[Recording],
    wrong_terms: Option<usize>,
) -> Result<(Diagnosis, Option<Placebo>), DiagnoseError> {
    told(None, model, train, wrong_terms)
}

/// The model alone, of which nothing needs to be said, and the narrow band if it is of that.
pub(crate) fn model_of(
    model: &ArmModel,
    train: &[Recording],
) -> Result<(ArmModel, Option<f64>), DiagnoseError> {
    let selected = selected(None, &model.chain, &names_of(model), train)?;
    let Selected { design, selection, narrowed_to_hz, .. } = &selected;
    let (problem, predicting) = selected.predicting();
    let metric = problem.marginalised(predicting.scale, &selection.inflated);
    let solution = Solution::new(design, &metric, &predicting.estimate, &selection.point);
    let (mut fitted, _) = fitted_model(model, &solution);
    choose_outputs(&mut fitted, design)?;
    Ok((fitted, *narrowed_to_hz))
}

/// The diagnosis of what changed in the recordings from `from` on, in the band that those before it had.
pub(crate) fn diagnose_from(
    known: &Known,
    train: &[Recording],
    from: usize,
    narrowed_to_hz: Option<f64>,
) -> Result<Diagnosis, DiagnoseError> {
    let model = known.arm();
    let names = names_of(model);
    let band_hz = narrowed_to_hz.unwrap_or(BAND_HZ);
    let (design, beyond_reference) =
        design_of(Some(known), &model.chain, &names, train, band_hz)?.against_reference(from);
    let (design, selection) = select(&design).ok_or(DiagnoseError::Unsolvable)?;
    let best = predictor(&selection.metric(), &selection.estimate);
    let selected = Selected { design, selection, best, sublinear: None, narrowed_to_hz };
    Ok(Diagnosis { beyond_reference, ..selected.told(model, &names)? })
}

fn names_of(model: &ArmModel) -> Vec<String> {
    model.chain.joints.iter().map(|j| j.name.clone()).collect()
}

/// A selection, what predicts best, and the recordings they are of.
struct Selected<'a> {
    design: Design<'a>,
    selection: Selection,
    best: Predictor,
    /// with friction that bends over the speed, where joints show that
    sublinear: Option<(LinearProblem, Predictor)>,
    narrowed_to_hz: Option<f64>,
}

/// The selection in the band, or in the narrow one where what it found does not hold there.
fn selected<'a>(
    known: Option<&'a Known>,
    chain: &'a DrivingAxisChain,
    names: &[String],
    train: &[Recording],
) -> Result<Selected<'a>, DiagnoseError> {
    let design = design_of(known, chain, names, train, BAND_HZ)?;
    let (selection, narrow) =
        rayon::join(|| select(&design), || design_of(known, chain, names, train, NARROW_HZ));
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
        let sublinear = with_sublinear_friction(&design, &selection, &best);
        Self { design, selection, best, sublinear, narrowed_to_hz }
    }

    /// What the model is made of.
    fn predicting(&self) -> (&LinearProblem, &Predictor) {
        match &self.sublinear {
            Some((problem, predictor)) => (problem, predictor),
            None => (&self.selection.problem, &self.best),
        }
    }

    /// What is said of it.
    fn told(&self, model: &ArmModel, names: &[String]) -> Result<Diagnosis, DiagnoseError> {
        let Self { design, selection, best, narrowed_to_hz, .. } = self;
        let (problem, predicting) = self.predicting();
        let metric = selection.metric();
        let best_metric = selection.problem.marginalised(best.scale, &selection.inflated);
        let best_solution = Solution::new(design, &best_metric, &best.estimate, &selection.point);
        let model_metric = problem.marginalised(predicting.scale, &selection.inflated);
        let model_solution =
            Solution::new(design, &model_metric, &predicting.estimate, &selection.point);
        let (mut fitted, links_off) = fitted_model(model, &model_solution);
        choose_outputs(&mut fitted, design)?;
        let constants = constants(model, &fitted, &model_metric, &predicting.estimate);
        let reported_findings = reported_findings(design, selection, &best_solution);
        // the model of another estimate, all that is not in question as in the model learned
        let model_of = |estimate: &Estimate, inflated: &[InflatedLink]| {
            let metric = problem.marginalised(predicting.scale, inflated);
            let estimate = predicting.beside(&metric, &selection.estimate, estimate)?;
            let solution = Solution::new(design, &metric, &estimate, &selection.point);
            let (mut model, _) = fitted_model(model, &solution);
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
        let mut rigid = rigid_alone(model, design).unwrap_or_else(|| model.links_in_band());
        choose_outputs(&mut rigid, design)?;
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

/// The recordings without what is known, and the arm they are compared with.
fn design_of<'a>(
    known: Option<&'a Known>,
    chain: &'a DrivingAxisChain,
    names: &[String],
    recordings: &[Recording],
    band_hz: f64,
) -> Result<Design<'a>, DiagnoseError> {
    let mut signals = usable_signals(names, recordings, band_hz)?;
    let Some(known) = known else { return Ok(Design::new(chain, signals)) };
    signals = signals.into_iter().map(|s| known.taken_out_of(s)).collect::<Result<_, _>>()?;
    Ok(Design::new(chain, signals).beside(known.effects()))
}

impl Diagnosis {
    /// Recordings made ready for its models.
    ///
    /// # Errors
    /// A recording that cannot be used.
    pub fn see<'a>(
        &self,
        recordings: &'a [Recording],
    ) -> Result<Vec<PreparedRecording<'a>>, RecordingError> {
        recordings.iter().map(|recording| PreparedRecording::of(recording, &self.joints)).collect()
    }

    /// Errors on recordings, all samples together; without recordings nothing.
    ///
    /// # Errors
    /// None but those of a prediction.
    pub fn errors(&self, recordings: &[PreparedRecording<'_>]) -> Result<Errors, RecordingError> {
        let of = |model| self.error_of(model, recordings);
        let (before, (rigid, after)) = rayon::join(
            || of(&self.believed),
            || rayon::join(|| of(&self.rigid), || of(&self.model)),
        );
        Ok(Errors { before: before?, rigid: rigid?, after: after? })
    }

    /// Marks every finding as confirmed or not by recordings that the model was not fitted to: whether
    /// they are predicted better with it than without it, all else fitted again, on the joint where it
    /// matters most. Changes neither names nor confidences nor the model.
    ///
    /// # Errors
    /// None but those of a prediction.
    pub fn confirm(&mut self, kept_out: &[PreparedRecording<'_>]) -> Result<(), RecordingError> {
        let with = self.error_of(&self.model, kept_out)?;
        let judged = |(finding, without): (&Finding, &Option<ArmModel>)| {
            let joint = &finding.evidence.joint;
            match without {
                Some(model) if finding.window.is_none() && with.contains_key(joint) => {
                    Ok(Some(with[joint] < self.error_of(model, kept_out)?[joint]))
                }
                _ => Ok(None),
            }
        };
        let findings = self.findings.par_iter().zip(&self.without);
        let confirmed = findings.map(judged).collect::<Result<Vec<_>, RecordingError>>()?;
        for (finding, confirmed) in self.findings.iter_mut().zip(confirmed) {
            finding.confirmed = confirmed;
        }
        Ok(())
    }

    /// Puts the inconclusive in the gains of drives into the standard errors of masses and moments: they are the
    /// gain's as much as the efforts'.
    pub fn doubt_gains(&mut self, gains: &[DriveGain]) {
        for finding in self.findings.iter_mut().filter(|f| f.link.is_some()) {
            let of_joint = |name: &str| gains.iter().find(|g| g.joint == name);
            let Some(gain) = of_joint(&finding.evidence.joint) else { continue };
            for name in ["mass", "delta_mass", "delta_mcx", "delta_mcy", "delta_mcz"] {
                if let Some(value) = finding.parameters.get_mut(name) {
                    let own = value.stderr.unwrap_or(0.0);
                    value.stderr = Some(own.hypot(value.value * gain.relative_stderr()));
                }
            }
        }
    }

    /// The motion that would best tell the findings from their alternatives, inside the arm's limits;
    /// none without alternatives, or where no motion tells them apart.
    ///
    /// # Errors
    /// None but those of a prediction.
    pub fn next_motion(&self) -> Result<Option<NextMotion>, RecordingError> {
        let place = |name: &String| self.joints.iter().position(|j| j == name);
        let mut pairs = Vec::new();
        for (finding, rivals) in self.findings.iter().zip(&self.rivals) {
            for (alternative, other) in finding.alternatives.iter().zip(rivals) {
                let Some(other) = other else { continue };
                let mut joints: Vec<usize> =
                    finding.joints.iter().chain(&alternative.joints).filter_map(place).collect();
                joints.extend(place(&finding.evidence.joint));
                pairs.push(Rivals { one: &self.model, other, joints });
            }
        }
        if pairs.is_empty() {
            return Ok(None);
        }
        let noise: Vec<f64> = self.joints.iter().map(|j| self.effort_noise[j]).collect();
        next_motion(&self.model.chain, &noise, &pairs)
    }

    /// Whether what the model leaves over on recordings is white: p-values of the Ljung-Box test, by joint
    /// with an effort.
    ///
    /// # Errors
    /// None but those of a prediction.
    pub fn whiteness(
        &self,
        recordings: &[PreparedRecording<'_>],
    ) -> Result<BTreeMap<String, f64>, RecordingError> {
        let mut left: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
        for PreparedRecording { signals, .. } in recordings {
            let predicted = self.model.predict_in_band(signals)?;
            for (j, name) in self.joints.iter().enumerate() {
                let recorded = &signals.effort[j];
                if recorded.is_empty() {
                    continue;
                }
                let difference: Vec<f64> =
                    recorded.iter().zip(&predicted[j]).map(|(e, p)| e - p).collect();
                left.entry(name.clone())
                    .or_default()
                    .push(signals.band.independent_rows(&difference));
            }
        }
        Ok(left.into_iter().map(|(name, rows)| (name, whiteness(&rows).1)).collect())
    }

    /// Root mean square errors of a model on recordings, by joint with an effort in any of them.
    fn error_of(
        &self,
        model: &ArmModel,
        recordings: &[PreparedRecording<'_>],
    ) -> Result<BTreeMap<String, f64>, RecordingError> {
        let mut squares: BTreeMap<String, (f64, usize)> = BTreeMap::new();
        for seen in recordings {
            let predicted = model.predict_prepared(seen)?;
            for (name, predicted) in self.joints.iter().zip(&predicted) {
                if let Some(recorded) = seen.recording().joint(name).and_then(|j| j.effort.as_ref())
                {
                    let (sum, samples) = squares.entry(name.clone()).or_default();
                    *sum +=
                        predicted.iter().zip(recorded).map(|(p, r)| (p - r).powi(2)).sum::<f64>();
                    *samples += recorded.len();
                }
            }
        }
        let error = |(sum, samples): (f64, usize)| (sum / samples as f64).sqrt();
        Ok(squares.into_iter().map(|(name, squares)| (name, error(squares))).collect())
    }
}
