//! Covariance of the searched constants of a law (its shape).
//!
//! Method: curvature of the profile sum of squares, all coefficients refitted at each value; widened where blocks of the
//! recordings disagree about its slope (sandwich estimator).
//! References: G. A. F. Seber, C. J. Wild, Nonlinear regression, 1989; H. White, Maximum likelihood estimation of misspecified
//! models, Econometrica 50(1), 1982.

use armident_effects::Effect;
use armident_inference::time_blocks;
use std::collections::BTreeMap;
use std::ops::Range;

use armident_numeric::{Cholesky, dot};

use crate::design::candidate::Candidate;
use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::rebuild::{continuous, formed};
use crate::design::training::Design;
use crate::regression::fit_set::Estimate;
use crate::regression::folds::LEFT_OUT_PER_RECORDING;
use crate::regression::marginalised::{LeastSquaresFit, Marginalised};

/// Steps towards a standard deviation; near enough to the curvature once the first one was that.
const ROUNDS: usize = 3;

/// Covariance of the shape constants of a candidate, and its effect on the coefficients.
#[derive(Debug, Clone)]
pub(crate) struct ProfileCurvature {
    /// the candidate
    pub(crate) candidate: usize,
    /// which of its constants; along the others the sum of squares has no minimum
    pub(crate) constants: Vec<usize>,
    /// covariance of these, from the curvature of the profile sum of squares, or where that is more from the disagreement of
    /// blocks: the error of a simulated link is autocorrelated
    pub(crate) covariance: Vec<Vec<f64>>,
    /// their change with efforts delayed by the standard deviation of the delay
    pub(crate) by_lag: Vec<f64>,
    /// by column of the problem: change of the coefficient over that of each constant
    pub(crate) slopes: BTreeMap<usize, Vec<f64>>,
}

/// Of a candidate of an estimate; none where it has no shape, or the sum of squares no minimum. `late`: the problem of the
/// estimate's candidates with delayed efforts. `least_factor`: jackknife over curvature variance of the candidate's
/// coefficients, 1 or more.
pub(crate) fn profile_curvature(
    design: &Design<'_>,
    at: &[Posed<'_>],
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    late: Option<&LinearProblem>,
    least_factor: f64,
) -> Option<ProfileCurvature> {
    let original = &metric.problem.candidates[candidate];
    let law = original.law()?;
    let place = of.set.iter().position(|g| *g == candidate)?;
    let (small, set) = metric.problem.restricted(&of.set);
    let mut trials = Trials { design, at, metric, of, law, original, place, small, set };
    let middle = trials.moved_by(&[])?.discrepancy.whole;
    let along: Vec<Along> =
        (0..continuous(original)).filter_map(|k| trials.along(k, middle)).collect();
    if along.is_empty() {
        return None;
    }
    let inverse = inverse_or_each_alone(&trials.hessian(&along, middle)?);
    let by_lag = match late {
        None => vec![0.0; along.len()],
        Some(late) => {
            let (small, set) = (late.clone(), (0..of.set.len()).collect());
            let mut late = Trials { small, set, ..trials };
            times(&inverse, &late.less_slope(&along)?)
        }
    };
    Some(ProfileCurvature {
        candidate,
        covariance: covariance(&inverse, &along, least_factor),
        by_lag,
        slopes: slopes_of_coefficients(&along),
        constants: along.iter().map(|along| along.constant).collect(),
    })
}

/// Sum of squares at a shape: of all rows, and of every block.
struct ProfileSquares {
    whole: f64,
    by_block: Vec<f64>,
}

impl ProfileSquares {
    fn of(metric: &Marginalised<'_>, fit: &LeastSquaresFit) -> Self {
        let rows = &metric.problem.observations;
        let residual = metric.residual(fit);
        let in_block = |inside: Range<usize>| -> f64 {
            let squares = residual.iter().map(|r| dot(&r[inside.clone()], &r[inside.clone()]));
            rows.weights.share * squares.sum::<f64>()
        };
        let blocks =
            time_blocks(&rows.starts[rows.comparison.first_judged()..], LEFT_OUT_PER_RECORDING);
        Self {
            whole: rows.weights.share * fit.sum_of_squares,
            by_block: blocks.into_iter().map(in_block).collect(),
        }
    }
}

/// A fit with the shape of a candidate moved.
struct Moved {
    discrepancy: ProfileSquares,
    /// by column of the problem
    coefficients: BTreeMap<usize, f64>,
}

/// Along one constant: a step of about its standard deviation, and the fits on both sides.
struct Along {
    constant: usize,
    step: f64,
    curvature: f64,
    sides: [Moved; 2],
}

impl Along {
    /// Slope of a number of both sides.
    fn slope(&self, of: impl Fn(&Moved) -> f64) -> f64 {
        let [below, above] = self.sides.each_ref().map(of);
        (above - below) / (2.0 * self.step)
    }
}

/// Profile of one candidate's shape, coefficients refitted at each value.
struct Trials<'a, 'e> {
    design: &'a Design<'e>,
    at: &'a [Posed<'e>],
    metric: &'a Marginalised<'a>,
    of: &'a Estimate,
    law: &'static dyn Effect,
    original: &'a Candidate,
    /// place of the candidate in the estimate
    place: usize,
    /// problem of the estimate's candidates alone
    small: LinearProblem,
    /// these in the order of the estimate
    set: Vec<usize>,
}

