//! `armident validate`.

use std::collections::BTreeMap;

use armident_report::{
    ByJoint, EffortErrorRow, PositionsUnderCommands, ValidateReport, counted, percent,
    standard_sections,
};

use super::joint_cards::joint_cards;
use crate::blocks::parts;
use crate::drawing::{Drawing, DrawnQuantity};
use crate::figures::{self, Figure};
use crate::view::{Step, Tone, View, number};

/// Relative error up to which a model predicts well.
const WELL: f64 = 0.05;
/// Share of the command's position error up to which a model follows well: what a gain, an offset and a lag of each joint
/// rarely reach.
const FOLLOWED: f64 = 0.5;
/// p-value below which a residual is not white.
const WHITE: f64 = 0.01;
/// Coverage of the 95 % band below which the noise level is too small.
const UNDER_COVERED: f64 = 0.9;

pub(crate) fn view(of: &ValidateReport, drawing: &Drawing) -> View {
    if let Some(errors) = &of.positions {
        return view_of_positions(of, errors, drawing);
    }
    let mut errors: Vec<(f64, &String)> =
        of.joints.iter().filter_map(|j| Some((of.after.get(j)?.relative, j))).collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let worst = errors.last().copied();
    let is_good = worst.is_some_and(|(share, _)| share < WELL);
    let coloured = coloured(of);
    let mut next = Vec::new();
    if !is_good || !coloured.is_empty() {
        next.push(Step::new("Run diagnose to find missing effects.").by(format!(
            "armident diagnose {} {}",
            of.model,
            of.recordings.join(" ")
        )));
    }
    if is_good {
        next.push(
            Step::new(
                "Use the model: predict efforts, or export it for a controller or simulator.",
            )
            .by(format!("armident export {} -o robot.urdf", of.model)),
        );
    }
    let open: Vec<String> = worst.map(|w| w.1.clone()).into_iter().collect();
    let values = |m: &BTreeMap<String, EffortErrorRow>| {
        of.joints.iter().map(|j| m.get(j).map(|e| e.rmse)).collect()
    };
    let bars = figures::errors(
        &of.joints,
        &[("URDF only".to_owned(), values(&of.before)), ("model".to_owned(), values(&of.after))],
        DrawnQuantity::Effort,
    );
    let shown = standard_sections::VALIDATE.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    View {
        kind: "Validation",
        tone: if is_good { Tone::Good } else { Tone::Bad },
        headline: match worst {
            Some((share, _)) if is_good => format!("Effort error at most {}", percent(share)),
            Some((share, joint)) => {
                format!("Worst joint: {joint}, effort error {}", percent(share))
            }
            None => "No joint has both a measured and a predicted effort".to_owned(),
        },
        sentences: sentences(of, &errors, &coloured),
        next,
        overview: bars
            .map(|f| Figure { title: "Effort error (low-passed)".to_owned(), ..f })
            .into_iter()
            .chain(figures::over_time(drawing))
            .collect(),
        joints: joint_cards(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &[], &[], &[])),
        sections: parts(shown, |_| None),
        cards: Vec::new(),
        robot: format!("{}: {}", of.robot, of.model),
        warnings: [&of.warnings[..], &of.notes].concat(),
    }
}

