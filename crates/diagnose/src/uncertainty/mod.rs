//! How well the estimates are known.

pub(crate) mod jackknife;
pub(crate) mod minimal_constants;
pub(crate) mod profile_curvature;
