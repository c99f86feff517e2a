//! Test whether the estimate in the band holds in a narrower band.
//!
//! A correct model has the same coefficients in every band, with smaller standard errors in a wide one. Where efforts and
//! accelerations disagree above some frequency (encoder jitter, a controller that estimates its encoder), the inertias of the
//! wide band are biased, however small their standard errors are, and leave a significantly larger residual below.
//!
//! Hypothesis: the coefficients of both bands are equal.
//! References: J. A. Hausman, Specification tests in econometrics, Econometrica 46(6), 1978: an efficient estimate against one
//! that is consistent under more.

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_inference::levels::SPECIFICATION_ERROR;
use armident_inference::{f_quantile, independent_share};
use armident_numeric::dot;

use crate::design::contact::ContactColumns;
use crate::design::rebuild::recreate;
use crate::design::training::Design;
use crate::regression::consistent_links::ConsistentEstimate;
use crate::selection::cross_validation::Predictor;
use crate::selection::solution::Selection;

/// The narrower band \[Hz\]: an octave below the other.
pub(crate) const NARROW_HZ: f64 = 5.0;
/// Least difference of the two on some joint, in noise levels: 2 % more prediction error. A narrow band determines springs,
/// gaps and reversals worse, which a smaller difference does not justify.
const WORTH: f64 = 0.2;
/// Independent samples a coefficient that the narrow band needs.
const SAMPLES_A_COEFFICIENT: f64 = 2.0;

/// Whether the coefficients of a selection, its small terms included, differ from those of the narrow band of the same
/// recordings, significantly and materially.
pub(crate) fn is_off_in(narrow: &Design<'_>, selection: &Selection, best: &Predictor) -> bool {
    contradicts(narrow, selection, best).unwrap_or(false)
}

/// None where the narrow band cannot form or fit the same candidates, or has too few samples.
fn contradicts(narrow: &Design<'_>, selection: &Selection, best: &Predictor) -> Option<bool> {
    let at = narrow.at(&selection.point);
    let contact = ContactColumns::new(narrow, &at);
    let mut problem = narrow.problem_without_trials(&selection.point);
    let candidates = best.estimate.set.iter().map(|g| &selection.problem.candidates[*g]);
    let again: Vec<usize> = candidates
        .map(|candidate| recreate(narrow, &at, &contact, &mut problem, candidate))
        .collect::<Option<_>>()?;
    let (problem, set) = problem.restricted(&again);
    let own = {
        let metric = problem.marginalised(best.scale, &selection.inflated);
        metric.residual(&metric.fit(metric.columns_of(&set))?)
    };
    // in standard parameters: the identifiable combinations are not the same in both
    let inflated = selection.problem.marginalised(best.scale, &selection.inflated);
    let ConsistentEstimate { change, coefficients, .. } =
        ConsistentEstimate::of(&inflated, &best.estimate);
    let mut taken: Vec<(usize, f64)> = change.iter().map(|x| -x).enumerate().collect();
    let laws = problem.candidates.iter().zip(&coefficients);
    for (candidate, coefficients) in laws.filter(|(candidate, _)| candidate.transform.is_none()) {
        taken.extend(candidate.columns.iter().copied().zip(coefficients.iter().map(|x| -x)));
    }
    let crossed = problem.with_added(&taken).effort;
    let rows = &problem.observations;
    let share = independent_share(&own, &rows.starts, rows.rows_hz);
    let constants = MinimalSet::of(&RigidArm::from_chain(narrow.chain)).ok()?;
    let of_laws: usize = coefficients.iter().map(Vec::len).sum();
    let coefficients = (constants.len() + of_laws) as f64;
    // added residual of the wide band's coefficients: in residual variances, and the largest effort between the two on a
    // joint in its noise
    let (mut samples, mut squares, mut largest) = (0.0, 0.0, 0.0_f64);
    for (j, (own, crossed)) in own.iter().zip(&crossed).enumerate() {
        let before = dot(own, own);
        if before > 0.0 {
            let independent = share * own.len() as f64;
            let between: Vec<f64> = own.iter().zip(crossed).map(|(a, b)| a - b).collect();
            largest = largest.max(rows.in_sample_noise(j, &between));
            squares += (dot(crossed, crossed) / before - 1.0) * independent;
            samples += independent;
        }
    }
    if samples <= SAMPLES_A_COEFFICIENT * coefficients {
        return None;
    }
    let ratio = squares / coefficients * (1.0 - coefficients / samples);
    let quantile = f_quantile(1.0 - SPECIFICATION_ERROR, coefficients, samples - coefficients)?;
    Some(largest > WORTH && ratio > quantile)
}
