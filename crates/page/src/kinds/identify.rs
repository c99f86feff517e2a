//! `armident identify`.

use armident_report::{
    ByJoint, ConstantRow, IdentifyReport, NOT_IDENTIFIED, capital, counted, percent,
    standard_sections, uncertain,
};

use super::charts::of_minimal_set;
use super::joint_cards::joint_cards;
use crate::blocks::parts;
use crate::drawing::{Drawing, DrawnQuantity};
use crate::figures::{self, Figure};
use crate::view::{Step, Tone, View, number};

/// Deviation from the URDF, in standard errors, from which on a constant is far from it.
const FAR: f64 = 5.0;
/// Constants that are named.
const NAMED: usize = 3;
/// Relative error that friction and rigid links leave at most.
const EXPLAINED: f64 = 0.05;

pub(crate) fn view(of: &IdentifyReport, drawing: &Drawing) -> View {
    let is_determined = of.rank == of.parameters;
    let (errors, is_holdout) = of.judged();
    let kind = if is_holdout { "hold-out" } else { "training" };
    let mut relative: Vec<(f64, &String)> =
        of.joints.iter().filter_map(|j| Some((*errors.relative.get(j)?, j))).collect();
    relative.sort_by(|a, b| a.0.total_cmp(&b.0));
    let worst = relative.last();
    let open: Vec<String> = worst.map(|w| w.1.clone()).into_iter().collect();
    let shown = standard_sections::IDENTIFY.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    View {
        kind: "Identification",
        tone: if is_determined { Tone::Good } else { Tone::Open },
        headline: if is_determined {
            format!("All {} parameters are identified", of.parameters)
        } else {
            format!("{} of {} parameters are identified", of.rank, of.parameters)
        },
        sentences: sentences(of, kind, &relative),
        next: next_steps(of, worst.map_or(0.0, |w| w.0)),
        overview: bars(of, kind).into_iter().chain(figures::over_time(drawing)).collect(),
        joints: joint_cards(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &[], &[], &[])),
        sections: parts(shown, |name| of_minimal_set(name, &of.constants, drawing)),
        cards: Vec::new(),
        robot: of.robot.clone(),
        warnings: [&of.warnings[..], &of.notes].concat(),
    }
}

fn sentences(of: &IdentifyReport, kind: &str, relative: &[(f64, &String)]) -> Vec<String> {
    let mut all = vec![format!(
        "{} of {} parameters are identified from {} ({} rows, effective sample size {}).",
        of.rank,
        of.parameters,
        counted(of.recordings.len(), "recording"),
        of.rows,
        percent(of.effective_sample_share)
    )];
    if let (Some(middle), Some(worst)) = (relative.get(relative.len() / 2), relative.last()) {
        let urdf = of.fit.urdf.relative.get(worst.1).copied().unwrap_or(f64::NAN);
        all.push(format!(
            "Effort error on the {kind} recordings: {} of the effort's standard deviation (median joint); worst {} on \
             {} (URDF only {}).",
            percent(middle.0),
            percent(worst.0),
            worst.1,
            percent(urdf)
        ));
    }
    let mut deviations: Vec<(&ConstantRow, f64)> =
        of.constants.iter().filter_map(|c| Some((c, c.deviation()?))).collect();
    deviations.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let far: Vec<String> = deviations
        .iter()
        .take_while(|(_, t)| t.abs() > FAR)
        .take(NAMED)
        .filter_map(|(c, t)| {
            let (value, error) = uncertain(c.value?, c.standard_error?);
            Some(format!(
                "{} of {}: {value} \u{b1} {error} {}, URDF {} ({} standard errors)",
                c.label,
                c.joint,
                c.unit,
                number(c.urdf, 4),
                number(t.abs(), 2)
            ))
        })
        .collect();
    all.push(if far.is_empty() {
        format!("No constant differs from the URDF by more than {FAR} standard errors.")
    } else {
        format!("Largest differences from the URDF: {}.", far.join("; "))
    });
    all.extend(of.consistency.as_ref().map(|links| format!("Links: {}.", links.text())));
    all
}

fn next_steps(of: &IdentifyReport, worst: f64) -> Vec<Step> {
    let mut steps = Vec::new();
    if of.rank < of.parameters {
        let open: Vec<&str> = of
            .constants
            .iter()
            .filter(|c| c.undetermined > NOT_IDENTIFIED)
            .map(|c| c.label.as_str())
            .take(6)
            .collect();
        steps.push(
            Step::new(capital(&format!("excite the joints that {} depend on.", open.join(", "))))
                .by("armident plan robot.urdf -o plan/"),
        );
    }
    if of.holdout_recordings.is_empty() {
        steps.push(Step::new("Validate on a hold-out recording.").by("--holdout other.csv"));
    }
    if worst > EXPLAINED {
        steps.push(
            Step::new(format!(
                "Run diagnose to find missing effects: friction and rigid links do not explain an error of {}.",
                percent(worst)
            ))
            .by(format!("armident diagnose robot.urdf {}", of.recordings.join(" "))),
        );
    }
    steps.push(
        Step::new("Use the model: predict efforts, or export it for a controller or simulator.")
            .by("armident export model.json -o robot.urdf"),
    );
    steps
}

fn bars(of: &IdentifyReport, kind: &str) -> Option<Figure> {
    let (errors, _) = of.judged();
    let values = |m: &ByJoint| of.joints.iter().map(|j| m.get(j).copied()).collect();
    let models = [
        ("URDF only".to_owned(), values(&of.fit.urdf.rmse)),
        ("model".to_owned(), values(&errors.rmse)),
    ];
    figures::errors(&of.joints, &models, DrawnQuantity::Effort)
        .map(|f| Figure { title: format!("Effort error, {kind} (low-passed)"), ..f })
}
