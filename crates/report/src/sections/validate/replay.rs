//! Forward replay.

use crate::layout::{Block, Table, significant};
use crate::results::{ReplayReport, ValidateReport};
use crate::section::Section;

/// Motion errors after recorded efforts drove the simulated arm.
pub(crate) struct Replay;

impl Section<ValidateReport> for Replay {
    fn key(&self) -> &'static str {
        "replay"
    }

    fn text(&self, result: &ValidateReport) -> Vec<Block> {
        let replays = [("URDF only", &result.replay_before), ("model", &result.replay_after)];
        let done: Vec<(&str, &ReplayReport)> =
            replays.iter().filter_map(|(name, replay)| Some((*name, replay.as_ref()?))).collect();
        let Some((_, first)) = done.first() else { return Vec::new() };
        let note = format!(
            "RMS position error in {} s windows driven by the recorded efforts, {}",
            significant(first.window_s, 3, 0.0),
            result.position_units()
        );
        let rows = result.joints.iter().map(|joint| {
            let of = replays.map(|(_, replay)| cell(replay.as_ref(), joint, false));
            std::iter::once(joint.clone()).chain(of).collect()
        });
        let table = Table::new("", &["joint"]).numbers(&["URDF only", "model"]);
        vec![
            Block::heading_with_note("Forward replay", note),
            Block::Table(table.with(rows)),
            Block::Line(windows(&done)),
        ]
    }

    fn page(&self, result: &ValidateReport) -> Vec<Block> {
        let (urdf, model) = (result.replay_before.as_ref(), result.replay_after.as_ref());
        if urdf.is_none() && model.is_none() {
            return Vec::new();
        }
        let rows = result.joints.iter().map(|joint| {
            vec![
                joint.clone(),
                cell(urdf, joint, false),
                cell(model, joint, false),
                cell(urdf, joint, true),
                cell(model, joint, true),
            ]
        });
        let unit = result.position_units();
        let caption = format!("Forward replay: RMS error of the motion [{unit}, per s]");
        let heads = ["position, URDF", "position, model", "speed, URDF", "speed, model"];
        let table = Table::new(&caption, &["joint"]);
        vec![Block::heading("Errors"), Block::Table(table.numbers(&heads).with(rows))]
    }
}

fn cell(replay: Option<&ReplayReport>, joint: &String, velocity: bool) -> String {
    let error =
        replay.and_then(|r| if velocity { &r.velocity_rms } else { &r.position_rms }.get(joint));
    error.map_or_else(|| "-".to_owned(), |x| significant(*x, 3, 0.0))
}

/// `23 windows (URDF only), 21 windows (model), 2 diverged`.
fn windows(done: &[(&str, &ReplayReport)]) -> String {
    let of = |(name, replay): &(&str, &ReplayReport)| {
        let diverged = match replay.diverged {
            0 => String::new(),
            n => format!(", {n} diverged"),
        };
        format!("{} ({name}){diverged}", crate::words::counted(replay.windows, "window"))
    };
    done.iter().map(of).collect::<Vec<_>>().join(", ")
}
