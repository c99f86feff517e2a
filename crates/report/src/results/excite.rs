//! `armident excite`: the suite of motions and what it will tell, as data and text.

use armident_excitation::{MotionLimits, Split, Suite, SuiteMotion};
use serde::Serialize;

use crate::layout::{aligned, significant};
use crate::words::effect_label;

/// The result of `excite`.
#[derive(Debug, Clone, Serialize)]
pub struct ExciteReport {
    schema: &'static str,
    robot: String,
    motions: Vec<MotionRow>,
    limits: Vec<LimitRow>,
    errors: Vec<ErrorRow>,
    condition: Option<f64>,
    random_condition: Option<f64>,
    starts: usize,
    notes: Vec<String>,
}

/// One motion of the suite.
#[derive(Debug, Clone, Serialize)]
pub struct MotionRow {
    /// Name; the file is that with `.csv`.
    pub name: String,
    /// What it is for.
    pub purpose: &'static str,
    /// Whether a fit uses it, a test, or neither.
    pub split: Split,
    /// Length \[s\].
    pub seconds: f64,
    /// Largest effort of the rigid body over what may be used of its limit.
    pub effort_share: f64,
    /// Joint on which that is.
    pub effort_joint: String,
    /// Condition number of its regressor with columns of unit length; none where a column is zero.
    pub condition: Option<f64>,
}

#[derive(Debug, Clone, Serialize)]
struct LimitRow {
    joint: String,
    #[serde(flatten)]
    limits: MotionLimits,
    assumed_noise: f64,
}

#[derive(Debug, Clone, Serialize)]
struct ErrorRow {
    name: String,
    joint: String,
    unit: String,
    value: Option<f64>,
    from_given: Option<f64>,
    from_train: Option<f64>,
    from_suite: Option<f64>,
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|x| x.is_finite())
}

impl ExciteReport {
    /// The result for a robot of this name, with the names of its joints.
    pub fn new(robot: &str, joints: &[String], suite: &Suite) -> Self {
        let row = |motion: &SuiteMotion| {
            let stamps = &motion.motion.time_s;
            MotionRow {
                name: motion.name.clone(),
                purpose: motion.purpose,
                split: motion.split,
                seconds: stamps.last().unwrap_or(&0.0) - stamps.first().unwrap_or(&0.0),
                effort_share: motion.effort_share.0,
                effort_joint: motion.effort_share.1.clone(),
                condition: finite(motion.condition),
            }
        };
        let limits = joints.iter().zip(&suite.limits).zip(&suite.noise);
        Self {
            schema: "armident.excite/1",
            robot: robot.to_owned(),
            motions: suite.motions.iter().map(row).collect(),
            limits: limits
                .map(|((joint, limits), noise)| LimitRow {
                    joint: joint.clone(),
                    limits: *limits,
                    assumed_noise: *noise,
                })
                .collect(),
            errors: suite
                .errors
                .iter()
                .map(|error| ErrorRow {
                    name: error.name.clone(),
                    joint: error.joint.clone(),
                    unit: error.unit.clone(),
                    value: error.value,
                    from_given: error.from_given.and_then(finite),
                    from_train: error.from_train.and_then(finite),
                    from_suite: finite(error.from_suite),
                })
                .collect(),
            condition: finite(suite.condition),
            random_condition: finite(suite.random_condition),
            starts: suite.starts,
            notes: suite.notes.clone(),
        }
    }

    /// The motions in the order in which they are recorded.
    pub fn motions(&self) -> &[MotionRow] {
        &self.motions
    }

    /// What was chosen and what is not part of the design.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The result as text.
    pub fn text(&self) -> String {
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| significant(x, 3, 0.0));
        let mut text = format!(
            "{}: {} motions, {:.0} s; condition number of the fit {} (a random motion as long as the training motion: {})\n",
            self.robot,
            self.motions.len(),
            self.motions.iter().map(|m| m.seconds).sum::<f64>(),
            number(self.condition),
            number(self.random_condition),
        );
        text += "\nMotions in the order of recording (effort: largest share of what may be used of a limit)\n";
        let rows: Vec<Vec<String>> = self
            .motions
            .iter()
            .map(|m| {
                let split = match m.split {
                    Split::Train => "fit",
                    Split::Holdout => "hold-out",
                    Split::Neither => "neither",
                };
                vec![
                    m.name.clone(),
                    split.to_owned(),
                    format!("{:.1}", m.seconds),
                    format!("{:.0} % {}", 100.0 * m.effort_share, m.effort_joint),
                    number(m.condition),
                    m.purpose.to_owned(),
                ]
            })
            .collect();
        let heads = ["motion", "for", "time [s]", "effort", "condition", "purpose"];
        text += &aligned(&heads, &rows, 2);
        let given = self.errors.iter().any(|e| e.from_given.is_some());
        let training = self.motions.iter().any(|m| m.name == "train");
        text += "\nStandard errors that the fit will give, before the arm has moved (independent effort noise: ";
        let noise: Vec<String> = self
            .limits
            .iter()
            .map(|l| format!("{} {}", l.joint, significant(l.assumed_noise, 2, 0.0)))
            .collect();
        text += &noise.join(", ");
        text += ")\n";
        let rows: Vec<Vec<String>> = self
            .errors
            .iter()
            .map(|e| {
                // constants have a label of their own, laws are named by their slug
                let name = if e.value.is_some() { e.name.clone() } else { effect_label(&e.name) };
                let mut row = vec![name, e.joint.clone(), number(e.value)];
                row.extend(given.then(|| number(e.from_given)));
                row.extend(training.then(|| number(e.from_train)));
                row.extend([number(e.from_suite), e.unit.clone()]);
                row
            })
            .collect();
        let mut heads = vec!["parameter", "joint", "value"];
        heads.extend(given.then_some("given recordings"));
        heads.extend(training.then_some("training motion"));
        heads.extend(["all of the fit", "unit"]);
        text += &aligned(&heads, &rows, 2);
        text
    }
}
