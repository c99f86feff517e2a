//! The verdict in one line.

use std::collections::BTreeSet;

use super::report::{DiagnoseReport, Fits};
use crate::layout::significant;
use crate::results::check::CheckTopic;
use crate::words::counted;

/// Hold-out error over that of the given model from which on it is worse: less is the scatter of a short hold-out.
const CLEARLY_WORSE: f64 = 1.1;
/// Residual in noise levels beyond which the noise level is unreliable: a channel that was smoothed before it was
/// recorded has next to no noise.
const NOISE_UNRELIABLE: f64 = 100.0;

/// A residual or an effort in noise levels, as people read it: `4.4`, or `> 100` where the noise level is unreliable.
pub fn in_noise_levels(times: f64, digits: usize) -> String {
    match times > NOISE_UNRELIABLE {
        true => format!("> {NOISE_UNRELIABLE}"),
        false => significant(times, digits, 0.0),
    }
}

impl DiagnoseReport {
    /// Sets the verdict and its sentence from the data.
    pub(crate) fn judge(&mut self) {
        let agrees = self.findings.is_empty()
            && self.unexplained.is_empty()
            && self.link_errors_material_on.is_empty()
            && self.input_checks.faults.is_empty();
        self.verdict = if agrees { "match" } else { "mismatch" }.to_owned();
        self.sentence = self.clauses().join("; ");
    }

    /// The clauses of the first line, beginning with what was found.
    pub fn clauses(&self) -> Vec<String> {
        let mut clauses = self.failed_checks();
        // where columns are wrong there may be nothing else
        if !clauses.is_empty() && self.fit.judged().is_none() {
            return clauses;
        }
        let found = self.found();
        clauses.push(match self.excluded_columns() {
            0 => found,
            1 => format!("without it, {found}"),
            _ => format!("without them, {found}"),
        });
        clauses.extend(self.confirmation());
        clauses.extend(self.residual_clause());
        if !self.worse_on_holdout.is_empty() {
            clauses.push(format!(
                "hold-out error on {} is over 10 % larger than with the given model",
                self.worse_on_holdout.join(", ")
            ));
        }
        clauses
    }

    /// Effort columns that failed an input check: one may have a fault in every recording.
    fn excluded_columns(&self) -> usize {
        let faults = self.input_checks.faults.iter();
        faults.map(|fault| fault.joint.as_deref()).collect::<BTreeSet<_>>().len()
    }

    fn failed_checks(&self) -> Vec<String> {
        // what is wrong with the arm as a whole, and no column
        let of_arm = |topic: CheckTopic| {
            matches!(topic, CheckTopic::Gravity | CheckTopic::JointSign | CheckTopic::Order)
        };
        let faults = &self.input_checks.faults;
        if !faults.is_empty() && faults.iter().all(|fault| of_arm(fault.topic)) {
            let all = faults.iter().map(|fault| format!("{}{}", fault.prefix(), fault.message));
            return vec![format!("input check failed: {}", all.collect::<Vec<_>>().join("; "))];
        }
        match self.excluded_columns() {
            0 => Vec::new(),
            1 => vec!["input check failed: 1 effort column does not match its header".to_owned()],
            n => vec![format!("input check failed: {n} effort columns do not match their headers")],
        }
    }

    /// What was found, in a clause.
    fn found(&self) -> String {
        match (self.findings.len(), self.is_change()) {
            (0, false) if !self.unexplained.is_empty() => {
                "no effect in the library explains the residual".to_owned()
            }
            (0, true) if !self.unexplained.is_empty() => {
                "no identifiable change since the reference".to_owned()
            }
            (0, false) if !self.link_errors_material_on.is_empty() => format!(
                "no single effect is missing, but the link inertias are off by about {} % (prior scale), which is \
                 material on {}",
                significant(100.0 * self.prior_scale, 2, 0.0),
                self.link_errors_material_on.join(", ")
            ),
            (0, false) => "no missing effect found".to_owned(),
            (1, false) => "1 effect is missing from the model".to_owned(),
            (n, false) => format!("{n} effects are missing from the model"),
            (0, true) => "no change since the reference".to_owned(),
            (n, true) => format!("{} since the reference", counted(n, "change")),
        }
    }

    fn confirmation(&self) -> Option<String> {
        let of =
            |confirmed| self.findings.iter().filter(|f| f.confirmed == Some(confirmed)).count();
        let (all, yes, no) = (self.findings.len(), of(true), of(false));
        Some(match (yes, no) {
            (0, 0) => return None,
            (1, 0) if all == 1 => "it is confirmed by the hold-out".to_owned(),
            (0, _) if all == 1 => "it is not confirmed by the hold-out".to_owned(),
            (yes, _) if yes == all => format!("all {all} are confirmed by the hold-out"),
            (0, _) => "none is confirmed by the hold-out".to_owned(),
            (1, _) => format!("1 of {all} is confirmed by the hold-out"),
            (yes, _) => format!("{yes} of {all} are confirmed by the hold-out"),
        })
    }

    /// Residual that no finding explains, and the joints that have it.
    pub fn residual_clause(&self) -> Option<String> {
        if self.unexplained.is_empty() {
            return None;
        }
        let of = |name: &String| {
            let joint = self.residual_map.iter().find(|joint| joint.joint == *name);
            joint.map_or(0.0, super::residual_map::JointResiduals::residual_over_noise)
        };
        let most = self.unexplained.iter().map(of).fold(0.0, f64::max);
        let joints = self.unexplained.join(", ");
        Some(match most < NOISE_UNRELIABLE {
            true => {
                format!("residual up to {} times the noise on {joints}", significant(most, 2, 0.0))
            }
            false => format!(
                "residual over {NOISE_UNRELIABLE} times the noise on {joints} (noise level unreliable: the channel is \
                 probably smoothed)"
            ),
        })
    }
}

/// Joints whose hold-out error is clearly larger than with the given model.
pub(crate) fn worse_on_holdout(fit: &Fits) -> Vec<String> {
    let Some(errors) = &fit.holdout else { return Vec::new() };
    let worse = |(joint, after): &(&String, &f64)| {
        errors.before.get(*joint).is_some_and(|before| **after > CLEARLY_WORSE * before)
    };
    errors.after.iter().filter(worse).map(|(joint, _)| joint.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::finding::FindingRow;
    use super::*;

    fn with_findings(confirmed: &[Option<bool>]) -> DiagnoseReport {
        let finding = |confirmed: &Option<bool>| FindingRow {
            confirmed: *confirmed,
            ..FindingRow::default()
        };
        DiagnoseReport {
            findings: confirmed.iter().map(finding).collect(),
            ..DiagnoseReport::default()
        }
    }

    #[test]
    fn verdict_counts_confirmed_findings() {
        for (confirmed, expected) in [
            (vec![], "no missing effect found"),
            (vec![None], "1 effect is missing from the model"),
            (
                vec![Some(true)],
                "1 effect is missing from the model; it is confirmed by the hold-out",
            ),
            (
                vec![Some(true), Some(true)],
                "2 effects are missing from the model; all 2 are confirmed by the hold-out",
            ),
            (
                vec![Some(true), Some(false), Some(true)],
                "3 effects are missing from the model; 2 of 3 are confirmed by the hold-out",
            ),
            (
                vec![Some(false), Some(false)],
                "2 effects are missing from the model; none is confirmed by the hold-out",
            ),
        ] {
            assert_eq!(with_findings(&confirmed).clauses().join("; "), expected);
        }
    }
}
