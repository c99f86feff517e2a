//! The diagnosis for people and programs.

use std::collections::BTreeMap;

use armident_diagnose::{Diagnosis, Errors, Finding};
use armident_effects::effect;
use armident_kinematics::DrivingAxisChain;
use serde::Serialize;

use crate::numbers::{significant, uncertain};
use crate::table::aligned;

/// Result of `armident diagnose`.
#[derive(Debug, Serialize)]
pub struct DiagnoseReport {
    schema: &'static str,
    verdict: &'static str,
    robot: String,
    recordings: Vec<String>,
    holdout_recordings: Vec<String>,
    joints: Vec<String>,
    findings: Vec<Finding>,
    fit: Fits,
    effort_noise: BTreeMap<String, f64>,
    inertial_error: f64,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Fits {
    train: Option<Errors>,
    holdout: Option<Errors>,
}

impl DiagnoseReport {
    /// From a diagnosis and its errors.
    pub fn new(
        chain: &DrivingAxisChain,
        diagnosis: &Diagnosis,
        recordings: Vec<String>,
        holdout_recordings: Vec<String>,
        train: Option<Errors>,
        holdout: Option<Errors>,
        warnings: Vec<String>,
    ) -> Self {
        Self {
            schema: "armident.diagnosis/1",
            verdict: if diagnosis.findings.is_empty() { "match" } else { "mismatch" },
            robot: chain.robot.clone(),
            recordings,
            holdout_recordings,
            joints: diagnosis.joints.clone(),
            findings: diagnosis.findings.clone(),
            fit: Fits { train, holdout },
            effort_noise: diagnosis.effort_noise.clone(),
            inertial_error: diagnosis.inertial_error,
            warnings,
        }
    }

    /// The page for people.
    pub fn text(&self) -> String {
        let mut page = format!("{}: {}\n", self.robot, self.sentence());
        for finding in &self.findings {
            page.push_str(&paragraph(finding));
        }
        let proof = self.fit.holdout.as_ref().or(self.fit.train.as_ref());
        if let Some(errors) = proof {
            let kind = if self.fit.holdout.is_some() { "hold-out" } else { "training" };
            page.push_str(&format!("\nError of the {kind} efforts as recorded (RMS, N m or N)\n"));
            let mut rows = Vec::new();
            for joint in &self.joints {
                let of = |m: &BTreeMap<String, f64>| {
                    m.get(joint).map_or_else(|| "-".to_owned(), |x| significant(*x, 3, 0.0))
                };
                rows.push(vec![
                    joint.clone(),
                    of(&errors.before),
                    of(&errors.rigid),
                    of(&errors.after),
                    of(&self.effort_noise),
                ]);
            }
            page.push_str(&aligned(&["joint", "before", "rigid", "after", "noise"], &rows, 1));
        }
        page
    }

    fn sentence(&self) -> String {
        match self.findings.len() {
            0 => "the recordings show nothing that the model leaves out".to_owned(),
            1 => "the recordings show one effect that the model leaves out".to_owned(),
            n => format!("the recordings show {n} effects that the model leaves out"),
        }
    }
}

fn paragraph(finding: &Finding) -> String {
    let title = effect(&finding.effect).map_or("structure without a name", |e| e.law().title);
    let place = finding.link.clone().unwrap_or_else(|| finding.joints.join(", "));
    let mut text = format!("\n{title}");
    if !place.is_empty() {
        text.push_str(&format!(" on {place}"));
    }
    text.push_str(&format!(" (confidence {:.2})\n", finding.confidence));
    for (name, value) in &finding.parameters {
        let number = match value.stderr {
            Some(stderr) => {
                let (number, error) = uncertain(value.value, stderr);
                format!("{number} +- {error}")
            }
            None => significant(value.value, 3, 0.0),
        };
        text.push_str(&format!("  {name} {number} {}\n", value.unit));
    }
    text
}
