//! `armident check`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{ByJoint, counted, joints};
use crate::drawing::Drawing;
use crate::figures;
use crate::page::{Grid, Section, Step, Tone, View, number, optional, percent};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Checked {
    robot: String,
    recordings: Vec<String>,
    verdict: String,
    checks: Vec<Check>,
    channels: Vec<Channel>,
    constants: Vec<Constant>,
    rank: usize,
    unknowns: usize,
    cutoff_hz: Option<f64>,
    warnings: Vec<String>,
    notes: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Check {
    topic: String,
    joint: Option<String>,
    verdict: String,
    message: String,
    advice: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Channel {
    joint: String,
    column: String,
    probability: BTreeMap<String, f64>,
    gain: f64,
    gain_95: [f64; 2],
    sd: f64,
    residual_rms: f64,
    urdf_sd: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Constant {
    label: String,
    joint: String,
    unit: String,
    size: f64,
    standard_error: Option<f64>,
    verdict: String,
    reason: Option<String>,
}

/// The worst first.
fn rank(verdict: &str) -> usize {
    ["wrong", "doubtful", "cannot_tell", "ok"].iter().position(|v| *v == verdict).unwrap_or(4)
}

pub(crate) fn view(of: Checked, drawing: &Drawing) -> View {
    let count = |verdict: &str| of.checks.iter().filter(|c| c.verdict == verdict).count();
    let wrong: Vec<&Check> = of.checks.iter().filter(|c| c.verdict == "wrong").collect();
    let of_joint = |c: &Check| c.joint.as_ref().map_or(String::new(), |j| format!("{j}: "));
    let mut sentences = vec![format!(
        "Of {}: {} ok, {} cannot be told, {} doubtful, {} wrong. {} of {} unknowns are determined by the \
         recordings alone.",
        counted(of.checks.len(), "check"),
        count("ok"),
        count("cannot_tell"),
        count("doubtful"),
        count("wrong"),
        of.rank,
        of.unknowns
    )];
    sentences.extend(wrong.iter().map(|c| format!("{}{}.", of_joint(c), c.message)));
    let mut advised: Vec<&Check> =
        of.checks.iter().filter(|c| c.verdict != "ok" && c.advice.is_some()).collect();
    advised.sort_by_key(|c| rank(&c.verdict));
    let mut next: Vec<Step> = advised
        .iter()
        .take(6)
        .filter_map(|c| Some(Step::new(format!("{}{}", of_joint(c), c.advice.as_ref()?))))
        .collect();
    if wrong.is_empty() {
        next.push(
            Step::new("The books are right as far as can be told: identify, or diagnose.")
                .by(format!("armident diagnose robot.urdf {}", of.recordings.join(" "))),
        );
    }
    let mut open: Vec<String> = wrong.iter().filter_map(|c| c.joint.clone()).collect();
    open.truncate(1);
    let mut ordered: Vec<&Check> = of.checks.iter().collect();
    ordered.sort_by_key(|c| rank(&c.verdict));
    let rows = ordered
        .iter()
        .map(|c| {
            vec![
                c.verdict.replace('_', " "),
                c.joint.clone().unwrap_or_else(|| "robot".to_owned()),
                c.topic.clone(),
                c.message.clone(),
                c.advice.clone().filter(|_| c.verdict != "ok").unwrap_or_default(),
            ]
        })
        .collect();
    let header = ["verdict", "joint", "what", "found", "what to do"];
    let marked: Vec<usize> = drawing
        .joints
        .iter()
        .enumerate()
        .filter(|(_, j)| wrong.iter().any(|c| c.joint.as_ref() == Some(&j.name)))
        .map(|(k, _)| k)
        .collect();
    View {
        kind: "Check of recordings",
        tone: match of.verdict.as_str() {
            "wrong" => Tone::Bad,
            "ok" => Tone::Good,
            _ => Tone::Open,
        },
        headline: match wrong.len() {
            0 if of.verdict == "ok" => "The recordings are fit for purpose".to_owned(),
            0 => "Nothing is wrong with the recordings, not everything is sure".to_owned(),
            1 => "One thing is wrong with the recordings".to_owned(),
            n => format!("{n} things are wrong with the recordings"),
        },
        sentences,
        next,
        overview: figures::over_time(drawing).into_iter().collect(),
        joints: joints(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &marked, &[])),
        sections: vec![
            Section {
                id: "checks".to_owned(),
                title: "Checks".to_owned(),
                sentences: Vec::new(),
                tables: vec![
                    Grid::new("Checks, the worst first", &header, 5).with(rows),
                    channels(&of),
                ],
                figures: Vec::new(),
            },
            constants(&of),
        ],
        cards: Vec::new(),
        robot: of.robot,
        warnings: [of.warnings, of.notes].concat(),
    }
}

fn channels(of: &Checked) -> Grid {
    let header = [
        "joint",
        "column",
        "most likely",
        "probability",
        "gain",
        "95 % interval",
        "variation",
        "free fit leaves",
        "URDF's variation",
    ];
    let rows = of
        .channels
        .iter()
        .map(|c| {
            let likely = c.probability.iter().max_by(|a, b| a.1.total_cmp(b.1));
            vec![
                c.joint.clone(),
                c.column.clone(),
                likely.map_or_else(String::new, |(kind, _)| kind.replace('_', " ")),
                likely.map_or_else(|| "-".to_owned(), |(_, p)| number(*p, 3)),
                number(c.gain, 4),
                format!("{} to {}", number(c.gain_95[0], 4), number(c.gain_95[1], 4)),
                number(c.sd, 3),
                number(c.residual_rms, 3),
                number(c.urdf_sd, 3),
            ]
        })
        .collect();
    Grid::new("What each effort column is", &header, 3).with(rows)
}

fn constants(of: &Checked) -> Section {
    let mut ordered: Vec<&Constant> = of.constants.iter().collect();
    ordered.sort_by_key(|c| rank(&c.verdict).min(3));
    let rows = ordered
        .iter()
        .map(|c| {
            let share = c.standard_error.map(|e| e / c.size);
            vec![
                c.label.clone(),
                c.joint.clone(),
                match c.verdict.as_str() {
                    "ok" => "well".to_owned(),
                    "doubtful" => "roughly".to_owned(),
                    _ => "hardly or not".to_owned(),
                },
                c.reason.clone().unwrap_or_default(),
                c.standard_error.map_or_else(|| "open".to_owned(), |e| number(e, 2)),
                optional(Some(c.size), 3),
                share.map_or_else(|| "-".to_owned(), percent),
                c.unit.clone(),
            ]
        })
        .collect();
    let header =
        ["constant", "joint", "determined", "why not", "std error", "size", "relative", "unit"];
    let cutoff = of.cutoff_hz.map(|c| format!("Low-pass of {} Hz.", number(c, 3)));
    Section {
        id: "constants".to_owned(),
        title: "Minimal set and excitation".to_owned(),
        sentences: std::iter::once(format!(
            "The recordings alone determine {} of {} unknowns; a constant is well determined when its standard \
             error is below a tenth of its size by the URDF.",
            of.rank, of.unknowns
        ))
        .chain(cutoff)
        .collect(),
        tables: vec![Grid::new("Constants", &header, 4).with(rows)],
        figures: Vec::new(),
    }
}
