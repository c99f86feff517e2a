//! Findings on recorded signals: kind, location, share of samples, and action.

use std::fmt;

use serde::Serialize;

use crate::quantity::Quantity;

/// Kind of a defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum QualityIssueKind {
    /// Uneven time stamps.
    UnevenStamps,
    /// Time stamps of reception, late against the sampling instants.
    LateStamps,
    /// Duplicate time stamps.
    RepeatedStamps,
    /// Rows not sorted by time.
    UnsortedRows,
    /// Duplicate frames (all channels) while the arm moves.
    RepeatedFrames,
    /// Missing samples.
    Gap,
    /// NaN values.
    MissingValues,
    /// Columns without any value.
    EmptyColumns,
    /// Channels in rows of their own stamps.
    OwnStamps,
    /// Rows of zeros between rows of motion.
    RowsOfZeros,
    /// Single positions that jump away and back.
    Glitches,
    /// Single efforts that jump away and back.
    Outliers,
    /// An effort that is exactly 0 for a few samples while the joint moves.
    DropOuts,
    /// Efforts that are renewed in some of the rows only.
    HeldEfforts,
    /// An angle wraps at a full turn.
    WrappedAngle,
    /// A constant value while the joint moves.
    Stuck,
    /// Flat tops at the largest or smallest value.
    Saturated,
    /// No velocity column.
    MissingVelocity,
    /// The velocity is a multiple of the differentiated position.
    VelocityScale,
    /// The sign of the velocity is opposite to the differentiated position.
    VelocitySign,
    /// The velocity lags the differentiated position.
    VelocityDelay,
    /// The velocity disagrees with the differentiated position.
    VelocityMismatch,
    /// Positions probably not in rad or m.
    SuspectedUnit,
    /// Recordings have different sample rates.
    RatesDiffer,
    /// Recordings have different joints or channels.
    ChannelsDiffer,
}

/// Action taken on a defect.
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

/// A time interval, both ends included \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Span {
    /// First stamp \[s\].
    pub from_s: f64,
    /// Last stamp \[s\].
    pub to_s: f64,
}

impl Span {
    /// The intervals of runs of samples, each given by its first and last index into the stamps
    /// `time_s` \[s\].
    ///
    /// # Panics
    /// An index is not below the number of stamps.
    pub fn of_runs(time_s: &[f64], runs: &[(usize, usize)]) -> Vec<Self> {
        runs.iter()
            .map(|(first, last)| Self { from_s: time_s[*first], to_s: time_s[*last] })
            .collect()
    }

    /// The intervals in words.
    ///
    /// ```
    /// use armident_recording::Span;
    ///
    /// let spans = Span::of_runs(&[0.0, 0.5, 1.0, 1.5], &[(0, 0), (2, 3)]);
    /// assert_eq!(Span::describe(&spans), "2 times, first at t = 0.000 s");
    /// assert_eq!(Span::describe(&spans[1..]), "from t = 1.000 s to 1.500 s");
    /// assert_eq!(Span::describe(&[]), "everywhere");
    /// ```
    pub fn describe(spans: &[Self]) -> String {
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
}

/// One defect of one channel, or of the time stamps. `Display` is [`message`](Self::message).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QualityIssue {
    /// Kind of the defect.
    pub kind: QualityIssueKind,
    /// Action taken.
    pub action: Action,
    /// The joint; none for the time stamps.
    pub joint: Option<String>,
    /// The channel; none for the time stamps.
    pub quantity: Option<Quantity>,
    /// Time intervals; empty if the whole recording is affected.
    pub spans: Vec<Span>,
    /// Share of the samples affected, 0 to 1.
    pub share: f64,
    /// One line: channel, share, times and action.
    pub message: String,
    /// What the user can do.
    pub advice: Option<String>,
}

impl fmt::Display for QualityIssue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl QualityIssue {
    /// A finding on the time stamps of the whole recording; `share` is 0 to 1.
    pub fn of_stamps(kind: QualityIssueKind, action: Action, share: f64) -> Self {
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

    /// A finding on a whole channel; `share` is 0 to 1.
    pub fn of_channel(
        kind: QualityIssueKind,
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

    /// The same at these time intervals.
    #[must_use]
    pub fn at(self, spans: Vec<Span>) -> Self {
        Self { spans, ..self }
    }

    /// The same with a message, to which the name of the channel is prepended: `elbow/effort: ...`.
    #[must_use]
    pub fn with_message(self, text: impl fmt::Display) -> Self {
        let message = match (&self.joint, self.quantity) {
            (Some(joint), Some(quantity)) => format!("{joint}/{quantity}: {text}"),
            _ => text.to_string(),
        };
        Self { message, ..self }
    }

    /// The same with advice.
    #[must_use]
    pub fn with_advice(self, advice: impl Into<String>) -> Self {
        Self { advice: Some(advice.into()), ..self }
    }
}

/// A share (0 to 1) as a percentage with about two significant digits.
///
/// ```
/// use armident_recording::percent;
///
/// assert_eq!([0.5, 0.0123, 0.0004].map(percent), ["50 %", "1.2 %", "0.04 %"]);
/// ```
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if p >= 9.95 => format!("{p:.0} %"),
        p if p >= 0.095 => format!("{p:.1} %"),
        p => format!("{p:.2} %"),
    }
}
