//! Choice of the reversal model of each joint's dry friction.
//!
//! A compliant drive train reverses its friction over some hundredths, sometimes a third, of the working speed, or over some
//! thousandths of a radian; a stiff one at once. Findings are selected with the sign of the velocity; the reversal model is
//! chosen afterwards. It rarely decides a finding, and often the prediction error (by 30 % on a UR10).
//!
//! Method: of regularised signs and presliding travels, the one with the lowest cross-validated error, if its gain is
//! significant ([`ReversalCandidates`], as `identify` chooses it).
//! References: P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18), 1968; own (the choice).

use armident_effects::{LawRole, ReversalModel, Scope};
use armident_ident::ReversalCandidates;
use armident_inference::levels::{CLEAR_T, EXPECTED_T};
use armident_model::{OperatingPoint, SHARP};

use crate::design::candidate::Candidate;
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::rebuild::recreate;
use crate::design::training::Design;
use crate::regression::fit_set::fit_set;
use crate::regression::folds::fold_errors;
use crate::selection::cross_validation::{confirm, with_baseline_terms_of};
use crate::selection::materiality::prune;
use crate::selection::solution::Selection;
use crate::selection::sublinear::{beside, push_sublinear, sublinear_joints};

/// The selection with other reversal models where these explain more; none where they do on no joint.
///
/// Linear viscous friction about a reversal that is sublinear looks like a drive train that winds up. So the reversals are
/// chosen once more beside sublinear friction where the first choice leaves that significant.
pub(crate) fn with_reversal_models(design: &Design<'_>, of: &Selection) -> Option<Selection> {
    let first = reversals_shown(design, of, &[]).map(|reversals| reselected(design, of, reversals));
    let beside = match &first {
        Some(found) => joints_with_sublinear_friction(design, found.as_ref()?),
        None => joints_with_sublinear_friction(design, of),
    };
    if beside.is_empty() {
        return first.flatten();
    }
    reselected(design, of, reversals_shown(design, of, &beside)?)
}

/// The selection of these reversal models.
fn reselected(
    design: &Design<'_>,
    of: &Selection,
    reversals: Vec<ReversalModel>,
) -> Option<Selection> {
    let point = OperatingPoint { reversals, ..of.point.clone() };
    let at = design.at(&point);
    let contact = ContactColumns::new(design, &at);
    let mut problem = design.problem(&point);
    let candidates = of.estimate.set.iter().map(|g| &of.problem.candidates[*g]);
    let set = candidates
        .map(|g| recreate(design, &at, &contact, &mut problem, g))
        .collect::<Option<_>>()?;
    let metric = problem.marginalised(of.scale, &of.inflated);
    let found = prune(&metric, fit_set(&metric, set)?, &point);
    let found = confirm(&metric, found, &point);
    drop(metric);
    let inconclusive = Vec::new();
    Some(Selection {
        problem,
        estimate: found,
        scale: of.scale,
        inflated: of.inflated.clone(),
        point,
        inconclusive,
    })
}

/// Joints with significant sublinear friction beside the candidates of a selection and the baseline terms.
fn joints_with_sublinear_friction(design: &Design<'_>, of: &Selection) -> Vec<usize> {
    let set = with_baseline_terms_of(&of.metric(), &of.estimate);
    let (mut small, set) = of.problem.restricted(&set);
    let Some(estimate) = fit_set(&small.marginalised(of.scale, &of.inflated), set) else {
        return Vec::new();
    };
    let at = design.at(&of.point);
    let joints = 0..design.joints();
    let terms = push_sublinear(design, &at, &mut small, joints);
    sublinear_joints(&small, &estimate, &terms, (of.scale, &of.inflated)).unwrap_or_default()
}

/// Reversal model by joint, with sublinear friction on these joints; none where all are the sign of the velocity.
fn reversals_shown(
    design: &Design<'_>,
    of: &Selection,
    sublinear: &[usize],
) -> Option<Vec<ReversalModel>> {
    let set = with_baseline_terms_of(&of.metric(), &of.estimate);
    let (mut small, mut set) = of.problem.restricted(&set);
    if !sublinear.is_empty() {
        let at = design.at(&of.point);
        let terms = push_sublinear(design, &at, &mut small, sublinear.iter().copied());
        let metric = small.marginalised(of.scale, &of.inflated);
        set = beside(&metric, &fit_set(&metric, set)?, &terms)?.set;
    }
    let dry: Vec<usize> = set.iter().copied().filter(|g| is_dry(&small.candidates[*g])).collect();
    if dry.is_empty() {
        return None;
    }
    let candidates = ReversalCandidates::new(SHARP, design.scale.clone());
    // an error is a column that cannot be formed
    let errors = |which, reversals: &[ReversalModel]| -> Result<_, ()> {
        if which == 0 {
            return Ok(fold_errors(&small, &set, of.scale, &of.inflated));
        }
        let point = OperatingPoint { reversals: reversals.to_vec(), ..of.point.clone() };
        let at = design.at(&point);
        let mut problem = small.clone();
        let set = set.iter().map(|&g| match dry.contains(&g) {
            true => turned(design, &at, &mut problem, g),
            false => Some(g),
        });
        let set: Vec<usize> = set.collect::<Option<_>>().ok_or(())?;
        Ok(fold_errors(&problem, &set, of.scale, &of.inflated))
    };
    let which = candidates.choose(|joint, _| least_gain(design, joint), errors).ok()?;
    which
        .iter()
        .any(|which| *which > 0)
        .then(|| which.iter().enumerate().map(|(j, which)| candidates.on(j, *which)).collect())
}

