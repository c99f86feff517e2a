//! `armident diagnose`.

mod say;

use std::collections::BTreeMap;

use armident_effects::effect;
use armident_report::{SmallTerm, uncertain, unit_told};
use serde::Deserialize;

use self::say::{
    capital, certainty, headline, look_alikes, next, place, proof, sentences, size, title_of,
    written,
};
use super::constants::{self, Constant};
use super::{ByJoint, counted, joints};
use crate::drawing::{Drawing, FindingTraces};
use crate::figures;
use crate::page::{Card, Fitted, Grid, JointCard, Section, Tone, View, number, percent};

/// The result, as far as the page says it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Diagnosis {
    robot: String,
    sentence: String,
    books: Books,
    recordings: Vec<String>,
    holdout_recordings: Vec<String>,
    joints: Vec<String>,
    findings: Vec<Finding>,
    fit: Fits,
    effort_noise: ByJoint,
    inertial_error: Option<f64>,
    small_terms: Vec<SmallTerm>,
    narrowed_to_hz: Option<f64>,
    beyond_reference: ByJoint,
    doubtful_changes: Vec<DoubtfulChange>,
    atlas: Vec<JointAtlas>,
    constants: Vec<Constant>,
    whiteness_p: ByJoint,
    replay: Option<Replay>,
    next_motion: Option<NextMotion>,
    warnings: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Books {
    faults: Vec<Fault>,
    unchecked: Option<String>,
}

