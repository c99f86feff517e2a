//! `merge`: an arm from the states of its recordings.

use std::collections::BTreeMap;
use std::path::PathBuf;

use armident_ident::{RecordingState, StateColumns};
use armident_model::ArmModel;
use armident_report::{MergeReport, SetAside};

use crate::failure::Failure;
use crate::robot::GivenRobot;
use crate::state_files::states as read_states;

/// An arm that was identified from states.
#[derive(Debug)]
pub struct Merged {
    /// The result.
    pub report: MergeReport,
    /// The identified model.
    pub model: ArmModel,
}

/// Identifies an arm from files of states; a recording that is in several of them counts once.
///
/// # Errors
/// A file that cannot be read; no states of this arm.
pub fn merge(robot: &GivenRobot, files: &[PathBuf]) -> Result<Merged, Failure> {
    let model = robot.arm(None)?;
    let (mut states, mut set_aside) = (BTreeMap::new(), Vec::new());
    for path in files {
        // one that was reduced anew stands further below
        let each = |state: RecordingState| drop(states.insert(state.recording.clone(), state));
        read_states(path, each, &mut set_aside)?;
    }
    let cutoff_hz = states.values().next().map_or(f64::NAN, |state| state.arm.cutoff_hz);
    let columns = StateColumns::new(&model, cutoff_hz)?;
    let mut used = Vec::new();
    for state in states.values() {
        match columns.check(state) {
            Ok(()) => used.push(state),
            Err(error) => set_aside
                .push(SetAside { file: state.recording.clone(), reason: error.to_string() }),
        }
    }
    let found = columns.identify(used.iter().copied()).map_err(|error| {
        let what = match set_aside.first() {
            Some(first) if used.is_empty() => first.reason.clone(),
            _ => error.to_string(),
        };
        let place = files.first().map(|path| path.display().to_string()).unwrap_or_default();
        let hint = "pass states that `armident accumulate` made for this robot";
        Failure::new(what, place, Some(hint))
    })?;
    let seconds = used.iter().map(|state| state.seconds).sum();
    let report = MergeReport::new(&model, &found, (used.len(), seconds, cutoff_hz), set_aside);
    Ok(Merged { report, model: found.model })
}