/// Least cross-validated gain of a reversal model on a joint, in standard errors.
fn least_gain(design: &Design<'_>, joint: usize) -> f64 {
    match design.signals.iter().any(|s| s.has_dwell(joint)) {
        true => CLEAR_T,
        false => EXPECTED_T,
    }
}

/// Whether a candidate is dry friction of one joint.
fn is_dry(candidate: &Candidate) -> bool {
    candidate.places.contains(&LawRole::Dry)
        && candidate.location.joints.len() == 1
        && law_of(candidate).is_some()
}

fn law_of(candidate: &Candidate) -> Option<&'static dyn armident_effects::Effect> {
    let law = candidate.law()?;
    (law.law().scope == Scope::Joint).then_some(law)
}

/// The candidate with the reversal models of these recordings, added to a problem.
fn turned(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    candidate: usize,
) -> Option<usize> {
    let of = problem.candidates[candidate].clone();
    design.push_joint_law(problem, at, law_of(&of)?, of.location.joints[0], &of.shape)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::test_arms::{design, ur5};

    /// A selection of Coulomb friction on the first two joints, with the sign of the velocity.
    fn with_coulomb_friction(design: &Design<'_>) -> Selection {
        let point = OperatingPoint::of(design.joints());
        let problem = design.problem(&point);
        let coulomb = |joint: usize| {
            let is = |g: &Candidate| g.slug() == "coulomb_friction" && g.location.joints == [joint];
            problem.candidates.iter().position(is).unwrap()
        };
        let set = vec![coulomb(0), coulomb(1)];
        let found = fit_set(&problem.marginalised(0.0, &[]), set).unwrap();
        let (inflated, inconclusive) = (Vec::new(), Vec::new());
        Selection { problem, estimate: found, scale: 0.0, inflated, point, inconclusive }
    }

    /// Of two joints with Coulomb friction, that of one is linear below 0.04 rad/s (a tenth of its speed).
    #[test]
    fn distinguishes_regularised_from_sharp_reversal() {
        let chain = ur5();
        let design = design(&chain, &chain, |j, v| match j {
            0 => 4.0 * (v / 0.04).clamp(-1.0, 1.0),
            1 => 4.0 * v.signum(),
            _ => 0.0,
        });
        let sharp = with_coulomb_friction(&design);
        let regularised_sign = with_reversal_models(&design, &sharp).unwrap();
        let reversals = &regularised_sign.point.reversals;
        let ReversalModel::RegularisedSign { below } = reversals[0] else {
            panic!("{reversals:?}")
        };
        assert!(
            (0.02..0.05).contains(&below) && reversals[1].regularised_below() < 0.02,
            "{reversals:?}"
        );
        let level = |of: &Selection| {
            of.estimate.fit.of_candidate(&of.problem.candidates[of.estimate.set[0]])[0]
        };
        assert!((level(&regularised_sign) - 4.0).abs() < 0.02, "{}", level(&regularised_sign));
        assert!((level(&sharp) - 4.0).abs() > (level(&regularised_sign) - 4.0).abs());
    }

    /// Of two joints with Coulomb friction, one has presliding over 4 mrad.
    #[test]
    fn distinguishes_presliding_from_coulomb_friction() {
        const TRAVEL_RAD: f64 = 0.004;
        const STEP_S: f64 = 1.0 / 200.0;
        let chain = ur5();
        // samples come in the order of time
        let deflection = Cell::new(0.0);
        let design = design(&chain, &chain, |j, v| match j {
            0 => {
                let side = v.signum();
                let left = (-(v * STEP_S / TRAVEL_RAD).abs()).exp();
                deflection.set(side + (deflection.get() - side) * left);
                4.0 * deflection.get()
            }
            1 => 4.0 * v.signum(),
            _ => 0.0,
        });
        let sharp = with_coulomb_friction(&design);
        let turned = with_reversal_models(&design, &sharp).unwrap();
        let reversals = &turned.point.reversals;
        assert!(
            (0.5..2.0).contains(&(reversals[0].presliding_travel() / TRAVEL_RAD)),
            "{reversals:?}"
        );
        assert!(reversals[1].presliding_travel() < 1e-3, "{reversals:?}");
    }
}
