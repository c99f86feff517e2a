//! Constants that were tried on a grid, polished; and groups formed again in another problem.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use armident_effects::{Scope, effect};
use armident_numeric::{Cholesky, dot};

use crate::at::At;
use crate::contact::ContactColumns;
use crate::crossval::{stretches, with_everyday_terms_of};
use crate::evidence::Evidence;
use crate::flexible;
use crate::problem::{Group, Meaning, Problem};
use crate::scatter::LEFT_OUT_PER_RECORDING;
use crate::search::{Answer, all_admissible, answer};
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
}

/// What the shape constants of a group are uncertain by, and what the coefficients are by that.
#[derive(Debug, Clone)]
pub(crate) struct ShapeScatter {
    /// the group
    pub(crate) group: usize,
    /// which of its constants; of the others the misfit has no bottom
    pub(crate) constants: Vec<usize>,
    /// covariance of these, from the curvature of the misfit with all coefficients fitted again, or where that is more
    /// from how much stretches of the recordings disagree: what a simulated link is off by lasts longer than noise
    pub(crate) covariance: Vec<Vec<f64>>,
    /// their change where the efforts are late by a standard deviation of what is not known of it
    pub(crate) by_lag: Vec<f64>,
    /// by column of the problem: change of the coefficient over that of each constant
    pub(crate) slopes: BTreeMap<usize, Vec<f64>>,
}

/// A fit with the shape of a group moved.
struct Moved {
    misfit: Misfit,
    /// by column of the problem
    coefficients: BTreeMap<usize, f64>,
}

/// Trials of the shape of one group of an answer, all coefficients fitted again.
struct ShapeTrials<'a, 'e> {
    evidence: &'a Evidence<'e>,
    at: &'a [At<'e>],
    metric: &'a Whitened<'a>,
    of: &'a Answer,
    slug: &'static str,
    original: &'a Group,
    /// place of the group in the answer
    place: usize,
}

impl ShapeTrials<'_, '_> {
    /// In a problem of the answer's groups, `set` in their order.
    fn moved(&self, small: &mut Problem, set: &[usize], shape: &[f64]) -> Option<Moved> {
        let moved = Group { shape: shape.to_vec(), ..self.original.clone() };
        let mut set = set.to_vec();
        set[self.place] = formed(self.evidence, self.at, small, self.slug, &moved)?;
        let metric = small.whitened(self.metric.scale, &self.metric.wide);
        let fit = metric.fit(metric.columns_of(&set))?;
        let pairs = self.of.set.iter().zip(&set).flat_map(|(&g, &here)| {
            let columns = self.metric.problem.groups[g].columns.iter();
            columns.copied().zip(small.groups[here].columns.iter().copied())
        });
        let coefficients = pairs.map(|(column, here)| (column, fit.coefficient(here))).collect();
        Some(Moved { misfit: Misfit::of(&metric, &fit), coefficients })
    }
}

/// Along one constant: a step of about its standard deviation, and the fits on both sides.
struct Along {
    constant: usize,
    step: f64,
    curvature: f64,
    sides: [Moved; 2],
}

