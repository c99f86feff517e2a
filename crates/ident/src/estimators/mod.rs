//! Estimators of the batch problem: one file each, listed in [`ALL`].
//!
//! | name | error model |
//! | --- | --- |
//! | `ols` | equal noise on every row of every joint |
//! | `wls` | each joint has its own noise |
//! | `irls` | outliers: Huber's weights on each joint's own scale |
//! | `iv` | noise in the regressors: instruments from the simulated arm |
//!
//! All of them report standard errors from the block jackknife ([`jackknife`](crate::BatchProblem::jackknife)). A new one is a file with a
//! type that is [`Estimator`], and its line in [`ALL`]; from outside this crate it goes into
//! [`IdentifyRequest::estimator`](crate::IdentifyRequest::estimator) as it is.

mod estimator;
mod huber;
mod instrumental;
mod ols;
mod wls;

pub use estimator::{Estimator, EstimatorError, TrainingData};
pub use huber::Huber;
pub use instrumental::Instrumental;
pub use ols::Ols;
pub use wls::Wls;

/// All estimators of the library, in the order in which they are listed.
pub const ALL: [&dyn Estimator; 4] = [&Ols, &Wls, &Huber, &Instrumental];

/// The estimator of this name.
pub fn by_name(name: &str) -> Option<&'static dyn Estimator> {
    ALL.into_iter().find(|estimator| estimator.name() == name)
}