/// Of an arm behind its controllers.
fn view_of_positions(
    of: &ValidateReport,
    errors: &PositionsUnderCommands,
    drawing: &Drawing,
) -> View {
    let share = |joint: &String| Some(errors.whole.get(joint)? / errors.command.get(joint)?);
    let shares = of.joints.iter().filter_map(|joint| Some((share(joint)?, joint)));
    let worst = shares.max_by(|a, b| a.0.total_cmp(&b.0));
    let is_good = worst.is_some_and(|(share, _)| share < FOLLOWED);
    let next =
        if is_good {
            Step::new("Export the controllers for a simulator.")
                .by(format!("armident export {} -o robot.xml", of.model))
        } else {
            Step::new("Run diagnose on recordings of commands to find what is missing.")
                .by(format!("armident diagnose {} {}", of.model, of.recordings.join(" ")))
        };
    let values = |errors: &ByJoint| of.joints.iter().map(|j| errors.get(j).copied()).collect();
    let bars = figures::errors(
        &of.joints,
        &[
            ("command".to_owned(), values(&errors.command)),
            ("model".to_owned(), values(&errors.whole)),
        ],
        DrawnQuantity::Position,
    );
    let shown = standard_sections::VALIDATE.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    let open: Vec<String> = worst.map(|w| w.1.clone()).into_iter().collect();
    View {
        kind: "Validation",
        tone: if is_good { Tone::Good } else { Tone::Bad },
        headline: match worst {
            Some((share, joint)) => {
                format!("Worst joint: {joint}, {} of the command's position error", percent(share))
            }
            None => "No joint has both a command and a position".to_owned(),
        },
        sentences: vec![format!(
            "Positions on {}: simulated from the commands, from the first recorded position on.",
            counted(of.recordings.len(), "hold-out recording")
        )],
        next: vec![next],
        overview: bars
            .map(|f| Figure { title: "Position error by joint".to_owned(), ..f })
            .into_iter()
            .chain(figures::over_time(drawing))
            .collect(),
        joints: joint_cards(drawing, &open, &ByJoint::default()),
        skeleton: drawing.skeleton.as_ref().map(|s| figures::skeleton(drawing, s, &[], &[], &[])),
        sections: parts(shown, |_| None),
        cards: Vec::new(),
        robot: format!("{}: {}", of.robot, of.model),
        warnings: [&of.warnings[..], &of.notes].concat(),
    }
}

/// Joints whose residual is not white.
fn coloured(of: &ValidateReport) -> Vec<&str> {
    let p_value = |joint: &String| of.after.get(joint).and_then(|errors| errors.whiteness_p);
    let joints = of.joints.iter().filter(|joint| p_value(joint).is_some_and(|p| p < WHITE));
    joints.map(String::as_str).collect()
}

fn sentences(of: &ValidateReport, errors: &[(f64, &String)], coloured: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    if let (Some(middle), Some((share, joint))) = (errors.get(errors.len() / 2), errors.last()) {
        let urdf = of.before.get(*joint).map_or(f64::NAN, |e| e.relative);
        all.push(format!(
            "Effort error on {}: {} of the effort's standard deviation (median joint); worst {} on {joint} (URDF only \
             {}).",
            counted(of.recordings.len(), "hold-out recording"),
            percent(middle.0),
            percent(*share),
            percent(urdf)
        ));
    }
    let smallest = of.after.values().filter_map(|e| e.whiteness_p).min_by(f64::total_cmp);
    if !coloured.is_empty() {
        all.push(format!(
            "The residual of {} is not white (Ljung-Box p < {WHITE}): the model is incomplete there.",
            coloured.join(", ")
        ));
    } else if let Some(p) = smallest {
        all.push(format!(
            "The residual is white (Ljung-Box p = {}, smallest of all joints).",
            number(p, 2)
        ));
    }
    let narrow: Vec<String> = of
        .joints
        .iter()
        .filter_map(|j| Some((j, of.after.get(j)?.band_coverage?)))
        .filter(|(_, share)| *share < UNDER_COVERED)
        .map(|(j, share)| format!("{j} ({})", percent(share)))
        .collect();
    if !narrow.is_empty() {
        all.push(format!(
            "Under-covered 95 % band on {}: the model's noise level is too small for these recordings.",
            narrow.join(", ")
        ));
    }
    all.extend(replayed(of));
    all
}

fn replayed(of: &ValidateReport) -> Option<String> {
    let replay = of.replay_after.as_ref()?;
    let (joint, error) = replay.position_rms.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
    let diverged = match replay.diverged {
        0 => String::new(),
        n => format!("; {} diverged", counted(n, "window")),
    };
    Some(format!(
        "Forward replay, {} of {} s: worst RMS position error {} {} ({joint}){diverged}.",
        counted(replay.windows, "window"),
        number(replay.window_s, 3),
        number(*error, 3),
        of.position_units(),
    ))
}
