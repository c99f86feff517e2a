//! How far the coefficients of an answer can be trusted, and what of it they leave certain.

use std::collections::BTreeMap;

use armident_numeric::Cholesky;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::crossval::stretches;
use crate::evidence::OperatingPoint;
use crate::material::{answer_without, held};
use crate::problem::{Group, Meaning, Problem};
use crate::search::Answer;
use crate::whitened::Whitened;

/// Stretches of a recording that are left out one after the other for a standard error.
const LEFT_OUT_PER_RECORDING: usize = 5;
/// A change is not named where nothing is, by its own standard errors, as far from nothing this often.
const CHANCE: f64 = 1e-3;

/// How coefficients scatter when stretches of the recordings are left out: what a model leaves over lasts longer
/// than noise, and is more. And what the clocks are not known by does to them.
pub(crate) struct Scatter {
    /// by column: variance of a delete-a-block jackknife
    variance: BTreeMap<usize, f64>,
    /// by how much more is left over than the weights say
    left_over: f64,
    /// the problem of the answer's groups, in their order, with efforts that are later by what is not known of it;
    /// none where the lag is part of the answer
    pub(crate) late: Option<Problem>,
    /// by column: change of the coefficient by that
    by_lag: BTreeMap<usize, f64>,
}

impl Scatter {
    /// Of the coefficients of an answer, efforts and positions read at the same time.
    fn of(metric: &Whitened<'_>, of: &Answer) -> Self {
        let problem = metric.problem;
        let rows = &problem.rows;
        let (small, ids) = problem.restricted(&of.set);
        let starts = &rows.starts[rows.changed_from..];
        let fits: Vec<_> = stretches(starts, LEFT_OUT_PER_RECORDING)
            .into_par_iter()
            .filter_map(|inside| {
                let fitted = small.of_rows(|row| !inside.contains(&row));
                let metric = fitted.whitened(metric.scale, &metric.wide);
                metric.fit(metric.columns_of(&ids))
            })
            .collect();
        let count = fits.len() as f64;
        let mut variance = BTreeMap::new();
        for (column, here) in pairs_of_columns(problem, of, &small) {
            let values: Vec<f64> = fits.iter().map(|fit| fit.coefficient(here)).collect();
            let mean = values.iter().sum::<f64>() / count;
            let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
            variance.insert(column, (count - 1.0) / count * squares);
        }
        let left_over = (of.fit.sum_of_squares / rows.effective()).sqrt();
        Self { variance, left_over, late: None, by_lag: BTreeMap::new() }
    }

    /// Of the coefficients of an answer. `step_s` between samples as recorded \[s\]: within it nobody knows which
    /// of position and effort was read first, and sensors of effort filter.
    pub(crate) fn with_lag(metric: &Whitened<'_>, of: &Answer, step_s: f64) -> Self {
        let problem = metric.problem;
        // any instant in the step, so its standard deviation
        let late = late_efforts(problem, of, -step_s / 12.0_f64.sqrt());
        let by_lag = late.as_ref().and_then(|late| {
            let ids: Vec<usize> = (0..of.set.len()).collect();
            let metric = late.whitened(metric.scale, &metric.wide);
            let fit = metric.fit(metric.columns_of(&ids))?;
            let columns = pairs_of_columns(problem, of, late);
            let by_lag =
                |(c, here): (usize, usize)| (c, fit.coefficient(here) - of.fit.coefficient(c));
            Some(columns.map(by_lag).collect())
        });
        Self { late, by_lag: by_lag.unwrap_or_default(), ..Self::of(metric, of) }
    }

    /// By how much more a coefficient of a group scatters than its covariance says, 1 or more. A window is in one
    /// stretch: there it is by how much more is left over.
    fn factor(&self, group: &Group, column: usize, covariance: f64) -> f64 {
        let factor = match group.site.window {
            Some(_) => self.left_over,
            None => self.variance.get(&column).map_or(1.0, |v| (v / covariance).sqrt()),
        };
        if factor.is_finite() { factor.max(1.0) } else { 1.0 }
    }

    /// Covariance of the coefficients of a group, and the largest factor that it was widened by.
    pub(crate) fn covariance(
        &self,
        metric: &Whitened<'_>,
        of: &Answer,
        group: &Group,
    ) -> (Vec<Vec<f64>>, f64) {
        let mut covariance = metric.covariance(&of.fit, &group.columns);
        let factors: Vec<f64> = (group.columns.iter().enumerate())
            .map(|(k, &column)| self.factor(group, column, covariance[k][k]))
            .collect();
        let by_lag = |k: usize| self.by_lag.get(&group.columns[k]).copied().unwrap_or(0.0);
        for (k, row) in covariance.iter_mut().enumerate() {
            for (l, x) in row.iter_mut().enumerate() {
                *x = *x * factors[k] * factors[l] + by_lag(k) * by_lag(l);
            }
        }
        (covariance, factors.into_iter().fold(1.0, f64::max))
    }
}

