//! Fits of sets of columns with the link errors marginalised: the estimates, their residuals and standard errors.
//!
//! Method: generalised least squares with the marginal covariance `1 + s² W W'` of [`NuisanceElimination`], by normal equations
//! of normalised columns.
//! References: A. C. Aitken, On least squares and linear combination of observations, Proceedings of the Royal Society of
//! Edinburgh 55, 1936; C. M. Bishop, Pattern recognition and machine learning, 2006, section 3.5 (marginal likelihood).

use crate::regression::elimination::{InflatedLink, NuisanceElimination, Prior, size_of_link};
use std::collections::HashSet;
use std::sync::Arc;

use armident_numeric::{Cholesky, Mat, dot};
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;

/// Relative ridge on normalised columns: nested laws share columns, round-off does the rest.
const RIDGE: f64 = 1e-7;
/// Least unique part of a normalised column, squared: below it the column is a combination.
const LEAST_UNIQUE: f64 = 1e-6;

/// A [`LinearProblem`] in the metric of the marginal covariance at one prior scale.
pub(crate) struct Marginalised<'a> {
    pub(crate) problem: &'a LinearProblem,
    pub(crate) scale: f64,
    /// links whose errors may be larger
    pub(crate) inflated: Vec<InflatedLink>,
    pub(super) gram: Vec<Vec<f64>>,
    pub(super) rhs: Vec<f64>,
    pub(super) square: f64,
    /// the sample size of fits
    pub(super) effective_rows: f64,
    pub(super) log_determinant: f64,
    pub(super) norm: Vec<f64>,
    pub(super) prior: Option<Arc<Prior>>,
    /// columns whose coefficient is 1
    pub(super) of_size_one: HashSet<usize>,
}

/// The least-squares fit of a set of columns.
#[derive(Debug, Clone)]
pub(crate) struct LeastSquaresFit {
    /// ids of columns whose coefficients were fitted
    pub(crate) columns: Vec<usize>,
    pub(super) coefficients: Vec<f64>,
    /// ids of those whose coefficient is 1
    pub(super) of_size_one: Vec<usize>,
    pub(crate) sum_of_squares: f64,
    pub(super) cholesky: Cholesky,
    pub(super) reduced: Vec<f64>,
}

impl LeastSquaresFit {
    pub(crate) fn coefficient(&self, column: usize) -> f64 {
        self.terms().find(|(c, _)| *c == column).map_or(0.0, |(_, x)| x)
    }

    /// Columns and their coefficients.
    pub(super) fn terms(&self) -> impl Iterator<Item = (usize, f64)> {
        let fitted = self.columns.iter().copied().zip(self.coefficients.iter().copied());
        fitted.chain(self.of_size_one.iter().map(|c| (*c, 1.0)))
    }

    pub(crate) fn of_candidate(&self, candidate: &Candidate) -> Vec<f64> {
        candidate.columns.iter().map(|c| self.coefficient(*c)).collect()
    }
}

