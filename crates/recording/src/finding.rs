//! What is wrong or doubtful in recorded signals: kind, place, share, and what was done about it.

use std::fmt;

use serde::Serialize;

use crate::recording::Quantity;

/// What kind of defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FindingKind {
    /// The steps between the stamps differ.
    UnevenStamps,
    /// Samples repeat the stamp before them.
    RepeatedStamps,
    /// Rows were out of the order of time.
    UnsortedRows,
    /// Whole frames repeat the one before although the arm moves.
    RepeatedFrames,
    /// Samples are lost.
    Gap,
    /// Values are NaN.
    MissingValues,
    /// An angle jumps by a full turn.
    WrappedAngle,
    /// A value repeats although the joint moves.
    Stuck,
    /// Flat tops at the largest or smallest value.
    Saturated,
    /// No velocity is recorded.
    MissingVelocity,
    /// The velocity is a multiple of the differentiated position.
    VelocityScale,
    /// The velocity has the other sign than the differentiated position.
    VelocitySign,
    /// The velocity comes later than the differentiated position.
    VelocityDelay,
    /// The velocity has little to do with the differentiated position.
    VelocityMismatch,
    /// Positions are probably not in rad or m.
    SuspectedUnit,
    /// Recordings have different sample rates.
    RatesDiffer,
    /// Recordings have different joints or channels.
    ChannelsDiffer,
}

/// What was done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// The recording differs from the file.
    Repaired,
    /// The recording is as the file.
    Kept,
    /// The file was not accepted.
    Refused,
}

/// A stretch of time, both ends included \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Span {
    /// First stamp \[s\].
    pub from_s: f64,
    /// Last stamp \[s\].
    pub to_s: f64,
}

/// One defect of one channel, or of the time stamps. `Display` is [`message`](Self::message).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What kind of defect.
    pub kind: FindingKind,
    /// What was done.
    pub action: Action,
    /// The joint; none for the time stamps.
    pub joint: Option<String>,
    /// The channel; none for the time stamps.
    pub quantity: Option<Quantity>,
    /// Where; empty if it is everywhere.
    pub spans: Vec<Span>,
    /// Share of the samples concerned, 0 to 1.
    pub share: f64,
    /// One sentence with place, share and what was done.
    pub message: String,
    /// What the user can do about it.
    pub advice: Option<String>,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Finding {
    /// About the time stamps, everywhere.
    pub fn of_stamps(kind: FindingKind, action: Action, share: f64) -> Self {
        Self {
            kind,
            action,
            joint: None,
            quantity: None,
            spans: Vec::new(),
            share,
            message: String::new(),
            advice: None,
        }
    }

    /// About a channel.
    pub fn of_channel(
        kind: FindingKind,
        action: Action,
        joint: &str,
        quantity: Quantity,
        share: f64,
    ) -> Self {
        Self {
            joint: Some(joint.to_owned()),
            quantity: Some(quantity),
            ..Self::of_stamps(kind, action, share)
        }
    }

    /// The same with its places.
    pub fn at(self, spans: Vec<Span>) -> Self {
        Self { spans, ..self }
    }

    /// The same with its sentence; `: ` and the channel's name go before it.
    pub fn saying(self, text: impl fmt::Display) -> Self {
        let message = match (&self.joint, self.quantity) {
            (Some(joint), Some(quantity)) => format!("{joint}/{quantity}: {text}"),
            _ => text.to_string(),
        };
        Self { message, ..self }
    }

    /// The same with advice.
    pub fn advising(self, advice: impl Into<String>) -> Self {
        Self { advice: Some(advice.into()), ..self }
    }
}

/// Spans of time of runs of samples `first..=last`.
pub fn spans_of(time_s: &[f64], runs: &[(usize, usize)]) -> Vec<Span> {
    runs.iter().map(|(from, to)| Span { from_s: time_s[*from], to_s: time_s[*to] }).collect()
}

/// `at t = 1.250 s`, `from t = 1.000 s to 1.250 s`, `3 times, first at t = 1.250 s`.
pub fn places(spans: &[Span]) -> String {
    let Some(first) = spans.first() else { return "everywhere".to_owned() };
    let one = if first.from_s == first.to_s {
        format!("at t = {:.3} s", first.from_s)
    } else {
        format!("from t = {:.3} s to {:.3} s", first.from_s, first.to_s)
    };
    match spans.len() {
        1 => one,
        count => format!("{count} times, first {one}"),
    }
}

/// A share as a percentage, with as many digits as say something.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if p >= 9.95 => format!("{p:.0} %"),
        p if p >= 0.095 => format!("{p:.1} %"),
        p => format!("{p:.2} %"),
    }
}
