//! The numbers of findings: parameters with standard errors, and the size of a finding over its error.
//!
//! Statistic: Wald statistic of the main parameters of a law, or of the mass and first moment of a body, against nothing, F
//! distributed with the degrees of freedom of the block jackknife; propagation of the block-jackknife covariance through the formulas.
//! References: A. Wald, Tests of statistical hypotheses concerning several parameters when the number of observations is large,
//! Transactions of the American Mathematical Society 54(3), 1943.

use std::collections::BTreeMap;

use armident_effects::{LawRole, OperatingTerm};
use armident_inference::f_quantile;
use armident_numeric::{Mat, symmetric_eigen};
use nalgebra::Vector3;
use serde::Serialize;

use crate::design::candidate::Candidate;
use crate::design::compliant_link::mean_inertia;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::findings::fitted_model::law_parameters;
use crate::selection::solution::Solution;
use crate::uncertainty::jackknife::Jackknife;
use armident_model::FittedTransmission;

/// A number with its standard error.
#[derive(Debug, Clone, Serialize)]
pub struct Value {
    /// Estimate.
    pub value: f64,
    /// Standard error, if it is known.
    pub stderr: Option<f64>,
    /// Unit.
    pub unit: &'static str,
}

/// Change of mass and first moment of a link, in the frame of its URDF link.
pub(crate) fn in_link_frame(design: &Design<'_>, link: usize, change: &[f64]) -> [f64; 4] {
    let pose = design.chain.joints[link].child_link_in_e;
    let moment = Vector3::new(change[1], change[2], change[3]);
    let moved = pose.rotation.inverse() * (moment - pose.translation.vector * change[0]);
    [change[0], moved.x, moved.y, moved.z]
}

/// Share of a link parameter's prior deviation that may be in combinations that are not excited; with more the parameter is
/// not reported.
const UNSEEN: f64 = 0.1;

/// Link parameters in combinations that are not excited, and axes of a tip force that load no joint.
fn unseen(design: &Design<'_>, problem: &LinearProblem, candidate: &Candidate) -> [bool; 4] {
    if candidate.has(|law| law.has_role(LawRole::Contact)) {
        let loads_none =
            |axis: usize| problem.columns[candidate.columns[axis]].iter().all(Vec::is_empty);
        return std::array::from_fn(|p| p > 0 && loads_none(p - 1));
    }
    let Some(transform) = &candidate.transform else { return [false; 4] };
    let size = |directions: &[Vec<f64>], p: usize| -> f64 {
        let of = |d: &Vec<f64>| in_link_frame(design, candidate.location.joints[0], d)[p].powi(2);
        directions.iter().map(of).sum()
    };
    std::array::from_fn(|p| {
        let hidden = size(&candidate.hidden, p);
        hidden >= UNSEEN * UNSEEN * (hidden + size(transform, p))
    })
}

/// Parameters of a finding, and how far it is from nothing.
#[derive(Default)]
pub(crate) struct Numbers {
    pub(crate) parameters: BTreeMap<&'static str, Value>,
    /// 1 at two standard errors; none where it is not known
    pub(crate) size: Option<f64>,
}

/// Confidence region outside which nothing must lie: two standard errors of one parameter.
const TWO_STANDARD_ERRORS: f64 = 0.954_499_736;
/// Variance of a combination of normalised estimates below which it is rounding.
const ROUNDING: f64 = 1e-9;

/// Distance of an estimate from nothing by its full covariance, which so many blocks less one determine, 1 on the border of the
/// region of two standard errors; none without a variance.
pub(crate) fn size_over_error(
    estimate: &[f64],
    covariance: &[Vec<f64>],
    freedom: f64,
) -> Option<f64> {
    let known: Vec<usize> = (0..estimate.len()).filter(|k| covariance[*k][*k] > 0.0).collect();
    let deviation = |k: usize| covariance[known[k]][known[k]].sqrt();
    let correlation =
        |a: usize, b: usize| covariance[known[a]][known[b]] / (deviation(a) * deviation(b));
    let (values, vectors) =
        symmetric_eigen(&Mat::from_fn(known.len(), known.len(), correlation)).ok()?;
    let seen: Vec<usize> = (0..known.len()).filter(|k| values[*k] > ROUNDING).collect();
    let squares: f64 = (seen.iter())
        .map(|&k| {
            let along: f64 =
                (0..known.len()).map(|a| vectors[(a, k)] * estimate[known[a]] / deviation(a)).sum();
            along * along / values[k]
        })
        .sum();
    let count = seen.len() as f64;
    let border = count * f_quantile(TWO_STANDARD_ERRORS, count, freedom)?;
    (!seen.is_empty()).then(|| (squares / border).sqrt())
}

