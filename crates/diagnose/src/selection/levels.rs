//! Significance levels of the selection.
//!
//! Method: one family-wise level for all candidates of a test (Bonferroni).
//! References: own.

/// SurrogateThreshold of a change that is none, among all that are tried.
pub(crate) const CHANCE: f64 = 0.01;
