//! `armident diagnose`: from a diagnosis to its result, and the text of the result.

use std::collections::BTreeMap;

use armident_diagnose::{Diagnosis, Errors, ServoDiagnosis};
use armident_kinematics::DrivingAxisChain;

use crate::layout::{Bars, render};
use crate::results::diagnosis::worse_on_holdout;
use crate::results::{
    DiagnoseInputs, DiagnoseReport, FindingRow, Fits, InputCheckRows, JointResiduals,
};
use crate::section::{DiagnosisSection, Source};
use crate::sections::{self, NextMotionResult, PlaceboTest, PositionFit, ReplayPair};

impl Fits {
    /// Of the errors of a diagnosis.
    pub fn of(train: Option<Errors>, holdout: Option<Errors>) -> Self {
        Self { train: train.map(Into::into), holdout: holdout.map(Into::into) }
    }
}

impl DiagnoseReport {
    /// From a diagnosis and its errors.
    pub fn new(
        chain: &DrivingAxisChain,
        diagnosis: &Diagnosis,
        inputs: DiagnoseInputs,
        fit: Fits,
    ) -> Self {
        Self::with_sections(chain, diagnosis, inputs, fit, sections::DIAGNOSIS)
    }

    /// From a diagnosis and its errors, with the data of these sections.
    pub fn with_sections(
        chain: &DrivingAxisChain,
        diagnosis: &Diagnosis,
        inputs: DiagnoseInputs,
        fit: Fits,
        sections: &[&dyn DiagnosisSection],
    ) -> Self {
        let residual_map: Vec<JointResiduals> =
            diagnosis.atlas.iter().map(JointResiduals::of).collect();
        let unexplained = residual_map.iter().filter(|joint| !joint.is_explained());
        let unexplained = unexplained.map(|joint| joint.joint.clone()).collect();
        let source = Source { chain, diagnosis, inputs: &inputs };
        let data: Vec<_> = sections
            .iter()
            .filter_map(|section| Some((section.key(), section.data(&source)?)))
            .collect();
        let mut report = Self {
            unexplained,
            worse_on_holdout: worse_on_holdout(&fit),
            joints: diagnosis.joints.clone(),
            findings: diagnosis.findings.iter().map(FindingRow::of).collect(),
            fit,
            effort_noise: diagnosis.effort_noise.clone().into(),
            prior_scale: diagnosis.inertial_error,
            link_errors_material_on: diagnosis.inertias_matter_on.clone(),
            residual_map,
            ..Self::empty(chain, inputs)
        };
        for (key, value) in data {
            report.more.set(key, value);
        }
        if let Some(placebo) = &diagnosis.placebo {
            report.set(&PlaceboTest::from(placebo.clone()));
        }
        report.with_input_checks(&diagnosis.input_checks)
    }

    /// From a diagnosis of commands and positions.
    pub fn of_commands(found: &ServoDiagnosis, inputs: DiagnoseInputs) -> Self {
        let ServoDiagnosis { findings, identification } = found;
        let mut report = Self {
            findings: findings.iter().map(FindingRow::of).collect(),
            ..Self::empty(&identification.model.chain, inputs)
        };
        report.set(&PositionFit::of(&identification.joints, &identification.magnitudes));
        report.judge();
        report
    }

    /// Of recordings whose columns fail the input checks, so that there is no diagnosis.
    pub fn of_failed_checks(
        chain: &DrivingAxisChain,
        checks: &armident_diagnose::InputChecks,
        inputs: DiagnoseInputs,
    ) -> Self {
        Self::empty(chain, inputs).with_input_checks(checks)
    }

    fn empty(chain: &DrivingAxisChain, inputs: DiagnoseInputs) -> Self {
        let translational = chain.joints.iter().filter(|joint| !joint.kind.is_rotational());
        Self {
            schema: Self::SCHEMA.to_owned(),
            robot: chain.robot.clone(),
            recordings: inputs.recordings,
            holdout_recordings: inputs.holdout_recordings,
            reference_recordings: inputs.reference_recordings,
            joints: chain.joints.iter().map(|joint| joint.name.clone()).collect(),
            prismatic_joints: Some(translational.map(|joint| joint.name.clone()).collect()),
            warnings: inputs.warnings,
            ..Self::default()
        }
    }

    /// With the outcome of the input checks; the diagnosis is then of the other joints.
    #[must_use]
    fn with_input_checks(mut self, checks: &armident_diagnose::InputChecks) -> Self {
        self.input_checks = InputCheckRows::of(checks);
        self.judge();
        self
    }

    /// With tests of the hold-out beside its errors.
    #[must_use]
    pub fn with_holdout_tests(
        mut self,
        whiteness_p: BTreeMap<String, f64>,
        replay: Option<ReplayPair>,
    ) -> Self {
        self.whiteness_p = whiteness_p.into();
        if let Some(replay) = replay {
            self.set(&replay);
        }
        self
    }

    /// With the motion that separates findings from their alternatives, if one was requested.
    #[must_use]
    pub fn with_next_motion(mut self, found: Option<NextMotionResult>) -> Self {
        if let Some(found) = found {
            self.set(&found);
        }
        self
    }

    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        text_of_sections(self, sections::DIAGNOSIS, bars)
    }
}

/// Text of a diagnosis: its first line, and these sections.
pub fn text_of_sections(
    result: &DiagnoseReport,
    sections: &[&dyn DiagnosisSection],
    bars: Bars,
) -> String {
    let blocks = sections.iter().flat_map(|section| section.text(result));
    format!("{}: {}\n{}", result.robot, result.sentence, render(blocks, bars))
}
