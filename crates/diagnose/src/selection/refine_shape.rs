//! Constants that were tried on a grid, polished; and groups formed again in another problem.

use crate::design::rebuild::{continuous, known, recreate};
use crate::design::transmission::push_transmission;
use std::collections::{HashMap, HashSet};

use crate::design::candidate::Group;
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::regression::admissible::all_admissible;
use crate::regression::elimination::{Integral, WrongBody};
use crate::regression::fit_set::{Answer, answer};
use crate::regression::marginalised::Whitened;
use crate::selection::cross_validation::with_everyday_terms_of;
use crate::selection::prior_scale::Memory;
use armident_model::Load;

/// Share of an order that a ripple of a rotational joint may be off a whole number.
const WHOLE_ORDER: f64 = 0.12;
/// Share of the first step of a constant with which one goes on that was polished before: steps that improve are repeated,
/// so that it gets as far as it has to.
const POLISHED: f64 = 0.125;

/// Polishes the constants that were tried on a grid. Everyday terms of the same joints are fitted beside them, with any
/// sign: what is too small to be named would otherwise be made up for by the constants.
pub(crate) fn refine(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    (scale, wide): (f64, &[WrongBody]),
    memory: &mut Memory,
    found: Answer,
    polished: impl Fn(&Group) -> bool,
) -> Answer {
    let named = found.set.len();
    let unnamed = everyday_beside(problem, (scale, wide), &found, &polished);
    // a problem of the answer's columns alone: trials are then cheap
    let (small, set) = problem.restricted(&[&found.set[..], &unnamed].concat());
    let mut integral = small.integral(scale, wide);
    let best = answer_of(&small.whitened_by(&mut integral), set, named);
    let Some(best) = best else { return found };
    let near = HashMap::new();
    let mut trials = Trials { evidence, at, contact, small, integral, best, named, near };
    for round in 0..2 {
        for k in 0..named {
            let group = trials.group(k).clone();
            if !polished(&group) {
                continue;
            }
            let again = round > 0 || known(memory.polished.iter(), &group).is_some();
            if !again {
                for shape in beside(&group) {
                    trials.improved_by(k, &Group { shape, ..group.clone() });
                }
            }
            for c in 0..continuous(&group) {
                let (mut step, smallest, relative) = step_of(&group, c);
                if again {
                    step *= POLISHED;
                }
                while step > smallest {
                    let moved = |sign: f64| {
                        let mut trial = trials.group(k).clone();
                        if relative {
                            trial.shape[c] *= 1.0 + sign * step;
                        } else {
                            trial.shape[c] += sign * step;
                        }
                        if let Some((_, window)) = &mut trial.site.window {
                            window[c] = trial.shape[c];
                        }
                        let long = |(_, window): &(usize, [f64; 2])| window[1] - window[0] >= step;
                        trial.site.window.as_ref().is_none_or(long).then_some(trial)
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
    let best = best.set[..named].iter().map(|g| &small.groups[*g]);
    let set: Vec<usize> =
        best.clone().filter_map(|g| recreate(evidence, at, contact, problem, g)).collect();
    let new = best.filter(|g| polished(g) && continuous(g) > 0);
    memory.polished.extend(new.cloned());
    answer(&problem.whitened(scale, wide), set).unwrap_or(found)
}

/// An answer, and what to try in its place.
struct Trials<'a, 'e> {
    evidence: &'a Evidence<'e>,
    at: &'a [Posed<'e>],
    contact: &'a ContactColumns,
    small: Problem,
    integral: Integral,
    best: Answer,
    /// so many groups of the answer have a name; the others stand beside them
    named: usize,
    /// loads on links that moved last, by joint and recording
    near: HashMap<usize, Vec<Option<Load>>>,
}

/// Fits a set in its order, of which the first groups have a name; none where it cannot be fitted or these are not
/// admissible.
fn answer_of(metric: &Whitened<'_>, set: Vec<usize>, named: usize) -> Option<Answer> {
    let columns = metric.columns_of(&set);
    let count = columns.len();
    let fit = metric.fit(columns)?;
    all_admissible(metric.problem, &set[..named], &fit).then(|| {
        let score = metric.score(fit.sum_of_squares, count, &set);
        Answer { set, fit, score }
    })
}

/// Everyday terms of the joints on which constants of laws of one joint are polished, where these are admissible. Not
/// beside a coupling: friction of its two joints with any sign is a coupling of another ratio (on a TX40 it took the
/// ratio of the wrist from 0.93 to 0.66, and half of what was gained).
fn everyday_beside(
    problem: &Problem,
    (scale, wide): (f64, &[WrongBody]),
    found: &Answer,
    polished: impl Fn(&Group) -> bool,
) -> Vec<usize> {
    let groups = &problem.groups;
    let shaped: HashSet<usize> = found
        .set
        .iter()
        .map(|g| &groups[*g])
        .filter(|group| polished(group) && !group.shape.is_empty())
        .filter(|group| group.site.joints.len() == 1)
        .flat_map(|group| group.site.joints.iter().copied())
        .collect();
    if shaped.is_empty() || problem.rows.changed_from > 0 {
        return Vec::new();
    }
    let mut all = with_everyday_terms_of(&problem.whitened(scale, wide), found);
    all.retain(|g| {
        !found.set.contains(g) && groups[*g].site.joints.iter().all(|j| shaped.contains(j))
    });
    all
}

impl Trials<'_, '_> {
    /// The trial in the small problem.
    fn formed(&mut self, trial: &Group) -> Option<usize> {
        let (evidence, at, small) = (self.evidence, self.at, &mut self.small);
        if !trial.moves_its_link() {
            return recreate(evidence, at, self.contact, small, trial);
        }
        let (joint, slug) = (trial.site.joints[0], trial.slug());
        let near = self.near.entry(joint).or_default();
        known(small.groups.iter(), trial)
            .or_else(|| push_transmission(evidence, at, small, slug, joint, &trial.shape, near))
    }

    /// Group in this place of the answer.
    fn group(&self, k: usize) -> &Group {
        &self.small.groups[self.best.set[k]]
    }

    /// Takes another group in a place of the answer, if the score is better by it.
    fn improved_by(&mut self, k: usize, trial: &Group) -> bool {
        let mark = self.small.mark();
        let id = self.formed(trial);
        let next = id.and_then(|id| {
            let mut set = self.best.set.clone();
            set[k] = id;
            let metric = self.small.whitened_by(&mut self.integral);
            answer_of(&metric, set, self.named)
        });
        match next.filter(|next| next.score < self.best.score - 1e-3) {
            Some(next) => {
                self.best = next;
                true
            }
            None => {
                self.small.back_to(mark);
                self.integral.truncate(mark.columns);
                false
            }
        }
    }
}

/// Shapes around one that are tried before it is polished: a spring that hardly damps rings in step with the recordings
/// in a narrow band of stiffness only, beside which the misfit has a bottom of its own, at a damping that is too high.
fn beside(group: &Group) -> Vec<Vec<f64>> {
    /// Stiffness over that of the shape, 2 % of the resonance apart, and damping over it.
    const STIFFNESSES: [f64; 11] = [0.8, 0.84, 0.88, 0.92, 0.96, 1.0, 1.04, 1.08, 1.12, 1.16, 1.2];
    const DAMPINGS: [f64; 2] = [0.5, 0.2];
    // a spring too stiff to ring in the band has no shape
    let ("joint_elasticity", &[stiffness, damping]) = (group.slug(), group.shape.as_slice()) else {
        return Vec::new();
    };
    let all = DAMPINGS.iter().flat_map(|d| STIFFNESSES.map(|k| vec![k * stiffness, d * damping]));
    all.collect()
}

/// First step of a constant, the smallest, and whether they are relative.
fn step_of(group: &Group, constant: usize) -> (f64, f64, bool) {
    match group.slug() {
        // the damping of a spring is not known within a factor
        "joint_elasticity" if constant == 1 => (0.6, 0.01, true),
        "joint_elasticity" => (0.16, 0.001, true),
        "external_contact" => (0.16, 0.01, false),
        "torque_ripple" => (0.25, 0.01, false),
        "joint_coupling" => (0.1, 0.002, true),
        _ => (0.16, 0.005, true),
    }
}

/// Joints whose ripple ended at an order that is no whole number.
pub(crate) fn fractional_ripples(
    evidence: &Evidence<'_>,
    problem: &Problem,
    found: &Answer,
) -> Vec<usize> {
    found
        .set
        .iter()
        .map(|g| &problem.groups[*g])
        .filter(|g| {
            g.slug() == "torque_ripple"
                && evidence.chain.joints[g.site.joints[0]].kind.is_rotational()
        })
        .filter(|g| (g.shape[0] - g.shape[0].round()).abs() > WHOLE_ORDER)
        .map(|g| g.site.joints[0])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selection::prior_scale::ChosenBy;
    use crate::test_arms::{STRIBECK, rubbing, stribeck, ur5};
    use armident_model::OperatingPoint;

    /// Viscous friction that nobody names does not change the speed that friction falls in.
    #[test]
    fn what_is_not_named_is_not_made_up_for() {
        let chain = ur5();
        let evidence = rubbing(&chain, 0.3);
        let point = OperatingPoint::of(evidence.joints());
        let at = evidence.at(&point);
        let contact = ContactColumns::new(&evidence, &at);
        let mut problem = evidence.problem(&point);
        let start = stribeck(&evidence, &at, &mut problem, 0.2);
        let found = answer(&problem.whitened(0.0, &[]), vec![start]).unwrap();
        let all = |_: &Group| true;
        let mut memory = Memory::new(ChosenBy::All);
        let found =
            refine(&evidence, &at, &contact, &mut problem, (0.0, &[]), &mut memory, found, all);
        let [group] = found.set[..] else { panic!("{:?}", found.set) };
        let speed = problem.groups[group].shape[0];
        assert!((speed / STRIBECK[2] - 1.0).abs() < 0.015, "{speed}");
    }
}
