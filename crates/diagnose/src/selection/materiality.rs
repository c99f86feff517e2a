//! Materiality: an effect is reported when the model without it is worse by an amount that matters, not when it is merely
//! significant. With some thousand independent samples even model discrepancy is significant.
//!
//! Statistic: root mean square effort that a candidate alone explains, all others refitted without it, in noise levels, on
//! the joint where its ratio to the threshold is largest.
//! References: own.

use crate::design::comparison::Comparison;
use crate::regression::fit_set::{Estimate, admissible_part, fit_any_sign};
use armident_effects::OperatingTerm;
use rayon::prelude::*;

use crate::design::candidate::Candidate;
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;
use crate::regression::marginalised::Marginalised;
use crate::selection::surrogate_threshold::SurrogateThreshold;
use armident_model::OperatingPoint;

/// Least materiality of a finding, in noise levels: a sixth more prediction error. The surrogate threshold of the
/// recordings ([`SurrogateThreshold`]) may be higher.
pub(crate) const LEAST: f64 = 0.6;
/// Least materiality of a change, 8 % more prediction error: the model discrepancy is known from the reference, and
/// [`crate::selection::change_significance::certain`] tests the significance.
pub(crate) const LEAST_CHANGE: f64 = 0.4;
/// Share of a joint's residual below which nothing is reported there.
pub(crate) const SHARE_OF_EXCESS: f64 = 0.9;
/// That share for a change: model discrepancy is the same before and after, and a change must hold in every block.
pub(crate) const SHARE_FOR_CHANGE: f64 = 0.3;

/// How much an effect matters, on the joint where it matters most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Materiality {
    /// standard deviations of one recorded sample
    pub(crate) value: f64,
    /// materiality threshold on that joint
    pub(crate) least: f64,
    pub(crate) joint: usize,
}

impl Materiality {
    pub(crate) fn ratio(&self) -> f64 {
        self.value / self.least
    }
}

/// Uncertainty of the estimated noise.
const UNCERTAINTY: f64 = 1.1;

/// Residual of each joint beyond its noise, in noise levels.
pub(crate) fn excess(problem: &LinearProblem, residual: &[Vec<f64>]) -> Vec<f64> {
    (0..residual.len())
        .map(|j| {
            let left = problem.observations.in_sample_noise(j, &residual[j]);
            let noise = band_noise(problem, j);
            (left * left - UNCERTAINTY * noise * noise).max(0.0).sqrt()
        })
        .collect()
}

/// The same on a joint in the reference: what the model leaves over where nothing changed.
pub(crate) fn excess_before(problem: &LinearProblem, joint: usize) -> f64 {
    let left = problem.observations.weights.discrepancy_before[joint];
    band_noise(problem, joint) * (left * left - UNCERTAINTY).max(0.0).sqrt()
}

/// Noise in the band, in standard deviations of one recorded sample.
pub(crate) fn band_noise(problem: &LinearProblem, joint: usize) -> f64 {
    let rows = &problem.observations;
    // in_sample_noise divides by the weights, discrepancy and all
    let weighted = rows.weight(joint).iter().zip(&rows.deviation[joint]).map(|(w, d)| w * d);
    rows.in_sample_noise(joint, &weighted.collect::<Vec<f64>>())
}

/// Materiality thresholds of an estimate.
struct Asked<'a> {
    problem: &'a LinearProblem,
    threshold: &'a SurrogateThreshold,
    /// residual of each joint beyond its noise
    left: Vec<f64>,
}

impl<'a> Asked<'a> {
    fn of(
        problem: &'a LinearProblem,
        threshold: &'a SurrogateThreshold,
        residual: &[Vec<f64>],
    ) -> Self {
        Self { problem, threshold, left: excess(problem, residual) }
    }

    /// Materiality threshold of a candidate of so many columns on a joint.
    fn least(&self, joint: usize, columns: usize) -> f64 {
        let left = self.left[joint];
        match self.problem.observations.comparison {
            Comparison::AgainstModel => {
                LEAST.max(SHARE_OF_EXCESS * left).max(self.threshold.least(joint, columns))
            }
            Comparison::AgainstReference { .. } => LEAST_CHANGE.max(SHARE_FOR_CHANGE * left),
        }
    }

    /// Effort of columns with these coefficients alone, on the joint where it is largest.
    fn of_effort(&self, terms: &[(usize, f64)]) -> Materiality {
        let mut worst = Materiality { value: 0.0, least: LEAST, joint: 0 };
        for j in 0..self.left.len() {
            let found = self.of_effort_on(terms, j);
            if found.ratio() > worst.ratio() {
                worst = found;
            }
        }
        worst
    }