impl Trials<'_, '_> {
    /// With some constants moved by these steps.
    fn moved_by(&mut self, steps: &[(usize, f64)]) -> Option<Moved> {
        let mut moved = self.original.clone();
        steps.iter().for_each(|(k, step)| moved.shape[*k] += step);
        let mut set = self.set.clone();
        set[self.place] = formed(self.design, self.at, &mut self.small, self.law, &moved)?;
        let metric = self.small.marginalised(self.metric.scale, &self.metric.inflated);
        let fit = metric.fit(metric.columns_of(&set))?;
        let pairs = self.of.set.iter().zip(&set).flat_map(|(&g, &here)| {
            let columns = self.metric.problem.candidates[g].columns.iter();
            columns.copied().zip(self.small.candidates[here].columns.iter().copied())
        });
        let coefficients = pairs.map(|(column, here)| (column, fit.coefficient(here))).collect();
        Some(Moved { discrepancy: ProfileSquares::of(&metric, &fit), coefficients })
    }

    /// Along a constant; none where the sum of squares has no minimum.
    fn along(&mut self, constant: usize, middle: f64) -> Option<Along> {
        let size = self.original.shape[constant].abs();
        let mut step = 1e-2 * size.max(f64::MIN_POSITIVE);
        let mut found = None;
        for _ in 0..ROUNDS {
            let mut side = |step: f64| self.moved_by(&[(constant, step)]);
            let (Some(below), Some(above)) = (side(-step), side(step)) else { break };
            let sides = [below, above];
            let [below, above] = sides.each_ref().map(|side| side.discrepancy.whole);
            let curvature = (above + below - 2.0 * middle) / (step * step);
            if curvature <= 0.0 {
                break;
            }
            let wanted = (2.0 / curvature).sqrt().min(0.3 * size);
            found = Some(Along { constant, step, curvature, sides });
            step = wanted;
        }
        found
    }