/// Numbers of a candidate of an estimate.
pub(crate) fn numbers(solution: &Solution<'_, '_>, id: usize, jackknife: &Jackknife) -> Numbers {
    let Solution { design, metric, estimate, point, ref gain, .. } = *solution;
    let candidate = &metric.problem.candidates[id];
    let Some(law) = candidate.law() else { return Numbers::default() };
    let kind = design.chain.joints[candidate.location.joints.first().copied().unwrap_or(0)].kind;
    let coefficients = estimate.fit.of_candidate(candidate);
    let covariance = jackknife.joint_covariance(metric, estimate, id);
    let freedom = jackknife.freedom();
    let of = |shape: &[f64], coefficients: &[f64]| -> Vec<f64> {
        let first = candidate.location.joints.first().copied();
        match (law.law().operating, first) {
            (Some(OperatingTerm::Tilt), _) => {
                let delta = [coefficients[0], coefficients[1]];
                let base = point.tilt;
                return law.parameters(&[], &[base[0] + delta[0], base[1] + delta[1]]);
            }
            (Some(OperatingTerm::Delay), _) => return vec![point.delay_s + coefficients[0]],
            (Some(OperatingTerm::EncoderZero), Some(j)) => {
                return vec![point.offset[j] + coefficients[0]];
            }
            _ => {}
        }
        if let (Some(_), Some(j)) = (law.law().link_side(), first) {
            let inertia = mean_inertia(solution.at(), j);
            let to_first_order =
                || FittedTransmission { gap: 0.0, stiffness: 1.0 / coefficients[0], damping: 0.0 };
            let mut of =
                FittedTransmission::of_law(law, shape, inertia).unwrap_or_else(to_first_order);
            of.gap = of.fitted_gap(coefficients[0]);
            return law
                .parameters_of_transmission(&of.with_motor_inertia(coefficients[1] / gain[j]));
        }
        if let (Some(transform), Some(link)) = (&candidate.transform, first) {
            let change: Vec<f64> = (0..10)
                .map(|p| transform.iter().zip(coefficients).map(|(t, c)| t[p] * c).sum())
                .collect();
            return law.parameters_of_link(in_link_frame(design, link, &change));
        }
        let moved = Candidate { shape: shape.to_vec(), ..candidate.clone() };
        law_parameters(&moved, coefficients, gain)
    };
    let values = of(&candidate.shape, &coefficients);
    // propagation of the covariance of coefficients and searched constants through the formulas
    let numbers = [&coefficients[..], &candidate.shape[..]].concat();
    let slopes: Vec<Vec<f64>> = (0..numbers.len())
        .map(|k| {
            let step = 1e-4 * covariance[k][k].sqrt().max(1e-12);
            let mut moved = numbers.clone();
            moved[k] += step;
            let (coefficients, shape) = moved.split_at(coefficients.len());
            of(shape, coefficients).iter().zip(&values).map(|(a, b)| (a - b) / step).collect()
        })
        .collect();
    let unseen = unseen(design, metric.problem, candidate);
    let propagated = |slopes: &[Vec<f64>], p: usize, q: usize| -> f64 {
        (0..numbers.len())
            .flat_map(|a| (0..numbers.len()).map(move |b| (a, b)))
            .map(|(a, b)| slopes[a][p] * slopes[b][q] * covariance[a][b])
            .sum()
    };
    let parameters = (law.law().parameters.iter().zip(&values).enumerate())
        .filter(|(p, _)| !unseen.get(*p).is_some_and(|unseen| *unseen))
        .map(|(p, (parameter, &value))| {
            let variance = propagated(&slopes, p, p);
            let stderr = (variance > 0.0).then(|| variance.sqrt());
            (parameter.name, Value { value, stderr, unit: parameter.unit(kind) })
        })
        .collect();
    // of a body its mass and first moment, and where only its inertia is excited, that
    if let Some(transform) = &candidate.transform {
        let moments: Vec<Vec<f64>> = transform.iter().map(|t| t[..4].to_vec()).collect();
        let change: Vec<f64> = (0..4)
            .map(|p| moments.iter().zip(&coefficients).map(|(t, c)| t[p] * c).sum())
            .collect();
        let spread = |p: usize| (0..4).map(|q| propagated(&moments, p, q)).collect();
        let size = size_over_error(&change, &(0..4).map(spread).collect::<Vec<_>>(), freedom);
        return Numbers {
            parameters,
            size: size.or_else(|| size_over_error(&coefficients, &covariance, freedom)),
        };
    }
    // constants of shape have no size: an order is never 0; transmissions have nothing else
    let main = || (0..values.len()).filter(|p| law.law().parameters[*p].is_main);
    let scales = |p: &usize| slopes[..coefficients.len()].iter().any(|s| s[*p] != 0.0);
    let mut judged: Vec<usize> = main().filter(scales).collect();
    if judged.is_empty() {
        judged = main().collect();
    }
    let off: Vec<f64> =
        judged.iter().map(|p| values[*p] - law.law().parameters[*p].neutral).collect();
    let spread = |p: &usize| judged.iter().map(|q| propagated(&slopes, *p, *q)).collect();
    let size = size_over_error(&off, &judged.iter().map(spread).collect::<Vec<_>>(), freedom);
    Numbers { parameters, size }
}

