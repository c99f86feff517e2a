//! How an answer is scored against the truth.

pub(crate) mod blame;
pub(crate) mod case_score;
pub(crate) mod exam;
pub(crate) mod holdout;
pub(crate) mod judge;
pub(crate) mod rules;
pub(crate) mod scoreboard;
pub(crate) mod text;