    /// Second derivatives of the sum of squares.
    fn hessian(&mut self, along: &[Along], middle: f64) -> Option<Vec<Vec<f64>>> {
        let count = along.len();
        let mut hessian = vec![vec![0.0; count]; count];
        for a in 0..count {
            hessian[a][a] = along[a].curvature;
            for b in 0..a {
                let (one, other) = (&along[a], &along[b]);
                let mut corner = |sign: f64| -> Option<f64> {
                    let steps =
                        [(one.constant, sign * one.step), (other.constant, sign * other.step)];
                    Some(self.moved_by(&steps)?.discrepancy.whole)
                };
                let corners = corner(-1.0)? + corner(1.0)?;
                let on_axes: f64 = [one, other]
                    .iter()
                    .flat_map(|a| &a.sides)
                    .map(|side| side.discrepancy.whole)
                    .sum();
                let mixed = (corners - on_axes + 2.0 * middle) / (2.0 * one.step * other.step);
                hessian[a][b] = mixed;
                hessian[b][a] = mixed;
            }
        }
        Some(hessian)
    }

    /// Slope of the sum of squares along each constant.
    fn less_slope(&mut self, along: &[Along]) -> Option<Vec<f64>> {
        let mut slopes = Vec::new();
        for along in along {
            let mut side = |sign: f64| -> Option<f64> {
                Some(self.moved_by(&[(along.constant, sign * along.step)])?.discrepancy.whole)
            };
            let here = (side(1.0)? - side(-1.0)?) / (2.0 * along.step);
            slopes.push(along.slope(|side| side.discrepancy.whole) - here);
        }
        Some(slopes)
    }
}

/// Covariance of the constants, each widened by the disagreement of blocks about the slope of the sum of squares.
fn covariance(inverse: &[Vec<f64>], along: &[Along], least_factor: f64) -> Vec<Vec<f64>> {
    let count = along.len();
    let by_block: Vec<Vec<f64>> = (0..along[0].sides[0].discrepancy.by_block.len())
        .map(|k| {
            along.iter().map(|along| along.slope(|side| side.discrepancy.by_block[k])).collect()
        })
        .collect();
    let mean = |k: usize| by_block.iter().map(|s| s[k]).sum::<f64>() / by_block.len() as f64;
    let means: Vec<f64> = (0..count).map(mean).collect();
    let mut by_blocks = vec![0.0; count];
    for slope in &by_block {
        let off: Vec<f64> = slope.iter().zip(&means).map(|(s, m)| s - m).collect();
        for (sum, moved) in by_blocks.iter_mut().zip(times(inverse, &off)) {
            *sum += moved * moved;
        }
    }
    let factors: Vec<f64> = (0..count)
        .map(|k| (by_blocks[k] / (2.0 * inverse[k][k])).sqrt().max(least_factor))
        .collect();
    let entry = |a: usize, b: usize| 2.0 * inverse[a][b] * factors[a] * factors[b];
    (0..count).map(|a| (0..count).map(|b| entry(a, b)).collect()).collect()
}

/// By column: change of the coefficient over that of each constant.
fn slopes_of_coefficients(along: &[Along]) -> BTreeMap<usize, Vec<f64>> {
    let columns = along[0].sides[0].coefficients.keys();
    let slopes = |column: &usize| -> Vec<f64> {
        along.iter().map(|along| along.slope(|side| side.coefficients[column])).collect()
    };
    columns.map(|column| (*column, slopes(column))).collect()
}

fn times(matrix: &[Vec<f64>], vector: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| dot(row, vector)).collect()
}

/// Inverse of second derivatives; where a direction between the constants has no minimum, of each alone.
fn inverse_or_each_alone(hessian: &[Vec<f64>]) -> Vec<Vec<f64>> {
    inverse(hessian).unwrap_or_else(|| {
        let alone = |a: usize, b: usize| if a == b { 1.0 / hessian[a][a] } else { 0.0 };
        let count = hessian.len();
        (0..count).map(|a| (0..count).map(|b| alone(a, b)).collect()).collect()
    })
}

