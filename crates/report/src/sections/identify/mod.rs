//! Sections of an identification.

mod constants;
mod drive_gains;
mod effects;
mod effort_error;
mod payloads;
mod problem;
mod significance;

pub(super) use constants::Constants;
pub(super) use drive_gains::DriveGains;
pub(super) use effects::JointEffects;
pub(super) use effort_error::EffortError;
pub(super) use payloads::Payloads;
pub(super) use problem::Problem;
pub(super) use significance::Significance;

/// Title of the page's section on the parameters.
const MINIMAL_SET: &str = "Minimal set";
/// Title of the page's section on the fit.
const FIT: &str = "Fit";