    /// The same on one joint.
    fn of_effort_on(&self, terms: &[(usize, f64)], joint: usize) -> Materiality {
        let rows = &self.problem.observations;
        let mut effort = vec![0.0; rows.len()];
        for &(column, coefficient) in terms {
            for (e, x) in effort.iter_mut().zip(&self.problem.columns[column][joint]) {
                *e += coefficient * x;
            }
        }
        let value = rows.in_sample_noise(joint, &effort);
        // errors of further links add few combinations on a joint to those of one
        const OF_A_LINK: usize = 10;
        Materiality { value, least: self.least(joint, terms.len().min(OF_A_LINK)), joint }
    }
}

/// Materiality of a candidate of an estimate: against the estimate without it, its contained law instead.
pub(crate) fn materiality(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    point: &OperatingPoint,
    threshold: &SurrogateThreshold,
) -> (Materiality, Option<Estimate>) {
    materiality_beside(metric, of, &metric.residual(&of.fit), candidate, point, threshold)
}

/// Materiality of a candidate, with the residual of the estimate given.
fn materiality_beside(
    metric: &Marginalised<'_>,
    of: &Estimate,
    with: &JointColumns,
    candidate: usize,
    point: &OperatingPoint,
    threshold: &SurrogateThreshold,
) -> (Materiality, Option<Estimate>) {
    let problem = metric.problem;
    let asked = Asked::of(problem, threshold, with);
    let without = reduced(metric, of, candidate, point);
    let columns = &problem.candidates[candidate].columns;
    let mut worst = Materiality { value: 0.0, least: LEAST, joint: 0 };
    let absorbed = metric.scale > 0.0 && !problem.observations.comparison.seeks_change();
    if absorbed && problem.candidates[candidate].transform.is_some() {
        // link errors would take the place of a load: its own effort counts
        let terms: Vec<(usize, f64)> =
            columns.iter().map(|&c| (c, of.fit.coefficient(c))).collect();
        return (asked.of_effort(&terms), without.map(|w| w.0));
    }
    if let Some((_, rest)) = &without {
        for j in 0..with.len() {
            let square = |r: &[f64]| problem.observations.in_sample_noise(j, r).powi(2);
            let in_band = (square(&rest[j]) - square(&with[j])).max(0.0).sqrt();
            let value = in_band * problem.candidates[candidate].above_band;
            let found = Materiality { value, least: asked.least(j, columns.len()), joint: j };
            if found.ratio() > worst.ratio() {
                worst = found;
            }
        }
    }
    (worst, without.map(|w| w.0))
}

/// Part of a candidate's effect in the operating point: its columns and their amounts.
pub(crate) fn held(candidate: &Candidate, point: &OperatingPoint) -> Vec<(usize, f64)> {
    let amounts = match candidate.law().and_then(|law| law.law().operating) {
        Some(OperatingTerm::Tilt) => point.tilt.to_vec(),
        Some(OperatingTerm::Delay) => vec![point.delay_s],
        Some(OperatingTerm::EncoderZero) => vec![point.offset[candidate.location.joints[0]]],
        Some(OperatingTerm::Gain) | None => return Vec::new(),
    };
    candidate.columns.iter().copied().zip(amounts).filter(|(_, a)| *a != 0.0).collect()
}

/// A set without a candidate, the laws it contains instead.
pub(crate) fn set_without(problem: &LinearProblem, set: &[usize], candidate: usize) -> Vec<usize> {
    let candidates = &problem.candidates;
    let contained = candidates[candidate].law().map_or(&[][..], |law| law.law().contains);
    let mut rest: Vec<usize> = set.iter().copied().filter(|g| *g != candidate).collect();
    let free =
        |g: &usize, rest: &[usize]| rest.iter().all(|r| !candidates[*r].excludes(&candidates[*g]));
    for (slug, joint) in contained
        .iter()
        .flat_map(|slug| candidates[candidate].location.joints.iter().map(move |j| (slug, j)))
    {
        let relative = (0..candidates.len()).find(|&g| {
            candidates[g].slug() == *slug
                && candidates[g].location.joints == [*joint]
                && candidates[g].location.window.is_none()
        });
        rest.extend(relative.filter(|g| free(g, &rest)));
    }
    // links are loaded more often than exchanged: as a change, a link must be better than a load
    if problem.observations.comparison.seeks_change() && candidates[candidate].is_of_link() {
        let load = (0..candidates.len()).find(|&g| {
            candidates[g].is_of_link()
                && candidates[g].location.joints == candidates[candidate].location.joints
                && candidates[g].columns.len() < candidates[candidate].columns.len()
        });
        rest.extend(load.filter(|g| free(g, &rest)));
    }
    rest
}

/// The estimate without a candidate, the laws it contains instead where these are admissible.
pub(crate) fn estimate_without(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
) -> Option<Estimate> {
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != candidate).collect();
    admissible_part(metric, set_without(metric.problem, &of.set, candidate), &rest)
}

