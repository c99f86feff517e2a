//! `armident check`: what is right, doubtful or wrong with recordings.

use std::collections::BTreeMap;

use armident_ident::checks::{
    ChannelKind, Check, ConstantCheck, QualityReport, RecordingCheck, Topic, Verdict,
};
use serde::Serialize;

use crate::numbers::significant;
use crate::table::aligned;

/// The result of `check`.
#[derive(Debug, Clone, Serialize)]
pub struct CheckReport {
    /// `armident.check/1`.
    pub schema: &'static str,
    /// Robot name.
    pub robot: String,
    /// Recordings checked.
    pub recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Cut-off of the low-pass \[Hz\].
    pub cutoff_hz: Option<f64>,
    /// The worst of the verdicts.
    pub verdict: Verdict,
    /// The checks.
    pub checks: Vec<Check>,
    /// Per joint, probabilities of what the effort column is.
    pub channels: Vec<ChannelRow>,
    /// Constants and how well they are determined.
    pub constants: Vec<ConstantCheck>,
    /// Rank of the recordings alone.
    pub rank: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// What can be measured without a model, per recording.
    pub quality: Vec<QualityReport>,
    /// Doubts worth reading.
    pub warnings: Vec<String>,
    /// What was chosen or repaired on the way.
    pub notes: Vec<String>,
}

/// What one effort column is.
#[derive(Debug, Clone, Serialize)]
pub struct ChannelRow {
    /// The joint.
    pub joint: String,
    /// Joint whose column most likely holds this joint's effort.
    pub column: String,
    /// Probability of each kind.
    pub probability: BTreeMap<&'static str, f64>,
    /// Most likely gain, recorded over joint effort.
    pub gain: f64,
    /// Its 95 % interval.
    pub gain_95: [f64; 2],
    /// Standard deviation of the column.
    pub sd: f64,
    /// Root mean square of what a free fit leaves of it.
    pub residual_rms: f64,
    /// Standard deviation of the URDF's effort on this motion \[N m or N\].
    pub urdf_sd: f64,
}

impl CheckReport {
    /// Fills the report from what was found.
    pub fn new(
        robot: &str,
        recordings: Vec<String>,
        joints: Vec<String>,
        cutoff_hz: Option<f64>,
        found: &RecordingCheck,
        warnings: Vec<String>,
        notes: Vec<String>,
    ) -> Self {
        let channels = (found.channels.iter().zip(&joints).zip(&found.order))
            .map(|((channel, joint), &held_by)| {
                let kinds = ChannelKind::ALL.iter().map(|kind| kind.name());
                ChannelRow {
                    joint: joint.clone(),
                    column: joints[held_by].clone(),
                    probability: kinds.zip(channel.probability).collect(),
                    gain: channel.gain,
                    gain_95: channel.gain_95,
                    sd: channel.sd,
                    residual_rms: channel.residual_rms,
                    urdf_sd: channel.urdf_sd,
                }
            })
            .collect();
        Self {
            schema: "armident.check/1",
            robot: robot.to_owned(),
            recordings,
            cutoff_hz,
            verdict: found.verdict(),
            checks: found.checks.clone(),
            channels,
            constants: found.constants.clone(),
            rank: found.rank.0,
            unknowns: found.rank.1,
            quality: found.quality.clone(),
            joints,
            warnings,
            notes,
        }
    }

    /// The page a person reads.
    pub fn text(&self) -> String {
        let count = |verdict| self.checks.iter().filter(|c| c.verdict == verdict).count();
        let mut text = format!(
            "{}: {} recording{}{}: {} ok, {} cannot tell, {} doubtful, {} wrong\n",
            self.robot,
            self.recordings.len(),
            if self.recordings.len() == 1 { "" } else { "s" },
            self.cutoff_hz
                .map_or(String::new(), |c| format!(", low-pass {} Hz", significant(c, 3, 0.0))),
            count(Verdict::Ok),
            count(Verdict::CannotTell),
            count(Verdict::Doubtful),
            count(Verdict::Wrong),
        );
        let wide: Vec<&Check> = self.checks.iter().filter(|c| c.joint.is_none()).collect();
        text += "\nRobot\n";
        text += &rows(&wide);
        for joint in &self.joints {
            let own: Vec<&Check> =
                self.checks.iter().filter(|c| c.joint.as_ref() == Some(joint)).collect();
            text += &format!("\n{joint}\n");
            text += &rows(&own);
        }
        let others: Vec<&Check> = self
            .checks
            .iter()
            .filter(|c| c.joint.as_ref().is_some_and(|j| !self.joints.contains(j)))
            .collect();
        if !others.is_empty() {
            text += "\nOther joints\n";
            text += &rows(&others);
        }
        let badly: Vec<Vec<String>> = self
            .constants
            .iter()
            .filter(|c| c.verdict != Verdict::Ok)
            .map(|c| {
                vec![
                    c.label.clone(),
                    c.joint.clone(),
                    c.reason.clone().unwrap_or_default(),
                    c.standard_error.map_or("open".to_owned(), |s| significant(s, 2, 0.0)),
                    significant(c.size, 2, 0.0),
                    c.unit.to_owned(),
                ]
            })
            .collect();
        if !badly.is_empty() {
            text += "\nConstants these recordings do not determine to a tenth of their size\n";
            let header = ["constant", "joint", "why", "std error", "size", "unit"];
            text += &aligned(&header, &badly, 3);
        }
        text.push('\n');
        text
    }
}

/// One line a check, and one for what to do.
fn rows(checks: &[&Check]) -> String {
    let mut text = String::new();
    for check in checks {
        let topic: Topic = check.topic;
        text += &format!("  {:<11}  {}: {}\n", check.verdict.name(), topic.name(), check.message);
        if let Some(advice) = &check.advice
            && check.verdict != Verdict::Ok
        {
            text += &format!("  {:<11}    -> {advice}\n", "");
        }
    }
    text
}
