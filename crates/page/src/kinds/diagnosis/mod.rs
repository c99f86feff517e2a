//! `armident diagnose`.

mod card;
mod evidence;
mod next_steps;
mod verdict;

use armident_report::{
    ByJoint, DiagnoseReport, DiagnosisSection, FindingRow, JointResiduals, MinimalSetEstimate,
    PositionFit, percent,
};

use self::card::card;
use self::evidence::WHITE;
use self::next_steps::next_steps;
use self::verdict::{headline, sentences};
use super::charts::of_minimal_set;
use super::joint_cards::joint_cards;
use crate::blocks::parts;
use crate::drawing::{Drawing, DrawnQuantity};
use crate::figures::{self, Figure, LitFinding};
use crate::view::{JointCard, Tone, View, number};

pub(crate) fn view(
    of: &DiagnoseReport,
    drawing: &Drawing,
    sections: &[&dyn DiagnosisSection],
) -> View {
    let faults = &of.input_checks.faults;
    let mut worst: Vec<String> =
        of.findings.iter().take(1).map(|f| f.evidence.joint.clone()).collect();
    worst.extend(faults.iter().take(1).filter_map(|f| f.joint.clone()));
    if worst.is_empty() {
        worst = of.joints.first().cloned().into_iter().collect();
    }
    let joints_found = on_chain(drawing, &of.findings, |f| f.link.is_none());
    let links_found = on_chain(drawing, &of.findings, |f| f.link.is_some());
    let findings = of.findings.iter().enumerate();
    let lit: Vec<LitFinding> = findings.map(|(k, finding)| lit(k, finding, drawing)).collect();
    let MinimalSetEstimate(constants) = of.section().unwrap_or_default();
    let shown = sections.iter().map(|section| (section.key(), section.page(of)));
    let findings = of.findings.iter().enumerate();
    View {
        kind: "Diagnosis",
        tone: if of.findings.is_empty() && faults.is_empty() { Tone::Good } else { Tone::Bad },
        headline: headline(of),
        sentences: sentences(of),
        next: next_steps(of, drawing),
        overview: overview(of, drawing),
        joints: with_residual_map(joint_cards(drawing, &worst, &of.effort_noise), of, drawing),
        skeleton: drawing
            .skeleton
            .as_ref()
            .map(|s| figures::skeleton(drawing, s, &joints_found, &links_found, &lit)),
        sections: parts(shown, |name| of_minimal_set(name, &constants, drawing)),
        cards: findings.map(|(k, finding)| card(k, finding, of, drawing)).collect(),
        robot: of.robot.clone(),
        warnings: of.warnings.clone(),
    }
}

/// What a finding lights in the arm.
fn lit(k: usize, finding: &FindingRow, drawing: &Drawing) -> LitFinding {
    let one = std::slice::from_ref(finding);
    let place = finding.location();
    let mut title = finding.label();
    if !place.is_empty() {
        title += &format!(" on {place}");
    }
    let found = LitFinding {
        title,
        joints: on_chain(drawing, one, |f| f.link.is_none()),
        links: on_chain(drawing, one, |f| f.link.is_some()),
        ..LitFinding::default()
    };
    drawing.findings.get(k).map_or_else(|| found.clone(), |traces| found.clone().with(traces))
}

