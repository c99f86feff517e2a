//! `armident diagnose`.

use std::collections::BTreeMap;

use armident_effects::{Place, effect};
use armident_report::uncertain;
use serde::Deserialize;
use serde_json::Value;

use super::{ByJoint, counted, joints};
use crate::drawing::{Drawing, FindingTraces};
use crate::figures;
use crate::page::{Card, Fitted, Grid, Section, Step, Tone, View, number, percent};

/// The result, as far as the page says it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Diagnosis {
    robot: String,
    recordings: Vec<String>,
    holdout_recordings: Vec<String>,
    joints: Vec<String>,
    findings: Vec<Finding>,
    fit: Fits,
    effort_noise: ByJoint,
    inertial_error: Option<f64>,
    warnings: Vec<String>,
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
    /// whatever else a later program says of it
    #[serde(flatten)]
    more: BTreeMap<String, Value>,
}

/// Findings that are open at first.
const OPEN: usize = 3;

pub(crate) fn view(of: Diagnosis, drawing: &Drawing) -> View {
    let cards: Vec<Card> =
        of.findings.iter().enumerate().map(|(k, finding)| card(k, finding, &of, drawing)).collect();
    let blamed_joints: Vec<usize> = on_chain(drawing, |f| f.link.is_none(), &of);
    let blamed_links: Vec<usize> = on_chain(drawing, |f| f.link.is_some(), &of);
    let mut worst: Vec<String> =
        of.findings.iter().take(1).map(|f| f.evidence.joint.clone()).collect();
    if worst.is_empty() {
        worst = of.joints.first().cloned().into_iter().collect();
    }
    View {
        kind: "Diagnosis",
        tone: if of.findings.is_empty() { Tone::Good } else { Tone::Bad },
        headline: match of.findings.len() {
            0 => "The recordings show nothing that the model leaves out".to_owned(),
            1 => "The recordings show one effect that the model leaves out".to_owned(),
            n => format!("The recordings show {n} effects that the model leaves out"),
        },
        sentences: sentences(&of),
        next: next(&of, drawing),
        overview: overview(&of, drawing),
        joints: joints(drawing, &worst, &of.effort_noise),
        skeleton: drawing
            .skeleton
            .as_ref()
            .map(|s| figures::skeleton(drawing, s, &blamed_joints, &blamed_links)),
        sections: vec![errors(&of)],
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
    if let Some((errors, kind)) = proof(of) {
        let ratio = |after: &ByJoint| -> Vec<(f64, String)> {
            let mut all: Vec<(f64, String)> = of
                .joints
                .iter()
                .filter_map(|j| Some((after.get(j)? / errors.before.get(j)?, j.clone())))
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
    let limit = of.findings.iter().filter(|f| f.confidence < 0.65).count();
    if limit > 0 {
        all.push(format!(
            "{} of the findings only just matter{} against the noise.",
            limit,
            if limit == 1 { "s" } else { "" }
        ));
    }
    if of.findings.is_empty() {
        all.push(
            "Effects clearly smaller than the noise of one recorded sample are not named."
                .to_owned(),
        );
    }
    all
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

fn next(of: &Diagnosis, drawing: &Drawing) -> Vec<Step> {
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
    let doubtful = of.findings.iter().find(|f| f.confidence < 0.9);
    if let Some((finding, separated)) = doubtful.and_then(|f| {
        let others = effect(&f.effect)?.law().look_alikes;
        let other = others.iter().find(|o| !o.separated_by.contains("nothing"))?;
        Some((f, format!("{} ({})", other.separated_by, title(other.slug))))
    }) {
        steps.push(Step::new(format!(
            "To be sure of {} on {}, record what tells it from its look-alike: {separated}.",
            title(&finding.effect),
            place(finding)
        )));
    }
    if !of.findings.is_empty() {
        let step = Step::new(
            "Use the model with these effects: save it, and predict the efforts of other motions.",
        );
        let command = &drawing.provenance.command;
        steps.push(if command.is_empty() || command.iter().any(|a| a.contains("--save-model")) {
            step.by("armident predict model.json motion.csv -o predicted.csv")
        } else {
            let kept: Vec<&str> = without_report(command);
            step.by(format!("{} --save-model model.json", kept.join(" ")))
        });
    }
    if of.holdout_recordings.is_empty() {
        steps.push(
            Step::new("Prove it on a recording that was not fitted.").by("--holdout other.csv"),
        );
    }
    if of.findings.is_empty() {
        steps.push(Step::new(
            "Nothing has to change. To see smaller effects record more slowly, more often, or with less noise.",
        ));
    }
    steps
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

fn errors(of: &Diagnosis) -> Section {
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
    Section {
        id: "errors-by-joint".to_owned(),
        title: "Errors".to_owned(),
        sentences,
        tables,
        figures: Vec::new(),
    }
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
            let more: Vec<String> = a
                .more
                .iter()
                .filter(|(_, v)| v.is_number() || v.is_string())
                .map(|(k, v)| {
                    let value = match v {
                        Value::Number(n) => {
                            n.as_f64().map_or_else(|| n.to_string(), |x| number(x, 3))
                        }
                        Value::String(s) => s.clone(),
                        other => other.to_string(),
                    };
                    format!("{} {value}", k.replace('_', " "))
                })
                .collect();
            let detail =
                if more.is_empty() { String::new() } else { format!(" ({})", more.join(", ")) };
            (
                format!("{} {place}", title(&a.effect)).trim().to_owned(),
                format!("these recordings cannot tell it from this finding{detail}"),
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
