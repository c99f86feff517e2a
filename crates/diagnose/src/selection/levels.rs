//! Levels of significance of the selection.

/// SurrogateThreshold of a change that is none, among all that are tried.
pub(crate) const CHANCE: f64 = 0.01;
