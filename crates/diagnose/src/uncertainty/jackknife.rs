//! Standard errors of the coefficients of an estimate.
//!
//! Method: delete-a-block jackknife, because residuals are autocorrelated, beside the covariance of the fit; the uncertain
//! delay of the efforts and the searched constants are added.
//! References: H. R. Künsch, The jackknife and the bootstrap for general stationary observations, Annals of Statistics 17(3),
//! 1989.

use crate::regression::folds::LEFT_OUT_PER_RECORDING;
use armident_effects::{LinkSide, OperatingTerm};
use armident_inference::{time_blocks, variance};
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::design::candidate::Candidate;
use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;
use crate::uncertainty::profile_curvature::{ProfileCurvature, profile_curvature};

/// Mass and first moment: the first standard parameters of a link.
const MOMENTS: usize = 4;

/// Block-jackknife variances of the coefficients of an estimate, and their changes with the uncertain effort delay.
pub(crate) struct Jackknife {
    /// by column: variance of a delete-a-block jackknife
    variance: BTreeMap<usize, f64>,
    /// residual over that of the weights
    residual_ratio: f64,
    /// the problem of the estimate's candidates, in their order, with efforts delayed by the standard deviation of the delay;
    /// none where the delay is part of the estimate
    late: Option<LinearProblem>,
    /// by column: change of the coefficient by that
    by_lag: BTreeMap<usize, f64>,
    /// by column: change of the coefficient where the reference does not determine it
    by_reference: BTreeMap<usize, f64>,
    /// of the candidates whose constants were searched
    shapes: Vec<ProfileCurvature>,
    /// by inflated link: variances of its mass and first moment
    links: BTreeMap<usize, Vec<f64>>,
    /// blocks that were left out
    blocks: usize,
}

impl Jackknife {
    /// Of the coefficients of an estimate, efforts and positions read at the same time.
    pub(crate) fn of(metric: &Marginalised<'_>, of: &Estimate) -> Self {
        let problem = metric.problem;
        let rows = &problem.observations;
        let (small, ids) = problem.restricted(&of.set);
        let starts = &rows.starts[rows.comparison.first_judged()..];
        let (fits, errors): (Vec<_>, Vec<_>) = time_blocks(starts, LEFT_OUT_PER_RECORDING)
            .into_par_iter()
            .filter_map(|inside| {
                let fitted = small.of_rows(|row| !inside.contains(&row));
                let metric = fitted.marginalised(metric.scale, &metric.inflated);
                let fit = metric.fit(metric.columns_of(&ids))?;
                let errors = metric.inertial_errors(&fit);
                Some((fit, errors))
            })
            .unzip();
        let of_link = |link: usize| -> Vec<f64> {
            let of = |p: usize| -> Vec<f64> { errors.iter().map(|e| e[10 * link + p]).collect() };
            (0..MOMENTS).map(|p| variance(&of(p))).collect()
        };
        let links = metric.inflated.iter().map(|body| (body.link, of_link(body.link))).collect();
        let mut variances = BTreeMap::new();
        for (column, here) in pairs_of_columns(problem, of, &small) {
            let values: Vec<f64> = fits.iter().map(|fit| fit.coefficient(here)).collect();
            variances.insert(column, variance(&values));
        }
        let residual_ratio = (of.fit.sum_of_squares / rows.effective()).sqrt();
        let (by_lag, by_reference) = (BTreeMap::new(), BTreeMap::new());
        Self {
            variance: variances,
            residual_ratio,
            late: None,
            by_lag,
            by_reference,
            shapes: Vec::new(),
            links,
            blocks: fits.len(),
        }
    }

