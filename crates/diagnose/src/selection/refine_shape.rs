//! Refinement of shape constants that were tried on a grid.
//!
//! Method: pattern search along one constant after the other, with halved steps, all coefficients refitted.
//! References: R. Hooke, T. A. Jeeves, "Direct search" solution of numerical and statistical problems, Journal of the ACM 8(2),
//! 1961.

use crate::design::rebuild::{continuous, known, recreate};
use crate::design::ripple::least_order;
use crate::design::transmission::push_transmission;
use armident_effects::{LawRole, ShapeStep};
use std::collections::{HashMap, HashSet};

use crate::design::candidate::Candidate;
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::regression::elimination::{InflatedLink, NuisanceElimination};
use crate::regression::fit_set::{Estimate, fit_judged, fit_set};
use crate::selection::cross_validation::with_baseline_terms_of;
use crate::selection::prior_scale::SearchState;
use armident_model::Load;

/// Share of an order that a ripple of a rotational joint may be off a whole number.
const WHOLE_ORDER: f64 = 0.12;
/// Share of the first step for a constant that was refined before: steps that improve are repeated.
const REFINED: f64 = 0.125;
/// Most rounds over all constants: one after the other, correlated ones come to their minimum in several.
const ROUNDS: usize = 8;
/// A round that lowers the score by less ends them: the minus two log likelihood of a constant that is 0.14 standard errors off.
const SETTLED: f64 = 0.02;

/// Refines the constants of an estimate. Baseline terms of the same joints are fitted beside them, with any sign: otherwise
/// the constants would absorb friction below the materiality threshold.
pub(crate) fn refine(
    design: &Design<'_>,
    at: &[Posed<'_>],
    contact: &ContactColumns,
    problem: &mut LinearProblem,
    (scale, inflated): (f64, &[InflatedLink]),
    state: &mut SearchState,
    found: Estimate,
    refined: impl Fn(&Candidate) -> bool,
) -> Estimate {
    let named = found.set.len();
    let baseline = baseline_beside(problem, (scale, inflated), &found, &refined);
    // a problem of the estimate's columns alone makes trials cheap
    let (small, set) = problem.restricted(&[&found.set[..], &baseline].concat());
    let mut elimination = small.elimination(scale, inflated);
    // a candidate that is refined may have a wrong size at first
    let judged: Vec<usize> =
        set[..named].iter().copied().filter(|g| !refined(&small.candidates[*g])).collect();
    let best = fit_judged(&small.marginalised_by(&mut elimination), set, &judged);
    let Some(best) = best else { return found };
    let near = HashMap::new();
    let least_orders = (0..design.joints()).map(|joint| least_order(design, joint)).collect();
    let mut trials =
        Trials { design, at, contact, least_orders, small, elimination, best, named, near };
    let mut before = f64::INFINITY;
    for round in 0..ROUNDS {
        if round > 1 && before - trials.best.score < SETTLED {
            break;
        }
        before = trials.best.score;
        for k in 0..named {
            let candidate = trials.candidate(k).clone();
            if !refined(&candidate) {
                continue;
            }
            let again = round > 0 || known(state.refined.iter(), &candidate).is_some();
            let Some(law) = candidate.law() else { continue };
            if !again {
                for shape in law.shapes_around(&candidate.shape) {
                    trials.improved_by(k, &Candidate { shape, ..candidate.clone() });
                }
            }
            for c in 0..continuous(&candidate) {
                let Some(ShapeStep { first, least, is_relative }) = law.shape_step(c) else {
                    break;
                };
                let mut step = first;
                if again {
                    step *= REFINED;
                }
                while step > least {
                    let moved = |sign: f64| {
                        let mut trial = trials.candidate(k).clone();
                        if is_relative {
                            trial.shape[c] *= 1.0 + sign * step;
                        } else {
                            trial.shape[c] += sign * step;
                        }
                        if let Some((_, window)) = &mut trial.location.window {
                            window[c] = trial.shape[c];
                        }
                        let long = |(_, window): &(usize, [f64; 2])| window[1] - window[0] >= step;
                        trial.location.window.as_ref().is_none_or(long).then_some(trial)
                    };
                    let both = [moved(-1.0), moved(1.0)];
                    if !both.iter().flatten().any(|trial| trials.improved_by(k, trial)) {
                        step *= 0.5;
                    }
                }
            }
        }
    }
    // back to the full problem
    let Trials { small, best, .. } = trials;
    let best = best.set[..named].iter().map(|g| &small.candidates[*g]);
    let set: Vec<usize> =
        best.clone().filter_map(|g| recreate(design, at, contact, problem, g)).collect();
    let new = best.filter(|g| refined(g) && continuous(g) > 0);
    let Some(estimate) = fit_set(&problem.marginalised(scale, inflated), set) else { return found };
    state.refined.extend(new.cloned());
    estimate
}

/// An estimate whose candidates are replaced by trials.
struct Trials<'a, 'e> {
    design: &'a Design<'e>,
    at: &'a [Posed<'e>],
    contact: &'a ContactColumns,
    /// of a ripple on each joint
    least_orders: Vec<f64>,
    small: LinearProblem,
    elimination: NuisanceElimination,
    best: Estimate,
    /// number of candidates of the estimate; the others are baseline terms beside them
    named: usize,
    /// loads on links that moved last, by joint and recording
    near: HashMap<usize, Vec<Option<Load>>>,
}

