//! The parts of a suite: what each is for.

use serde::{Deserialize, Serialize};

/// A part of the suite, in the order in which it is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The training motion at half its speed.
    WarmUp,
    /// Each joint at five constant speeds in both directions.
    FrictionLadder,
    /// The motion with the largest information.
    Train,
    /// The same at the speed limits.
    Fast,
    /// Poses that are held.
    StaticHolds,
    /// Small slow movements back and forth.
    SlowReversals,
    /// An independent motion, for the test of what was identified.
    Validation,
    /// The motion that separates findings from their alternatives.
    Separation,
}

impl Part {
    /// All parts, in order, without the one that needs rivals.
    pub const ALL: [Self; 7] = [
        Self::WarmUp,
        Self::FrictionLadder,
        Self::Train,
        Self::Fast,
        Self::StaticHolds,
        Self::SlowReversals,
        Self::Validation,
    ];

    /// Its name, in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::WarmUp => "warm_up",
            Self::FrictionLadder => "friction_ladder",
            Self::Train => "train",
            Self::Fast => "fast",
            Self::StaticHolds => "static_holds",
            Self::SlowReversals => "slow_reversals",
            Self::Validation => "validation",
            Self::Separation => "separation",
        }
    }

    /// What it is for.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::WarmUp => "warms the drives; not for a fit",
            Self::FrictionLadder => "friction over speed",
            Self::Train => "link inertias and friction",
            Self::Fast => "link inertias at high acceleration, friction at high speed",
            Self::StaticHolds => "gravity, offsets, stiction",
            Self::SlowReversals => "friction at reversal, backlash",
            Self::Validation => "test of the model, never for a fit",
            Self::Separation => "separates findings from their alternatives",
        }
    }

    /// Whether a fit uses it, a test, or neither.
    pub fn split(self) -> Split {
        match self {
            Self::WarmUp => Split::Neither,
            Self::Validation => Split::Holdout,
            _ => Split::Train,
        }
    }

    pub(crate) fn has_rehearsal(self) -> bool {
        matches!(self, Self::Train | Self::Fast | Self::Validation | Self::Separation)
    }
}

/// What a recording of a motion is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// The fit.
    Train,
    /// The test of the fit.
    Holdout,
    /// Neither.
    Neither,
}
