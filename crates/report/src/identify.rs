//! `armident identify`: constants with their standard errors beside the URDF's values.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::bar::Bars;
use crate::consistency::ConsistencyReport;
use crate::numbers::{significant, uncertain};
use crate::table::aligned;

/// Share of the prior in a constant above which the page says so.
const PRIOR_SHOWN: f64 = 0.1;

/// The result of `identify`.
#[derive(Debug, Clone, Serialize)]
pub struct IdentifyReport {
    /// `armident.identify/1`.
    pub schema: &'static str,
    /// `algorithm2` or `batch`.
    pub method: &'static str,
    /// How a batch was solved: `ols`, `wls`, `irls` or `iv`.
    pub estimator: Option<&'static str>,
    /// Robot name.
    pub robot: String,
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Cut-off of the low-pass \[Hz\]; absent when recorded accelerations were used.
    pub cutoff_hz: Option<f64>,
    /// `position` or `recorded`: what velocities were taken from.
    pub velocities: &'static str,
    /// Standard deviation of the links' numbers before the recordings, relative to their size; absent
    /// when nothing was believed.
    pub link_prior: Option<f64>,
    /// The real links of the model; absent when the estimate was kept as it is.
    pub consistency: Option<ConsistencyReport>,
    /// Constants of the minimal set.
    pub constants: Vec<ConstantRow>,
    /// Parameters of effects on joints.
    pub effects: Vec<EffectRow>,
    /// Unknowns that are part of others on this arm.
    pub merged: Vec<MergedRow>,
    /// Gains of drives whose current was recorded in the place of an effort.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drive_gains: Vec<DriveGainRow>,
    /// Loads of known mass in some recordings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<LoadRow>,
    /// Steps of Algorithm 2; empty for `batch`.
    pub steps: Vec<StepRow>,
    /// Numerical rank, of all unknowns.
    pub rank: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Condition number of the unit columns (the worst step's for Algorithm 2).
    pub condition: f64,
    /// Rows used.
    pub rows: usize,
    /// Independent samples over samples after filtering.
    pub independent_share: f64,
    /// Noise level of each joint's effort \[N m or N\].
    pub effort_noise: BTreeMap<String, f64>,
    /// Unknowns whose 95 % interval holds 0: the recordings would not miss them.
    pub not_essential: Vec<String>,
    /// Least squares against instruments, with `iv`.
    pub endogeneity: Option<EndogeneityRow>,
    /// Errors on each recording of a fit to the others, if there are several.
    pub cross_validation: Option<FitRows>,
    /// Effort error per joint.
    pub fit: FitReport,
    /// Doubts worth reading.
    pub warnings: Vec<String>,
    /// What was chosen or repaired on the way.
    pub notes: Vec<String>,
}

/// Durbin, Wu and Hausman's test of least squares.
#[derive(Debug, Clone, Serialize)]
pub struct EndogeneityRow {
    /// Unknown that instruments change most.
    pub term: String,
    /// Change over its standard error.
    pub t: f64,
    /// Probability of as large a change of any unknown if the columns hold no noise.
    pub p: f64,
}

/// One constant.
#[derive(Debug, Clone, Serialize)]
pub struct ConstantRow {
    /// Label of the paper.
    pub label: String,
    /// Joint name.
    pub joint: String,
    /// Unit.
    pub unit: &'static str,
    /// Estimate; absent when no step determined it.
    pub value: Option<f64>,
    /// Standard error.
    pub standard_error: Option<f64>,
    /// 95 % interval.
    pub interval_95: Option<[f64; 2]>,
    /// Value of the URDF.
    pub urdf: f64,
    /// Value of the model's real links; absent when the estimate was kept as it is.
    pub consistent: Option<f64>,
    /// Share of what is known of it that is the prior's and not the recordings', 0 to 1.
    pub from_prior: f64,
    /// Share of the constant the recordings leave open, 0 to 1.
    pub undetermined: f64,
}

/// One parameter of an effect on a joint.
#[derive(Debug, Clone, Serialize)]
pub struct EffectRow {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name.
    pub joint: String,
    /// The second of two joints that share a transmission.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_joint: Option<String>,
    /// Parameter of the law.
    pub parameter: String,
    /// Unit.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard error; absent at a bound, where none is claimed.
    pub standard_error: Option<f64>,
    /// Whether the sign is one the law admits.
    pub admissible: bool,
    /// Whether the sign the law admits holds the estimate at 0.
    pub at_bound: bool,
    /// Share the recordings leave open, 0 to 1.
    pub undetermined: f64,
}

/// The gain of a drive: effort over current.
#[derive(Debug, Clone, Serialize)]
pub struct DriveGainRow {
    /// Joint name.
    pub joint: String,
    /// Estimate; relative to one drive where nothing fixes the size of the gains.
    pub value: f64,
    /// Standard error; absent for the drive that the others are relative to.
    pub standard_error: Option<f64>,
    /// 95 % interval; absent where the gain is not known at all.
    pub interval_95: Option<[f64; 2]>,
    /// `N m/A`, `N/A` or `relative`.
    pub unit: &'static str,
    /// Effort over current that the fit used.
    pub used: f64,
}

/// A load of known mass on the last link.
#[derive(Debug, Clone, Serialize)]
pub struct LoadRow {
    /// Recordings that have it.
    pub recordings: Vec<String>,
    /// Its mass \[kg\].
    pub mass_kg: f64,
    /// Its centre in the frame of the last moving link \[m\].
    pub centre_m: [f64; 3],
    /// Whether the centre was found and not given.
    pub found: bool,
}

/// An unknown that cannot be told from others on this arm.
#[derive(Debug, Clone, Serialize)]
pub struct MergedRow {
    /// The unknown.
    pub term: String,
    /// What it adds to, with factors.
    pub into: BTreeMap<String, f64>,
}

/// One step of Algorithm 2.
#[derive(Debug, Clone, Serialize)]
pub struct StepRow {
    /// Number in the paper.
    pub step: String,
    /// Equation of the paper.
    pub equation: String,
    /// Observed joint.
    pub observed: String,
    /// Constants found.
    pub unknowns: Vec<String>,
    /// Rows.
    pub rows: usize,
    /// Rank over columns.
    pub rank: usize,
    /// Columns.
    pub columns: usize,
    /// Condition number.
    pub condition: f64,
    /// Residual RMS.
    pub rmse: f64,
}

/// Effort errors on both sides.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FitReport {
    /// On the recordings fitted to.
    pub train: FitRows,
    /// On the recordings kept out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holdout: Option<FitRows>,
    /// The URDF as it stands, without friction, on the hold-out (or else on the training).
    pub urdf: FitRows,
}