impl Marginalised<'_> {
    fn product(&self, a: usize, b: usize) -> f64 {
        let value = if a >= b { self.gram[a][b] } else { self.gram[b][a] };
        value / (self.norm[a] * self.norm[b])
    }

    /// Factor from the coefficient of a normalised column to that of the column; 0 for a zero column.
    pub(super) fn per_norm(&self, column: usize) -> f64 {
        let norm = self.norm[column];
        if norm > f64::MIN_POSITIVE.sqrt() { 1.0 / norm } else { 0.0 }
    }

    /// Columns of a set of candidates, each once.
    pub(crate) fn columns_of(&self, set: &[usize]) -> Vec<usize> {
        let candidates = &self.problem.candidates;
        let mut columns: Vec<usize> =
            set.iter().flat_map(|g| candidates[*g].columns.iter().copied()).collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    }

    /// Fits a set of columns; none where they are numerically dependent beyond the ridge.
    pub(crate) fn fit(&self, columns: Vec<usize>) -> Option<LeastSquaresFit> {
        let (of_size_one, columns): (Vec<usize>, Vec<usize>) =
            columns.into_iter().partition(|c| self.of_size_one.contains(c));
        let cholesky = Cholesky::of(columns.len(), |i, j| {
            self.product(columns[i], columns[j]) + if i == j { RIDGE } else { 0.0 }
        })?;
        let rhs: Vec<f64> = columns.iter().map(|&k| self.rhs_beside(&of_size_one, k)).collect();
        let reduced = cholesky.forward(&rhs);
        // efforts minus the columns with coefficient 1
        let explained = |&u: &usize| {
            self.norm[u] * (self.rhs[u] / self.norm[u] + self.rhs_beside(&of_size_one, u))
        };
        let square = self.square - of_size_one.iter().map(explained).sum::<f64>();
        let sum_of_squares = (square - dot(&reduced, &reduced)).max(f64::MIN_POSITIVE);
        let coefficients = cholesky
            .backward(&reduced)
            .iter()
            .zip(&columns)
            .map(|(x, &k)| x / self.norm[k])
            .collect();
        Some(LeastSquaresFit {
            columns,
            coefficients,
            of_size_one,
            sum_of_squares,
            cholesky,
            reduced,
        })
    }

    /// Product of a normalised column with the efforts beside columns of size one.
    fn rhs_beside(&self, of_size_one: &[usize], column: usize) -> f64 {
        let beside = |&u: &usize| self.norm[u] * self.product(column, u);
        self.rhs[column] / self.norm[column] - of_size_one.iter().map(beside).sum::<f64>()
    }

    /// Reduction of the sum of squares by adding these columns to a fit.
    pub(crate) fn gain(&self, fit: &LeastSquaresFit, added: &[usize]) -> f64 {
        if added.is_empty() {
            return 0.0;
        }
        let across: Vec<Vec<f64>> = added
            .iter()
            .map(|&g| {
                let products: Vec<f64> = fit.columns.iter().map(|&c| self.product(c, g)).collect();
                fit.cholesky.forward(&products)
            })
            .collect();
        let rhs: Vec<f64> = added
            .iter()
            .zip(&across)
            .map(|(&g, z)| self.rhs_beside(&fit.of_size_one, g) - dot(z, &fit.reduced))
            .collect();
        let own = Cholesky::of(added.len(), |i, j| {
            self.product(added[i], added[j]) - dot(&across[i], &across[j])
                + if i == j { LEAST_UNIQUE } else { 0.0 }
        });
        own.map_or(0.0, |own| {
            let reduced = own.forward(&rhs);
            dot(&reduced, &reduced)
        })
    }

    /// Relative size of the errors of a link.
    pub(crate) fn size_of(&self, link: usize) -> f64 {
        size_of_link(link, self.scale, &self.inflated)
    }

    /// Posterior mean of the relative inertial errors, and with it the change of all standard
    /// parameters; zeros at scale 0.
    pub(crate) fn inertial_errors(&self, fit: &LeastSquaresFit) -> Vec<f64> {
        let problem = self.problem;
        let mut change = vec![0.0; problem.rigid];
        let Some(prior) = &self.prior else { return change };
        let Prior { weight, cholesky, w_y, directions } = &**prior;
        let rhs: Vec<f64> = directions
            .iter()
            .zip(w_y)
            .map(|(d, w_y)| {
                let explained: f64 = fit
                    .terms()
                    .map(|(c, x)| {
                        x * (0..problem.rigid).map(|p| d[p] * problem.product(c, p)).sum::<f64>()
                    })
                    .sum();
                weight * (w_y - explained)
            })
            .collect();
        for (direction, c) in directions.iter().zip(cholesky.solve(&rhs)) {
            for (change, d) in change.iter_mut().zip(direction) {
                *change += c * d;
            }
        }
        change
    }

    /// Weighted residual of a fit, link errors at their posterior mean.
    pub(crate) fn residual(&self, fit: &LeastSquaresFit) -> JointColumns {
        self.residual_of(fit, self.problem)
    }

    /// Weighted residual of the same fit in another problem of the same columns.
    pub(crate) fn residual_of(
        &self,
        fit: &LeastSquaresFit,
        problem: &LinearProblem,
    ) -> JointColumns {
        let mut residual = problem.effort.clone();
        let errors = self.inertial_errors(fit);
        let rigid = errors.iter().enumerate().filter(|(_, x)| **x != 0.0);
        let rigid = rigid.map(|(k, x)| (k, *x));
        for (k, x) in rigid.chain(fit.terms()) {
            for (residual, column) in residual.iter_mut().zip(&problem.columns[k]) {
                for (r, c) in residual.iter_mut().zip(column) {
                    *r -= x * c;
                }
            }
        }
        residual
    }
}

