//! Limits of a valid recording and of repairs on reading.

/// Least number of samples of a recording.
pub const MIN_SAMPLES: usize = 8;
/// Longest run of NaN that is interpolated. The cubic through two samples on either side spans five
/// steps then, which follows a motion sampled ten times per period to about 1 %.
pub const MISSING_RUN: usize = 3;
/// Largest share of NaN in a channel that is interpolated: more is a fault of the logging, not an
/// occasional missing value.
pub const MISSING_SHARE: f64 = 0.01;
/// Largest share of samples with a duplicate time stamp.
pub const REPEATED_SHARE: f64 = 0.01;
/// Median steps from this on are not in seconds \[s\].
pub(crate) const LONGEST_STEP_S: f64 = 0.5;
/// Median steps up to this are not in seconds \[s\].
pub(crate) const SHORTEST_STEP_S: f64 = 1e-6;
