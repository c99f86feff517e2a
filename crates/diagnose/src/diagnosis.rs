//! The diagnosis: findings, models, and how these predict recordings.

use crate::checks::effort_columns::InputChecks;
use crate::checks::reporting::EffortReporting;
use crate::design::known_effort::KnownModel;
use std::collections::BTreeMap;

use armident_effects::{DriveLowPass, Effect, TimeDelay};
use armident_ident::checks::LinkLength;
use armident_inference::levels::EXPECTED_T;
use armident_inference::{paired_t, whiteness};
use armident_model::{ArmModel, PreparedRecording};
use armident_recording::{Recording, RecordingError};
use rayon::prelude::*;
use serde::Serialize;

use crate::findings::confidence::{NOT_CONFIRMED, beside_other, with_odds};
use crate::findings::finding::{Alternative, DoubtfulChange, Finding};
use crate::findings::geometry::length_finding;
use crate::findings::placebo::Placebo;
use crate::findings::residual_map::JointAtlas;
use crate::uncertainty::minimal_constants::ConstantEstimates;

/// Blocks of a hold-out recording over which errors are compared.
const HOLDOUT_BLOCKS: usize = 8;

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

/// A finding and an alternative that the recordings do not distinguish.
#[derive(Debug, Clone, Copy)]
pub struct OpenPair<'a> {
    /// The finding.
    pub finding: &'a Finding,
    /// What it may be instead.
    pub alternative: &'a Alternative,
    /// The models fitted with the one and with the other; none where there are no such models.
    pub models: Option<[&'a ArmModel; 2]>,
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
    /// Links whose given inertials are placeholders: no prior was taken from them.
    pub placeholder_links: Vec<String>,
    /// Joints on which these errors of all links together matter, whether or not a single link is named.
    pub inertias_matter_on: Vec<String>,
    /// Where the mismatch is, joint by joint, on the recordings fitted.
    pub atlas: Vec<JointAtlas>,
    /// Whether the effort columns are what their headers say.
    pub input_checks: InputChecks,
    /// What the selection makes of placebo terms, where they were asked for.
    pub placebo: Option<Placebo>,
    /// The recordings that were fitted, currents and voltages as efforts.
    pub recordings: Vec<Recording>,
    /// The same of those that were held out.
    pub holdout: Vec<Recording>,
}

impl Diagnosis {
    /// What a model explained beforehand becomes part of all models of a diagnosis of what it leaves out.
    pub(crate) fn put_back(&mut self, known: &KnownModel) {
        let beside = self.without.iter_mut().flatten();
        let rivals = self.rivals.iter_mut().flatten().flatten();
        let own = [&mut self.model, &mut self.rigid, &mut self.believed];
        for model in own.into_iter().chain(beside).chain(rivals) {
            *model = known.model.with_change(model.clone());
        }
    }

    /// The first finding is a distance between two axes, which the models of the arm have; the given one has its own.
    pub(crate) fn report_length(&mut self, found: &LinkLength, without: Option<ArmModel>) {
        let given = &mut self.believed;
        *given = found.as_given(given);
        let shown_by = &self.joints[found.shown_by];
        let noise = self.effort_noise.get(shown_by).copied().unwrap_or(0.0);
        self.findings.insert(0, length_finding(found, &self.joints, noise));
        self.without.insert(0, without);
        self.rivals.insert(0, Vec::new());
    }

    /// The models of the arm report their efforts as they come into the recordings; the given one does only where it is what a
    /// reference shows.
    pub(crate) fn report_as(&mut self, reporting: EffortReporting, of_reference: bool) {
        let beside = self.without.iter_mut().flatten();
        let rivals = self.rivals.iter_mut().flatten().flatten();
        let given = of_reference.then_some(&mut self.believed);
        let own = [&mut self.model, &mut self.rigid].into_iter().chain(given);
        for model in own.chain(beside).chain(rivals) {
            reporting.put_into(model);
        }
    }

    /// A delay of the efforts that a low-pass explains as well is less sure, and has it as an alternative.
    pub(crate) fn weigh_low_pass_against_delay(&mut self) {
        let Some(found) = self.input_checks.low_pass_or_delay else { return };
        for finding in self.findings.iter_mut().filter(|f| f.effect == TimeDelay.slug()) {
            finding.confidence = beside_other(finding.confidence, found.delay_over_low_pass);
            finding.alternatives.push(Alternative {
                effect: DriveLowPass.slug().to_owned(),
                joints: finding.joints.clone(),
                link: None,
                left_more: None,
                separated_by: TimeDelay.law().separated_from(DriveLowPass.law()),
            });
        }
    }