impl LinearProblem {
    /// The problem with link errors marginalised at a prior scale, a larger one for the links in `inflated`.
    pub(crate) fn marginalised(&self, scale: f64, inflated: &[InflatedLink]) -> Marginalised<'_> {
        self.marginalised_by(&mut self.elimination(scale, inflated))
    }

    /// The problem with link errors marginalised, some of its columns reduced before.
    pub(crate) fn marginalised_by(
        &self,
        elimination: &mut NuisanceElimination,
    ) -> Marginalised<'_> {
        let count = self.columns.len();
        let NuisanceElimination { reduced, gram, rhs, .. } = elimination;
        let known = gram.len();
        gram.extend_from_slice(&self.gram[known..]);
        rhs.extend_from_slice(&self.rhs[known..]);
        for column in self.held_columns().filter(|k| *k >= known) {
            gram[column][column] += 1.0 / self.observations.weights.share;
        }
        let mut square = self.square;
        if let Some(prior) = &elimination.prior {
            let Prior { weight, cholesky, w_y, directions } = &**prior;
            let reduce = |k: usize| cholesky.forward(&self.along(directions, k));
            if known == 0 {
                reduced.par_extend((0..count).into_par_iter().map(reduce));
                let matrix = Mat::from_fn(directions.len(), count, |i, j| reduced[j][i]);
                let correction = matrix.transpose() * &matrix;
                for (k, row) in gram.iter_mut().enumerate() {
                    for (l, product) in row.iter_mut().enumerate() {
                        *product -= weight * correction[(k, l)];
                    }
                }
            } else {
                reduced.extend((known..count).map(reduce));
                for (k, row) in gram.iter_mut().enumerate().skip(known) {
                    for (product, other) in row.iter_mut().zip(reduced.iter()) {
                        *product -= weight * dot(&reduced[k], other);
                    }
                }
            }
            let reduced_y = cholesky.forward(w_y);
            for (product, reduced) in rhs.iter_mut().zip(reduced.iter()).skip(known) {
                *product -= weight * dot(reduced, &reduced_y);
            }
            square -= weight * dot(&reduced_y, &reduced_y);
        }
        let norm = (0..count).map(|k| gram[k][k].max(f64::MIN_POSITIVE).sqrt()).collect();
        Marginalised {
            problem: self,
            scale: elimination.scale,
            inflated: elimination.inflated.clone(),
            gram: gram.clone(),
            rhs: rhs.clone(),
            square,
            effective_rows: self.observations.effective(),
            log_determinant: elimination.log_determinant,
            norm,
            prior: elimination.prior.clone(),
            of_size_one: self.columns_of_size_one().collect(),
        }
    }

    /// Columns whose coefficients have a prior of deviation 1: directions of a smooth term that a block of the
    /// recordings does not visit stay at 0 there.
    fn held_columns(&self) -> impl Iterator<Item = usize> {
        let described =
            |candidate: &&Candidate| matches!(candidate.kind, CandidateKind::SmoothDirections(_));
        self.candidates
            .iter()
            .filter(described)
            .flat_map(|candidate| candidate.columns.iter().copied())
    }

    /// Columns whose coefficient is 1.
    fn columns_of_size_one(&self) -> impl Iterator<Item = usize> {
        self.candidates
            .iter()
            .filter(|candidate| candidate.is_of_size_one)
            .map(|candidate| candidate.columns[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::candidate::Location;
    use crate::design::candidate::SmoothDirections;
    use crate::design::link_error_prior::LinkErrorPrior;
    use crate::design::observations::Observations;
    use armident_effects::ViscousFriction;
    use armident_model::SmoothBasis;
    use armident_motion::BAND_HZ;
    use armident_motion::BandMotion;
    use armident_recording::{JointChannels, Recording};

    /// A hinge that swings for 10 s.
    fn swinging() -> Observations {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) / 200.0).collect();
        let position = Some(time.iter().map(|t| (3.0 * t).sin()).collect());
        let joint = JointChannels { position, ..JointChannels::new("hinge") };
        let recording = Recording::new("made", time, vec![joint]).unwrap();
        let signals = BandMotion::below(&recording, &["hinge".to_owned()], BAND_HZ).unwrap();
        Observations::new(&[signals], &[vec![vec![1.0]]])
    }

    fn candidate(kind: CandidateKind, columns: Vec<usize>) -> Candidate {
        Candidate {
            kind,
            location: Location::default(),
            shape: Vec::new(),
            columns,
            searched: 0,
            places: Vec::new(),
            transform: None,
            hidden: Vec::new(),
            above_band: 1.0,
            is_of_size_one: false,
        }
    }

    /// A column whose coefficient is 1 is taken from the efforts, and all others are fitted to the rest.
    #[test]
    fn unit_coefficient_column_is_subtracted_from_efforts() {
        let rows = swinging();
        let along = |of: &dyn Fn(f64) -> f64| -> JointColumns {
            vec![(0..rows.len()).map(|row| of(row as f64)).collect()]
        };
        let columns = vec![
            along(&|x| (0.1 * x).sin()),
            along(&|x| (0.13 * x).cos()),
            along(&|x| (0.07 * x).sin()),
        ];
        let effort = along(&|x| 2.0 * (0.1 * x).sin() + 0.3 * (0.13 * x).cos() + (0.11 * x).sin());
        let rest: JointColumns =
            vec![effort[0].iter().zip(&columns[0][0]).map(|(effort, one)| effort - one).collect()];
        let problem = |effort: &JointColumns| {
            let mut problem = LinearProblem::new(
                rows.clone(),
                effort.clone(),
                Vec::new(),
                LinkErrorPrior::default(),
            );
            problem.push_columns(columns.clone());
            for column in 0..columns.len() {
                problem
                    .candidates
                    .push(candidate(CandidateKind::Law(&ViscousFriction), vec![column]));
            }
            problem
        };
        let mut fixed = problem(&effort);
        fixed.candidates[0].is_of_size_one = true;
        let fixed = fixed.marginalised(0.0, &[]);
        let fit = fixed.fit(vec![0, 1]).unwrap();
        let expected = problem(&rest);
        let expected = expected.marginalised(0.0, &[]);
        let of_rest = expected.fit(vec![1]).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1.0);
        assert_eq!(fit.coefficient(0), 1.0);
        assert!(near(fit.coefficient(1), of_rest.coefficient(1)));
        assert!(near(fit.sum_of_squares, of_rest.sum_of_squares));
        assert!(near(fixed.gain(&fit, &[2]), expected.gain(&of_rest, &[2])));
        assert_eq!(fixed.covariance(&fit, &[0, 1])[0], [0.0, 0.0]);
        // a zero column has no coefficient and no standard error
        let mut idle = problem(&effort);
        let first = idle.push_columns(vec![vec![Vec::new()]]);
        idle.candidates.push(candidate(CandidateKind::Law(&ViscousFriction), vec![first]));
        let idle = idle.marginalised(0.0, &[]);
        let of_idle = idle.fit(vec![0, first]).unwrap();
        assert_eq!(of_idle.coefficient(first), 0.0);
        let covariance = idle.covariance(&of_idle, &[0, first]);
        assert!(covariance[0][0] > 0.0 && covariance[0][1] == 0.0 && covariance[1] == [0.0, 0.0]);
        let (left, left_of_rest) = (fixed.residual(&fit), expected.residual(&of_rest));
        assert!(left[0].iter().zip(&left_of_rest[0]).all(|(a, b)| near(*a, *b)));
    }

    /// Two collinear directions of a smooth term stay within their prior; columns of a law, which have none, do not.
    #[test]
    fn collinear_smooth_terms_stay_within_their_prior() {
        let rows = swinging();
        let along = |of: &dyn Fn(f64) -> f64| -> JointColumns {
            vec![(0..rows.len()).map(|row| of(row as f64)).collect()]
        };
        let effort = along(&|x| (7.3 * x * x).sin());
        let largest = |kind: CandidateKind| {
            let mut problem = LinearProblem::new(
                rows.clone(),
                effort.clone(),
                Vec::new(),
                LinkErrorPrior::default(),
            );
            let first = problem.push_columns(vec![
                along(&|x| (0.1 * x).sin()),
                along(&|x| (0.1 * x).sin() + 1e-3 * (0.37 * x).cos()),
            ]);
            problem.candidates.push(candidate(kind, vec![first, first + 1]));
            let metric = problem.marginalised(0.0, &[]);
            let fit = metric.fit(metric.columns_of(&[0])).unwrap();
            fit.coefficients.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        let basis = SmoothBasis { factors: Vec::new(), axes: Vec::new() };
        let described = largest(CandidateKind::SmoothDirections(SmoothDirections {
            basis,
            transform: Vec::new(),
        }));
        assert!(described < 3.0, "{described}");
        let of_law = largest(CandidateKind::Law(&ViscousFriction));
        assert!(of_law > 10.0, "{of_law}");
    }
}
