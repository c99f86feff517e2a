//! How strong the evidence of a finding is, and how large it is, in words.

use armident_effects::effect;
use armident_report::{FindingRow, parameter_label};

/// p-value below which a residual is not white.
pub(super) const WHITE: f64 = 0.01;
/// Confidence from which on evidence is strong, and moderate.
const STRONG: f64 = 0.9;
const MODERATE: f64 = 0.65;

/// Whether a finding is close to the materiality threshold.
pub(super) fn is_marginal(finding: &FindingRow) -> bool {
    finding.confidence < MODERATE
}

/// `strong evidence; not distinguishable from payload on link_6`.
pub(super) fn strength(finding: &FindingRow) -> String {
    let word = match finding.confidence {
        confidence if confidence >= STRONG => "strong",
        _ if is_marginal(finding) => "marginal",
        _ => "moderate",
    };
    let others: Vec<String> = finding.alternatives.iter().map(|other| other.title()).collect();
    match others.is_empty() {
        true => format!("{word} evidence"),
        false => format!("{word} evidence; not distinguishable from {}", others.join(" or ")),
    }
}

/// The first parameter in the order of the law.
pub(super) fn size(finding: &FindingRow) -> String {
    let names: Vec<&str> = match effect(&finding.effect) {
        Some(known) => known.law().parameters.iter().map(|p| p.name).collect(),
        None => finding.parameters.keys().map(String::as_str).collect(),
    };
    let first = names.iter().find_map(|name| finding.parameters.get_key_value(*name));
    let first = first.or_else(|| finding.parameters.iter().next());
    first.map_or_else(String::new, |(name, estimate)| {
        format!("{} {}", parameter_label(name), estimate.text())
    })
}