/// The estimate without a candidate, the law it contains instead where that is admissible, and its residual. The
/// candidate's part of the operating point is added to the efforts first.
fn reduced(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    point: &OperatingPoint,
) -> Option<(Estimate, JointColumns)> {
    let candidates = &metric.problem.candidates;
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != candidate).collect();
    let held = held(&candidates[candidate], point);
    if !held.is_empty() {
        let moved = metric.problem.with_added(&held);
        let metric = moved.marginalised(metric.scale, &metric.inflated);
        return fit_any_sign(&metric, rest);
    }
    let with_relatives = estimate_without(metric, of, candidate)
        .map(|found| (metric.residual(&found.fit), found))
        .map(|(residual, found)| (found, residual));
    with_relatives.or_else(|| fit_any_sign(metric, rest))
}

/// Surrogate threshold beside an estimate; none with a reference, where changes are tested for significance
/// ([`crate::selection::change_significance::certain`]).
pub(crate) fn surrogate_threshold_beside(
    metric: &Marginalised<'_>,
    of: &Estimate,
) -> SurrogateThreshold {
    match metric.problem.observations.comparison {
        Comparison::AgainstModel => SurrogateThreshold::beside(metric, of),
        Comparison::AgainstReference { .. } => {
            SurrogateThreshold::none(metric.problem.observations.joints())
        }
    }
}

/// Removes immaterial candidates, the least material first.
pub(crate) fn prune(
    metric: &Marginalised<'_>,
    mut of: Estimate,
    point: &OperatingPoint,
) -> Estimate {
    let threshold = surrogate_threshold_beside(metric, &of);
    loop {
        let with = metric.residual(&of.fit);
        let sizes: Vec<(f64, Estimate)> = of
            .set
            .par_iter()
            .filter_map(|&g| {
                let (size, without) = materiality_beside(metric, &of, &with, g, point, &threshold);
                without.map(|without| (size.ratio(), without))
            })
            .collect();
        let least = sizes.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((ratio, without)) if ratio < 1.0 => of = without,
            _ => return of,
        }
    }
}

/// Effort of the inertial errors of one link, on the joint where it is largest.
pub(crate) fn link_materiality(
    metric: &Marginalised<'_>,
    of: &Estimate,
    link: usize,
    threshold: &SurrogateThreshold,
) -> Materiality {
    let errors = metric.inertial_errors(&of.fit);
    let terms: Vec<(usize, f64)> = (10 * link..10 * (link + 1)).map(|p| (p, errors[p])).collect();
    Asked::of(metric.problem, threshold, &metric.residual(&of.fit)).of_effort(&terms)
}

/// Joints on which the inertial errors of all links together matter.
pub(crate) fn joints_of_inertial_errors(metric: &Marginalised<'_>, of: &Estimate) -> Vec<usize> {
    let problem = metric.problem;
    if metric.scale == 0.0 || problem.observations.comparison.seeks_change() {
        return Vec::new();
    }
    let terms: Vec<(usize, f64)> =
        metric.inertial_errors(&of.fit).into_iter().enumerate().collect();
    let threshold = surrogate_threshold_beside(metric, of);
    let asked = Asked::of(problem, &threshold, &metric.residual(&of.fit));
    (0..problem.observations.joints())
        .filter(|j| asked.of_effort_on(&terms, *j).ratio() >= 1.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{design, ur5};
    use armident_effects::JointCoupling;

    /// A joint whose dry friction falls with speed, fitted by a coupling: without it the dry friction stays, and viscous
    /// friction of the wrong sign does not remove it.
    #[test]
    fn removed_law_is_replaced_by_admissible_contained_laws() {
        const JOINT: usize = 1;
        let chain = ur5();
        let design = design(&chain, &chain, |j, v| match j {
            JOINT => 4.0 * v.signum() - 1.5 * v,
            _ => 0.0,
        });
        let point = OperatingPoint::of(design.joints());
        let at = design.at(&point);
        let mut problem = design.problem(&point);
        let law = &JointCoupling;
        let coupling = design.push_pair_law(&mut problem, &at, law, JOINT, &[1.0]);
        let metric = problem.marginalised(0.0, &[]);
        let (coupled, _) = fit_any_sign(&metric, vec![coupling]).unwrap();
        let without = estimate_without(&metric, &coupled, coupling).unwrap();
        let there = |slug: &str| {
            let candidates = without.set.iter().map(|g| &problem.candidates[*g]);
            candidates.filter(|g| g.slug() == slug && g.location.joints == [JOINT]).count()
        };
        assert_eq!((there("coulomb_friction"), there("viscous_friction")), (1, 0));
        let place =
            without.set.iter().position(|g| problem.candidates[*g].location.joints == [JOINT]);
        let level = without.fit.of_candidate(&problem.candidates[without.set[place.unwrap()]])[0];
        // the rest of the falling part is absorbed by the level
        assert!((2.0..4.0).contains(&level), "{level}");
    }
}
