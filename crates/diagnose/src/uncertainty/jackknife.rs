//! How far the coefficients of an answer can be trusted.

use crate::regression::folds::{LEFT_OUT_PER_RECORDING, stretches};
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::design::candidate::Group;
use crate::design::compliant_link::Posed;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::regression::fit_set::Answer;
use crate::regression::marginalised::Whitened;
use crate::uncertainty::profile_curvature::{ShapeScatter, shape_scatter};

/// How coefficients scatter when stretches of the recordings are left out: what a model leaves over lasts longer
/// than noise, and is more. And what the clocks are not known by does to them.
pub(crate) struct Scatter {
    /// by column: variance of a delete-a-block jackknife
    variance: BTreeMap<usize, f64>,
    /// by how much more is left over than the weights say
    left_over: f64,
    /// the problem of the answer's groups, in their order, with efforts that are later by what is not known of it;
    /// none where the lag is part of the answer
    late: Option<Problem>,
    /// by column: change of the coefficient by that
    by_lag: BTreeMap<usize, f64>,
    /// by column: change of the coefficient by what a reference leaves open
    by_reference: BTreeMap<usize, f64>,
    /// of the groups whose constants were searched
    shapes: Vec<ShapeScatter>,
}

impl Scatter {
    /// Of the coefficients of an answer, efforts and positions read at the same time.
    pub(crate) fn of(metric: &Whitened<'_>, of: &Answer) -> Self {
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
        let (by_lag, by_reference) = (BTreeMap::new(), BTreeMap::new());
        Self { variance, left_over, late: None, by_lag, by_reference, shapes: Vec::new() }
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

    /// The same where constants that were searched are uncertain too: all coefficients are by that.
    pub(crate) fn with_shapes(
        mut self,
        evidence: &Evidence<'_>,
        at: &[Posed<'_>],
        metric: &Whitened<'_>,
        of: &Answer,
    ) -> Self {
        // of a link that bounces in a gap the misfit is too jagged to say how much
        let smooth = |g: &&usize| {
            let group = &metric.problem.groups[**g];
            group.slug() != "backlash" && group.site.window.is_none() && !group.shape.is_empty()
        };
        let scatter = |g: &usize| {
            let (_, wider) = self.covariance(metric, of, &metric.problem.groups[*g]);
            shape_scatter(evidence, at, metric, of, *g, self.late.as_ref(), wider)
        };
        self.shapes = of.set.iter().filter(smooth).filter_map(scatter).collect();
        self
    }

    /// Covariance of the coefficients of a group and, after them, of its shape constants.
    pub(crate) fn joint_covariance(
        &self,
        metric: &Whitened<'_>,
        of: &Answer,
        id: usize,
    ) -> Vec<Vec<f64>> {
        let group = &metric.problem.groups[id];
        let (linear, _) = self.covariance(metric, of, group);
        let (coefficients, count) = (linear.len(), linear.len() + group.shape.len());
        let mut covariance = vec![vec![0.0; count]; count];
        for (row, of_row) in covariance.iter_mut().zip(&linear) {
            row[..coefficients].copy_from_slice(of_row);
        }
        let mut lag = changes(&self.by_lag, group);
        lag.resize(count, 0.0);
        for shape in &self.shapes {
            // what each number changes by with each searched constant
            let slopes: Vec<Vec<f64>> = (0..count)
                .map(|k| match group.columns.get(k) {
                    Some(column) => shape.slopes[column].clone(),
                    None => {
                        let own = |c: &usize| shape.group == id && *c + coefficients == k;
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

    /// A coefficient has this variance, and changes by so much, where what a reference leaves open is free.
    pub(crate) fn leave_open(&mut self, column: usize, variance: f64, change: f64) {
        let known = self.variance.entry(column).or_insert(variance);
        *known = known.max(variance);
        self.by_reference.insert(column, change);
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

    /// Covariance of the coefficients of a group at the searched constants and with efforts on time, and the largest
    /// factor that it was widened by.
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
        let open = changes(&self.by_reference, group);
        for (k, row) in covariance.iter_mut().enumerate() {
            for (l, x) in row.iter_mut().enumerate() {
                *x *= factors[k] * factors[l];
                *x += open[k] * open[l];
            }
        }
        (covariance, factors.into_iter().fold(1.0, f64::max))
    }
}

/// Changes of the coefficients of a group, from those by column.
fn changes(by_column: &BTreeMap<usize, f64>, group: &Group) -> Vec<f64> {
    group.columns.iter().map(|column| by_column.get(column).copied().unwrap_or(0.0)).collect()
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