/// Of a group of an answer; none where it has no shape, or the misfit no bottom. `late`: the problem of the answer's
/// groups with late efforts. `least_wider`: by what coefficients of the group scatter more than the curvature says, 1 or
/// more.
pub(crate) fn shape_scatter(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
    late: Option<&Problem>,
    least_wider: f64,
) -> Option<ShapeScatter> {
    // near enough to the curvature once the first step was a standard deviation
    const ROUNDS: usize = 3;
    let problem = metric.problem;
    let (mut small, set) = problem.restricted(&of.set);
    let original = &problem.groups[group];
    let Meaning::Law(slug) = original.meaning else { return None };
    let place = of.set.iter().position(|g| *g == group)?;
    let trials = ShapeTrials { evidence, at, metric, of, slug, original, place };
    let shape = &original.shape;
    let middle = trials.moved(&mut small, &set, shape)?.misfit.whole;
    let moved_by = |steps: &[(usize, f64)]| -> Vec<f64> {
        let mut moved = shape.clone();
        steps.iter().for_each(|(k, step)| moved[*k] += step);
        moved
    };
    let mut along: Vec<Along> = Vec::new();
    for (k, value) in shape.iter().enumerate().take(continuous(original)) {
        let mut step = 1e-2 * value.abs().max(f64::MIN_POSITIVE);
        let mut found = None;
        for _ in 0..ROUNDS {
            let mut side = |step: f64| trials.moved(&mut small, &set, &moved_by(&[(k, step)]));
            let (Some(below), Some(above)) = (side(-step), side(step)) else { break };
            let sides = [below, above];
            let [below, above] = sides.each_ref().map(|side| side.misfit.whole);
            let curvature = (above + below - 2.0 * middle) / (step * step);
            if curvature <= 0.0 {
                break;
            }
            let wanted = (2.0 / curvature).sqrt().min(0.3 * value.abs());
            found = Some(Along { constant: k, step, curvature, sides });
            step = wanted;
        }
        along.extend(found);
    }
    if along.is_empty() {
        return None;
    }
    let count = along.len();
    let mut hessian = vec![vec![0.0; count]; count];
    for a in 0..count {
        hessian[a][a] = along[a].curvature;
        for b in 0..a {
            let (one, other) = (&along[a], &along[b]);
            let mut corner = |sign: f64| -> Option<f64> {
                let steps = [(one.constant, sign * one.step), (other.constant, sign * other.step)];
                Some(trials.moved(&mut small, &set, &moved_by(&steps))?.misfit.whole)
            };
            let corners = corner(-1.0)? + corner(1.0)?;
            let on_axes: f64 =
                [one, other].iter().flat_map(|a| &a.sides).map(|side| side.misfit.whole).sum();
            let mixed = (corners - on_axes + 2.0 * middle) / (2.0 * one.step * other.step);
            hessian[a][b] = mixed;
            hessian[b][a] = mixed;
        }
    }
    let inverse = inverse(&hessian).unwrap_or_else(|| {
        // no bottom in some direction between the constants: each by itself
        let alone = |a: usize, b: usize| if a == b { 1.0 / hessian[a][a] } else { 0.0 };
        (0..count).map(|a| (0..count).map(|b| alone(a, b)).collect()).collect()
    });
    let times_inverse = |slope: &[f64]| -> Vec<f64> {
        inverse.iter().map(|row| row.iter().zip(slope).map(|(x, s)| x * s).sum()).collect()
    };
    // how much the stretches disagree about the slope of the misfit
    let by_stretch: Vec<Vec<f64>> = (0..along[0].sides[0].misfit.by_stretch.len())
        .map(|stretch| along.iter().map(|along| along.slope_of_stretch(stretch)).collect())
        .collect();
    let mean = |k: usize| by_stretch.iter().map(|s| s[k]).sum::<f64>() / by_stretch.len() as f64;
    let means: Vec<f64> = (0..count).map(mean).collect();
    let mut by_stretches = vec![0.0; count];
    for slope in &by_stretch {
        let off: Vec<f64> = slope.iter().zip(&means).map(|(s, m)| s - m).collect();
        for (sum, moved) in by_stretches.iter_mut().zip(times_inverse(&off)) {
            *sum += moved * moved;
        }
    }
    let wider: Vec<f64> = (0..count)
        .map(|k| (by_stretches[k] / (2.0 * inverse[k][k])).sqrt().max(least_wider))
        .collect();
    let covariance = (0..count)
        .map(|a| (0..count).map(|b| 2.0 * inverse[a][b] * wider[a] * wider[b]).collect())
        .collect();
    // where the slope of the misfit, changed by the lag, is zero again
    let by_lag = match late {
        None => vec![0.0; count],
        Some(late) => {
            let mut late = late.clone();
            let set: Vec<usize> = (0..of.set.len()).collect();
            let mut slopes = Vec::new();
            for along in &along {
                let mut side = |sign: f64| -> Option<f64> {
                    let shape = moved_by(&[(along.constant, sign * along.step)]);
                    Some(trials.moved(&mut late, &set, &shape)?.misfit.whole)
                };
                let lagging = side(1.0)? - side(-1.0)?;
                let [below, above] = along.sides.each_ref().map(|side| side.misfit.whole);
                slopes.push((above - below - lagging) / (2.0 * along.step));
            }
            times_inverse(&slopes)
        }
    };
    let columns = along[0].sides[0].coefficients.keys();
    let slopes = columns
        .map(|column| {
            let of = |along: &Along| {
                let [below, above] = along.sides.each_ref().map(|side| side.coefficients[column]);
                (above - below) / (2.0 * along.step)
            };
            (*column, along.iter().map(of).collect())
        })
        .collect();
    let constants = along.iter().map(|along| along.constant).collect();
    Some(ShapeScatter { group, constants, covariance, by_lag, slopes })
}

