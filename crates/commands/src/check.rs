//! `check`: are recordings what their columns are called.

use armident_ident::check_commands;
use armident_ident::checks::{check as checked, with_drive_signals};
use armident_model::ArmModel;
use armident_page::{Drawing, RecordingRole};
use armident_recording::Recording;
use armident_report::CheckReport;

use crate::drawing;
use crate::failure::Failure;
use crate::recordings::{joints_with_position, motions_with_effort, notes};
use crate::robot::{GivenRobot, chain_warnings};
use crate::servos::{failure, has_commands_only};

/// Checked recordings.
#[derive(Debug, Clone)]
pub struct Checked {
    /// The result.
    pub report: CheckReport,
    /// The links of the arm.
    pub model: ArmModel,
    /// The recordings, with currents or voltages where efforts are missing.
    pub recordings: Vec<Recording>,
}

/// Checks recordings against the links of an arm. `cutoff_hz`: low-pass \[Hz\]; none: from the spectrum of the motion.
///
/// # Errors
/// Recordings without the joints or efforts of the arm; a low-pass that is not possible.
pub fn check(
    robot: &GivenRobot,
    recordings: &[Recording],
    cutoff_hz: Option<f64>,
) -> Result<Checked, Failure> {
    if has_commands_only(robot, recordings)? {
        return of_commands(robot, recordings);
    }
    let (recorded, signals) = with_drive_signals(recordings);
    let names = joints_with_position(&recorded);
    let (model, unused) = robot.links(Some(&names))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz =
        armident_motion::common_cutoff_hz(&recorded, &joints, cutoff_hz.or(model.cutoff_hz))?;
    let motions = motions_with_effort(&recorded, &joints, cutoff_hz)?;
    let found = checked(&model, &recorded, &motions, &signals)?;
    let warnings = chain_warnings(&model);
    let sources = recorded.iter().map(|r| r.source.clone()).collect();
    let mut notes = notes(&motions);
    notes.extend(unused);
    let robot = model.chain.robot.clone();
    let report = CheckReport::new(&robot, sources, names, cutoff_hz, &found, warnings, notes);
    Ok(Checked { report, model, recordings: recorded })
}

/// Recordings of commands and positions without efforts.
fn of_commands(robot: &GivenRobot, recordings: &[Recording]) -> Result<Checked, Failure> {
    let (model, notes) = robot.links(Some(&joints_with_position(recordings)))?;
    let found = check_commands(&model, recordings).map_err(failure)?;
    let names = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let sources = recordings.iter().map(|r| r.source.clone()).collect();
    let (robot, warnings) = (model.chain.robot.clone(), chain_warnings(&model));
    let report = CheckReport::new(
        &robot,
        sources,
        names,
        None,
        &found,
        warnings,
        notes.into_iter().collect(),
    );
    Ok(Checked { report, model, recordings: recordings.to_vec() })
}

impl Checked {
    /// What the page shows beside the result.
    ///
    /// # Errors
    /// Recordings that cannot be predicted.
    pub fn drawing(&self) -> Result<Drawing, Failure> {
        if self.report.channels.is_empty() {
            return Err(Failure::new(
                "no page of recordings of commands without efforts",
                "--report",
                Some("omit the option, or use --json FILE"),
            ));
        }
        let recorded = [(self.recordings.as_slice(), RecordingRole::Training)];
        let models: [(&str, &ArmModel); 1] = [("given", &self.model)];
        drawing::of_models(&self.model.chain, &models, &recorded, self.report.cutoff_hz)
    }
}
