//! Dry friction that builds up over a travel since the last reversal, in the place of one that turns with the speed.
//!
//! Names and their numbers are found with dry friction that turns at once, or below a speed (`fading.rs`). Where the travel
//! since a reversal explains stretches that were not fitted better, a prediction has that: friction at a reversal is no
//! function of the speed, only near one where all reversals are alike.

use armident_effects::{Effect, PreslidingHysteresis};

use crate::crossval::{Predictor, errors_left_out, in_standard_errors};
use crate::evidence::Evidence;
use crate::fading::least_gain;
use crate::problem::Problem;
use crate::search::admissible_part;
use crate::select::Selection;

/// What predicts best with friction that builds up on joints whose stretches say so, and the problem that has it behind
/// the groups of the selection; none where no joint does.
pub(crate) fn with_travels(
    evidence: &Evidence<'_>,
    selection: &Selection,
    best: &Predictor,
) -> Option<(Problem, Predictor)> {
    let law = &PreslidingHysteresis;
    let at = evidence.at(&selection.point);
    let push = |problem: &mut Problem, joint: usize, shape: &[f64]| {
        evidence.push_joint_law(problem, &at, law, joint, shape)
    };
    let (small, set) = selection.problem.restricted(&best.answer.set);
    let dry = |problem: &Problem, set: &[usize], joint: usize| -> Option<usize> {
        let is = |g: &&usize| {
            let group = &problem.groups[**g];
            group.slug() == "coulomb_friction" && group.site.joints == [joint]
        };
        set.iter().find(is).copied()
    };
    let joints: Vec<usize> =
        (0..evidence.joints()).filter(|&joint| dry(&small, &set, joint).is_some()).collect();
    let errors = |problem: &Problem, set: &[usize]| {
        errors_left_out(problem, set, best.scale, &selection.wide)
    };
    let before = errors(&small, &set);
    let shapes: Vec<Vec<Vec<f64>>> = evidence.scale.iter().map(|s| law.shapes(s)).collect();
    let tried = shapes.iter().map(Vec::len).max().unwrap_or(0);
    let mut found: Vec<(f64, Option<&[f64]>)> = vec![(0.0, None); evidence.joints()];
    for k in 0..tried {
        let mut problem = small.clone();
        let mut with = set.clone();
        for &joint in &joints {
            let (Some(shape), Some(dry)) = (shapes[joint].get(k), dry(&small, &set, joint)) else {
                continue;
            };
            if let Some(travelled) = push(&mut problem, joint, shape) {
                with.iter_mut().filter(|g| **g == dry).for_each(|g| *g = travelled);
            }
        }
        let after = errors(&problem, &with);
        for &joint in &joints {
            let gains: Vec<f64> =
                before.iter().zip(&after).map(|(b, a)| (b[joint] / a[joint]).ln()).collect();
            let mean = gains.iter().sum::<f64>() / gains.len() as f64;
            if mean > found[joint].0 && in_standard_errors(&gains) > least_gain(evidence, joint) {
                found[joint] = (mean, shapes[joint].get(k).map(Vec::as_slice));
            }
        }
    }
    let mut problem = selection.problem.clone();
    let mut instead = Vec::new();
    for (joint, (_, shape)) in found.iter().enumerate() {
        let (Some(shape), Some(dry)) = (shape, dry(&problem, &best.answer.set, joint)) else {
            continue;
        };
        instead.push((dry, push(&mut problem, joint, shape)?));
    }
    if instead.is_empty() {
        return None;
    }
    let metric = problem.whitened(best.scale, &selection.wide);
    let with: Vec<usize> = best.answer.set.iter().map(|g| replaced(&instead, *g)).collect();
    let answer = admissible_part(&metric, with.clone(), &with)?;
    drop(metric);
    Some((problem, Predictor { answer, scale: best.scale, instead }))
}

/// What stands in the place of a group.
pub(crate) fn replaced(instead: &[(usize, usize)], group: usize) -> usize {
    instead.iter().find(|(of, _)| *of == group).map_or(group, |(_, by)| *by)
}
