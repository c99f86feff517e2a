//! The score of one case.

use serde::Serialize;

use crate::score::exam::ExamScore;
use crate::score::holdout::HoldoutScore;

/// The score of one case.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct CaseScore {
    /// Name of the case.
    pub case: String,
    /// Name of its robot.
    pub robot: String,
    /// `clean`, `field` or `change`.
    pub kind: &'static str,
    /// Why there is no answer.
    pub unanswered: Option<String>,
    /// Slugs of the hidden effects.
    pub effects: Vec<String>,
    /// Naming margins of these effects.
    pub naming_margins: Vec<f64>,
    /// (effect, place) pairs that should be named.
    pub pairs: Vec<String>,
    /// Pairs that are named, or whose `accept` is.
    pub named: Vec<String>,
    /// Pairs that are not.
    pub missed: Vec<String>,
    /// Missed pairs that are among the `alternatives` of a finding.
    pub in_alternatives: Vec<String>,
    /// Pairs that are named and not right, tolerated or baseline friction.
    pub false_names: Vec<String>,
    /// Slugs named rightly, alone.
    pub named_slugs: Vec<String>,
    /// Slugs named that no effect of the case has.
    pub false_slugs: Vec<String>,
    /// More false names than effects: nothing is credited.
    pub discredited: bool,
    /// Cases with effects: whether something is found.
    pub detected: Option<bool>,
    /// Nulls: whether something is found that is not there.
    pub false_alarm: Option<bool>,
    /// One effect: whether the finding of highest confidence is it.
    pub top1: Option<bool>,
    /// Whether the joints blamed hold all right ones, and at least half of them are right.
    pub located: Option<bool>,
    /// Intersection over union of the windows of contacts; 0 for a contact that is missed.
    pub window_iou: Vec<f64>,
    /// Slug and worst relative error of the bold parameters of effects that are named.
    pub parameter_errors: Vec<(String, f64)>,
    /// Errors of all parameters of named effects and baseline friction that have a standard error, in
    /// such errors.
    pub standardized_errors: Vec<f64>,
    /// Jaccard index of the variables of unlisted laws.
    pub variables: Vec<f64>,
    /// Baseline friction of a field case.
    #[serde(rename = "everyday")]
    pub baseline: BaselineScore,
    /// What the diagnosis says about its fit.
    pub holdout: HoldoutScore,
    /// What its model predicts.
    pub exam: Option<ExamScore>,
    /// True slug -> slugs named instead; `nothing` on either side.
    pub confusion: Vec<(String, String)>,
    /// Confidence of each finding that is right or false, and whether it is right.
    pub reliability: Vec<(f64, bool)>,
}

/// Baseline friction of a field case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct BaselineScore {
    /// Terms that stand above the noise.
    pub counted: usize,
    /// Of these, named by themselves or by the law that contains them.
    pub named: usize,
    /// Of the counted ones named by themselves,
    pub with_level: usize,
    /// those within a factor of two.
    pub within_factor_2: usize,
}
