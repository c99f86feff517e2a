//! The minimal set, as identification and diagnosis show it.

use armident_report::{significant, uncertain};
use serde::Deserialize;

use crate::figures::{self, Figure};
use crate::page::{Grid, optional, percent};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Constant {
    pub(super) label: String,
    pub(super) joint: String,
    pub(super) unit: String,
    pub(super) value: Option<f64>,
    pub(super) standard_error: Option<f64>,
    interval_95: Option<[f64; 2]>,
    pub(super) urdf: f64,
    from_prior: f64,
    pub(super) undetermined: f64,
}

/// Share left open above which the recordings do not determine a number.
pub(super) const OPEN: f64 = 1e-3;
/// Share of the prior above which a number is the robot description's.
const BELIEVED: f64 = 0.5;

impl Constant {
    /// Standard errors from the URDF.
    pub(super) fn off(&self) -> Option<f64> {
        let off = (self.value? - self.urdf) / self.standard_error?;
        off.is_finite().then_some(off)
    }

    /// How well the recordings determine it, in words.
    fn determined(&self) -> String {
        if self.undetermined > OPEN {
            return format!("open: {} not seen", percent(self.undetermined));
        }
        let Some((value, error)) = self.value.zip(self.standard_error) else {
            return "not sought".to_owned();
        };
        let known = if self.from_prior > BELIEVED {
            "mostly the URDF's word"
        } else {
            match error / value.abs().max(self.urdf.abs()) {
                r if r < 0.02 => "very well",
                r if r < 0.1 => "well",
                r if r < 0.5 => "roughly",
                _ => "hardly",
            }
        };
        if (0.1..=BELIEVED).contains(&self.from_prior) {
            format!("{known}, {} the URDF's word", percent(self.from_prior))
        } else {
            known.to_owned()
        }
    }
}

/// The set with what is known of each constant.
pub(super) fn table(constants: &[Constant]) -> Grid {
    let header = [
        "constant",
        "joint",
        "determined",
        "estimate",
        "std error",
        "95 % interval",
        "URDF",
        "off [std err]",
        "unit",
    ];
    // what round-off leaves of a zero, beside the largest of its unit
    let zero = |unit: &str| {
        let same = constants.iter().filter(|c| c.unit == unit);
        1e-12 * same.fold(0.0_f64, |m, c| m.max(c.urdf.abs()))
    };
    let rows = constants
        .iter()
        .map(|c| {
            let (value, error) = match c.value.zip(c.standard_error) {
                Some((value, error)) => uncertain(value, error),
                None => (optional(c.value, 4), "-".to_owned()),
            };
            let interval = c.interval_95.zip(c.standard_error).map_or_else(
                || "-".to_owned(),
                |([a, b], e)| format!("{} to {}", uncertain(a, e).0, uncertain(b, e).0),
            );
            vec![
                c.label.clone(),
                c.joint.clone(),
                c.determined(),
                value,
                error,
                interval,
                significant(c.urdf, 5, zero(&c.unit)),
                c.off().map_or_else(|| "-".to_owned(), |t| format!("{t:+.1}")),
                c.unit.clone(),
            ]
        })
        .collect();
    Grid::new("Inertia constants", &header, 3).with(rows)
}

/// How far the estimates are from the URDF, drawn.
pub(super) fn off_the_urdf(constants: &[Constant]) -> Option<Figure> {
    let rows: Vec<(String, f64, f64)> = constants
        .iter()
        .filter_map(|c| {
            let error = c.standard_error.filter(|e| *e > 0.0)?;
            Some((format!("{} {}", c.label, c.joint), c.value? - c.urdf, error))
        })
        .collect();
    figures::intervals(&rows)
}
