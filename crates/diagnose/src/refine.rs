//! Constants that were tried on a grid, polished; and groups formed again in another problem.

use std::ops::Range;

use armident_effects::{Scope, effect};
use armident_numeric::dot;

use crate::contact::ContactColumns;
use crate::crossval::stretches;
use crate::evidence::{At, Evidence};
use crate::flexible;
use crate::problem::{Group, Meaning, Problem};
use crate::scatter::LEFT_OUT_PER_RECORDING;
use crate::search::{Answer, answer};
use crate::transmission;
use crate::whitened::{Fit, Integral, Whitened, WrongBody};

/// Share of an order that a ripple of a rotational joint may be off a whole number.
const WHOLE_ORDER: f64 = 0.12;

/// The group of a new problem that stands for the same.
pub(crate) fn recreate(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    group: &Group,
) -> Option<usize> {
    match group.site.window {
        Some((recording, window)) => known(problem, group).or_else(|| {
            let id = contact.push(evidence, problem, recording, window);
            problem.groups[id].searched = group.searched;
            Some(id)
        }),
        None => recreate_lasting(evidence, at, problem, group),
    }
}

/// The same of what acts at all times.
pub(crate) fn recreate_lasting(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    group: &Group,
) -> Option<usize> {
    known(problem, group).or_else(|| match &group.meaning {
        Meaning::Law(slug) => {
            let id = formed(evidence, at, problem, slug, group)?;
            problem.groups[id].searched = group.searched;
            Some(id)
        }
        Meaning::Flexible(flexible) => {
            let joint = group.site.joints[0];
            Some(flexible::recreate(evidence, at, problem, joint, flexible))
        }
    })
}

/// The group of a problem that is the same already.
fn known(problem: &Problem, group: &Group) -> Option<usize> {
    problem.groups.iter().position(|other| {
        other.meaning == group.meaning && other.site == group.site && other.shape == group.shape
    })
}

/// A law of joints with the shape of a group, added to a problem.
fn formed(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    slug: &'static str,
    group: &Group,
) -> Option<usize> {
    let law = effect(slug)?;
    let joint = *group.site.joints.first()?;
    match law.law().scope {
        Scope::Joint => evidence.push_joint_law(problem, at, law, joint, &group.shape),
        Scope::Neighbours => Some(evidence.push_pair_law(problem, at, law, joint, &group.shape)),
        Scope::ThroughJoint if !group.shape.is_empty() => {
            transmission::push(evidence, at, problem, slug, joint, &group.shape)
        }
        _ => None,
    }
}

/// Misfit of a shape: all of it, and that of every stretch.
struct Misfit {
    whole: f64,
    by_stretch: Vec<f64>,
}

impl Misfit {
    fn of(metric: &Whitened<'_>, fit: &Fit) -> Self {
        let rows = &metric.problem.rows;
        let residual = metric.residual(fit);
        let in_stretch = |inside: Range<usize>| -> f64 {
            let squares = residual.iter().map(|r| dot(&r[inside.clone()], &r[inside.clone()]));
            rows.share * squares.sum::<f64>()
        };
        let stretches = stretches(&rows.starts[rows.changed_from..], LEFT_OUT_PER_RECORDING);
        Self {
            whole: rows.share * fit.sum_of_squares,
            by_stretch: stretches.into_iter().map(in_stretch).collect(),
        }
    }

    /// How much the stretches disagree about the slope of the misfit, from its values on both sides, twice as much as a
    /// step apart: root sum of squares about the mean.
    fn scatter_of_slope(below: &Self, above: &Self, step: f64) -> f64 {
        let slopes =
            below.by_stretch.iter().zip(&above.by_stretch).map(|(b, a)| (a - b) / (2.0 * step));
        let slopes: Vec<f64> = slopes.collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len().max(1) as f64;
        slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>().sqrt()
    }
}

/// What a shape constant is uncertain by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShapeDeviation {
    /// standard deviation, from the curvature of the misfit with all coefficients fitted again, or where that is more from
    /// how much stretches of the recordings disagree: what a simulated link is off by lasts longer than noise
    pub(crate) by_noise: f64,
    /// change where the efforts are late by a standard deviation of what is not known of it
    pub(crate) by_lag: f64,
}

