//! `armident diagnose`.

use std::collections::BTreeMap;

use armident_effects::{Place, effect};
use armident_report::uncertain;
use serde::Deserialize;

use super::constants::{self, Constant};
use super::{ByJoint, counted, joints};
use crate::drawing::{Drawing, FindingTraces};
use crate::figures;
use crate::page::{Card, Fitted, Grid, JointCard, Section, Step, Tone, View, number, percent};

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

/// The sentence; of findings its first clause, the rest is said below.
fn headline(of: &Diagnosis) -> String {
    if of.sentence.is_empty() {
        return format!("{} findings", of.findings.len());
    }
    if !of.books.faults.is_empty() {
        return capital(&of.sentence);
    }
    capital(of.sentence.split([';', ',']).next().unwrap_or_default())
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

fn title(slug: &str) -> String {
    effect(slug).map_or_else(
        || {
            if slug == "unmodelled" {
                "structure without a name".to_owned()
            } else {
                slug.replace('_', " ")
            }
        },
        |e| e.law().title.to_owned(),
    )
}

fn place(finding: &Finding) -> String {
    finding.link.clone().unwrap_or_else(|| finding.joints.join(", "))
}

fn size(finding: &Finding) -> String {
    // in the order of the law, the first says most
    let names: Vec<&str> = match effect(&finding.effect) {
        Some(e) => e.law().parameters.iter().map(|p| p.name).collect(),
        None => finding.parameters.keys().map(String::as_str).collect(),
    };
    let first = names.iter().find_map(|n| finding.parameters.get_key_value(*n));
    let first = first.or_else(|| finding.parameters.iter().next());
    first.map_or_else(String::new, |(name, n)| {
        let (value, error) = written(n);
        let error = error.map_or_else(String::new, |e| format!(" \u{b1} {e}"));
        format!("{} {value}{error} {}", name.replace('_', " "), n.unit)
    })
}

fn written(n: &Number) -> (String, Option<String>) {
    match n.stderr {
        Some(stderr) => {
            let (value, error) = uncertain(n.value, stderr);
            (value, Some(error))
        }
        None => (number(n.value, 3), None),
    }
}

fn sure(confidence: f64) -> &'static str {
    match confidence {
        c if c >= 0.9 => "clear",
        c if c >= 0.65 => "likely",
        _ => "at the limit of what these recordings show",
    }
}

fn proof(of: &Diagnosis) -> Option<(&Errors, &'static str)> {
    let holdout = of.fit.holdout.as_ref().map(|e| (e, "hold-out"));
    holdout.or_else(|| of.fit.train.as_ref().map(|e| (e, "training")))
}