/// A column that is not what the header says.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fault {
    joint: Option<String>,
    message: String,
    advice: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Replay {
    window_s: f64,
    before: ByJoint,
    after: ByJoint,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct NextMotion {
    file: Option<String>,
    description: Option<String>,
    told_apart: usize,
    pairs: usize,
    separation: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fits {
    train: Option<Errors>,
    holdout: Option<Errors>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Errors {
    before: ByJoint,
    rigid: ByJoint,
    after: ByJoint,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Finding {
    effect: String,
    joints: Vec<String>,
    link: Option<String>,
    window: Option<[f64; 2]>,
    recording: Option<String>,
    parameters: BTreeMap<String, Number>,
    confidence: f64,
    confirmed: Option<bool>,
    evidence: Evidence,
    alternatives: Vec<Alternative>,
}

/// A change that is not certain enough to be named.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct DoubtfulChange {
    effect: String,
    joints: Vec<String>,
    link: Option<String>,
    maybe_before: bool,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Number {
    value: f64,
    stderr: Option<f64>,
    unit: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Evidence {
    materiality: f64,
    least_materiality: f64,
    joint: String,
    variables: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Alternative {
    effect: String,
    joints: Vec<String>,
    link: Option<String>,
    left_more: Option<f64>,
    separated_by: Option<String>,
}

/// Findings that are open at first.
const OPEN: usize = 3;

/// p-value below which a residual is not white.
const WHITE: f64 = 0.01;

/// Where the mismatch is, on one joint.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct JointAtlas {
    joint: String,
    before: f64,
    rigid: f64,
    after: f64,
    noise: f64,
    whiteness_p: Option<f64>,
    symmetries: Vec<Symmetry>,
    regimes: Vec<Regime>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Symmetry {
    function: String,
    share_before: f64,
    share_after: f64,
    points_to: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Regime {
    variable: String,
    share_before: f64,
    share_after: f64,
}

/// Joints with what their residuals depend on; joints of the atlas alone where nothing is drawn.
fn with_atlas(mut cards: Vec<JointCard>, of: &Diagnosis, drawing: &Drawing) -> Vec<JointCard> {
    if drawing.joints.is_empty() {
        cards = of
            .atlas
            .iter()
            .map(|a| JointCard {
                name: a.joint.clone(),
                summary: format!(
                    "RMS residual in the band of the comparison: before {}, rigid {}, after {}, noise {}",
                    number(a.before, 3),
                    number(a.rigid, 3),
                    number(a.after, 3),
                    number(a.noise, 2)
                ),
                figures: Vec::new(),
                open: false,
            })
            .collect();
    }
    for card in &mut cards {
        let Some((k, atlas)) = of.atlas.iter().enumerate().find(|(_, a)| a.joint == card.name)
        else {
            continue;
        };
        let rows: Vec<(String, f64, f64)> = atlas
            .regimes
            .iter()
            .map(|r| (r.variable.replace('_', " "), r.share_before, r.share_after))
            .chain(
                atlas
                    .symmetries
                    .iter()
                    .map(|s| (s.function.clone(), s.share_before, s.share_after)),
            )
            .collect();
        let mut said = atlas.symmetries.first().map_or_else(String::new, |s| {
            format!(
                "Before, {} of it goes with {}: {}.",
                percent(s.share_before),
                s.function,
                s.points_to
            )
        });
        if let Some(p) = atlas.whiteness_p {
            said += &format!(
                " After, it is {} white (p = {}).",
                if p < WHITE { "not" } else { "as far as can be told" },
                number(p, 2)
            );
        }
        card.figures.extend(figures::depends(k, &rows, &said));
    }
    cards
}

pub(crate) fn view(of: Diagnosis, drawing: &Drawing) -> View {
    let cards: Vec<Card> =
        of.findings.iter().enumerate().map(|(k, finding)| card(k, finding, &of, drawing)).collect();
    let blamed_joints: Vec<usize> = on_chain(drawing, |f| f.link.is_none(), &of);
    let blamed_links: Vec<usize> = on_chain(drawing, |f| f.link.is_some(), &of);
    let mut worst: Vec<String> =
        of.findings.iter().take(1).map(|f| f.evidence.joint.clone()).collect();
    worst.extend(of.books.faults.iter().take(1).filter_map(|f| f.joint.clone()));
    if worst.is_empty() {
        worst = of.joints.first().cloned().into_iter().collect();
    }
    View {
        kind: "Diagnosis",
        tone: if of.findings.is_empty() && of.books.faults.is_empty() {
            Tone::Good
        } else {
            Tone::Bad
        },
        headline: headline(&of),
        sentences: sentences(&of),
        next: next(&of, drawing),
        overview: overview(&of, drawing),
        joints: with_atlas(joints(drawing, &worst, &of.effort_noise), &of, drawing),
        skeleton: drawing
            .skeleton
            .as_ref()
            .map(|s| figures::skeleton(drawing, s, &blamed_joints, &blamed_links)),
        sections: errors(&of).into_iter().chain(minimal_set(&of, drawing)).collect(),
        cards,
        robot: of.robot,
        warnings: of.warnings,
    }
}

fn on_chain(drawing: &Drawing, which: impl Fn(&Finding) -> bool, of: &Diagnosis) -> Vec<usize> {
    let mut found: Vec<usize> = of
        .findings
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

fn overview(of: &Diagnosis, drawing: &Drawing) -> Vec<figures::Figure> {
    let mut all = Vec::new();
    if let Some((errors, kind)) = proof(of) {
        let values = |m: &ByJoint| of.joints.iter().map(|j| m.get(j).copied()).collect();
        let mut models = vec![
            ("before".to_owned(), values(&errors.before)),
            ("rigid".to_owned(), values(&errors.rigid)),
            ("after".to_owned(), values(&errors.after)),
        ];
        models.retain(|m: &(String, Vec<Option<f64>>)| m.1.iter().any(Option::is_some));
        all.extend(figures::errors(&of.joints, &models).map(|f| figures::Figure {
            title: format!("Error of the {kind} efforts"),
            legend: format!(
                "before: the robot as given; rigid: its links identified again, nothing else; after: with the \
                 findings. {}",
                f.legend
            ),
            ..f
        }));
    }
    all.extend(figures::over_time(drawing));
    all
}

fn errors(of: &Diagnosis) -> Option<Section> {
    let mut tables = Vec::new();
    for (name, errors) in [("hold-out", &of.fit.holdout), ("training", &of.fit.train)] {
        let Some(errors) = errors else { continue };
        let cell =
            |m: &ByJoint, j: &String| m.get(j).map_or_else(|| "-".to_owned(), |x| number(*x, 3));
        let rows = of
            .joints
            .iter()
            .map(|j| {
                vec![
                    j.clone(),
                    cell(&errors.before, j),
                    cell(&errors.rigid, j),
                    cell(&errors.after, j),
                    cell(&of.effort_noise, j),
                ]
            })
            .collect();
        let caption = format!("RMS error of the {name} efforts as recorded [N m or N]");
        let header = ["joint", "before", "rigid", "after", "noise of a sample"];
        tables.push(Grid::new(caption, &header, 1).with(rows));
    }
    let mut sentences = vec![format!(
        "{} fitted, {} kept out.",
        counted(of.recordings.len(), "recording"),
        of.holdout_recordings.len()
    )];
    if let Some(scale) = of.inertial_error.filter(|s| *s > 0.0) {
        sentences.push(format!(
            "Beside the findings, the recordings ask for errors of about {} of the inertias of all links.",
            percent(scale)
        ));
    }
    let found = Section {
        id: "errors-by-joint".to_owned(),
        title: "Errors".to_owned(),
        sentences,
        tables,
        figures: Vec::new(),
    };
    (!found.tables.is_empty()).then_some(found)
}

/// The inertia constants of the diagnosed arm, and what the recordings know of each.
fn minimal_set(of: &Diagnosis, drawing: &Drawing) -> Option<Section> {
    let mut figures: Vec<figures::Figure> =
        constants::off_the_urdf(&of.constants).into_iter().collect();
    figures.extend(drawing.correlation.as_ref().map(figures::correlation));
    (!of.constants.is_empty()).then(|| Section {
        id: "constants".to_owned(),
        title: "Minimal set".to_owned(),
        sentences: vec![
            "What the efforts know of the links, with all that was found fitted along. The URDF is believed as far \
             as these recordings bear it out; `the URDF's word` is the share of that belief that they leave."
                .to_owned(),
        ],
        tables: vec![constants::table(&of.constants)],
        figures,
    })
}

fn card(k: usize, finding: &Finding, of: &Diagnosis, drawing: &Drawing) -> Card {
    let law = effect(&finding.effect).map(|e| e.law());
    let traces = drawing.findings.get(k);
    let mut where_it_is = place(finding);
    if let (Some([from, to]), Some(recording)) = (finding.window, &finding.recording) {
        where_it_is = format!(
            "{where_it_is} from {} s to {} s of {recording}",
            number(from, 4),
            number(to, 4)
        );
        where_it_is = where_it_is.trim().to_owned();
    }
    let evidence = &finding.evidence;
    let mut why = format!(
        "{} (confidence {:.2}, not a probability): without it an effort of {} times the noise of one sample \
         comes back on {}, after everything else has been fitted again; {} is needed for a name.",
        capital(&certainty(finding)),
        finding.confidence,
        number(evidence.materiality, 2),
        evidence.joint,
        number(evidence.least_materiality, 2),
    );
    if !evidence.variables.is_empty() {
        why += &format!(" It depends on {}.", evidence.variables.join(", "));
    }
    match finding.confirmed {
        Some(true) => why += " The hold-out confirms it.",
        Some(false) => {
            why += " The hold-out does NOT confirm it: it is predicted no better with it.";
        }
        None => {}
    }
    Card {
        id: format!("finding-card-{k}"),
        what: title_of(finding),
        place: where_it_is,
        size: size(finding),
        sure: format!("{}, {}", size(finding), certainty(finding)),
        confidence: format!("{:.2}", finding.confidence),
        formula: law.map_or_else(String::new, |l| l.formula.to_owned()),
        parameters: finding
            .parameters
            .iter()
            // a term of the law that was not needed
            .filter(|(_, n)| n.value != 0.0 || n.stderr.is_some())
            .map(|(name, n)| {
                let (value, _) = written(n);
                let interval = n.stderr.map_or_else(
                    || "not known".to_owned(),
                    |s| {
                        let ends = [n.value - 1.96 * s, n.value + 1.96 * s];
                        format!("{} to {}", uncertain(ends[0], s).0, uncertain(ends[1], s).0)
                    },
                );
                let unit = unit_told(&n.unit).to_owned();
                Fitted { name: name.replace('_', " "), value, interval, unit }
            })
            .collect(),
        why,
        regime: traces.map_or_else(String::new, |t| regime(t, drawing)),
        look_alikes: look_alikes(finding, of),
        figure: traces.and_then(|t| figures::finding(drawing, k, t)),
        open: k < OPEN,
    }
}

fn regime(traces: &FindingTraces, drawing: &Drawing) -> String {
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
                    unit = joint.effort_unit
                ),
            ));
        }
    }
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    parts.truncate(4);
    parts.into_iter().map(|p| p.1).collect::<Vec<_>>().join("; ")
}