/// Of a group's shape constants; none for a constant in which the misfit has no bottom. `late`: the
/// problem of the answer's groups with late efforts.
pub(crate) fn shape_deviations(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
    late: Option<&Problem>,
) -> Vec<Option<ShapeDeviation>> {
    // near enough to the curvature once the first step was a standard deviation
    const ROUNDS: usize = 3;
    let problem = metric.problem;
    let (mut small, set) = problem.restricted(&of.set);
    let mut lagging = late.cloned();
    let Some(place) = of.set.iter().position(|g| *g == group) else { return Vec::new() };
    let original = problem.groups[group].clone();
    let Meaning::Law(slug) = original.meaning else { return Vec::new() };
    let misfit = |small: &mut Problem, constant: usize, value: f64| -> Option<Misfit> {
        let mut moved = original.clone();
        moved.shape[constant] = value;
        let mut set = set.clone();
        set[place] = formed(evidence, at, small, slug, &moved)?;
        let metric = small.whitened(metric.scale, &metric.wide);
        let fit = metric.fit(metric.columns_of(&set))?;
        Some(Misfit::of(&metric, &fit))
    };
    (0..original.shape.len())
        .map(|k| {
            let value = original.shape[k];
            let middle = misfit(&mut small, k, value)?.whole;
            let mut step = 1e-2 * value.abs().max(f64::MIN_POSITIVE);
            let mut found = None;
            for _ in 0..ROUNDS {
                let sides = [value - step, value + step];
                let [below, above] = sides.map(|value| misfit(&mut small, k, value));
                let (below, above) = (below?, above?);
                let curvature = (above.whole + below.whole - 2.0 * middle) / (step * step);
                if curvature <= 0.0 {
                    return found;
                }
                let by_curvature = (2.0 / curvature).sqrt();
                let by_stretches = Misfit::scatter_of_slope(&below, &above, step) / curvature;
                let by_noise = by_curvature.max(by_stretches);
                // where the slope of the misfit, changed by the lag, is zero again
                let mut by_lag = 0.0;
                if let Some(lagging) = &mut lagging {
                    let [lower, upper] = sides.map(|value| misfit(lagging, k, value));
                    let (lagging, prompt) =
                        (upper?.whole - lower?.whole, above.whole - below.whole);
                    by_lag = (lagging - prompt) / (2.0 * step * curvature);
                }
                found = Some(ShapeDeviation { by_noise, by_lag });
                step = by_curvature.min(0.3 * value.abs());
            }
            found
        })
        .collect()
}

/// Polishes the constants that were tried on a grid.
pub(crate) fn refine(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    (scale, wide): (f64, &[WrongBody]),
    found: Answer,
    polished: impl Fn(&Group) -> bool,
) -> Answer {
    // a problem of the answer's columns alone: trials are then cheap
    let (small, set) = problem.restricted(&found.set);
    let mut integral = small.integral(scale, wide);
    let Some(best) = answer(&small.whitened_by(&mut integral), set) else { return found };
    let mut trials = Trials { evidence, at, contact, small, integral, best };
    for round in 0..2 {
        for k in 0..trials.best.set.len() {
            let group = trials.group(k).clone();
            if !polished(&group) {
                continue;
            }
            if round == 0 {
                for shape in beside(&group) {
                    trials.improved_by(k, &Group { shape, ..group.clone() });
                }
            }
            let count = if group.slug() == "torque_ripple" { 1 } else { group.shape.len() };
            for c in 0..count {
                let (mut step, smallest, relative) = step_of(&group, c);
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
    let set: Vec<usize> = best
        .set
        .iter()
        .filter_map(|g| recreate(evidence, at, contact, problem, &small.groups[*g].clone()))
        .collect();
    answer(&problem.whitened(scale, wide), set).unwrap_or(found)
}

/// An answer, and what to try in its place.
struct Trials<'a, 'e> {
    evidence: &'a Evidence<'e>,
    at: &'a [At<'e>],
    contact: &'a ContactColumns,
    small: Problem,
    integral: Integral,
    best: Answer,
}

impl Trials<'_, '_> {
    /// Group in this place of the answer.
    fn group(&self, k: usize) -> &Group {
        &self.small.groups[self.best.set[k]]
    }

    /// Takes another group in a place of the answer, if the score is better by it.
    fn improved_by(&mut self, k: usize, trial: &Group) -> bool {
        let mark = self.small.mark();
        let id = recreate(self.evidence, self.at, self.contact, &mut self.small, trial);
        let next = id.and_then(|id| {
            let mut set = self.best.set.clone();
            set[k] = id;
            let metric = self.small.whitened_by(&mut self.integral);
            // keeps the order of groups, so that k stays the same group
            answer(&metric, set.clone()).map(|next| Answer { set, ..next })
        });
        match next.filter(|next| next.score < self.best.score - 1e-3) {
            Some(next) => {
                self.best = next;
                true
            }
            None => {
                self.small.back_to(mark, &mut self.integral);
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
