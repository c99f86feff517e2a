//! The minimal set as `identify` and `diagnose` estimate it.

use armident_diagnose::ConstantEstimate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, Table, percent, significant, uncertain};

/// Share that the recordings do not identify above which a constant counts as not identified.
pub const NOT_IDENTIFIED: f64 = 1e-3;
/// Prior share above which it is printed.
const PRIOR_SHOWN: f64 = 0.1;
/// Prior share above which the robot description dominates an estimate.
const PRIOR_DOMINATES: f64 = 0.5;

/// One constant of the minimal set.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ConstantRow {
    /// Label of the paper.
    pub label: String,
    /// Joint name.
    pub joint: String,
    /// Unit.
    pub unit: String,
    /// Estimate; `null` when no step determined it.
    pub value: Option<f64>,
    /// Standard error.
    pub standard_error: Option<f64>,
    /// 95 % interval.
    pub interval_95: Option<[f64; 2]>,
    /// Value of the URDF.
    pub urdf: f64,
    /// Value of the model's physically consistent links; absent without a projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consistent: Option<f64>,
    /// Prior share of the information, 0 to 1.
    #[serde(alias = "from_prior")]
    pub prior_share: f64,
    /// Share of the constant that the recordings do not identify, 0 to 1.
    pub undetermined: f64,
}

impl ConstantRow {
    pub(crate) fn of(found: &ConstantEstimate) -> Self {
        Self {
            label: found.label.clone(),
            joint: found.joint.clone(),
            unit: found.unit.to_owned(),
            value: Some(found.value),
            standard_error: Some(found.standard_error),
            interval_95: Some(found.interval_95),
            urdf: found.urdf,
            consistent: None,
            prior_share: found.from_prior,
            undetermined: 0.0,
        }
    }

    /// Estimate less URDF, in standard errors.
    pub fn deviation(&self) -> Option<f64> {
        let deviation = (self.value? - self.urdf) / self.standard_error?;
        deviation.is_finite().then_some(deviation)
    }

    /// Share that the recordings do not identify, or that comes from the prior.
    fn prior_text(&self) -> String {
        if self.undetermined > NOT_IDENTIFIED {
            format!("{:.0} % not identified", 100.0 * self.undetermined)
        } else if self.prior_share > PRIOR_SHOWN {
            format!("{:.0} %", 100.0 * self.prior_share)
        } else {
            String::new()
        }
    }

    /// Standard error over the size, in classes.
    fn relative_error(&self) -> String {
        if self.undetermined > NOT_IDENTIFIED {
            return format!("{} not identified", percent(self.undetermined));
        }
        let Some((value, error)) = self.value.zip(self.standard_error) else {
            return "not estimated".to_owned();
        };
        if self.prior_share > PRIOR_DOMINATES {
            return "prior dominated".to_owned();
        }
        match error / value.abs().max(self.urdf.abs()) {
            r if r < 0.02 => "< 2 %",
            r if r < 0.1 => "< 10 %",
            r if r < 0.5 => "< 50 %",
            _ => ">= 50 %",
        }
        .to_owned()
    }
}

/// The table of a terminal, by joint in the order of the chain.
pub(crate) fn text_table(constants: &[ConstantRow], joints: &[String]) -> Block {
    // by joint, and within a joint in the order of the theorem
    let mut sorted: Vec<&ConstantRow> = constants.iter().collect();
    sorted.sort_by_key(|row| joints.iter().position(|joint| *joint == row.joint));
    let rows = sorted.into_iter().map(|row| {
        let (value, error) = match (row.value, row.standard_error) {
            (Some(value), Some(error)) => uncertain(value, error),
            _ => ("-".to_owned(), "-".to_owned()),
        };
        let deviation = match (row.value, row.standard_error) {
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
            deviation,
            row.unit.clone(),
            row.prior_text(),
        ]
    });
    let table = Table::new("Inertia constants", &["constant", "joint"]).numbers(&[
        "estimate",
        "std error",
        "URDF",
        "(est-URDF)/se",
        "unit",
        "prior share",
    ]);
    Block::Table(table.with(rows).without_empty_columns())
}

/// The table of a page, with intervals.
pub(crate) fn page_table(constants: &[ConstantRow]) -> Block {
    // what round-off leaves of a zero, beside the largest of its unit
    let zero = |unit: &str| {
        let same = constants.iter().filter(|c| c.unit == unit);
        1e-12 * same.fold(0.0_f64, |m, c| m.max(c.urdf.abs()))
    };
    let rows = constants.iter().map(|c| {
        let (value, error) = match c.value.zip(c.standard_error) {
            Some((value, error)) => uncertain(value, error),
            None => {
                (c.value.map_or_else(|| "-".to_owned(), |x| significant(x, 4, 0.0)), "-".to_owned())
            }
        };
        let interval = c.interval_95.zip(c.standard_error).map_or_else(
            || "-".to_owned(),
            |([a, b], e)| format!("{} to {}", uncertain(a, e).0, uncertain(b, e).0),
        );
        let prior = match c.prior_share {
            share if share > PRIOR_SHOWN => format!("{} prior", percent(share)),
            _ => String::new(),
        };
        vec![
            c.label.clone(),
            c.joint.clone(),
            c.relative_error(),
            value,
            error,
            interval,
            significant(c.urdf, 5, zero(&c.unit)),
            c.deviation().map_or_else(|| "-".to_owned(), |t| format!("{t:+.1}")),
            c.unit.clone(),
            prior,
        ]
    });
    let table = Table::new("Inertia constants", &["constant", "joint", "relative std error"])
        .numbers(&["estimate", "std error", "95 % interval", "URDF", "(est-URDF)/se"])
        .texts(&["unit", "prior share"]);
    Block::Table(table.with(rows).without_empty_columns())
}
