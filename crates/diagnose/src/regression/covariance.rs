//! Covariances of fitted coefficients and of the link errors beside them.
//!
//! Method: posterior covariance of a linear Gaussian model, kept as rows whose outer products add up to it.
//! References: C. M. Bishop, Pattern recognition and machine learning, 2006, section 3.3.

use crate::regression::elimination::Prior;
use crate::regression::marginalised::{LeastSquaresFit, Marginalised};
use armident_numeric::dot;

impl Marginalised<'_> {
    /// Posterior covariance of some standard parameters' errors, the fit of the laws as it is.
    pub(crate) fn inertial_covariance(&self, parameters: &[usize]) -> Vec<Vec<f64>> {
        let Some(Prior { cholesky, directions, .. }) = self.prior.as_deref() else {
            return vec![vec![0.0; parameters.len()]; parameters.len()];
        };
        let rows: Vec<Vec<f64>> =
            parameters.iter().map(|p| directions.iter().map(|d| d[*p]).collect()).collect();
        let solved: Vec<Vec<f64>> = rows.iter().map(|row| cholesky.solve(row)).collect();
        rows.iter().map(|row| solved.iter().map(|s| dot(row, s)).collect()).collect()
    }

    /// Observations whose outer products add up to the prior covariance of all standard parameters; none without
    /// inertial errors.
    pub(crate) fn prior_factors(&self) -> Option<Vec<Vec<f64>>> {
        self.prior.as_ref().map(|prior| prior.directions.clone())
    }

    /// Such observations of the posterior with the laws as they are, and the change of the standard parameters with each
    /// coefficient of the fit.
    pub(crate) fn inertial_posterior(&self, fit: &LeastSquaresFit) -> Option<[Vec<Vec<f64>>; 2]> {
        let Prior { weight, cholesky, directions, .. } = self.prior.as_deref()?;
        let rigid = self.problem.rigid;
        // A = L L': the rows of L^-1 D
        let columns: Vec<Vec<f64>> = (0..rigid)
            .map(|p| cholesky.forward(&directions.iter().map(|d| d[p]).collect::<Vec<_>>()))
            .collect();
        let rows = (0..directions.len()).map(|k| columns.iter().map(|c| c[k]).collect()).collect();
        let sensitivity = fit
            .columns
            .iter()
            .map(|&c| {
                let along = |d: &Vec<f64>| -> f64 {
                    (0..rigid).map(|p| d[p] * self.problem.product(c, p)).sum()
                };
                let solved = cholesky.solve(&directions.iter().map(along).collect::<Vec<_>>());
                (0..rigid)
                    .map(|p| {
                        -weight * directions.iter().zip(&solved).map(|(d, s)| d[p] * s).sum::<f64>()
                    })
                    .collect()
            })
            .collect();
        Some([rows, sensitivity])
    }

    /// Observations whose outer products add up to the covariance of the coefficients of a fit.
    pub(crate) fn coefficient_factors(&self, fit: &LeastSquaresFit) -> Vec<Vec<f64>> {
        let scale = |k: usize| {
            self.per_norm(fit.columns[k]) / self.problem.observations.weights.share.sqrt()
        };
        let count = fit.columns.len();
        let columns: Vec<Vec<f64>> = (0..count)
            .map(|c| {
                let unit: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k == c))).collect();
                fit.cholesky.forward(&unit)
            })
            .collect();
        (0..count).map(|k| (0..count).map(|c| columns[c][k] * scale(c)).collect()).collect()
    }

    /// Covariance of the coefficients of some columns of a fit.
    pub(crate) fn covariance(&self, fit: &LeastSquaresFit, columns: &[usize]) -> Vec<Vec<f64>> {
        let reduced: Vec<Vec<f64>> = columns
            .iter()
            .map(|c| {
                let unit: Vec<f64> =
                    fit.columns.iter().map(|k| f64::from(u8::from(k == c))).collect();
                fit.cholesky.forward(&unit)
            })
            .collect();
        let scale = |k: usize| self.per_norm(columns[k]);
        (0..columns.len())
            .map(|a| {
                (0..columns.len())
                    .map(|b| {
                        dot(&reduced[a], &reduced[b]) * scale(a) * scale(b)
                            / self.problem.observations.weights.share
                    })
                    .collect()
            })
            .collect()
    }
}
