//! What is checked, and the verdicts.

use serde::Serialize;

/// Outcome of one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Right; the recordings would show a fault.
    Ok,
    /// The recordings would not show a fault.
    #[serde(rename = "cannot_tell")]
    Inconclusive,
    /// More likely wrong than not, or of little use.
    Doubtful,
    /// Wrong beyond a thousand to one.
    Wrong,
}

/// A fault less likely than this is none, one more likely than its complement is one.
pub(super) const SURE: f64 = 1e-3;
/// Probability of what a header states above which a column is right.
pub(super) const PROBABLY_RIGHT: f64 = 0.99;

impl Verdict {
    /// On something that is right with this probability.
    pub(super) fn of_probability(p: f64) -> Self {
        match p {
            p if p >= PROBABLY_RIGHT => Self::Ok,
            p if p >= 0.5 => Self::Inconclusive,
            p if p > SURE => Self::Doubtful,
            _ => Self::Wrong,
        }
    }
}

/// What was checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// Sample rate against the bandwidth of the motion.
    Rate,
    /// Noise of a channel.
    Noise,
    /// Which effort channel a column is.
    Channel,
    /// Which joint each column belongs to.
    Order,
    /// Where gravity points.
    Gravity,
    /// Whether a joint counts as its axis does, with position and effort.
    JointSign,
    /// Whether the distances of the axes are those of the arm.
    Geometry,
    /// Delay between effort and motion.
    Delay,
    /// Whether efforts and positions are recorded by one clock.
    Clock,
    /// Whether the motion determines the constants.
    Excitation,
    /// Properties of the samples that need no model.
    Quality,
    /// Whether a column is the command of a joint, and how far the position is behind it.
    Command,
}

/// One check with its verdict.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What was checked.
    pub topic: Topic,
    /// The joint; none for the robot as a whole.
    pub joint: Option<String>,
    /// The verdict.
    pub verdict: Verdict,
    /// The number it rests on.
    pub value: Option<f64>,
    /// Unit of the number.
    pub unit: &'static str,
    /// 95 % interval of the number.
    pub interval_95: Option<[f64; 2]>,
    /// One sentence.
    pub message: String,
    /// What to do.
    pub advice: Option<String>,
}

impl Check {
    /// A verdict and its sentence, on a joint or on the robot as a whole.
    pub(crate) fn of(topic: Topic, joint: Option<&str>, verdict: Verdict, message: String) -> Self {
        Self {
            topic,
            joint: joint.map(ToOwned::to_owned),
            verdict,
            value: None,
            unit: "",
            interval_95: None,
            message,
            advice: None,
        }
    }
}