/// Columns of an answer, and the same in a problem restricted to it, whose groups have its order.
fn pairs_of_columns<'a>(
    problem: &'a Problem,
    of: &'a Answer,
    small: &'a Problem,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    of.set.iter().zip(&small.groups).flat_map(|(&g, here)| {
        problem.groups[g].columns.iter().copied().zip(here.columns.iter().copied())
    })
}

/// The problem of an answer's groups with so much lag \[s\] added to its efforts: none where a lag is part of
/// the answer, and where only a change is sought, before which they were as late.
fn late_efforts(problem: &Problem, of: &Answer, lag_s: f64) -> Option<Problem> {
    let is_lag = |g: &usize| problem.groups[*g].slug() == "time_delay";
    if problem.rows.changed_from > 0 || of.set.iter().any(is_lag) {
        return None;
    }
    let lag = (0..problem.groups.len()).find(is_lag)?;
    // the lag comes last, so that the others have the ids they have without it
    let (small, ids) = problem.restricted(&[&of.set[..], &[lag]].concat());
    let column = small.groups[*ids.last()?].columns.first()?;
    Some(small.with_added(&[(*column, lag_s)]))
}

/// Removes changes that may be none by the standard errors of their own coefficients, the most doubtful first: what
/// is material and helps in a few seconds may still be anything. That an arm has friction is no such question.
pub(crate) fn certain(metric: &Whitened<'_>, mut of: Answer, point: &OperatingPoint) -> Answer {
    loop {
        let scatter = Scatter::of(metric, &of);
        let doubt = |&g: &usize| Some((chance(metric, &of, g, &scatter, point)?, g));
        let most = of.set.iter().filter_map(doubt).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, g)) = most.filter(|(chance, _)| *chance > CHANCE) else { return of };
        match answer_without(metric, &of, g) {
            Some(next) => of = next,
            None => return of,
        }
    }
}

/// Probability that coefficients of nothing are as far from zero as those of a law: all of them together, or one of
/// them alone. None of a description, whose many coefficients stand for one another where stretches are left out.
fn chance(
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
    scatter: &Scatter,
    point: &OperatingPoint,
) -> Option<f64> {
    let group = &metric.problem.groups[group];
    if let Meaning::Flexible(_) = group.meaning {
        return None;
    }
    let mut coefficients = of.fit.of_group(group);
    for (column, amount) in held(group, point) {
        let place = group.columns.iter().position(|c| *c == column)?;
        coefficients[place] += amount;
    }
    let (covariance, _) = scatter.covariance(metric, of, group);
    let count = coefficients.len();
    let cholesky = Cholesky::of(count, |i, j| covariance[i][j])?;
    let tail = |squares: f64, freedom: usize| -> Option<f64> {
        Some(ChiSquared::new(freedom as f64).ok()?.sf(squares))
    };
    let together = cholesky.forward(&coefficients).iter().map(|x| x * x).sum();
    let largest =
        (0..count).map(|k| coefficients[k].powi(2) / covariance[k][k]).fold(0.0, f64::max);
    Some(tail(together, count)?.min(count as f64 * tail(largest, 1)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made::{evidence, ur5};
    use crate::search::answer;

    /// An offset that is there stays, and those that are fitted to noise go, whatever else is in the answer.
    #[test]
    fn what_may_be_nothing_goes() {
        let chain = ur5();
        let evidence = evidence(&chain, &chain, |j, _| if j == 2 { 0.3 } else { 0.0 });
        let point = OperatingPoint::of(evidence.joints());
        let problem = evidence.problem(&point);
        let on = |joint: usize| {
            let is = |g: &Group| g.slug() == "torque_offset" && g.site.joints == [joint];
            problem.groups.iter().position(is).unwrap()
        };
        let metric = problem.whitened(0.0, &[]);
        let all = answer(&metric, (0..evidence.joints()).map(on).collect()).unwrap();
        let scatter = Scatter::of(&metric, &all);
        let of = |joint: usize| chance(&metric, &all, on(joint), &scatter, &point).unwrap();
        assert!(of(2) < 1e-9 && of(4) > CHANCE, "{} {}", of(2), of(4));
        assert_eq!(certain(&metric, all, &point).set, [on(2)]);
    }
}
