//! Columns to estimates, errors of all links marginalised.

pub(crate) mod admissible;
pub(crate) mod consistent_links;
pub(crate) mod covariance;
pub(crate) mod elimination;
pub(crate) mod fit_set;
pub(crate) mod folds;
pub(crate) mod marginalised;
pub(crate) mod relinearise;
pub(crate) mod score;
