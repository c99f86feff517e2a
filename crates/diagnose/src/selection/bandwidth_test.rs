//! Whether what was found in the band is what a narrower one says.
//!
//! A right model has the same coefficients in every band, a wider one only knows them better. Where efforts and
//! accelerations do not go together above some frequency (positions that shake by themselves, a controller that
//! estimates its encoder), the inflated band's inertias are biased, however small their standard errors are: compared
//! where all still goes together, its fit then leaves over more than that of the narrow band by more than chance.
//!
//! Reference: J. A. Hausman, Specification tests in econometrics, Econometrica 46(6), 1978: an efficient estimate
//! against one that is consistent under more.

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_numeric::dot;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::design::contact::ContactColumns;
use crate::design::design::Design;
use crate::design::rebuild::recreate;
use crate::regression::consistent_links::ConsistentEstimate;
use crate::selection::cross_validation::Predictor;
use crate::selection::solution::Selection;
use crate::selection::weights::independent_share;

/// The narrower band \[Hz\]: an octave below the other.
pub(crate) const NARROW_HZ: f64 = 5.0;
/// SurrogateThreshold of leaving the inflated band of a right model.
const CHANCE: f64 = 1e-3;
/// What the two must differ by on some joint, in units of the noise of one recorded sample: predictions of efforts err
/// 2 % more by it. A narrow band sees less of springs, gaps and reversals, which less than that is not worth.
const WORTH: f64 = 0.2;
/// Independent samples a coefficient that the narrow band must have, to say what it leaves over.
const SAMPLES_A_COEFFICIENT: f64 = 2.0;

/// Whether the coefficients of a selection, with the friction beside it that is too small to be named, are off those
/// that the narrow band of the same recordings has, by more than chance and by enough to matter.
pub(crate) fn is_off_in(narrow: &Design<'_>, selection: &Selection, best: &Predictor) -> bool {
    contradicts(narrow, selection, best).unwrap_or(false)
}

/// None where the narrow band cannot form or fit the same candidates, or has too few samples to say.
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
    // in standard parameters: what of a link can be told is not the same in both
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
    // what the inflated band's coefficients leave over more: in variances of what is left, and the largest effort on a
    // joint between the two in its noise
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
    let law = FisherSnedecor::new(coefficients, samples - coefficients).ok()?;
    Some(largest > WORTH && ratio > law.inverse_cdf(1.0 - CHANCE))
}