    /// Of the coefficients of an estimate. `step_s` is the sample interval \[s\]: the order of
    /// reading position and effort within it is unknown, and effort sensors filter.
    pub(crate) fn with_lag(metric: &Marginalised<'_>, of: &Estimate, step_s: f64) -> Self {
        let problem = metric.problem;
        // any instant in the step, so its standard deviation
        let late = late_efforts(problem, of, -step_s / 12.0_f64.sqrt());
        let by_lag = late.as_ref().and_then(|late| {
            let ids: Vec<usize> = (0..of.set.len()).collect();
            let metric = late.marginalised(metric.scale, &metric.inflated);
            let fit = metric.fit(metric.columns_of(&ids))?;
            let columns = pairs_of_columns(problem, of, late);
            let by_lag =
                |(c, here): (usize, usize)| (c, fit.coefficient(here) - of.fit.coefficient(c));
            Some(columns.map(by_lag).collect())
        });
        Self { late, by_lag: by_lag.unwrap_or_default(), ..Self::of(metric, of) }
    }

    /// The jackknife with the uncertainty of searched constants, which all coefficients share.
    pub(crate) fn with_shapes(
        mut self,
        design: &Design<'_>,
        at: &[Posed<'_>],
        metric: &Marginalised<'_>,
        of: &Estimate,
    ) -> Self {
        // the sum of squares is too jagged for a curvature where a link bounces in a gap
        let smooth = |g: &&usize| {
            let candidate = &metric.problem.candidates[**g];
            !candidate.has_link_side(LinkSide::Play)
                && candidate.location.window.is_none()
                && !candidate.shape.is_empty()
        };
        let jackknife = |g: &usize| {
            let (_, wider) = self.covariance(metric, of, &metric.problem.candidates[*g]);
            profile_curvature(design, at, metric, of, *g, self.late.as_ref(), wider)
        };
        self.shapes = of.set.iter().filter(smooth).filter_map(jackknife).collect();
        self
    }

    /// Covariance of the coefficients of a candidate and, after them, of its shape constants.
    pub(crate) fn joint_covariance(
        &self,
        metric: &Marginalised<'_>,
        of: &Estimate,
        id: usize,
    ) -> Vec<Vec<f64>> {
        let candidate = &metric.problem.candidates[id];
        let (linear, _) = self.covariance(metric, of, candidate);
        let (coefficients, count) = (linear.len(), linear.len() + candidate.shape.len());
        let mut covariance = vec![vec![0.0; count]; count];
        for (row, of_row) in covariance.iter_mut().zip(&linear) {
            row[..coefficients].copy_from_slice(of_row);
        }
        let mut lag = changes(&self.by_lag, candidate);
        lag.resize(count, 0.0);
        for shape in &self.shapes {
            // change of each coefficient with each searched constant
            let slopes: Vec<Vec<f64>> = (0..count)
                .map(|k| match candidate.columns.get(k) {
                    Some(column) => shape.slopes[column].clone(),
                    None => {
                        let own = |c: &usize| shape.candidate == id && *c + coefficients == k;
                        shape.constants.iter().map(|c| f64::from(u8::from(own(c)))).collect()
                    }
                })
                .collect();
            for (k, row) in covariance.iter_mut().enumerate() {
                for (l, x) in row.iter_mut().enumerate() {
                    for (a, of_a) in shape.covariance.iter().enumerate() {
                        for (b, between) in of_a.iter().enumerate() {
                            *x += slopes[k][a] * slopes[l][b] * between;
                        }
                    }
                }
            }
            for (lag, slopes) in lag.iter_mut().zip(&slopes) {
                *lag += slopes.iter().zip(&shape.by_lag).map(|(s, by)| s * by).sum::<f64>();
            }
        }
        // the lag moves all of them together
        for (k, row) in covariance.iter_mut().enumerate() {
            for (l, x) in row.iter_mut().enumerate() {
                *x += lag[k] * lag[l];
            }
        }
        covariance
    }

    /// Degrees of freedom of its variances.
    pub(crate) fn freedom(&self) -> f64 {
        self.blocks.saturating_sub(1).max(1) as f64
    }

    /// Covariance of mass and first moment of an inflated link, in its driving-axis frame: that of the fit, widened to
    /// the jackknife variance where that is larger.
    pub(crate) fn covariance_of_link(
        &self,
        metric: &Marginalised<'_>,
        link: usize,
    ) -> Vec<Vec<f64>> {
        let moments: Vec<usize> = (10 * link..10 * link + MOMENTS).collect();
        let mut covariance = metric.inertial_covariance(&moments);
        let factor = |p: usize| {
            let variance = self.links.get(&link).map_or(0.0, |of| of[p]);
            let ratio = (variance / covariance[p][p]).sqrt();
            if ratio.is_finite() { ratio.max(1.0) } else { 1.0 }
        };
        let factors: Vec<f64> = (0..MOMENTS).map(factor).collect();
        for (a, row) in covariance.iter_mut().enumerate() {
            for (b, x) in row.iter_mut().enumerate() {
                *x *= factors[a] * factors[b];
            }
        }
        covariance
    }

    /// Widens a coefficient to this variance and change, those with the effects free that a reference does not determine.
    pub(crate) fn leave_open(&mut self, column: usize, variance: f64, change: f64) {
        let known = self.variance.entry(column).or_insert(variance);
        *known = known.max(variance);
        self.by_reference.insert(column, change);
    }

    /// Largest ratio of the jackknife variance of a candidate's coefficients to that of the fit, 1 or more. A window is in one
    /// block: there it is the residual ratio.
    fn factor(&self, candidate: &Candidate, column: usize, covariance: f64) -> f64 {
        let factor = match candidate.location.window {
            Some(_) => self.residual_ratio,
            None => self.variance.get(&column).map_or(1.0, |v| (v / covariance).sqrt()),
        };
        if factor.is_finite() { factor.max(1.0) } else { 1.0 }
    }

    /// Covariance of the coefficients of a candidate at the searched constants and with efforts on time, and the largest
    /// factor that it was widened by.
    pub(crate) fn covariance(
        &self,
        metric: &Marginalised<'_>,
        of: &Estimate,
        candidate: &Candidate,
    ) -> (Vec<Vec<f64>>, f64) {
        let mut covariance = metric.covariance(&of.fit, &candidate.columns);
        let factors: Vec<f64> = (candidate.columns.iter().enumerate())
            .map(|(k, &column)| self.factor(candidate, column, covariance[k][k]))
            .collect();
        let open = changes(&self.by_reference, candidate);
        for (k, row) in covariance.iter_mut().enumerate() {
            for (l, x) in row.iter_mut().enumerate() {
                *x *= factors[k] * factors[l];
                *x += open[k] * open[l];
            }
        }
        (covariance, factors.into_iter().fold(1.0, f64::max))
    }
}

/// Changes of the coefficients of a candidate, from those by column.
fn changes(by_column: &BTreeMap<usize, f64>, candidate: &Candidate) -> Vec<f64> {
    candidate.columns.iter().map(|column| by_column.get(column).copied().unwrap_or(0.0)).collect()
}

/// Columns of an estimate, and the same in a problem restricted to it, whose candidates have its order.
fn pairs_of_columns<'a>(
    problem: &'a LinearProblem,
    of: &'a Estimate,
    small: &'a LinearProblem,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    of.set.iter().zip(&small.candidates).flat_map(|(&g, here)| {
        problem.candidates[g].columns.iter().copied().zip(here.columns.iter().copied())
    })
}

/// The problem of an estimate's candidates with so much lag \[s\] added to its efforts: none where a lag is part of
/// the estimate, and where only a change is sought, before which they were as late.
fn late_efforts(problem: &LinearProblem, of: &Estimate, lag_s: f64) -> Option<LinearProblem> {
    let is_lag =
        |g: &usize| problem.candidates[*g].has(|law| law.operating == Some(OperatingTerm::Delay));
    if problem.observations.comparison.seeks_change() || of.set.iter().any(is_lag) {
        return None;
    }
    let lag = (0..problem.candidates.len()).find(is_lag)?;
    // the lag comes last, so that the others have the ids they have without it
    let (small, ids) = problem.restricted(&[&of.set[..], &[lag]].concat());
    let column = small.candidates[*ids.last()?].columns.first()?;
    Some(small.with_added(&[(*column, lag_s)]))
}