/// Numbers of a link with larger errors than all others: the change of its standard parameters.
pub(crate) fn numbers_of_link(
    design: &Design<'_>,
    link: usize,
    change: &[f64],
    covariance: &[Vec<f64>],
    freedom: f64,
) -> Numbers {
    let names = ["delta_mass", "delta_mcx", "delta_mcy", "delta_mcz"];
    let units = ["kg", "kg m", "kg m", "kg m"];
    let in_link = in_link_frame(design, link, change);
    let parameters = (0..4)
        .map(|p| {
            // the frames' change is linear
            let slopes: Vec<f64> = (0..4)
                .map(|k| {
                    let unit: Vec<f64> = (0..10).map(|i| f64::from(u8::from(i == k))).collect();
                    in_link_frame(design, link, &unit)[p]
                })
                .collect();
            let variance: f64 = (0..4)
                .flat_map(|a| (0..4).map(move |b| (a, b)))
                .map(|(a, b)| slopes[a] * slopes[b] * covariance[a][b])
                .sum();
            let stderr = (variance > 0.0).then(|| variance.sqrt());
            (names[p], Value { value: in_link[p], stderr, unit: units[p] })
        })
        .collect();
    Numbers { parameters, size: size_over_error(&change[..4], covariance, freedom) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Many blocks: the border is that of the normal distribution.
    const MANY: f64 = 1e6;

    #[test]
    fn size_is_one_at_two_standard_errors() {
        let one = size_over_error(&[0.6], &[vec![0.09]], MANY).unwrap();
        assert!((one - 1.0).abs() < 1e-3, "{one}");
        let few = size_over_error(&[0.6], &[vec![0.09]], 4.0).unwrap();
        assert!((0.6..0.8).contains(&few), "{few}");
        assert!(size_over_error(&[2.0], &[vec![0.0]], MANY).is_none());
    }

    /// Of two of which the sum alone is known; and where a combination has no variance.
    #[test]
    fn size_follows_full_covariance() {
        let correlated = [vec![1.0, -0.99], vec![-0.99, 1.0]];
        let [apart, together] =
            [[2.0, -2.0], [2.0, 2.0]].map(|of| size_over_error(&of, &correlated, MANY).unwrap());
        assert!(apart < 1.2 && together > 8.0, "{apart} {together}");
        let singular = [vec![1.0, 1.0], vec![1.0, 1.0]];
        assert!(size_over_error(&[2.0, 2.0], &singular, MANY).unwrap() < 1.01);
    }
}
