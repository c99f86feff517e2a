//! What to do after a diagnosis.

use armident_effects::{LawRole, effect};
use armident_report::{DiagnoseReport, FindingRow, NextMotionResult};

use crate::drawing::Drawing;
use crate::view::Step;

/// Findings that a step names.
const NAMED: usize = 3;

/// The first law of a finding's effect among its places.
fn role(finding: &FindingRow) -> Option<LawRole> {
    effect(&finding.effect).and_then(|e| e.law().roles.first().copied())
}

pub(super) fn next_steps(of: &DiagnoseReport, drawing: &Drawing) -> Vec<Step> {
    let faults = &of.input_checks.faults;
    if !faults.is_empty() {
        let advised = faults.iter().filter_map(|f| Some((f.prefix(), f.advice.as_ref()?)));
        let mut steps: Vec<Step> =
            advised.map(|(prefix, advice)| Step::new(format!("{prefix}{advice}"))).collect();
        steps.push(Step::new(
            "Diagnose again; --trust-columns uses columns that fail the input checks.",
        ));
        return steps;
    }
    let mut steps = Vec::new();
    steps.extend(channels(of));
    if of.findings.iter().any(|finding| role(finding) == Some(LawRole::Contact)) {
        steps.push(Step::new(
            "Record the motion again with nothing near the arm: a contact masks other effects.",
        ));
    }
    steps.extend(separation(of, drawing));
    if !of.findings.is_empty() {
        let step = Step::new(
            "Use the diagnosed model: save it, and predict the efforts of other motions.",
        );
        let command = &drawing.provenance.command;
        steps.push(if command.is_empty() || command.iter().any(|a| a.contains("--save-model")) {
            step.by("armident predict model.json motion.csv -o predicted.csv")
        } else {
            step.by(with_option(drawing, "--save-model model.json"))
        });
    }
    if of.holdout_recordings.is_empty() {
        steps.push(
            Step::new("Validate on a hold-out recording.")
                .by(with_option(drawing, "--holdout other.csv")),
        );
    }
    steps.extend(reference(of));
    if of.findings.is_empty() {
        steps.push(Step::new(match of.residual_clause() {
            Some(_) => {
                "No law of the library explains the residual; its strongest regressors are listed by joint. Longer \
                 recordings, or other motions, may identify it."
            }
            None => {
                "No action needed. To detect smaller effects, record longer, more slowly, or with less noise."
            }
        }));
    }
    steps
}

/// Faults of channels, which other effects are measured with.
fn channels(of: &DiagnoseReport) -> Option<Step> {
    let is_channel = |finding: &&FindingRow| {
        matches!(role(finding), Some(LawRole::Gain | LawRole::Zero | LawRole::Time))
    };
    let names: Vec<String> = of.findings.iter().filter(is_channel).map(FindingRow::title).collect();
    (!names.is_empty()).then(|| {
        Step::new(format!(
            "Correct the channels first ({}), in a mapping file or in the drive.",
            names.join("; ")
        ))
    })
}

/// How to separate findings from their alternatives.
fn separation(of: &DiagnoseReport, drawing: &Drawing) -> Option<Step> {
    let search: Option<NextMotionResult> = of.section();
    if let Some(next) = &search
        && let (Some(file), Some(motion), Some(achieves)) =
            (&next.file, &next.description, next.achieves())
    {
        return Some(Step::new(format!("Record the motion in {file} ({motion}). {achieves}")));
    }
    let open: Vec<String> = of
        .findings
        .iter()
        .filter(|finding| !finding.alternatives.is_empty())
        .take(NAMED)
        .map(FindingRow::title)
        .collect();
    if open.is_empty() {
        return None;
    }
    let step = Step::new(format!(
        "To resolve {}, record a motion that separates the alternatives.",
        open.join(", ")
    ));
    // a search that found none finds none again
    Some(match search {
        Some(_) => step,
        None => step.by(with_option(drawing, "--next-motion FOLDER")),
    })
}

/// What the reference leaves open.
fn reference(of: &DiagnoseReport) -> Vec<Step> {
    let mut steps = Vec::new();
    if let Some(speeds) = of.section::<armident_report::ReferenceSpeed>() {
        steps.push(Step::new(format!(
            "Record a reference that is as fast as these recordings (its maximum speed: {}).",
            speeds.listed(of)
        )));
    }
    let inconclusive = of.section::<armident_report::InconclusiveChanges>().unwrap_or_default();
    let names = inconclusive.maybe_in_reference();
    if !names.is_empty() {
        steps.push(Step::new(format!(
            "To decide whether {names} changed, record the motions of these recordings with the arm in its earlier \
             state, as the reference."
        )));
    }
    steps
}

/// The command of the result with one more option.
fn with_option(drawing: &Drawing, option: &str) -> String {
    let mut kept = Vec::new();
    let mut words = drawing.provenance.command.iter();
    while let Some(word) = words.next() {
        if word == "--report" || word == "--json" {
            words.next();
        } else if word != "--traces" {
            kept.push(word.as_str());
        }
    }
    format!("{} {option}", kept.join(" ")).trim().to_owned()
}
