//! Minimal inertia sets, experiment plans, and estimation with uncertainty.

mod constant;
mod minimal_set;
mod theorem2;

pub use constant::{Constant, Quantity};
pub use minimal_set::{DroppedConstant, MinimalSet};
pub use theorem2::Theorem2;
