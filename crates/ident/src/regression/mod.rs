//! The batch problem: parameters, columns, rows, priors, and weighted least squares with its standard errors.

mod block_errors;
mod columns;
mod estimate;
mod joint_rows;
mod known_load;
mod link_prior;
mod prior;
mod prior_scale;
mod problem;
mod projection;
mod unknown;

pub use estimate::{BatchEstimate, Endogeneity, EstimateNote, JointFit};
pub use joint_rows::JointRows;
pub use known_load::{KnownLoad, without_loads};
pub use prior::BatchSettings;
pub use problem::BatchProblem;
pub use unknown::{Coupling, LAWS, MergedTerm, Term};

pub(crate) use columns::TermColumn;
pub(crate) use estimate::{RANK_CUT, noise_of};
pub(crate) use joint_rows::{blocks_of, used_s};
pub(crate) use link_prior::{UNKNOWN, spread_of_numbers};
pub(crate) use unknown::SHARED;