impl Along {
    /// Slope of the misfit of one stretch.
    fn slope_of_stretch(&self, stretch: usize) -> f64 {
        let [below, above] = self.sides.each_ref().map(|side| side.misfit.by_stretch[stretch]);
        (above - below) / (2.0 * self.step)
    }
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

/// Polishes the constants that were tried on a grid. Everyday terms of the same joints are fitted beside them, with any
/// sign: what is too small to be named would otherwise be made up for by the constants.
pub(crate) fn refine(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    (scale, wide): (f64, &[WrongBody]),
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
    let mut trials = Trials { evidence, at, contact, small, integral, best, named };
    for round in 0..2 {
        for k in 0..named {
            let group = trials.group(k).clone();
            if !polished(&group) {
                continue;
            }
            if round == 0 {
                for shape in beside(&group) {
                    trials.improved_by(k, &Group { shape, ..group.clone() });
                }
            }
            for c in 0..continuous(&group) {
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
    let set: Vec<usize> = best.set[..named]
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
    /// so many groups of the answer have a name; the others stand beside them
    named: usize,
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
            answer_of(&metric, set, self.named)
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

/// How many of a group's shape constants are numbers that can be polished: those of a ripple after its order say which
/// harmonics it has.
fn continuous(group: &Group) -> usize {
    if group.slug() == "torque_ripple" { 1 } else { group.shape.len() }
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
    use crate::at::OperatingPoint;
    use crate::made::{evidence, ur5};
    use armident_kinematics::DrivingAxisChain;

    const JOINT: usize = 1;
    /// Static and sliding level \[N m\] and speed \[rad/s\].
    const STRIBECK: [f64; 3] = [9.0, 4.0, 0.15];

    /// An arm with Stribeck friction on a joint, beside viscous friction \[N m s/rad\].
    fn rubbing(chain: &DrivingAxisChain, viscous: f64) -> Evidence<'_> {
        let [highest, sliding, speed] = STRIBECK;
        evidence(chain, chain, |j, v| match j {
            JOINT => {
                let more = (highest - sliding) * (-(v / speed).powi(2)).exp();
                v.signum() * (sliding + more) + viscous * v
            }
            _ => 0.0,
        })
    }

    fn stribeck(
        evidence: &Evidence<'_>,
        at: &[At<'_>],
        problem: &mut Problem,
        speed: f64,
    ) -> usize {
        let law = effect("stribeck_friction").unwrap();
        evidence.push_joint_law(problem, at, law, JOINT, &[speed]).unwrap()
    }

    /// With the speed as one more coefficient, of the derivative of the efforts by it, the linear answer has the
    /// covariance that trials of the speed give.
    #[test]
    fn a_searched_constant_is_as_uncertain_as_a_coefficient_would_be() {
        let chain = ur5();
        let evidence = rubbing(&chain, 0.0);
        let point = OperatingPoint::of(evidence.joints());
        let at = evidence.at(&point);
        let mut problem = evidence.problem_without_trials(&point);
        let speed = STRIBECK[2];
        let id = stribeck(&evidence, &at, &mut problem, speed);
        let sides = [0.999, 1.001].map(|by| stribeck(&evidence, &at, &mut problem, by * speed));
        let metric = problem.whitened(0.0, &[]);
        let found = answer(&metric, vec![id]).unwrap();
        let scatter = shape_scatter(&evidence, &at, &metric, &found, id, None, 1.0).unwrap();

        let columns = problem.groups[id].columns.clone();
        let levels = found.fit.of_group(&problem.groups[id]);
        let efforts = sides.map(|side| -> Vec<f64> {
            let columns = problem.groups[side].columns.iter().map(|c| &problem.columns[*c][JOINT]);
            let mut sum = vec![0.0; problem.rows.len()];
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
            .map(|a| all.iter().map(|b| problem.rows.share * dot(a, b)).collect())
            .collect();
        let covariance = inverse(&gram).unwrap();
        let variance = covariance[2][2];
        // stretches may disagree by more than the curvature says, never by less
        let found_variance = scatter.covariance[0][0];
        assert!((0.9..3.0).contains(&(found_variance / variance)), "{found_variance} {variance}");
        for (k, column) in columns.iter().enumerate() {
            let [expected, got] = [covariance[k][2] / variance, scatter.slopes[column][0]];
            assert!((got - expected).abs() < 0.05 * expected.abs(), "{k}: {got} {expected}");
        }
    }

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
        let found = refine(&evidence, &at, &contact, &mut problem, (0.0, &[]), found, all);
        let [group] = found.set[..] else { panic!("{:?}", found.set) };
        let speed = problem.groups[group].shape[0];
        assert!((speed / STRIBECK[2] - 1.0).abs() < 0.015, "{speed}");
    }

    /// How many harmonics a ripple has is no number that is a little more or less.
    #[test]
    fn of_a_ripple_the_order_is_uncertain() {
        let chain = ur5();
        let evidence = rubbing(&chain, 0.0);
        let point = OperatingPoint::of(evidence.joints());
        let at = evidence.at(&point);
        let mut problem = evidence.problem_without_trials(&point);
        let law = effect("torque_ripple").unwrap();
        let id = evidence.push_joint_law(&mut problem, &at, law, JOINT, &[7.0, 2.0]).unwrap();
        let metric = problem.whitened(0.0, &[]);
        let found = answer(&metric, vec![id]).unwrap();
        let scatter = shape_scatter(&evidence, &at, &metric, &found, id, None, 1.0);
        assert!(scatter.is_none_or(|scatter| scatter.constants == [0]));
    }
}
