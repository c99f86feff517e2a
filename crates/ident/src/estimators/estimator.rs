//! What an estimator is, and what it may use.

use std::error::Error;
use std::fmt;

use armident_model::ArmModel;
use armident_motion::Motion;
use armident_numeric::NumericError;

use crate::regression::{BatchEstimate, BatchProblem, BatchSettings, JointRows};

/// A way to solve the batch problem.
pub trait Estimator: fmt::Debug + Send + Sync {
    /// Name on the command line and in files.
    fn name(&self) -> &'static str;

    /// Name of the method for people, as in "identified by weighted least squares".
    fn title(&self) -> &'static str;

    /// The method in a clause, for help texts; the title by default.
    fn description(&self) -> &'static str {
        self.title()
    }

    /// Estimates all terms of a problem, in their order, with standard errors. By-products are
    /// [notes](BatchEstimate::notes) of the estimate.
    ///
    /// # Errors
    /// [`EstimatorError`] when a number is not finite, or the data do not suffice for the method.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError>;
}

/// What an estimator may use.
#[derive(Debug, Clone, Copy)]
pub struct TrainingData<'a> {
    /// The given model of the arm, for simulations.
    pub model: &'a ArmModel,
    /// Motions with efforts.
    pub motions: &'a [&'a Motion],
    /// Their rows ([`BatchProblem::accumulate`]).
    pub rows: &'a JointRows,
}

/// Why an estimate failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EstimatorError {
    /// A number is not finite.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The data do not suffice for the method.
    #[error("{message}")]
    Unsuitable {
        /// Name of the estimator.
        estimator: &'static str,
        /// What is missing.
        message: String,
        /// What to do instead.
        hint: String,
        /// The error behind it.
        source: Option<Box<dyn Error + Send + Sync>>,
    },
}
