//! The operating point of the next iteration, from the estimate of this one, and the step of springs and links.
//!
//! Method: Gauss-Newton iteration of the operating terms; Aitken extrapolation of springs and the links behind them.
//! References: A. C. Aitken, On Bernoulli's numerical solution of algebraic equations, Proceedings of the Royal Society of
//! Edinburgh 46, 1926.

use crate::design::candidate::Candidate;
use crate::design::compliant_link::{Posed, mean_inertia};
use crate::design::linear_problem::LinearProblem;
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;
use armident_effects::{LinkSide, OperatingTerm};
use armident_model::{FittedTransmission, OperatingPoint, Spring};

/// The springs of an estimate, beside which its links are fitted.
pub(crate) fn springs(
    metric: &Marginalised<'_>,
    found: &Estimate,
    at: &[Posed<'_>],
) -> Vec<Spring> {
    let candidates = found.set.iter().map(|g| &metric.problem.candidates[*g]);
    candidates
        .filter(|candidate| candidate.has_link_side(LinkSide::Spring))
        .filter_map(|candidate| {
            let joint = candidate.location.joints[0];
            let inertia = mean_inertia(at, joint);
            let transmission =
                FittedTransmission::of_law(candidate.law()?, &candidate.shape, inertia)?;
            Some(Spring { joint, transmission, share: found.fit.of_candidate(candidate)[0] })
        })
        .collect()
}

/// Springs that columns were formed beside, and those then fitted.
pub(crate) struct Step {
    pub(crate) from: Vec<Spring>,
    pub(crate) to: Vec<Spring>,
}

/// Extrapolates the step of springs and links from their last two: the fitted value changes with the operating point by a
/// share of its change, which two steps determine (Aitken 1926). Its fixed point lies beyond the fit where the share is
/// positive, before it where it is negative. A spring and its links are nearly collinear, and the columns of links are
/// linear only near both. The damping is left as it was fitted: it is not collinear with them, and the share of the stiffness is not
/// its own.
pub(crate) fn stride(to: &mut OperatingPoint, from: &OperatingPoint, last: Option<&Step>) {
    /// Largest factor of the fitted step: two steps do not determine a share near one.
    const LONGEST: f64 = 3.0;
    let Some(last) = last else { return };
    let stiffness = |springs: &[Spring], joint: usize| {
        let there = springs.iter().find(|spring| spring.joint == joint);
        there.map(|spring| spring.transmission.stiffness.ln())
    };
    let (mut along, mut moved) = (0.0, 0.0);
    for spring in &to.springs {
        let steps = [&last.from, &last.to, &from.springs, &to.springs];
        let steps = steps.map(|springs| stiffness(springs, spring.joint));
        if let [Some(from_before), Some(to_before), Some(from), Some(to)] = steps {
            along += (to - to_before) * (from - from_before);
            moved += (from - from_before).powi(2);
        }
    }
    if moved == 0.0 {
        return;
    }
    let share = along / moved;
    let factor = 1.0 / (1.0 - share).max(1.0 / LONGEST);
    let scaled = |to: f64, from: f64| from * (to / from).powf(factor);
    for spring in &mut to.springs {
        if let Some(other) = from.springs.iter().find(|other| other.joint == spring.joint) {
            let (to, from) = (&mut spring.transmission.stiffness, other.transmission.stiffness);
            *to = scaled(*to, from);
        }
    }
    if let (Some(to), Some(from)) = (&mut to.links, &from.links) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = from + factor * (*to - from));
    }
}

/// The operating point moved by the coefficients of a fit.
pub(crate) fn moves(
    problem: &LinearProblem,
    found: &Estimate,
    from: &OperatingPoint,
) -> OperatingPoint {
    let mut point = OperatingPoint::of(from.offset.len());
    point.links.clone_from(&from.links);
    point.springs.clone_from(&from.springs);
    point.reversals.clone_from(&from.reversals);
    for &g in &found.set {
        let candidate = &problem.candidates[g];
        let coefficients = found.fit.of_candidate(candidate);
        match candidate.law().and_then(|law| law.law().operating) {
            Some(OperatingTerm::Tilt) => {
                point.tilt = [from.tilt[0] + coefficients[0], from.tilt[1] + coefficients[1]];
            }
            Some(OperatingTerm::Delay) => point.delay_s = from.delay_s + coefficients[0],
            Some(OperatingTerm::EncoderZero) => {
                let j = candidate.location.joints[0];
                point.offset[j] = from.offset[j] + coefficients[0];
            }
            Some(OperatingTerm::Gain) => {
                point.gain[candidate.location.joints[0]] = 1.0 + coefficients[0];
            }
            None => {}
        }
    }
    point
}

/// Change of the links' standard parameters, where an estimate has a transmission or friction that follows the load; none
/// where links have no influence on the columns.
pub(crate) fn other_links(metric: &Marginalised<'_>, found: &Estimate) -> Option<Vec<f64>> {
    let candidates = || found.set.iter().map(|g| &metric.problem.candidates[*g]);
    let matters = |candidate: &Candidate| {
        candidate.moves_its_link()
            || candidate.has_link_side(LinkSide::Spring)
            || candidate.has(|law| law.follows_load)
    };
    if !candidates().any(matters) {
        return None;
    }
    let mut change = metric.inertial_errors(&found.fit);
    for candidate in candidates() {
        candidate.add_to_links(&found.fit.of_candidate(candidate), &mut change);
    }
    change.iter().any(|x| *x != 0.0).then_some(change)
}

/// Whether a move of the operating point no longer matters.
pub(crate) fn has_converged(to: &OperatingPoint, from: &OperatingPoint) -> bool {
    (to.tilt[0] - from.tilt[0]).hypot(to.tilt[1] - from.tilt[1]) < STILL.0
        && to.offset.iter().zip(&from.offset).all(|(a, b)| (a - b).abs() < STILL.1)
        && (to.delay_s - from.delay_s).abs() < STILL.2
        && to.gain.iter().zip(&from.gain).all(|(a, b)| (a - b).abs() < STILL.3)
}

/// Whether the constants of a transmission are those beside which its links were fitted; true of other candidates.
pub(crate) fn is_settled(
    candidate: &Candidate,
    before: &[Candidate],
    point: &OperatingPoint,
) -> bool {
    let near = |a: f64, b: f64| (a / b).ln().abs() < SETTLED;
    if !candidate.moves_its_link() {
        return true;
    }
    if candidate.has_link_side(LinkSide::Spring) {
        let same = |spring: &&Spring| spring.joint == candidate.location.joints[0];
        let fitted_beside = point.springs.iter().find(same);
        return fitted_beside.is_some_and(|s| near(candidate.shape[0], s.transmission.stiffness));
    }
    let same =
        |other: &&Candidate| other.kind == candidate.kind && other.location == candidate.location;
    before.iter().find(same).is_some_and(|other| near(candidate.shape[0], other.shape[0]))
}

/// Moves of the operating point below these no longer matter \[rad, rad or m, s, 1\].
pub(crate) const STILL: (f64, f64, f64, f64) = (1e-3, 5e-4, 2e-4, 2e-3);

/// A stiffness or a gap that moves by less than this share is settled.
pub(crate) const SETTLED: f64 = 5e-3;