fn sentences(of: &Diagnosis) -> Vec<String> {
    if !of.books.faults.is_empty() {
        let mut all: Vec<String> =
            of.books.faults.iter().map(|f| format!("{}{}.", on(f), f.message)).collect();
        all.push("Nothing is said of physics before the columns are right.".to_owned());
        return all;
    }
    let mut all = Vec::new();
    let largest: Vec<String> = of
        .findings
        .iter()
        .take(OPEN)
        .map(|f| {
            let place = place(f);
            let on = if place.is_empty() { String::new() } else { format!(" on {place}") };
            format!("{}{on} ({}, {})", title(&f.effect), size(f), sure(f.confidence))
        })
        .collect();
    if !largest.is_empty() {
        let lead = if of.findings.len() > largest.len() { "The largest: " } else { "" };
        all.push(capital(&format!("{lead}{}.", largest.join("; "))));
    }
    if let Some(clause) = of.sentence.split("; ").find(|c| c.ends_with("left unexplained")) {
        all.push(capital(&format!("{clause}.")));
    }
    if let Some((errors, kind)) = proof(of) {
        let ratio = |after: &ByJoint| -> Vec<(f64, String)> {
            let mut all: Vec<(f64, String)> = of
                .joints
                .iter()
                .filter_map(|j| Some((j, *after.get(j)?, *errors.before.get(j)?)))
                // what was noise before can be no better after
                .filter(|(j, _, before)| of.effort_noise.get(*j).is_none_or(|n| *before > 2.0 * n))
                .map(|(j, after, before)| (after / before, j.clone()))
                .filter(|(r, _)| r.is_finite())
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            all
        };
        let (after, rigid) = (ratio(&errors.after), ratio(&errors.rigid));
        if let (Some(middle), Some(middle_rigid), Some(worst)) =
            (after.get(after.len() / 2), rigid.get(rigid.len() / 2), after.last())
        {
            all.push(format!(
                "With these effects the model leaves {} of the given model's error on the {kind} recordings \
                 (median joint; {} on {}, the worst). Its links identified again without any effect leave {}.",
                percent(middle.0),
                percent(worst.0),
                worst.1,
                percent(middle_rigid.0),
            ));
        }
        let left = of
            .joints
            .iter()
            .filter_map(|j| Some((errors.after.get(j)? / of.effort_noise.get(j)?, j)))
            .filter(|(r, _)| r.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((times, joint)) = left {
            all.push(format!(
                "What is left is at most {} times the noise of one recorded sample ({joint}).",
                number(times, 2)
            ));
        }
    }
    let unconfirmed: Vec<String> = of
        .findings
        .iter()
        .filter(|f| f.confirmed == Some(false))
        .map(|f| format!("{} on {}", title(&f.effect), place(f)))
        .collect();
    let confirmed = of.findings.iter().filter(|f| f.confirmed == Some(true)).count();
    if !unconfirmed.is_empty() {
        all.push(format!(
            "The hold-out does not confirm {}: it is predicted no better with it.",
            unconfirmed.join(", ")
        ));
    } else if confirmed > 0 && confirmed == of.findings.len() {
        all.push(format!(
            "The hold-out confirms {}: without it, all else fitted again, it is predicted worse.",
            if confirmed == 1 { "the finding" } else { "every finding" }
        ));
    }
    if let Some(replay) = &of.replay {
        let worst = replay.after.iter().max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((joint, after)) = worst {
            let before = replay.before.get(joint).copied().unwrap_or(f64::NAN);
            all.push(format!(
                "Driven by the recorded efforts for {} s, the simulated arm is off by {} at most (RMS of the \
                 position, {joint}; {} before).",
                number(replay.window_s, 3),
                number(*after, 2),
                number(before, 2)
            ));
        }
    }
    let coloured: Vec<&str> =
        of.whiteness_p.iter().filter(|w| *w.1 < WHITE).map(|w| w.0.as_str()).collect();
    if !coloured.is_empty() {
        all.push(format!(
            "What is left on {} is not white: something small is still left out there.",
            coloured.join(", ")
        ));
    }
    let limit = of.findings.iter().filter(|f| f.confidence < 0.65).count();
    if limit > 0 {
        all.push(format!(
            "{} of the findings only just matter{} against the noise.",
            limit,
            if limit == 1 { "s" } else { "" }
        ));
    }
    all.extend(
        of.books.unchecked.iter().map(|why| format!("The columns were not checked: {why}.")),
    );
    if of.findings.is_empty() {
        all.push(
            "Effects clearly smaller than the noise of one recorded sample are not named."
                .to_owned(),
        );
    }
    all
}

/// The joint of a fault.
fn on(fault: &Fault) -> String {
    fault.joint.as_ref().map_or_else(String::new, |joint| format!("{joint}: "))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

fn next(of: &Diagnosis, drawing: &Drawing) -> Vec<Step> {
    if !of.books.faults.is_empty() {
        let mut steps: Vec<Step> = of
            .books
            .faults
            .iter()
            .filter_map(|f| Some(Step::new(format!("{}{}", on(f), f.advice.as_ref()?))))
            .collect();
        steps.push(Step::new("Diagnose again; --trust-columns takes the columns as they are."));
        return steps;
    }
    let mut steps = Vec::new();
    let channel: Vec<String> = of
        .findings
        .iter()
        .filter(|f| {
            let place = effect(&f.effect).and_then(|e| e.law().places.first().copied());
            matches!(place, Some(Place::Gain | Place::Zero | Place::Time))
        })
        .map(|f| format!("{} {}", title(&f.effect), f.joints.join(", ")).trim().to_owned())
        .collect();
    if !channel.is_empty() {
        steps.push(Step::new(format!(
            "Correct the channels first ({}): in a mapping file, or in the drive.",
            channel.join("; ")
        )));
    }
    if of.findings.iter().any(|f| f.effect == "external_contact") {
        steps.push(Step::new(
            "Record the motion again with nothing near the arm: a contact hides other effects.",
        ));
    }
    let rivals: Vec<&Finding> = of.findings.iter().filter(|f| !f.alternatives.is_empty()).collect();
    match &of.next_motion {
        Some(NextMotion {
            file: Some(file),
            description: Some(motion),
            told_apart,
            pairs,
            separation,
        }) => {
            let by = separation.map_or_else(String::new, |s| {
                format!(", efforts differ by {} times the noise of a sample", number(s, 2))
            });
            steps.push(Step::new(format!(
                "Record the motion in {file} ({motion}): it tells {told_apart} of {pairs} pairs of look-alikes \
                 apart{by}."
            )));
        }
        _ if !rivals.is_empty() => {
            let names: Vec<String> = rivals
                .iter()
                .take(OPEN)
                .map(|f| format!("{} on {}", title(&f.effect), place(f)))
                .collect();
            steps.push(
                Step::new(format!(
                    "To be sure of {}, record a motion that tells {} from the alternatives.",
                    names.join(", "),
                    if names.len() == 1 { "it" } else { "them" }
                ))
                .by(with_option(drawing, "--next-motion FOLDER")),
            );
        }
        _ => {}
    }
    if !of.findings.is_empty() {
        let step = Step::new(
            "Use the model with these effects: save it, and predict the efforts of other motions.",
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
            Step::new("Prove it on a recording that was not fitted.")
                .by(with_option(drawing, "--holdout other.csv")),
        );
    }
    if of.findings.is_empty() {
        steps.push(Step::new(
            "Nothing has to change. To see smaller effects record more slowly, more often, or with less noise.",
        ));
    }
    steps
}

/// The command of the result with one more option.
fn with_option(drawing: &Drawing, option: &str) -> String {
    format!("{} {option}", without_report(&drawing.provenance.command).join(" ")).trim().to_owned()
}

fn without_report(command: &[String]) -> Vec<&str> {
    let mut kept = Vec::new();
    let mut words = command.iter();
    while let Some(word) = words.next() {
        if word == "--report" || word == "--json" {
            words.next();
        } else if word != "--traces" {
            kept.push(word.as_str());
        }
    }
    kept
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
        capital(sure(finding.confidence)),
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
        what: title(&finding.effect),
        place: where_it_is,
        size: size(finding),
        sure: format!("{}, {}", size(finding), sure(finding.confidence)),
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
                Fitted { name: name.replace('_', " "), value, interval, unit: n.unit.clone() }
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

/// What a finding may be taken for: what the result says of it, and what tells them apart.
fn look_alikes(finding: &Finding, of: &Diagnosis) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = finding
        .alternatives
        .iter()
        .map(|a| {
            let place = a.link.clone().unwrap_or_else(|| a.joints.join(", "));
            let more = a.left_more.map_or_else(String::new, |m| {
                format!("; it leaves only {} noise levels of a sample more", number(m.max(0.0), 2))
            });
            let apart = a.separated_by.as_ref().map_or_else(
                || "; a motion that tells them apart: --next-motion".to_owned(),
                |motion| format!(". What tells them apart: {motion}"),
            );
            (
                if place.is_empty() {
                    title(&a.effect)
                } else {
                    format!("{} on {place}", title(&a.effect))
                },
                format!("these recordings cannot tell it from this finding{more}{apart}"),
            )
        })
        .collect();
    let Some(law) = effect(&finding.effect).map(|e| e.law()) else { return all };
    for other in law.look_alikes {
        if finding.alternatives.iter().any(|a| a.effect == other.slug) {
            continue;
        }
        let beside =
            of.findings.iter().any(|f| f.effect == other.slug && f.joints == finding.joints);
        let lead = if beside {
            "found beside it, each counted with the other fitted. What tells them apart:"
        } else if effect(other.slug).is_some() {
            "was tried and not chosen. What tells them apart:"
        } else {
            "what tells them apart:"
        };
        all.push((title(other.slug), format!("{lead} {}", other.separated_by)));
    }
    all
}