    /// Recordings prepared once for the predictions of its models: [those fitted](Self::recordings), the
    /// [hold-out](Self::holdout), or others.
    ///
    /// # Errors
    /// A recording that cannot be used.
    pub fn prepared<'a>(
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

    /// Marks every finding as confirmed or not by the hold-out: whether it is predicted better with the finding than
    /// without it, all else fitted again, on the joint where it matters most. Changes neither names nor the model. What the
    /// hold-out contradicts is less sure: hypothesis, the finding does not raise the error; statistic, the paired t of the
    /// errors with and without it over blocks of the hold-out. Where neither is better beyond their scatter, the odds fall
    /// instead of the confidence: the others explain as much.
    pub(crate) fn confirm(&mut self) -> Result<(), RecordingError> {
        let holdout = self.prepared(&self.holdout)?;
        let with = self.block_squares(&self.model, &holdout)?;
        let judged = |(finding, without): (&Finding, &Option<ArmModel>)| {
            let joint = &finding.evidence.joint;
            let (Some(model), None, Some(with)) = (without, &finding.window, with.get(joint))
            else {
                return Ok(None);
            };
            let without = &self.block_squares(model, &holdout)?[joint];
            let gains: Vec<f64> =
                without.iter().zip(with).map(|(without, with)| (without / with).ln()).collect();
            let [with, without] = [with, without].map(|squares| squares.iter().sum::<f64>());
            let gain = Some(1.0 - with / without).filter(|gain| gain.is_finite());
            Ok(Some((with < without, paired_t(&gains) < -EXPECTED_T, gain)))
        };
        let findings = self.findings.par_iter().zip(&self.without);
        let judged = findings.map(judged).collect::<Result<Vec<_>, RecordingError>>()?;
        for (finding, judged) in self.findings.iter_mut().zip(judged) {
            let Some((is_better, is_clearly_worse, gain)) = judged else {
                finding.confirmed = None;
                continue;
            };
            finding.evidence.holdout_gain = gain;
            finding.confirmed = Some(is_better);
            match (is_better, is_clearly_worse) {
                (true, _) => {}
                (false, true) => finding.confidence *= NOT_CONFIRMED,
                (false, false) => {
                    finding.confidence = with_odds(finding.confidence, NOT_CONFIRMED);
                }
            }
        }
        Ok(())
    }

    /// Squared errors of a model on blocks of recordings, by joint with an effort in any of them.
    fn block_squares(
        &self,
        model: &ArmModel,
        recordings: &[PreparedRecording<'_>],
    ) -> Result<BTreeMap<String, Vec<f64>>, RecordingError> {
        let mut squares: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for seen in recordings {
            let predicted = model.predict_prepared(seen)?;
            for (name, predicted) in self.joints.iter().zip(&predicted) {
                if let Some(recorded) = seen.recording().joint(name).and_then(|j| j.effort.as_ref())
                {
                    let length = recorded.len().div_ceil(HOLDOUT_BLOCKS).max(1);
                    let errors: Vec<f64> =
                        predicted.iter().zip(recorded).map(|(p, r)| (p - r).powi(2)).collect();
                    let blocks = errors.chunks(length).map(|block| block.iter().sum::<f64>());
                    squares.entry(name.clone()).or_default().extend(blocks);
                }
            }
        }
        Ok(squares)
    }

    /// Puts the uncertainty of inferred drive gains into the standard errors of masses and moments: they are the
    /// gain's as much as the efforts'.
    pub(crate) fn widen_by_drive_gains(&mut self) {
        let gains = &self.input_checks.drive_gains;
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

    /// Findings and their alternatives: what the recordings do not distinguish.
    pub fn open_pairs(&self) -> Vec<OpenPair<'_>> {
        let pairs = self.findings.iter().zip(&self.rivals).flat_map(|(finding, rivals)| {
            // a finding that was not fitted has no model of its alternatives
            let models = rivals.iter().map(Option::as_ref).chain(std::iter::repeat(None));
            let pair = move |(alternative, other): (_, Option<_>)| OpenPair {
                finding,
                alternative,
                models: other.map(|other| [&self.model, other]),
            };
            finding.alternatives.iter().zip(models).map(pair)
        });
        pairs.collect()
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
        let samples = |name: &str| -> usize {
            let efforts = |seen: &PreparedRecording<'_>| {
                seen.recording().joint(name).and_then(|j| j.effort.as_ref()).map_or(0, Vec::len)
            };
            recordings.iter().map(efforts).sum()
        };
        let error = |(name, squares): (String, Vec<f64>)| {
            let mean = squares.iter().sum::<f64>() / samples(&name) as f64;
            (name, mean.sqrt())
        };
        Ok(self.block_squares(model, recordings)?.into_iter().map(error).collect())
    }
}
