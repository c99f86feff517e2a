//! Which inertia constants an arm's efforts depend on: Theorem 2, Algorithm M and Algorithm 1 of Lin 1992.

mod algorithm1;
mod algorithm_m;
mod constant;
mod in_model;
mod theorem2;

pub use algorithm_m::{DroppedConstant, MinimalSet};
pub use algorithm1::algorithm1;
pub use constant::{Constant, ConstantKind};
pub use theorem2::Theorem2;

pub(crate) use algorithm_m::random_states;
