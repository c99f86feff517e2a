//! The verdict of a diagnosis.

use armident_report::{
    ByJoint, DiagnoseReport, EffortErrors, FindingRow, ReplayPair, capital, counted,
    in_noise_levels, percent,
};

use super::evidence::{WHITE, is_marginal, size, strength};
use crate::view::number;

/// Findings that the verdict names.
const NAMED: usize = 3;

/// What was found; with failed input checks, the whole first line of the text.
pub(super) fn headline(of: &DiagnoseReport) -> String {
    let clauses = of.clauses();
    match of.input_checks.faults.is_empty() {
        true => capital(clauses.first().map_or("", String::as_str)),
        false => capital(&clauses.join("; ")),
    }
}

pub(super) fn sentences(of: &DiagnoseReport) -> Vec<String> {
    let faults = &of.input_checks.faults;
    if !faults.is_empty() {
        let mut all: Vec<String> =
            faults.iter().map(|fault| format!("{}{}.", fault.prefix(), fault.message)).collect();
        all.push("No physical diagnosis until the columns are fixed.".to_owned());
        return all;
    }
    let mut all = Vec::new();
    all.extend(most_material(of));
    all.extend(of.residual_clause().map(|clause| capital(&format!("{clause}."))));
    if let Some((errors, is_holdout)) = of.fit.judged() {
        let kind = if is_holdout { "hold-out" } else { "training recordings" };
        all.extend(improvement(of, errors, kind));
        all.extend(largest_error(of, errors));
    }
    all.extend(confirmation(of));
    all.extend(of.section::<ReplayPair>().and_then(|replay| replayed(of, &replay)));
    all.extend(whiteness(of));
    let marginal = of.findings.iter().filter(|finding| is_marginal(finding)).count();
    if marginal > 0 {
        let is = if marginal == 1 { "is" } else { "are" };
        all.push(format!(
            "{} {is} close to the materiality threshold.",
            counted(marginal, "finding")
        ));
    }
    let skipped = of.input_checks.unchecked.iter();
    all.extend(skipped.map(|why| format!("Input checks skipped: {why}.")));
    if of.findings.is_empty() {
        all.push("Effects clearly below the noise level are not reported.".to_owned());
    }
    all
}

fn most_material(of: &DiagnoseReport) -> Option<String> {
    let largest: Vec<String> = of
        .findings
        .iter()
        .take(NAMED)
        .map(|finding| {
            let details = [size(finding), strength(finding)];
            let details: Vec<String> = details.into_iter().filter(|d| !d.is_empty()).collect();
            format!("{} ({})", finding.title(), details.join(", "))
        })
        .collect();
    let lead = if of.findings.len() > largest.len() { "Most material: " } else { "" };
    (!largest.is_empty()).then(|| capital(&format!("{lead}{}.", largest.join("; "))))
}

/// Errors over those of the given model, on the median joint.
fn improvement(of: &DiagnoseReport, errors: &EffortErrors, kind: &str) -> Option<String> {
    let ratios = |model: &ByJoint| -> Vec<(f64, String)> {
        let mut all: Vec<(f64, String)> = of
            .joints
            .iter()
            .filter_map(|j| Some((j, *model.get(j)?, *errors.before.get(j)?)))
            // what is noise with the given model can be no better with another
            .filter(|(j, _, given)| of.effort_noise.get(*j).is_none_or(|n| *given > 2.0 * n))
            .map(|(j, model, given)| (model / given, j.clone()))
            .filter(|(r, _)| r.is_finite())
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    let (diagnosed, links_only) = (ratios(&errors.after), ratios(&errors.rigid));
    let (middle, worst) = (diagnosed.get(diagnosed.len() / 2)?, diagnosed.last()?);
    let middle_of_links = links_only.get(links_only.len() / 2)?;
    Some(format!(
        "Diagnosed model: {} of the given model's error on the {kind} (median joint; worst {} on {}). Links-only fit: \
         {}.",
        percent(middle.0),
        percent(worst.0),
        worst.1,
        percent(middle_of_links.0),
    ))
}

fn largest_error(of: &DiagnoseReport, errors: &EffortErrors) -> Option<String> {
    let over_noise = of
        .joints
        .iter()
        .filter_map(|j| Some((errors.after.get(j)? / of.effort_noise.get(j)?, j)))
        .filter(|(r, _)| r.is_finite());
    let (times, joint) = over_noise.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!("Worst joint: RMS error {} noise levels ({joint}).", in_noise_levels(times, 2)))
}

fn confirmation(of: &DiagnoseReport) -> Option<String> {
    let with = |confirmed| of.findings.iter().filter(move |f| f.confirmed == Some(confirmed));
    let unconfirmed: Vec<String> = with(false).map(FindingRow::title).collect();
    if !unconfirmed.is_empty() {
        return Some(format!(
            "Not confirmed: {}. The hold-out error is not lower with {}.",
            unconfirmed.join(", "),
            if unconfirmed.len() == 1 { "it" } else { "them" }
        ));
    }
    let confirmed = with(true).count();
    (confirmed > 0 && confirmed == of.findings.len()).then(|| match confirmed {
        1 => "The hold-out confirms the finding: its error is larger without it.".to_owned(),
        n => format!(
            "The hold-out confirms all {n} findings: its error is larger without any of them."
        ),
    })
}

fn replayed(of: &DiagnoseReport, replay: &ReplayPair) -> Option<String> {
    let (joint, after) = replay.after.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
    let unit = of.position_unit(joint);
    let given = replay.before.get(joint).map_or_else(|| "-".to_owned(), |given| number(*given, 2));
    Some(format!(
        "Forward replay, {} s windows: worst RMS position error {} {unit} ({joint}; given model {given} {unit}).",
        number(replay.window_s, 3),
        number(*after, 2),
    ))
}

fn whiteness(of: &DiagnoseReport) -> Option<String> {
    let coloured: Vec<&str> =
        of.whiteness_p.iter().filter(|w| *w.1 < WHITE).map(|w| w.0.as_str()).collect();
    if !coloured.is_empty() {
        return Some(format!(
            "The residual of {} is not white (Ljung-Box p < {WHITE}): the model is incomplete there.",
            coloured.join(", ")
        ));
    }
    let smallest = of.whiteness_p.values().copied().min_by(f64::total_cmp)?;
    Some(format!(
        "The residual is white (Ljung-Box p = {}, smallest of all joints).",
        number(smallest, 2)
    ))
}
