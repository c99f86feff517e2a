//! Findings and their alternatives: of a diagnosis, or from the JSON that `diagnose --json` writes.

use std::path::Path;

use armident_diagnose::{Diagnosis, OpenPair, Value};
use armident_effects::{EffectOnJoint, Library, Scope};
use armident_excitation::{RivalEffects, RivalModels};
use armident_kinematics::DrivingAxisChain;
use armident_model::{ArmModel, PreparedRecording};
use armident_recording::Recording;
use armident_report::DiagnoseReport;

use crate::failure::Failure;

const HINT: &str = "pass the JSON of a diagnosis of this arm with alternatives: `armident diagnose ROBOT LOG --json FILE`";

/// The pairs that the recordings of a diagnosis do not distinguish.
///
/// # Errors
/// A file that cannot be read, is no diagnosis, or has no finding with an alternative.
pub fn read_rivals(
    path: &Path,
    chain: &DrivingAxisChain,
) -> Result<Vec<RivalEffects<'static>>, Failure> {
    let fault = |what: String| Failure::new(what, path.display(), Some(HINT));
    let text =
        std::fs::read_to_string(path).map_err(|error| fault(format!("cannot read: {error}")))?;
    let report: DiagnoseReport = serde_json::from_str(&text)
        .map_err(|error| fault(format!("expected a diagnosis: {error}")))?;
    let mut rivals = Vec::new();
    for finding in &report.findings {
        let place = Place { joints: &finding.joints, link: finding.link.as_deref() };
        let value = |name: &str| finding.parameters.get(name).map(|estimate| estimate.value);
        let Some(of_finding) = placed(chain, &finding.effect, place, value) else { continue };
        for other in &finding.alternatives {
            let at = Place { joints: &other.joints, link: other.link.as_deref() };
            rivals.extend(rival(chain, &of_finding, &other.effect, at));
        }
    }
    if rivals.is_empty() {
        return Err(fault(format!(
            "expected a finding with an alternative, found {} without one",
            armident_report::counted(report.findings.len(), "finding")
        )));
    }
    Ok(rivals)
}

/// The models of an open pair of a diagnosis.
#[derive(Debug)]
pub(crate) struct FittedPair<'a> {
    joints: &'a [String],
    models: [&'a ArmModel; 2],
}

impl RivalModels for FittedPair<'_> {
    fn difference(&self, motion: &Recording) -> Option<Vec<Vec<f64>>> {
        let motion = PreparedRecording::of(motion, self.joints).ok()?;
        let [mut one, other] = self.models.map(|model| model.predict_prepared(&motion).ok());
        for (one, other) in one.iter_mut().flatten().zip(other?) {
            one.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
        }
        one
    }
}

/// The models of pairs that a diagnosis leaves open, in their order.
pub(crate) fn fitted_pairs<'a>(
    diagnosis: &'a Diagnosis,
    open: &[OpenPair<'a>],
) -> Vec<Option<FittedPair<'a>>> {
    let pair = |models| FittedPair { joints: &diagnosis.joints, models };
    open.iter().map(|open| open.models.map(pair)).collect()
}

/// The pairs that a diagnosis leaves open; structure that no law explains has no effort to compare.
pub(crate) fn open_rivals<'a>(
    chain: &DrivingAxisChain,
    open: &[OpenPair<'_>],
    models: &'a [Option<FittedPair<'a>>],
) -> Vec<RivalEffects<'a>> {
    let mut rivals = Vec::new();
    for (open, models) in open.iter().zip(models) {
        let (finding, other) = (open.finding, open.alternative);
        let place = Place { joints: &finding.joints, link: finding.link.as_deref() };
        let value = |name: &str| finding.parameters.get(name).map(|of: &Value| of.value);
        let at = Place { joints: &other.joints, link: other.link.as_deref() };
        let pair = placed(chain, &finding.effect, place, value)
            .and_then(|finding| rival(chain, &finding, &other.effect, at));
        let models = models.as_ref().map(|models| models as &dyn RivalModels);
        rivals.extend(pair.map(|pair| RivalEffects { models, ..pair }));
    }
    rivals
}

/// Where an effect is.
#[derive(Clone, Copy)]
struct Place<'a> {
    joints: &'a [String],
    link: Option<&'a str>,
}

impl Place<'_> {
    /// The joint of an effect; of a link, the one that moves it.
    fn joint(&self, chain: &DrivingAxisChain) -> String {
        let moved = self.link.and_then(|link| {
            let holds = |names: &[String]| names.iter().any(|name| name == link);
            chain.joints.iter().find(|j| holds(&j.body_links)).map(|j| j.name.clone())
        });
        moved.or_else(|| self.joints.first().cloned()).unwrap_or_default()
    }
}

/// A finding beside an alternative; none where the library has no such effect.
fn rival(
    chain: &DrivingAxisChain,
    finding: &EffectOnJoint,
    alternative: &str,
    at: Place<'_>,
) -> Option<RivalEffects<'static>> {
    Library::standard().get(alternative)?;
    Some(RivalEffects {
        finding: finding.clone(),
        alternative: alternative.to_owned(),
        alternative_joint: at.joint(chain),
        models: None,
    })
}

/// The finding with parameters in the order of its law; those that its motion did not excite are zero. None of structure that
/// no law explains.
fn placed(
    chain: &DrivingAxisChain,
    effect: &str,
    at: Place<'_>,
    value: impl Fn(&str) -> Option<f64>,
) -> Option<EffectOnJoint> {
    let law = Library::standard().law(effect)?;
    let parameters: Vec<f64> =
        law.parameters.iter().map(|p| value(p.name).unwrap_or(0.0)).collect();
    let joint = match law.scope {
        Scope::Arm => String::new(),
        _ => at.joint(chain),
    };
    Some(EffectOnJoint {
        other_joint: at.joints.get(1).cloned(),
        ..EffectOnJoint::new(effect, joint, parameters)
    })
}