/// Effort errors by joint, on the filtered effort.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FitRows {
    /// Root mean square residual \[N m or N\].
    pub rmse: BTreeMap<String, f64>,
    /// Residual norm over the norm of effort less its mean.
    pub relative: BTreeMap<String, f64>,
}

/// What an estimator of this name is called in texts; the name itself of one that is not in the library.
pub fn estimator_title(name: &str) -> &str {
    armident_ident::estimators::by_name(name).map_or(name, |estimator| estimator.title())
}

impl IdentifyReport {
    /// The page a person reads.
    pub fn text(&self, bars: Bars) -> String {
        let mut text = format!(
            "{}: {} from {} recording{} by {}\n",
            self.robot,
            if self.method == "batch" {
                format!("{} unknowns", self.unknowns)
            } else {
                format!("{} constants", self.constants.len())
            },
            self.recordings.len(),
            if self.recordings.len() == 1 { "" } else { "s" },
            self.estimator.map_or("Algorithm 2", estimator_title),
        );
        text += &format!(
            "rank {} of {}, condition number {}, {} rows ({} % independent), {}\n",
            self.rank,
            self.unknowns,
            significant(self.condition, 3, 0.0),
            self.rows,
            significant(100.0 * self.independent_share, 2, 0.0),
            match self.cutoff_hz {
                Some(cutoff) => format!("low-pass {} Hz", significant(cutoff, 3, 0.0)),
                None => "recorded accelerations, no filter".to_owned(),
            }
        );
        if let Some(relative) = self.link_prior {
            text += &format!(
                "prior: every link's mass and its second moments known to {} % (--prior none: nothing)\n",
                significant(100.0 * relative, 2, 0.0)
            );
        }
        if let Some(consistency) = &self.consistency {
            text += &consistency.text();
        }
        text += "\nInertia constants\n";
        text += &self.constants_text();
        if !self.drive_gains.is_empty() {
            text += "\nDrive gains (effort over current)\n";
            text += &self.gains_text();
        }
        for load in &self.loads {
            let [x, y, z] = load.centre_m;
            text += &format!(
                "\nLoad of {} kg in {}, centre {} ({x:.4}, {y:.4}, {z:.4}) m\n",
                load.mass_kg,
                load.recordings.join(", "),
                if load.found { "found at" } else { "at" },
            );
        }
        if !self.effects.is_empty() {
            text += "\nJoint effects\n";
            text += &self.effects_text();
        }
        for merged in &self.merged {
            let into: Vec<String> = merged
                .into
                .iter()
                .map(|(label, factor)| {
                    if (factor - 1.0).abs() < 1e-9 {
                        label.clone()
                    } else {
                        format!("{} {label}", significant(*factor, 3, 0.0))
                    }
                })
                .collect();
            text += &format!(
                "{} cannot be told apart on this arm: it is part of {}\n",
                merged.term,
                into.join(", ")
            );
        }
        if self.estimator.is_some() && !self.not_essential.is_empty() {
            text += &format!(
                "{} of {} unknowns are essential; the intervals of the others hold 0: {}\n",
                self.unknowns - self.not_essential.len(),
                self.unknowns,
                self.not_essential.join(", ")
            );
        }
        if let Some(tested) = &self.endogeneity {
            let verdict = if tested.p < 0.05 {
                "least squares is biased by noise in its columns"
            } else {
                "nothing against least squares"
            };
            text += &format!(
                "Durbin-Wu-Hausman: {verdict} ({} moves by {:+.1} standard errors, p = {})\n",
                tested.term,
                tested.t,
                significant(tested.p, 2, 0.0)
            );
        }
        text += "\nEffort error (root mean square, and relative to the effort's variation)\n";
        text += &self.fit_text(bars);
        text
    }