/// Joints, from 0, of some findings.
fn on_chain(
    drawing: &Drawing,
    of: &[FindingRow],
    which: impl Fn(&FindingRow) -> bool,
) -> Vec<usize> {
    let mut found: Vec<usize> = of
        .iter()
        .filter(|f| which(f))
        .flat_map(|f| f.joints.iter().map(move |j| (f, j)))
        .filter_map(|(f, joint)| {
            let by_link = |link: &String| drawing.joints.iter().position(|j| j.link == *link);
            let by_name = || drawing.joints.iter().position(|j| j.name == *joint);
            f.link.as_ref().and_then(by_link).or_else(by_name)
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

fn overview(of: &DiagnoseReport, drawing: &Drawing) -> Vec<Figure> {
    let mut all = Vec::new();
    if let Some((errors, is_holdout)) = of.fit.judged() {
        let kind = if is_holdout { "hold-out" } else { "training" };
        let values = |m: &ByJoint| of.joints.iter().map(|j| m.get(j).copied()).collect();
        let mut models = vec![
            ("given".to_owned(), values(&errors.before)),
            ("links only".to_owned(), values(&errors.rigid)),
            ("diagnosed".to_owned(), values(&errors.after)),
        ];
        models.retain(|m: &(String, Vec<Option<f64>>)| m.1.iter().any(Option::is_some));
        all.extend(figures::errors(&of.joints, &models, DrawnQuantity::Effort).map(|f| Figure {
            title: format!("Effort error, {kind}"),
            legend: format!(
                "given: model as passed in; links only: its link inertias refitted, no effects; diagnosed: with all \
                 findings. {}",
                f.legend
            ),
            ..f
        }));
    }
    all.extend(position_errors(of));
    all.extend(figures::over_time(drawing));
    all
}

/// Errors of positions, where commands and no efforts are recorded.
fn position_errors(of: &DiagnoseReport) -> Option<Figure> {
    let fit = of.section::<PositionFit>()?;
    let (errors, kind) = match &fit.holdout {
        Some(errors) => (errors, "hold-out"),
        None => (&fit.train, "training"),
    };
    let values = |m: &ByJoint| of.joints.iter().map(|j| m.get(j).copied()).collect();
    let models = [
        ("command".to_owned(), values(&errors.before)),
        ("simulated".to_owned(), values(&errors.after)),
    ];
    figures::errors(&of.joints, &models, DrawnQuantity::Position).map(|f| Figure {
        title: format!("Position error, {kind}"),
        legend: format!(
            "command: command minus position; simulated: simulated from the commands with all findings. {}",
            f.legend
        ),
        ..f
    })
}

/// Cards with the residual map of their joint; cards of the map alone where nothing is drawn.
fn with_residual_map(
    mut cards: Vec<JointCard>,
    of: &DiagnoseReport,
    drawing: &Drawing,
) -> Vec<JointCard> {
    if drawing.joints.is_empty() {
        cards = of.residual_map.iter().map(card_of_map).collect();
    }
    for card in &mut cards {
        let joints = of.residual_map.iter().enumerate();
        let found = joints.into_iter().find(|(_, joint)| joint.joint == card.name);
        card.figures.extend(found.and_then(|(k, joint)| regressors(k, joint)));
    }
    cards
}

fn card_of_map(joint: &JointResiduals) -> JointCard {
    let summary = format!(
        "In-band RMS residual: given {}, links only {}, diagnosed {}, noise {}",
        number(joint.before, 3),
        number(joint.rigid, 3),
        number(joint.after, 3),
        number(joint.noise, 2)
    );
    JointCard { name: joint.joint.clone(), summary, figures: Vec::new(), open: false }
}

/// What the residual of a joint depends on.
fn regressors(k: usize, joint: &JointResiduals) -> Option<Figure> {
    let variables = joint.variables.iter();
    let functions = joint.regressors.iter();
    let rows: Vec<(String, f64, f64)> = variables
        .map(|v| (v.variable.replace('_', " "), v.share_before, v.share_after))
        .chain(functions.map(|f| (f.function.clone(), f.share_before, f.share_after)))
        .collect();
    let mut about = joint.regressors.first().map_or_else(String::new, |strongest| {
        format!(
            "Given model: {} explains {} of the residual variance ({}).",
            strongest.function,
            percent(strongest.share_before),
            strongest.indicates
        )
    });
    if joint.whiteness_p.is_finite() {
        let white = if joint.whiteness_p < WHITE { "not white" } else { "white" };
        about += &format!(
            " Diagnosed model: residual {white} (Ljung-Box p = {}).",
            number(joint.whiteness_p, 2)
        );
    }
    figures::regressors(k, &rows, &about)
}
