//! What a diagnosis says about its own fit on the hold-out.

use serde::Serialize;

use crate::contract::answer::HoldoutRmse;
use crate::contract::truth::{Floors, PerJoint, Truth};
use crate::score::exam::{ExamScore, ratios};

/// `after` below this share of the noise is too good to be true.
const LEAST_SHARE_OF_NOISE: f64 = 0.9;
/// `before` this factor away from the URDF's error is not the URDF's error.
const OTHER_BEFORE: f64 = 1.25;
/// `after` this share below the error of the exam promises what is not kept.
const OVER_CLAIM: f64 = 0.25;

/// Ratios of the hold-out errors that a diagnosis states.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct HoldoutScore {
    /// `after` over the noise floor, on the affected joints.
    pub after_over_oracle: PerJoint,
    /// `after` over what a careful user attains, on the affected joints.
    pub after_over_attainable: PerJoint,
    /// `after` over the smaller of practical and attainable error, on the affected joints.
    pub after_over_reachable: PerJoint,
    /// `before` over `after`, on the affected joints.
    pub improvement: PerJoint,
    /// What cannot be: better than noise, or a `before` that is not the URDF's.
    pub suspicious: Vec<String>,
    /// Joints on which `after` is lower than the exam's error by more than a quarter.
    pub over_claimed: Vec<String>,
}

pub(crate) fn score_holdout(
    stated: &HoldoutRmse,
    truth: &Truth,
    exam: Option<&ExamScore>,
) -> HoldoutScore {
    let floors = &truth.holdout;
    let affected = |all: PerJoint| -> PerJoint {
        all.into_iter().filter(|(joint, _)| truth.affected_joints.contains(joint)).collect()
    };
    let reachable: PerJoint = floors
        .attainable_rmse
        .iter()
        .map(|(joint, &a)| {
            (joint.clone(), floors.practical_rmse.get(joint).map_or(a, |p| p.min(a)))
        })
        .collect();
    HoldoutScore {
        after_over_oracle: affected(ratios(&stated.after, &floors.oracle_rmse)),
        after_over_attainable: affected(ratios(&stated.after, &floors.attainable_rmse)),
        after_over_reachable: affected(ratios(&stated.after, &reachable)),
        improvement: affected(ratios(&stated.before, &stated.after)),
        suspicious: suspicious(stated, floors),
        over_claimed: exam.map(|exam| over_claimed(stated, truth, exam)).unwrap_or_default(),
    }
}

fn suspicious(stated: &HoldoutRmse, floors: &Floors) -> Vec<String> {
    let mut found = Vec::new();
    for (joint, ratio) in ratios(&stated.after, &floors.oracle_rmse) {
        if ratio < LEAST_SHARE_OF_NOISE {
            found.push(format!("`after` of {joint} is {ratio:.2} of the noise"));
        }
    }
    for (joint, &before) in &stated.before {
        let (Some(&exact), Some(&practical)) =
            (floors.urdf_rmse.get(joint), floors.urdf_rmse_practical.get(joint))
        else {
            continue;
        };
        let (low, high) =
            (exact.min(practical) / OTHER_BEFORE, exact.max(practical) * OTHER_BEFORE);
        if !(low..=high).contains(&before) {
            found.push(format!("`before` of {joint} is {before:.4}, the URDF's is {exact:.4}"));
        }
    }
    found
}

/// The exam may be harder by itself: its error is scaled by what is attainable there.
fn over_claimed(stated: &HoldoutRmse, truth: &Truth, exam: &ExamScore) -> Vec<String> {
    let harder = match (exam.recording, &truth.exam) {
        ("exam", Some(floors)) => ratios(&floors.attainable_rmse, &truth.holdout.attainable_rmse),
        _ => PerJoint::new(),
    };
    let too_low = |(joint, after): &(&String, &f64)| {
        let allowed = harder.get(*joint).copied().unwrap_or(1.0).max(1.0);
        exam.rmse.get(*joint).is_some_and(|rmse| **after < (1.0 - OVER_CLAIM) * rmse / allowed)
    };
    stated.after.iter().filter(too_low).map(|(joint, _)| joint.clone()).collect()
}