/// Baseline terms of the joints on which constants of laws of one joint are refined, where these are admissible. Not
/// beside a coupling: friction of its two joints with any sign is a coupling of another ratio (on a TX40 it took the
/// ratio of the wrist from 0.93 to 0.66, and half of the gain).
fn baseline_beside(
    problem: &LinearProblem,
    (scale, inflated): (f64, &[InflatedLink]),
    found: &Estimate,
    refined: impl Fn(&Candidate) -> bool,
) -> Vec<usize> {
    let candidates = &problem.candidates;
    let shaped: HashSet<usize> = found
        .set
        .iter()
        .map(|g| &candidates[*g])
        .filter(|candidate| refined(candidate) && !candidate.shape.is_empty())
        .filter(|candidate| candidate.location.joints.len() == 1)
        .flat_map(|candidate| candidate.location.joints.iter().copied())
        .collect();
    if shaped.is_empty() || problem.observations.comparison.seeks_change() {
        return Vec::new();
    }
    let mut all = with_baseline_terms_of(&problem.marginalised(scale, inflated), found);
    all.retain(|g| {
        !found.set.contains(g) && candidates[*g].location.joints.iter().all(|j| shaped.contains(j))
    });
    all
}

impl Trials<'_, '_> {
    /// The trial in the small problem.
    fn formed(&mut self, trial: &Candidate) -> Option<usize> {
        let (design, at, small) = (self.design, self.at, &mut self.small);
        if !trial.moves_its_link() {
            return recreate(design, at, self.contact, small, trial);
        }
        let (joint, law) = (trial.location.joints[0], trial.law()?);
        let near = self.near.entry(joint).or_default();
        known(small.candidates.iter(), trial)
            .or_else(|| push_transmission(design, at, small, law, joint, &trial.shape, near))
    }

    /// Candidate in this place of the estimate.
    fn candidate(&self, k: usize) -> &Candidate {
        &self.small.candidates[self.best.set[k]]
    }

    /// Whether a candidate is no ripple, or one of at least a wave over the travel of its joint.
    fn is_full_wave(&self, candidate: &Candidate) -> bool {
        !candidate.has(|law| law.has_role(LawRole::Ripple))
            || candidate.shape[0] >= self.least_orders[candidate.location.joints[0]]
    }

    /// Takes another candidate in a place of the estimate, if the score is better by it.
    fn improved_by(&mut self, k: usize, trial: &Candidate) -> bool {
        if !self.is_full_wave(trial) {
            return false;
        }
        let mark = self.small.mark();
        let id = self.formed(trial);
        let next = id.and_then(|id| {
            let mut set = self.best.set.clone();
            set[k] = id;
            let metric = self.small.marginalised_by(&mut self.elimination);
            let judged = set[..self.named].to_vec();
            fit_judged(&metric, set, &judged)
        });
        match next.filter(|next| next.score < self.best.score - 1e-3) {
            Some(next) => {
                self.best = next;
                true
            }
            None => {
                self.small.back_to(mark);
                self.elimination.truncate(mark.columns);
                false
            }
        }
    }
}

/// Joints whose ripple ended at an order that is no whole number.
pub(crate) fn fractional_ripples(
    design: &Design<'_>,
    problem: &LinearProblem,
    found: &Estimate,
) -> Vec<usize> {
    found
        .set
        .iter()
        .map(|g| &problem.candidates[*g])
        .filter(|g| {
            g.has(|law| law.has_role(LawRole::Ripple))
                && design.chain.joints[g.location.joints[0]].kind.is_rotational()
        })
        .filter(|g| (g.shape[0] - g.shape[0].round()).abs() > WHOLE_ORDER)
        .map(|g| g.location.joints[0])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selection::prior_scale::ScaleCriterion;
    use crate::test_arms::{STRIBECK, rubbing, stribeck, ur5};
    use armident_model::OperatingPoint;

    /// Viscous friction that is not in the set does not change the Stribeck velocity.
    #[test]
    fn immaterial_friction_does_not_bias_shape() {
        let chain = ur5();
        let design = rubbing(&chain, 0.3);
        let point = OperatingPoint::of(design.joints());
        let at = design.at(&point);
        let contact = ContactColumns::new(&design, &at);
        let mut problem = design.problem(&point);
        let start = stribeck(&design, &at, &mut problem, 0.2);
        let found = fit_set(&problem.marginalised(0.0, &[]), vec![start]).unwrap();
        let all = |_: &Candidate| true;
        let mut state = SearchState::new(ScaleCriterion::All);
        let found =
            refine(&design, &at, &contact, &mut problem, (0.0, &[]), &mut state, found, all);
        let [candidate] = found.set[..] else { panic!("{:?}", found.set) };
        let speed = problem.candidates[candidate].shape[0];
        assert!((speed / STRIBECK[2] - 1.0).abs() < 0.015, "{speed}");
    }
}
