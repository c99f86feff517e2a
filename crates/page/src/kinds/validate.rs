//! `armident validate`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{ByJoint, counted, joints};
use crate::drawing::Drawing;
use crate::figures;
use crate::page::{Grid, Section, Step, Tone, View, number, optional, percent};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Validated {
    robot: String,
    model: String,
    recordings: Vec<String>,
    joints: Vec<String>,
    cutoff_hz: Option<f64>,
    before: BTreeMap<String, Errors>,
    after: BTreeMap<String, Errors>,
    replay_before: Option<Replay>,
    replay_after: Option<Replay>,
    warnings: Vec<String>,
    notes: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Errors {
    rmse: f64,
    relative: f64,
    rmse_raw: f64,
    band_coverage: Option<f64>,
    lag1_correlation: Option<f64>,
    whiteness_p: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Replay {
    window_s: f64,
    windows: usize,
    diverged: usize,
    position_rms: ByJoint,
    velocity_rms: ByJoint,
}

/// Relative error up to which a model is said to predict well.
const WELL: f64 = 0.05;
/// p-value below which a residual is not white.
const WHITE: f64 = 0.01;

pub(crate) fn view(of: Validated, drawing: &Drawing) -> View {
    let mut errors: Vec<(f64, &String)> =
        of.joints.iter().filter_map(|j| Some((of.after.get(j)?.relative, j))).collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = errors.get(errors.len() / 2).map_or(f64::NAN, |e| e.0);
    let worst = errors.last().cloned();
    let coloured: Vec<&str> = of
        .joints
        .iter()
        .filter(|j| of.after.get(*j).and_then(|e| e.whiteness_p).is_some_and(|p| p < WHITE))
        .map(String::as_str)
        .collect();
    let narrow: Vec<String> = of
        .joints
        .iter()
        .filter_map(|j| Some((j, of.after.get(j)?.band_coverage?)))
        .filter(|(_, share)| *share < 0.9)
        .map(|(j, share)| format!("{j} {}", percent(share)))
        .collect();
    let mut sentences = Vec::new();
    if let Some((share, joint)) = worst {
        let before = of.before.get(joint).map_or(f64::NAN, |e| e.relative);
        sentences.push(format!(
            "On {} that {} not fitted here, the model errs by {} of the effort's variation (median joint); \
             the worst is {joint} with {}, where the URDF alone errs by {}.",
            counted(of.recordings.len(), "recording"),
            if of.recordings.len() == 1 { "was" } else { "were" },
            percent(middle),
            percent(share),
            percent(before)
        ));
    }
    sentences.push(if coloured.is_empty() {
        "What is left is white as far as the test can tell: no structure that a model could take."
            .to_owned()
    } else {
        format!(
            "What is left on {} is not white: the model leaves something out.",
            coloured.join(", ")
        )
    });
    if !narrow.is_empty() {
        sentences.push(format!(
            "Fewer samples than 95 % lie in the model's band: {}. Its noise levels are too small for these \
             recordings.",
            narrow.join(", ")
        ));
    }
    if let Some(replay) = &of.replay_after {
        let largest = replay.position_rms.iter().max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((joint, error)) = largest {
            sentences.push(format!(
                "Driven by the recorded efforts through {} windows of {} s, the simulated arm is off by at most {} \
                 (RMS in rad or m, {joint}){}.",
                replay.windows,
                number(replay.window_s, 3),
                number(*error, 3),
                if replay.diverged > 0 {
                    format!("; {} windows diverged", replay.diverged)
                } else {
                    String::new()
                }
            ));
        }
    }
    let worst_share = worst.map_or(f64::NAN, |w| w.0);
    let good = worst_share < WELL;
    let mut next = Vec::new();
    if !good || !coloured.is_empty() {
        next.push(Step::new("Ask what the model leaves out.").by(format!(
            "armident diagnose {} {}",
            of.model,
            of.recordings.join(" ")
        )));
    }
    if good {
        next.push(
            Step::new("Use it: predict efforts, or write it for a controller or simulator.")
                .by(format!("armident export {} -o robot.urdf", of.model)),
        );
    }
    let open = worst.map(|w| vec![w.1.clone()]).unwrap_or_default();
    let values =
        |m: &BTreeMap<String, Errors>| of.joints.iter().map(|j| m.get(j).map(|e| e.rmse)).collect();
    let bars = figures::errors(
        &of.joints,
        &[("URDF alone".to_owned(), values(&of.before)), ("model".to_owned(), values(&of.after))],
    );
    View {
        kind: "Validation",
        tone: if good { Tone::Good } else { Tone::Bad },
        headline: match worst {
            Some((share, _)) if good => format!("The model predicts within {}", percent(share)),
            Some((share, joint)) => format!("The model errs by {} on {joint}", percent(share)),
            None => "Nothing could be compared".to_owned(),
        },
        sentences,
        next,
        overview: bars
            .map(|f| figures::Figure { title: "Error of the low-passed efforts".to_owned(), ..f })
            .into_iter()
            .chain(figures::over_time(drawing))
            .collect(),
        joints: joints(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &[], &[])),
        sections: vec![numbers(&of)],
        cards: Vec::new(),
        robot: format!("{}: {}", of.robot, of.model),
        warnings: [of.warnings, of.notes].concat(),
    }
}

fn numbers(of: &Validated) -> Section {
    let rows = of
        .joints
        .iter()
        .filter_map(|j| {
            let (before, after) = (of.before.get(j)?, of.after.get(j)?);
            Some(vec![
                j.clone(),
                number(before.rmse, 4),
                percent(before.relative),
                number(after.rmse, 4),
                percent(after.relative),
                number(after.rmse_raw, 4),
                after.band_coverage.map_or_else(|| "-".to_owned(), percent),
                optional(after.lag1_correlation, 2),
                after.whiteness_p.map_or_else(
                    || "-".to_owned(),
                    |p| if p < 1e-4 { "< 1e-4".to_owned() } else { number(p, 2) },
                ),
            ])
        })
        .collect();
    let header = [
        "joint",
        "URDF alone",
        "of its variation",
        "model",
        "of its variation",
        "as recorded",
        "in the 95 % band",
        "lag-1",
        "white, p",
    ];
    let mut tables = vec![Grid::new("RMS error of the effort [N m or N]", &header, 1).with(rows)];
    if of.replay_after.is_some() || of.replay_before.is_some() {
        let cell = |replay: &Option<Replay>, velocity: bool, j: &String| {
            let found = replay
                .as_ref()
                .and_then(|r| if velocity { &r.velocity_rms } else { &r.position_rms }.get(j));
            found.map_or_else(|| "-".to_owned(), |x| number(*x, 3))
        };
        let rows = of
            .joints
            .iter()
            .map(|j| {
                vec![
                    j.clone(),
                    cell(&of.replay_before, false, j),
                    cell(&of.replay_after, false, j),
                    cell(&of.replay_before, true, j),
                    cell(&of.replay_after, true, j),
                ]
            })
            .collect();
        let header = ["joint", "position, URDF", "position, model", "speed, URDF", "speed, model"];
        let caption = "Forward replay: RMS error of the motion [rad or m, per s]";
        tables.push(Grid::new(caption, &header, 1).with(rows));
    }
    let cutoff = of.cutoff_hz.map(|c| format!("Low-pass of {} Hz.", number(c, 3)));
    Section {
        id: "numbers".to_owned(),
        title: "Errors".to_owned(),
        sentences: cutoff.into_iter().collect(),
        tables,
        figures: Vec::new(),
    }
}
