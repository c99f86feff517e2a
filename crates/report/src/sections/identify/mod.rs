//! Sections of an identification.

mod constants;
mod drive_gains;
mod effects;
mod effort_error;
mod payloads;
mod problem;
mod sensed_gears;
mod significance;
mod titles;

pub(super) use constants::Constants;
pub(super) use drive_gains::DriveGains;
pub(super) use effects::JointEffects;
pub(super) use effort_error::EffortError;
pub(super) use payloads::Payloads;
pub(super) use problem::Problem;
pub(super) use sensed_gears::SensedGears;
pub(super) use significance::Significance;
