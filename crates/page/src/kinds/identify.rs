//! `armident identify`.

use std::collections::BTreeMap;

use armident_report::uncertain;
use serde::Deserialize;

use super::constants::{self, Constant, OPEN};
use super::{ByJoint, counted, joints};
use crate::drawing::Drawing;
use crate::figures;
use crate::page::{Grid, Section, Step, Tone, View, number, percent};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Identified {
    robot: String,
    method: String,
    estimator: Option<String>,
    recordings: Vec<String>,
    holdout_recordings: Vec<String>,
    joints: Vec<String>,
    cutoff_hz: Option<f64>,
    velocities: String,
    consistency: Option<Consistency>,
    constants: Vec<Constant>,
    effects: Vec<Effect>,
    merged: Vec<Merged>,
    rank: usize,
    unknowns: usize,
    condition: f64,
    rows: usize,
    independent_share: f64,
    effort_noise: ByJoint,
    not_essential: Vec<String>,
    fit: Fits,
    warnings: Vec<String>,
    notes: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Consistency {
    exact: bool,
    distance_in_standard_errors: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Effect {
    effect: String,
    joint: String,
    parameter: String,
    unit: String,
    value: f64,
    standard_error: Option<f64>,
    admissible: bool,
    at_bound: bool,
    undetermined: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Merged {
    term: String,
    into: BTreeMap<String, f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fits {
    train: Fit,
    holdout: Option<Fit>,
    urdf: Fit,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fit {
    rmse: ByJoint,
    relative: ByJoint,
}

pub(crate) fn view(of: Identified, drawing: &Drawing) -> View {
    let determined = of.rank == of.unknowns;
    let errors = of.fit.holdout.as_ref().unwrap_or(&of.fit.train);
    let kind = if of.fit.holdout.is_some() { "hold-out" } else { "training" };
    let mut sentences = vec![format!(
        "{} of {} unknowns are determined by {} ({} rows, {} of them independent).",
        of.rank,
        of.unknowns,
        counted(of.recordings.len(), "recording"),
        of.rows,
        percent(of.independent_share)
    )];
    let mut relative: Vec<(f64, &String)> =
        of.joints.iter().filter_map(|j| Some((*errors.relative.get(j)?, j))).collect();
    relative.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let (Some(middle), Some(worst)) = (relative.get(relative.len() / 2), relative.last()) {
        let urdf = of.fit.urdf.relative.get(worst.1).copied().unwrap_or(f64::NAN);
        sentences.push(format!(
            "On the {kind} recordings the model errs by {} of the effort's variation (median joint; {} on {}, \
             the worst, where the URDF alone errs by {}).",
            percent(middle.0),
            percent(worst.0),
            worst.1,
            percent(urdf)
        ));
    }
    let mut off: Vec<(&Constant, f64)> =
        of.constants.iter().filter_map(|c| Some((c, c.off()?))).collect();
    off.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let far: Vec<String> = off
        .iter()
        .take_while(|(_, t)| t.abs() > 5.0)
        .take(3)
        .filter_map(|(c, t)| {
            let (value, error) = uncertain(c.value?, c.standard_error?);
            Some(format!(
                "{} of {}: {value} \u{b1} {error} {}, the URDF says {} ({} standard errors off)",
                c.label,
                c.joint,
                c.unit,
                number(c.urdf, 4),
                number(t.abs(), 2)
            ))
        })
        .collect();
    sentences.push(if far.is_empty() {
        "No constant is clearly off the URDF.".to_owned()
    } else {
        format!("Farthest from the URDF: {}.", far.join("; "))
    });
    if let Some(links) = &of.consistency {
        sentences.push(if links.exact {
            "Real links have exactly these constants.".to_owned()
        } else {
            format!(
                "The nearest real links are {} standard errors off; the model has them.",
                number(links.distance_in_standard_errors, 3)
            )
        });
    }
    let open = relative.last().map(|w| vec![w.1.clone()]).unwrap_or_default();
    let worst = relative.last().map_or(0.0, |w| w.0);
    let mut set = Section {
        id: "constants".to_owned(),
        title: "Minimal set".to_owned(),
        sentences: cannot_be_separated(&of),
        tables: vec![constants::table(&of.constants), effects(&of)],
        figures: constants::off_the_urdf(&of.constants).into_iter().collect(),
    };
    set.tables.retain(|t| !t.rows.is_empty());
    set.figures.extend(drawing.correlation.as_ref().map(figures::correlation));
    View {
        kind: "Identification",
        tone: if determined { Tone::Good } else { Tone::Open },
        headline: if determined {
            format!("All {} unknowns are determined", of.unknowns)
        } else {
            format!("{} of {} unknowns are determined", of.rank, of.unknowns)
        },
        sentences,
        next: next(&of, worst),
        overview: bars(&of, kind).into_iter().chain(figures::over_time(drawing)).collect(),
        joints: joints(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &[], &[])),
        sections: vec![set, excitation(&of)],
        cards: Vec::new(),
        robot: of.robot,
        warnings: [of.warnings, of.notes].concat(),
    }
}

fn next(of: &Identified, worst: f64) -> Vec<Step> {
    let mut steps = Vec::new();
    if of.rank < of.unknowns {
        let open: Vec<&str> = of
            .constants
            .iter()
            .filter(|c| c.undetermined > OPEN)
            .map(|c| c.label.as_str())
            .take(6)
            .collect();
        steps.push(
            Step::new(format!("Move the joints that leave {} open.", open.join(", ")))
                .by("armident plan robot.urdf -o plan/"),
        );
    }
    if of.holdout_recordings.is_empty() {
        steps.push(
            Step::new("Judge the model on a recording that was not fitted.")
                .by("--holdout other.csv"),
        );
    }
    if worst > 0.05 {
        steps.push(
            Step::new(format!(
                "An error of {} is more than friction and rigid links explain: ask what the model leaves out.",
                percent(worst)
            ))
            .by(format!("armident diagnose robot.urdf {}", of.recordings.join(" "))),
        );
    }
    steps.push(
        Step::new("Use the model: predict efforts, or write it for a controller or simulator.")
            .by("armident export model.json -o robot.urdf"),
    );
    steps
}

fn cannot_be_separated(of: &Identified) -> Vec<String> {
    let mut all: Vec<String> = of
        .merged
        .iter()
        .map(|m| {
            let into: Vec<&str> = m.into.keys().map(String::as_str).collect();
            format!(
                "{} cannot be told apart on this arm: it is part of {}.",
                m.term,
                into.join(", ")
            )
        })
        .collect();
    if !of.not_essential.is_empty() {
        all.push(format!(
            "The intervals of {} hold 0: the recordings would not miss them.",
            of.not_essential.join(", ")
        ));
    }
    all
}

fn effects(of: &Identified) -> Grid {
    let header = ["effect", "joint", "remark", "estimate", "std error", "unit"];
    let rows = of
        .effects
        .iter()
        .map(|e| {
            let (value, error) = match e.standard_error {
                Some(error) => uncertain(e.value, error),
                None => (number(e.value, 4), "-".to_owned()),
            };
            let remark = if e.at_bound {
                "held at 0 by its sign"
            } else if !e.admissible {
                "of a sign the law does not admit"
            } else if e.undetermined > OPEN {
                "open"
            } else {
                ""
            };
            let law = armident_effects::effect(&e.effect)
                .map_or_else(|| e.effect.clone(), |l| l.law().title.to_owned());
            let name = format!("{law}, {}", e.parameter.replace('_', " "));
            vec![name, e.joint.clone(), remark.to_owned(), value, error, e.unit.clone()]
        })
        .collect();
    Grid::new("Joint effects", &header, 3).with(rows)
}

fn bars(of: &Identified, kind: &str) -> Option<figures::Figure> {
    let errors = of.fit.holdout.as_ref().unwrap_or(&of.fit.train);
    let values = |m: &ByJoint| of.joints.iter().map(|j| m.get(j).copied()).collect();
    let models = [
        ("URDF alone".to_owned(), values(&of.fit.urdf.rmse)),
        ("model".to_owned(), values(&errors.rmse)),
    ];
    figures::errors(&of.joints, &models).map(|f| figures::Figure {
        title: format!("Error of the {kind} efforts (low-passed)"),
        ..f
    })
}

fn excitation(of: &Identified) -> Section {
    let method = match of.estimator.as_deref() {
        Some(name) => armident_report::estimator_title(name),
        _ if of.method == "algorithm2" => "Algorithm 2",
        _ => &of.method,
    };
    let rows = [
        ("method", method.to_owned()),
        ("rank of unknowns", format!("{} of {}", of.rank, of.unknowns)),
        ("condition number of the unit columns", number(of.condition, 3)),
        ("rows", of.rows.to_string()),
        ("independent share", percent(of.independent_share)),
        (
            "low-pass",
            of.cutoff_hz.map_or_else(|| "none".into(), |c| format!("{} Hz", number(c, 3))),
        ),
        ("velocities from", of.velocities.clone()),
    ];
    let rows = rows.into_iter().map(|(a, b)| vec![a.to_owned(), b]).collect();
    let cell = |m: &ByJoint, j: &String, digits| {
        m.get(j).map_or_else(|| "-".to_owned(), |x| number(*x, digits))
    };
    let share = |m: &ByJoint, j: &String| m.get(j).map_or_else(|| "-".to_owned(), |x| percent(*x));
    let empty = Fit::default();
    let holdout = of.fit.holdout.as_ref().unwrap_or(&empty);
    let errors = of
        .joints
        .iter()
        .map(|j| {
            vec![
                j.clone(),
                cell(&of.fit.train.rmse, j, 4),
                share(&of.fit.train.relative, j),
                cell(&holdout.rmse, j, 4),
                share(&holdout.relative, j),
                cell(&of.fit.urdf.rmse, j, 4),
                share(&of.fit.urdf.relative, j),
                cell(&of.effort_noise, j, 3),
            ]
        })
        .collect();
    let header = [
        "joint",
        "training",
        "of its variation",
        "hold-out",
        "of its variation",
        "URDF alone",
        "of its variation",
        "noise level",
    ];
    Section {
        id: "excitation".to_owned(),
        title: "Excitation and fit".to_owned(),
        sentences: Vec::new(),
        tables: vec![
            Grid::new("The least-squares problem", &["what", ""], 2).with(rows),
            Grid::new("RMS error of the low-passed effort [N m or N]", &header, 1).with(errors),
        ],
        figures: Vec::new(),
    }
}
