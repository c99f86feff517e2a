//! How much the parameters of a robot differ from recording to recording where nothing has changed.
//!
//! Real recordings scatter more than their standard errors: friction follows temperature, and each motion weighs what the
//! model lacks in its own way. Without this term every difference of two days would count as a change.
//!
//! Method: parameters of a recording are those of the robot plus `u ~ N(0, diag(τ²))`, with one τ for each parameter of the
//! fleet. Expectation and maximisation, where the maximisation takes differences of successive recordings of a robot, each
//! cut at 2.5 standard deviations: a change point is in one difference only, and bounded there. The start is above the result
//! (all scatter given to each parameter alone), so that a search which ends early is on the safe side.
//!
//! References: N. M. Laird, J. H. Ware, Random-effects models for longitudinal data, Biometrics 38 (1982); P. J. Huber,
//! Robust Statistics (1981), for the cut; J. von Neumann, Distribution of the ratio of the mean square successive difference
//! to the variance, Ann. Math. Stat. 12 (1941).

use armident_numeric::{Cholesky, order_statistic};
use rayon::prelude::*;

use crate::information::Information;
use crate::series::Series;

/// Steps of the search.
const STEPS: usize = 24;
/// Where differences are cut, in standard deviations.
const CUT: f64 = 2.5;
/// Mean square of a standard normal number cut at [`CUT`].
const CUT_SQUARE: f64 = 0.9776;
/// Median of the square of a standard normal number.
const MEDIAN_SQUARE: f64 = 0.4549;
/// Degrees of freedom of a difference: successive differences share recordings, which costs a third (von Neumann 1941), and
/// the cut some more.
const FREEDOM_OF_DIFFERENCE: f64 = 0.6;

/// Standard deviations between recordings of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// One of each parameter, in its unit.
    pub deviations: Vec<f64>,
    /// Degrees of freedom of these.
    pub freedom: f64,
    /// Recordings that they were estimated from.
    pub recordings: usize,
}

/// Mean square of differences, those far out cut.
fn cut_mean_square(differences: &[f64]) -> f64 {
    let squares: Vec<f64> = differences.iter().map(|d| d * d).collect();
    let median = order_statistic(&mut squares.clone(), squares.len() / 2).unwrap_or(0.0);
    let variance = median / MEDIAN_SQUARE;
    let most = CUT * CUT * variance;
    squares.iter().map(|square| square.min(most)).sum::<f64>()
        / (CUT_SQUARE * squares.len().max(1) as f64)
}

/// Scatter in scaled parameters, from robots each with successive recordings.
pub(crate) fn estimate(robots: &[Vec<Information>]) -> Scatter {
    let p = robots.iter().flatten().next().map_or(0, |first| first.moment.len());
    let pairs: usize = robots.iter().map(|robot| robot.len().saturating_sub(1)).sum();
    let recordings = robots.iter().map(Vec::len).sum();
    if pairs == 0 {
        return Scatter { deviations: vec![0.0; p], freedom: 1.0, recordings };
    }
    let mut deviations = start(robots, p);
    for _ in 0..STEPS {
        let pairs: Vec<Difference> =
            robots.par_iter().flat_map_iter(|robot| differences(robot, &deviations)).collect();
        for k in 0..p {
            let means: Vec<f64> = pairs.iter().map(|pair| pair.mean[k]).collect();
            let variance = pairs.iter().map(|pair| pair.variance[k]).sum::<f64>();
            let square = cut_mean_square(&means) + variance / pairs.len().max(1) as f64;
            deviations[k] = (0.5 * square).max(0.0).sqrt();
        }
    }
    let freedom = (FREEDOM_OF_DIFFERENCE * pairs as f64).max(1.0);
    Scatter { deviations, freedom, recordings }
}

/// Scatter of each parameter where all others are held.
fn start(robots: &[Vec<Information>], p: usize) -> Vec<f64> {
    let none = vec![0.0; p];
    let alone: Vec<Vec<Vec<f64>>> = robots
        .par_iter()
        .map(|robot| {
            let series = Series::new(robot.clone());
            let Some(fit) = series.fit(&[]) else { return Vec::new() };
            (0..robot.len())
                .map(|index| {
                    let residual = series.residual(index, &fit.values);
                    let own = |k: usize| robot[index].matrix[(k, k)];
                    (0..p)
                        .map(|k| if own(k) > 1e-9 { residual[k] / own(k) } else { none[k] })
                        .collect()
                })
                .collect()
        })
        .collect();
    (0..p)
        .map(|k| {
            let differences: Vec<f64> =
                alone.iter().flat_map(|of| of.windows(2).map(|w| w[1][k] - w[0][k])).collect();
            cut_mean_square(&differences).sqrt()
        })
        .collect()
}

/// What is known of the difference `u` of a recording from the one before it.
struct Difference {
    mean: Vec<f64>,
    variance: Vec<f64>,
}

/// Differences of successive recordings: `u = T Λ* (y - x)` in each, with the variance `(T⁻¹ + Λ)⁻¹` and that of the robot's
/// parameters `x`, which cancels where both recordings determine the same.
fn differences(robot: &[Information], deviations: &[f64]) -> Vec<Difference> {
    let p = deviations.len();
    let common: Vec<Information> = robot.iter().map(|of| of.in_common(deviations)).collect();
    let series = Series::new(common);
    let Some(fit) = series.fit(&[]) else { return Vec::new() };
    let own: Vec<(Vec<f64>, Vec<f64>)> = (robot.iter().enumerate())
        .map(|(index, of)| (series.residual(index, &fit.values), variances(of, deviations)))
        .collect();
    (1..robot.len())
        .map(|index| {
            let [before, after] = [index - 1, index].map(|index| &series.recordings[index].matrix);
            let weights = after - before;
            let spread = &weights * &fit.covariance;
            let of_robot =
                |k: usize| -> f64 { (0..p).map(|j| spread[(k, j)] * weights[(k, j)]).sum() };
            let ((first, first_variance), (second, second_variance)) =
                (&own[index - 1], &own[index]);
            Difference {
                mean: (0..p).map(|k| deviations[k].powi(2) * (second[k] - first[k])).collect(),
                variance: (0..p)
                    .map(|k| {
                        first_variance[k] + second_variance[k] + deviations[k].powi(4) * of_robot(k)
                    })
                    .collect(),
            }
        })
        .collect()
}

/// Diagonal of `(T⁻¹ + Λ)⁻¹`.
fn variances(of: &Information, deviations: &[f64]) -> Vec<f64> {
    let p = deviations.len();
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let entry = |i: usize, j: usize| unit(i, j) + deviations[i] * of.matrix[(i, j)] * deviations[j];
    match Cholesky::of(p, entry) {
        Some(factor) => factor
            .inverse_diagonal()
            .iter()
            .zip(deviations)
            .map(|(share, deviation)| share * deviation * deviation)
            .collect(),
        None => deviations.iter().map(|d| d * d).collect(),
    }
}
