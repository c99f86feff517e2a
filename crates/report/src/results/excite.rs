//! `armident excite`: the suite of motions and what it will tell, as data and text.

use armident_excitation::{
    MotionLimits, STANDARD_ERRORS, Separation, Sight, Split, Suite, SuiteMotion, Visibility,
};
use serde::Serialize;

use crate::layout::{aligned, significant};
use crate::words::{effect_label, parameter_label};

/// The result of `excite`.
#[derive(Debug, Clone, Serialize)]
pub struct ExciteReport {
    schema: &'static str,
    robot: String,
    motions: Vec<MotionRow>,
    limits: Vec<LimitRow>,
    errors: Vec<ErrorRow>,
    visibilities: Vec<Visibility>,
    separations: Vec<Separation>,
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
    /// Smallest distance of links from each other and from regions \[m\], a lower bound; none where nothing can touch.
    pub clearance_m: Option<f64>,
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
                clearance_m: motion.clearance_m,
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
            visibilities: suite.visibilities.clone(),
            separations: suite.separations.clone(),
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
                    m.clearance_m.map_or("-".to_owned(), |d| format!("{:.0}", 1000.0 * d)),
                    m.purpose.to_owned(),
                ]
            })
            .collect();
        let heads =
            ["motion", "for", "time [s]", "effort", "condition", "distance [mm]", "purpose"];
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
        text += &self.visible_text();
        text += &self.separation_text();
        text
    }

    /// Smallest visible size of each effect on each joint, and what is not visible.
    fn visible_text(&self) -> String {
        let mut text = format!(
            "\nEffects that the fit will show: smallest size, {STANDARD_ERRORS:.0} standard errors ({SMALL} above the largest of \
             simulated cases, {IMITATED} imitated by what is fitted anyway)\n"
        );
        let mut effects: Vec<(&str, &str, &str)> = Vec::new();
        for seen in &self.visibilities {
            let row = (seen.effect.as_str(), seen.parameter.as_str(), seen.unit.as_str());
            if !effects.contains(&row) {
                effects.push(row);
            }
        }
        let cell = |seen: &Visibility| {
            let size = seen.least_from_suite.map(|size| significant(size, 2, 0.0));
            match (seen.suite, size) {
                (Sight::Visible, Some(size)) => size,
                (Sight::TooSmall, Some(size)) => format!("{size} {SMALL}"),
                _ => IMITATED.to_owned(),
            }
        };
        let rows: Vec<Vec<String>> = effects
            .iter()
            .map(|&(effect, parameter, unit)| {
                let of = |joint: &str| {
                    let mut seen = self.visibilities.iter().filter(|seen| {
                        seen.effect == effect && seen.parameter == parameter && seen.unit == unit
                    });
                    // an effect of the whole arm stands under the first joint
                    seen.find(|s| {
                        s.joint.as_deref().map_or(joint == self.limits[0].joint, |own| own == joint)
                    })
                    .map_or(String::new(), cell)
                };
                let name = format!("{} ({})", effect_label(effect), parameter_label(parameter));
                let mut row = vec![name];
                row.extend(self.limits.iter().map(|limits| of(&limits.joint)));
                row.push(unit.to_owned());
                row
            })
            .collect();
        let mut heads = vec!["effect (size)"];
        heads.extend(self.limits.iter().map(|limits| limits.joint.as_str()));
        heads.push("unit");
        text += &aligned(&heads, &rows, 1);
        let hidden = |seen: &&Visibility| {
            seen.suite == Sight::Visible && seen.train.is_some_and(|train| train != Sight::Visible)
        };
        let only: Vec<String> = self
            .visibilities
            .iter()
            .filter(hidden)
            .map(|seen| {
                let label = effect_label(&seen.effect);
                seen.joint.as_ref().map_or(label.clone(), |joint| format!("{label} on {joint}"))
            })
            .collect();
        if !only.is_empty() {
            text += &format!("  not visible by the training motion alone: {}\n", only.join(", "));
        }
        text
    }

    fn separation_text(&self) -> String {
        if self.separations.is_empty() {
            return String::new();
        }
        let mut text = "\nFindings and alternatives: residual after the best imitation, in standard deviations of one recorded effort \
             (root of the sum of squares)\n"
            .to_owned();
        let rows: Vec<Vec<String>> = self
            .separations
            .iter()
            .map(|pair| {
                let at = |slug: &str, joint: &str| match joint {
                    "" => effect_label(slug),
                    joint => format!("{} on {joint}", effect_label(slug)),
                };
                vec![
                    at(&pair.finding, &pair.joint),
                    at(&pair.alternative, &pair.alternative_joint),
                    pair.standard_errors.map_or("-".to_owned(), |x| significant(x, 3, 0.0)),
                    pair.note.clone().unwrap_or_default(),
                ]
            })
            .collect();
        text += &aligned(&["finding", "alternative", "residual", "note"], &rows, 2);
        text
    }
}

/// Marks of effects that are not visible.
const SMALL: &str = "!";
const IMITATED: &str = "-";