    fn constants_text(&self) -> String {
        // by joint, and within a joint in the order of the theorem
        let mut sorted: Vec<&ConstantRow> = self.constants.iter().collect();
        sorted.sort_by_key(|row| self.joints.iter().position(|j| *j == row.joint));
        let rows: Vec<Vec<String>> = sorted
            .into_iter()
            .map(|row| {
                let (value, error) = match (row.value, row.standard_error) {
                    (Some(value), Some(error)) => uncertain(value, error),
                    _ => ("-".to_owned(), "-".to_owned()),
                };
                let off = match (row.value, row.standard_error) {
                    (Some(v), Some(e)) if e > 1e-9 * v.abs().max(1e-6) => {
                        format!("{:+.1}", (v - row.urdf) / e)
                    }
                    _ => String::new(),
                };
                vec![
                    row.label.clone(),
                    row.joint.clone(),
                    value,
                    error,
                    significant(row.urdf, 6, 1e-12),
                    off,
                    row.unit.to_owned(),
                    if row.undetermined > 1e-3 {
                        format!("{:.0} % open", 100.0 * row.undetermined)
                    } else if row.from_prior > PRIOR_SHOWN {
                        format!("{:.0} % prior", 100.0 * row.from_prior)
                    } else {
                        String::new()
                    },
                ]
            })
            .collect();
        aligned(
            &["constant", "joint", "estimate", "std error", "URDF", "off [std err]", "unit", ""],
            &rows,
            2,
        )
    }

    fn gains_text(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .drive_gains
            .iter()
            .map(|row| {
                let (value, error) = match row.standard_error {
                    Some(error) => uncertain(row.value, error),
                    None => (significant(row.value, 4, 0.0), "-".to_owned()),
                };
                let interval = match row.interval_95 {
                    Some([a, b]) => {
                        format!("{} to {}", significant(a, 4, 0.0), significant(b, 4, 0.0))
                    }
                    None if row.standard_error.is_some() => "not known".to_owned(),
                    None => "-".to_owned(),
                };
                let used = significant(row.used, 4, 0.0);
                vec![row.joint.clone(), value, error, interval, row.unit.to_owned(), used]
            })
            .collect();
        aligned(&["joint", "gain", "std error", "95 %", "unit", "used"], &rows, 1)
    }

    fn effects_text(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .effects
            .iter()
            .map(|row| {
                let (value, error) = match row.standard_error {
                    Some(error) => uncertain(row.value, error),
                    None => ("0".to_owned(), "-".to_owned()),
                };
                let (effect, joint) = match &row.other_joint {
                    Some(other) => (
                        format!("{}.{}", row.effect, row.parameter),
                        format!("{}, {other}", row.joint),
                    ),
                    None => (row.effect.clone(), row.joint.clone()),
                };
                vec![
                    effect,
                    joint,
                    value,
                    error,
                    row.unit.clone(),
                    if row.at_bound {
                        "at bound 0".to_owned()
                    } else if row.undetermined > 1e-3 {
                        format!("{:.0} % open", 100.0 * row.undetermined)
                    } else if row.admissible {
                        String::new()
                    } else {
                        "wrong sign".to_owned()
                    },
                ]
            })
            .collect();
        aligned(&["effect", "joint", "estimate", "std error", "unit", ""], &rows, 2)
    }

    fn fit_text(&self, bars: Bars) -> String {
        let cell = |rows: &FitRows, joint: &String| {
            [
                rows.rmse.get(joint).map_or("-".to_owned(), |x| significant(*x, 4, 0.0)),
                rows.relative.get(joint).map_or("-".to_owned(), |x| format!("{:.1} %", 100.0 * x)),
            ]
        };
        let rows: Vec<Vec<String>> = self
            .joints
            .iter()
            .map(|joint| {
                let mut row = vec![joint.clone()];
                row.extend(cell(&self.fit.train, joint));
                if let Some(left_out) = &self.cross_validation {
                    row.extend(cell(left_out, joint));
                }
                if let Some(holdout) = &self.fit.holdout {
                    row.extend(cell(holdout, joint));
                }
                row.extend(cell(&self.fit.urdf, joint));
                // the URDF was judged on the same recordings
                let judged = self.fit.holdout.as_ref().unwrap_or(&self.fit.train);
                let ends = self.fit.urdf.rmse.get(joint).zip(judged.rmse.get(joint));
                row.push(ends.map_or_else(String::new, |(urdf, found)| bars.left(*urdf, *found)));
                row
            })
            .collect();
        let mut header = vec!["joint", "training", ""];
        if self.cross_validation.is_some() {
            header.extend(["each left out", ""]);
        }
        if self.fit.holdout.is_some() {
            header.extend(["hold-out", ""]);
        }
        header.extend(["URDF alone", "", "found/URDF"]);
        aligned(&header, &rows, 1)
    }
}
