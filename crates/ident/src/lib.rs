//! Minimal inertia sets, experiment plans, and estimation with uncertainty.

pub mod algorithm2;
mod constant;
mod minimal_set;
mod quantiles;
mod theorem2;

pub use constant::{Constant, Quantity};
pub use minimal_set::{DroppedConstant, MinimalSet};
pub use quantiles::student_t_975;
pub use theorem2::Theorem2;
