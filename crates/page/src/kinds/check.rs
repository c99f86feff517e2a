//! `armident check`.

use armident_report::{ByJoint, CheckReport, CheckRow, CheckVerdict, counted, standard_sections};

use super::joint_cards::joint_cards;
use crate::blocks::parts;
use crate::drawing::Drawing;
use crate::figures;
use crate::view::{Step, Tone, View};

/// Hints among the next steps.
const HINTS: usize = 6;

pub(crate) fn view(of: &CheckReport, drawing: &Drawing) -> View {
    let wrong: Vec<&CheckRow> =
        of.checks.iter().filter(|check| check.verdict == CheckVerdict::Wrong).collect();
    let mut open: Vec<String> = wrong.iter().filter_map(|check| check.joint.clone()).collect();
    open.truncate(1);
    let marked: Vec<usize> = drawing
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| wrong.iter().any(|c| c.joint.as_ref() == Some(&joint.name)))
        .map(|(k, _)| k)
        .collect();
    let shown = standard_sections::CHECK.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    View {
        kind: "Check of recordings",
        tone: match of.verdict {
            CheckVerdict::Wrong => Tone::Bad,
            CheckVerdict::Ok => Tone::Good,
            CheckVerdict::Inconclusive | CheckVerdict::Doubtful => Tone::Open,
        },
        headline: match wrong.len() {
            0 if of.verdict == CheckVerdict::Ok => "All checks passed".to_owned(),
            0 => "No errors; some checks are doubtful or inconclusive".to_owned(),
            n => format!("{} failed", counted(n, "check")),
        },
        sentences: sentences(of, &wrong),
        next: next_steps(of, wrong.is_empty()),
        overview: figures::over_time(drawing).into_iter().collect(),
        joints: joint_cards(drawing, &open, &ByJoint::default()),
        skeleton: drawing
            .skeleton
            .as_ref()
            .map(|s| figures::skeleton(drawing, s, &marked, &[], &[])),
        sections: parts(shown, |_| None),
        cards: Vec::new(),
        robot: of.robot.clone(),
        warnings: [&of.warnings[..], &of.notes].concat(),
    }
}

fn sentences(of: &CheckReport, wrong: &[&CheckRow]) -> Vec<String> {
    let counts = CheckVerdict::WORST_FIRST
        .map(|verdict| format!("{} {}", of.count(verdict), verdict.word()))
        .join(", ");
    let mut all = vec![format!(
        "{}: {counts}. The recordings alone determine {} of {} parameters.",
        counted(of.checks.len(), "check"),
        of.rank,
        of.parameters
    )];
    all.extend(wrong.iter().map(|check| format!("{}{}.", check.prefix(), check.message)));
    all
}

/// The hints of the worst checks first.
fn next_steps(of: &CheckReport, is_fine: bool) -> Vec<Step> {
    let mut advised: Vec<(&CheckRow, &String)> = of
        .checks
        .iter()
        .filter(|check| check.verdict != CheckVerdict::Ok)
        .filter_map(|check| Some((check, check.advice.as_ref()?)))
        .collect();
    advised.sort_by_key(|(check, _)| std::cmp::Reverse(check.verdict));
    let hints = advised.into_iter().take(HINTS);
    let mut steps: Vec<Step> =
        hints.map(|(check, hint)| Step::new(format!("{}{hint}", check.prefix()))).collect();
    if is_fine {
        steps.push(
            Step::new("All input checks passed: run identify or diagnose.")
                .by(format!("armident diagnose robot.urdf {}", of.recordings.join(" "))),
        );
    }
    steps
}
