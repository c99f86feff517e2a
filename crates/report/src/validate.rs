//! `armident validate`: the judges of a model, joint by joint.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::bar::Bars;
use crate::numbers::significant;
use crate::table::aligned;

/// The result of `validate`.
#[derive(Debug, Clone, Serialize)]
pub struct ValidateReport {
    /// `armident.validate/1`.
    pub schema: &'static str,
    /// Robot name.
    pub robot: String,
    /// Model file or URDF.
    pub model: String,
    /// Recordings judged on.
    pub recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Cut-off of the low-pass \[Hz\].
    pub cutoff_hz: Option<f64>,
    /// Effort error of the URDF the model started from.
    pub before: BTreeMap<String, EffortErrorRow>,
    /// Effort error of the model.
    pub after: BTreeMap<String, EffortErrorRow>,
    /// Forward replay of the URDF; absent where it cannot be simulated or was not asked for.
    pub replay_before: Option<ReplayReport>,
    /// Forward replay of the model.
    pub replay_after: Option<ReplayReport>,
    /// Doubts worth reading.
    pub warnings: Vec<String>,
    /// What was chosen or repaired on the way.
    pub notes: Vec<String>,
}

/// Effort error of one joint; absent numbers could not be determined.
#[derive(Debug, Clone, Serialize)]
pub struct EffortErrorRow {
    /// Root mean square on the filtered effort \[N m or N\].
    pub rmse: f64,
    /// Relative to the effort's variation.
    pub relative: f64,
    /// Root mean square on the effort as recorded \[N m or N\].
    pub rmse_raw: f64,
    /// Share of samples inside the 95 % band.
    pub band_coverage: Option<f64>,
    /// Correlation of neighbouring residuals.
    pub lag1_correlation: Option<f64>,
    /// p-value of the whiteness test.
    pub whiteness_p: Option<f64>,
}

/// Forward replay of all joints.
#[derive(Debug, Clone, Serialize)]
pub struct ReplayReport {
    /// Length of a window \[s\].
    pub window_s: f64,
    /// Windows simulated to their end.
    pub windows: usize,
    /// Windows that diverged.
    pub diverged: usize,
    /// Root mean square position error \[rad or m\].
    pub position_rms: BTreeMap<String, f64>,
    /// Root mean square velocity error \[rad/s or m/s\].
    pub velocity_rms: BTreeMap<String, f64>,
}

impl ValidateReport {
    /// The page a person reads.
    pub fn text(&self, bars: Bars) -> String {
        let mut text = format!(
            "{}: {} on {} recording{}{}\n\nEffort error (before: the URDF alone; relative to the effort's variation)\n",
            self.robot,
            self.model,
            self.recordings.len(),
            if self.recordings.len() == 1 { "" } else { "s" },
            self.cutoff_hz
                .map_or(String::new(), |c| format!(", low-pass {} Hz", significant(c, 3, 0.0)))
        );
        // an effort that is one number has no variation to be relative to
        let percent = |x: f64| {
            if x.is_finite() { format!("{:.1} %", 100.0 * x) } else { "-".to_owned() }
        };
        let optional =
            |x: Option<f64>, show: &dyn Fn(f64) -> String| x.map_or("-".to_owned(), show);
        let rows: Vec<Vec<String>> = self
            .joints
            .iter()
            .filter_map(|joint| {
                let (before, after) = (self.before.get(joint)?, self.after.get(joint)?);
                Some(vec![
                    joint.clone(),
                    significant(before.rmse, 4, 0.0),
                    percent(before.relative),
                    significant(after.rmse, 4, 0.0),
                    percent(after.relative),
                    significant(after.rmse_raw, 4, 0.0),
                    optional(after.band_coverage, &percent),
                    optional(after.lag1_correlation, &|x| format!("{x:.2}")),
                    optional(after.whiteness_p, &|p| {
                        if p < 1e-4 { "< 1e-4".to_owned() } else { significant(p, 2, 0.0) }
                    }),
                    bars.left(before.rmse, after.rmse),
                ])
            })
            .collect();
        text += &aligned(
            &[
                "joint",
                "before",
                "",
                "after",
                "",
                "as recorded",
                "in 95 % band",
                "lag-1",
                "white, p",
                "after/before",
            ],
            &rows,
            1,
        );
        let replays = [("before", &self.replay_before), ("after", &self.replay_after)];
        if replays.iter().any(|(_, replay)| replay.is_some()) {
            text += "\nForward replay (root mean square position error after recorded efforts drive the arm)\n";
            let cell = |replay: &Option<ReplayReport>, joint: &String| {
                replay
                    .as_ref()
                    .and_then(|r| r.position_rms.get(joint))
                    .map_or("-".to_owned(), |x| significant(*x, 3, 0.0))
            };
            let rows: Vec<Vec<String>> = self
                .joints
                .iter()
                .map(|joint| {
                    vec![
                        joint.clone(),
                        cell(&self.replay_before, joint),
                        cell(&self.replay_after, joint),
                    ]
                })
                .collect();
            text += &aligned(&["joint", "before", "after"], &rows, 1);
            for (name, replay) in replays {
                if let Some(r) = replay {
                    text += &format!(
                        "{name}: {} windows of {} s{}\n",
                        r.windows,
                        significant(r.window_s, 3, 0.0),
                        if r.diverged > 0 {
                            format!(", {} more diverged", r.diverged)
                        } else {
                            String::new()
                        }
                    );
                }
            }
        }
        text
    }
}
