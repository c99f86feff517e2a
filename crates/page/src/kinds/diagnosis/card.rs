//! The card of a finding.

use armident_effects::effect;
use armident_report::{
    DiagnoseReport, EstimateRow, FindingRow, capital, effect_label, in_noise_levels,
    parameter_label, percent, sentence, significant, uncertain, unit_after_number,
};

use super::evidence::{size, strength};
use crate::drawing::{Drawing, DrawnQuantity, FindingTraces};
use crate::figures;
use crate::view::{Card, Fitted, number};

/// Cards that are open at first.
const OPEN: usize = 3;
/// Joints whose residuals are listed.
const LISTED: usize = 4;

pub(super) fn card(k: usize, finding: &FindingRow, of: &DiagnoseReport, drawing: &Drawing) -> Card {
    let traces = drawing.findings.get(k);
    let mut location = finding.location();
    if let (Some([from, to]), Some(recording)) = (finding.window, &finding.recording) {
        location =
            format!("{location} from {} s to {} s of {recording}", number(from, 4), number(to, 4));
        location = location.trim().to_owned();
    }
    let size = size(finding);
    let strength = strength(finding);
    let needed = finding.parameters.iter().filter(|(_, estimate)| estimate.is_needed());
    Card {
        id: format!("finding-card-{k}"),
        what: finding.label(),
        place: location,
        sure: if size.is_empty() { strength } else { format!("{size}, {strength}") },
        size,
        confidence: format!("{:.2}", finding.confidence),
        formula: effect(&finding.effect).map_or_else(String::new, |e| e.law().formula.to_owned()),
        parameters: needed.map(|(name, estimate)| fitted(name, estimate)).collect(),
        why: evidence(finding, drawing.quantity),
        regime: traces.map_or_else(String::new, |traces| residuals(traces, drawing)),
        look_alikes: look_alikes(finding, of),
        figure: traces.and_then(|traces| figures::finding(drawing, k, traces)),
        open: k < OPEN,
    }
}

fn fitted(name: &str, estimate: &EstimateRow) -> Fitted {
    let interval = estimate.stderr.map_or_else(
        || "-".to_owned(),
        |s| {
            let ends = [estimate.value - 1.96 * s, estimate.value + 1.96 * s];
            format!("{} to {}", uncertain(ends[0], s).0, uncertain(ends[1], s).0)
        },
    );
    Fitted {
        name: parameter_label(name),
        value: estimate.stderr.map_or_else(
            || significant(estimate.value, 3, 0.0),
            |s| uncertain(estimate.value, s).0,
        ),
        interval,
        unit: unit_after_number(&estimate.unit).to_owned(),
    }
}

/// Evidence of the finding, in words.
fn evidence(finding: &FindingRow, quantity: DrawnQuantity) -> String {
    let of = &finding.evidence;
    let mut text = format!(
        "{} (confidence {:.2}, a score: 0.50 at the threshold of materiality or size, 0.95 at twice the threshold). Materiality {} \
         on {} (threshold {}): RMS {} in noise levels that only this finding explains, after refitting everything \
         else.",
        capital(&strength(finding)),
        finding.confidence,
        in_noise_levels(of.materiality, 2),
        of.joint,
        number(of.materiality_threshold, 2),
        quantity.word(),
    );
    if !of.variables.is_empty() {
        text += &format!(" Regressors: {}.", of.variables.join(", "));
    }
    if let Some(character) = &of.character {
        text += &format!(" {}.", capital(&character.traits().join(", ")));
    }
    match finding.confirmed {
        Some(true) => text += " Confirmed by the hold-out.",
        Some(false) => text += " Not confirmed: the hold-out error is not lower with it.",
        None => {}
    }
    text
}

/// Residuals with and without a finding, where it acts, the joints that it improves most first.
fn residuals(traces: &FindingTraces, drawing: &Drawing) -> String {
    let mut parts = Vec::new();
    for ((joint, rms), share) in drawing.joints.iter().zip(&traces.joints).zip(&traces.share) {
        if let Some([without, with]) = rms {
            parts.push((
                without / with.max(f64::MIN_POSITIVE),
                format!(
                    "{}: RMS residual {} {unit} without it, {} {unit} with it (in {} of the samples)",
                    joint.name,
                    number(*without, 3),
                    number(*with, 3),
                    percent(*share),
                    unit = drawing.quantity.unit(joint)
                ),
            ));
        }
    }
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    parts.truncate(LISTED);
    parts.into_iter().map(|p| p.1).collect::<Vec<_>>().join("; ")
}

/// Effects with a similar signature, and how to distinguish them from a finding.
fn look_alikes(finding: &FindingRow, of: &DiagnoseReport) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = finding
        .alternatives
        .iter()
        .map(|other| {
            let more = other.extra_residual.map_or_else(String::new, |m| {
                format!(
                    "; with it instead, the residual is only {} noise levels larger",
                    number(m.max(0.0), 2)
                )
            });
            let how = other.separated_by.as_ref().map_or_else(
                || "Use --next-motion DIR to generate a motion that separates them.".to_owned(),
                |motion| sentence(motion),
            );
            (other.title(), format!("not distinguishable with these recordings{more}. {how}"))
        })
        .collect();
    let Some(law) = effect(&finding.effect).map(|e| e.law()) else { return all };
    for other in law.look_alikes {
        if finding.alternatives.iter().any(|a| a.effect == other.slug) {
            continue;
        }
        let is_beside =
            of.findings.iter().any(|f| f.effect == other.slug && f.joints == finding.joints);
        let lead = if is_beside {
            "reported as well, each fitted jointly with the other. "
        } else if effect(other.slug).is_some() {
            "tested, not selected. "
        } else {
            ""
        };
        all.push((effect_label(other.slug), format!("{lead}{}", sentence(other.separated_by))));
    }
    all
}
