//! Findings of a diagnosis and their alternatives, from the JSON that `diagnose --json` writes.

use std::path::Path;

use armident_effects::{EffectOnJoint, Library, Scope};
use armident_excitation::RivalEffects;
use armident_kinematics::DrivingAxisChain;
use armident_report::{DiagnoseReport, FindingRow};

use crate::failure::Failure;

const HINT: &str = "pass the JSON of a diagnosis of this arm with alternatives: `armident diagnose ROBOT LOG --json FILE`";

/// The pairs that the recordings of a diagnosis do not distinguish.
///
/// # Errors
/// A file that cannot be read, is no diagnosis, or has no finding with an alternative.
pub fn read_rivals(path: &Path, chain: &DrivingAxisChain) -> Result<Vec<RivalEffects>, Failure> {
    let fault = |what: String| Failure::new(what, path.display(), Some(HINT));
    let text =
        std::fs::read_to_string(path).map_err(|error| fault(format!("cannot read: {error}")))?;
    let report: DiagnoseReport = serde_json::from_str(&text)
        .map_err(|error| fault(format!("expected a diagnosis: {error}")))?;
    let mut rivals = Vec::new();
    for finding in &report.findings {
        // structure that no law explains has no effort to compare
        let Some(of_finding) = placed(finding, chain) else { continue };
        for other in &finding.alternatives {
            if Library::standard().get(&other.effect).is_none() {
                continue;
            }
            rivals.push(RivalEffects {
                finding: of_finding.clone(),
                alternative: other.effect.clone(),
                alternative_joint: joint_of(chain, &other.joints, other.link.as_deref()),
            });
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

/// The finding with parameters in the order of its law; those that its motion did not excite are zero.
fn placed(finding: &FindingRow, chain: &DrivingAxisChain) -> Option<EffectOnJoint> {
    let law = Library::standard().law(&finding.effect)?;
    let value = |name: &str| finding.parameters.get(name).map_or(0.0, |estimate| estimate.value);
    let parameters: Vec<f64> = law.parameters.iter().map(|p| value(p.name)).collect();
    let joint = match law.scope {
        Scope::Arm => String::new(),
        _ => joint_of(chain, &finding.joints, finding.link.as_deref()),
    };
    Some(EffectOnJoint {
        other_joint: finding.joints.get(1).cloned(),
        ..EffectOnJoint::new(&finding.effect, joint, parameters)
    })
}

/// The joint of an effect; of a link, the one that moves it.
fn joint_of(chain: &DrivingAxisChain, joints: &[String], link: Option<&str>) -> String {
    let moved = link.and_then(|link| {
        let holds = |names: &[String]| names.iter().any(|name| name == link);
        chain.joints.iter().find(|j| holds(&j.body_links)).map(|j| j.name.clone())
    });
    moved.or_else(|| joints.first().cloned()).unwrap_or_default()
}