/// Inverse of a symmetric positive definite matrix; none of another.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let count = matrix.len();
    let norm: Vec<f64> = (0..count).map(|k| matrix[k][k].sqrt()).collect();
    let cholesky = Cholesky::of(count, |a, b| matrix[a][b] / (norm[a] * norm[b]))?;
    let column = |b: usize| -> Vec<f64> {
        let unit: Vec<f64> = (0..count).map(|k| if k == b { 1.0 / norm[k] } else { 0.0 }).collect();
        cholesky.solve(&unit).iter().zip(&norm).map(|(x, n)| x / n).collect()
    };
    Some((0..count).map(column).collect())
}

#[cfg(test)]
mod tests {
    use armident_effects::TorqueRipple;

    use super::*;
    use crate::regression::fit_set::fit_set;
    use crate::test_arms::{RUBBING_JOINT as JOINT, STRIBECK, rubbing, stribeck, ur5};
    use armident_model::OperatingPoint;

    /// With the speed as one more coefficient, of the derivative of the efforts by it, the linear estimate has the
    /// covariance that trials of the speed give.
    #[test]
    fn shape_covariance_equals_that_of_linear_coefficient() {
        let chain = ur5();
        let design = rubbing(&chain, 0.0);
        let point = OperatingPoint::of(design.joints());
        let at = design.at(&point);
        let mut problem = design.problem_without_trials(&point);
        let speed = STRIBECK[2];
        let id = stribeck(&design, &at, &mut problem, speed);
        let sides = [0.999, 1.001].map(|by| stribeck(&design, &at, &mut problem, by * speed));
        let metric = problem.marginalised(0.0, &[]);
        let found = fit_set(&metric, vec![id]).unwrap();
        let jackknife = profile_curvature(&design, &at, &metric, &found, id, None, 1.0).unwrap();

        let columns = problem.candidates[id].columns.clone();
        let levels = found.fit.of_candidate(&problem.candidates[id]);
        let efforts = sides.map(|side| -> Vec<f64> {
            let columns =
                problem.candidates[side].columns.iter().map(|c| &problem.columns[*c][JOINT]);
            let mut sum = vec![0.0; problem.observations.len()];
            for (column, level) in columns.zip(&levels) {
                sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += level * x);
            }
            sum
        });
        let slope: Vec<f64> =
            efforts[0].iter().zip(&efforts[1]).map(|(a, b)| (b - a) / (0.002 * speed)).collect();
        let all: Vec<&[f64]> = columns
            .iter()
            .map(|c| problem.columns[*c][JOINT].as_slice())
            .chain([slope.as_slice()])
            .collect();
        let gram: Vec<Vec<f64>> = all
            .iter()
            .map(|a| all.iter().map(|b| problem.observations.weights.share * dot(a, b)).collect())
            .collect();
        let covariance = inverse(&gram).unwrap();
        let variance = covariance[2][2];
        // the disagreement of blocks widens the covariance and never narrows it
        let found_variance = jackknife.covariance[0][0];
        assert!((0.9..3.0).contains(&(found_variance / variance)), "{found_variance} {variance}");
        for (k, column) in columns.iter().enumerate() {
            let [expected, got] = [covariance[k][2] / variance, jackknife.slopes[column][0]];
            assert!((got - expected).abs() < 0.05 * expected.abs(), "{k}: {got} {expected}");
        }
    }

    /// The number of harmonics of a ripple is no continuous constant.
    #[test]
    fn harmonics_of_ripple_have_no_covariance() {
        let chain = ur5();
        let design = rubbing(&chain, 0.0);
        let point = OperatingPoint::of(design.joints());
        let at = design.at(&point);
        let mut problem = design.problem_without_trials(&point);
        let law = &TorqueRipple;
        let id = design.push_joint_law(&mut problem, &at, law, JOINT, &[7.0, 2.0]).unwrap();
        let metric = problem.marginalised(0.0, &[]);
        let found = fit_set(&metric, vec![id]).unwrap();
        let jackknife = profile_curvature(&design, &at, &metric, &found, id, None, 1.0);
        assert!(jackknife.is_none_or(|jackknife| jackknife.constants == [0]));
    }
}
