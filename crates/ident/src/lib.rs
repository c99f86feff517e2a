//! Minimal inertia sets, experiment plans, and estimation with uncertainty.
//!
//! ```text
//! τ = Y(q, q̇, q̈) x + Σ φ(motion) p + noise
//! ```
//!
//! | question | answer |
//! | --- | --- |
//! | which constants `x` can be known at all | [`MinimalSet`] (Theorem 2 and Algorithm M) |
//! | which experiments find them one joint at a time | [`algorithm2::plan`] |
//! | what do such recordings say | [`algorithm2::algorithm2`] |
//! | what do ordinary motions say, friction included | [`BatchProblem`] |
//! | which real links have such constants, or nearly | [`ConsistencyProblem`] |
//! | the same by another method, with honest errors, judged on hold-outs | [`BatchFit`] |
//! | do the recordings and their books fit the arm | [`check::check`] |
//! | the arm with what was found, to predict and to keep | [`armident_model::ArmModel`] |

mod algorithm1;
pub mod algorithm2;
mod batch;
mod bending;
pub mod check;
mod consistency;
mod consistent_estimate;
mod constant;
mod coupling;
mod fit;
mod gains;
mod left_out;
mod link_prior;
mod methods;
mod minimal_set;
mod payload;
mod quantiles;
mod rows;
mod theorem2;
mod unreported;
pub mod validate;

pub use algorithm1::algorithm1;
pub use batch::{BatchEstimate, BatchProblem, BatchSettings, JointFit, LAWS, MergedTerm, Term};
pub use bending::BendFound;
pub use consistency::{ConsistencyError, ConsistencyProblem, Consistent, EffectUnknown};
pub use constant::{Constant, Quantity};
pub use coupling::{Coupling, CouplingFound};
pub use fit::{BatchFit, Recorded};
pub use gains::{DriveGain, DriveGains};
pub use left_out::{Chosen, Sought};
pub use methods::{Endogeneity, Method, MethodError};
pub use minimal_set::{DroppedConstant, MinimalSet};
pub use payload::{KnownLoad, without_loads};
pub use quantiles::student_t_975;
pub use rows::{JointRows, used_samples};
pub use theorem2::Theorem2;
pub use unreported::unreported;
