//! Friction that grows more slowly than the speed, beside what was named.
//!
//! Names and their numbers are found with a line over the speed. A line through friction that bends errs at low and at high
//! speed, so that a prediction has the bend where its coefficient is away from zero, as it scatters from stretch to stretch,
//! and stretches that were not fitted are explained no worse: as `identify` chooses it.

use armident_effects::SublinearViscousFriction;
use armident_ident::student_t_975;

use crate::design::candidate::{Group, Meaning};
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::regression::elimination::WrongBody;
use crate::regression::fit_set::{Answer, admissible_part, answer as answer_of};
use crate::regression::folds::{LEFT_OUT_PER_RECORDING, errors_left_out, stretches};
use crate::regression::marginalised::Whitened;
use crate::selection::cross_validation::Predictor;
use crate::selection::solution::Selection;
use crate::uncertainty::jackknife::Scatter;

/// What predicts best with bends on the joints that show one, and the problem that has their groups behind those of the
/// selection; none where no joint does.
pub(crate) fn with_bends(
    evidence: &Evidence<'_>,
    selection: &Selection,
    best: &Predictor,
) -> Option<(Problem, Predictor)> {
    let Predictor { answer, scale } = best;
    let scale = *scale;
    let at = evidence.at(&selection.point);
    let push = |problem: &mut Problem, joint: usize| {
        evidence.push_joint_law(problem, &at, &SublinearViscousFriction, joint, &[])
    };
    let of = |problem: &Problem, answer: &Answer, bends: &[usize]| {
        beside(&problem.whitened(scale, &selection.wide), answer, bends)
    };
    let joints = {
        let (mut small, set) = selection.problem.restricted(&answer.set);
        let answer = answer_of(&small.whitened(scale, &selection.wide), set)?;
        let recorded: Vec<usize> =
            (0..evidence.joints()).filter(|&joint| !small.effort[joint].is_empty()).collect();
        let bends: Vec<usize> =
            recorded.into_iter().filter_map(|joint| push(&mut small, joint)).collect();
        joints_that_bend(&small, &answer, &bends, (scale, &selection.wide))?
    };
    let mut problem = selection.problem.clone();
    let bends: Vec<usize> = joints.iter().filter_map(|&joint| push(&mut problem, joint)).collect();
    let answer = of(&problem, answer, &bends)?;
    Some((problem, Predictor { answer, scale }))
}

/// Joints of bends that are shown beside an answer.
fn joints_that_bend(
    problem: &Problem,
    answer: &Answer,
    bends: &[usize],
    (scale, wide): (f64, &[WrongBody]),
) -> Option<Vec<usize>> {
    let metric = problem.whitened(scale, wide);
    let with = |bends: &[usize]| beside(&metric, answer, bends);
    let is_possible = |bend: &usize| may_bend(problem, answer, *bend) && with(&[*bend]).is_some();
    let possible: Vec<usize> = bends.iter().copied().filter(is_possible).collect();
    let all = with(&possible)?;
    let scatter = Scatter::of(&metric, &all);
    let starts = &problem.rows.starts;
    let quantile = student_t_975(stretches(starts, LEFT_OUT_PER_RECORDING).len() as f64 - 1.0);
    let errors = |set: &[usize]| errors_left_out(problem, set, scale, wide);
    let (before, after) = (errors(&answer.set), errors(&all.set));
    let shown = |bend: &usize| {
        let group = &problem.groups[*bend];
        let (covariance, _) = scatter.covariance(&metric, &all, group);
        let in_errors = all.fit.of_group(group)[0] / covariance[0][0].sqrt();
        let joint = group.site.joints[0];
        let gain: f64 = before.iter().zip(&after).map(|(b, a)| (b[joint] / a[joint]).ln()).sum();
        (in_errors > quantile && gain > 0.0).then_some(joint)
    };
    let there = possible.iter().filter(|bend| all.set.contains(bend));
    let joints: Vec<usize> = there.filter_map(shown).collect();
    (!joints.is_empty()).then_some(joints)
}

/// The answer with bends that have the right sign, in the place of viscous friction where that has the wrong one beside
/// them; none where something else has.
fn beside(metric: &Whitened<'_>, answer: &Answer, bends: &[usize]) -> Option<Answer> {
    let groups = &metric.problem.groups;
    let gives_way = |g: &usize| {
        groups[*g].slug() == "viscous_friction"
            && bends.iter().any(|bend| groups[*bend].site == groups[*g].site)
    };
    let stays: Vec<usize> = answer.set.iter().copied().filter(|g| !gives_way(g)).collect();
    admissible_part(metric, [&answer.set[..], bends].concat(), &stays)
}

/// Whether friction of the joint may bend beside an answer: what is named may have its place, and Stribeck friction bends
/// at a speed of its own.
fn may_bend(problem: &Problem, answer: &Answer, bend: usize) -> bool {
    let bend = &problem.groups[bend];
    let bends_by_itself = |other: &Group| {
        let is_description = matches!(other.meaning, Meaning::SmoothDirections(_));
        other.site == bend.site && (other.slug() == "stribeck_friction" || is_description)
    };
    let mut others = answer.set.iter().map(|g| &problem.groups[*g]);
    !others.any(|other| other.excludes(bend) || bends_by_itself(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{evidence, ur5};
    use armident_model::OperatingPoint;
    use armident_model::is_bend;

    /// Of two joints whose friction grows with the speed one bends; names stay a line's.
    #[test]
    fn friction_that_bends_is_told_from_a_line() {
        const BENDS: usize = 0;
        let chain = ur5();
        let evidence = evidence(&chain, &chain, |j, v| match j {
            BENDS => 2.0 * v.signum() + 3.0 * v.signum() * v.abs().sqrt(),
            1 => 2.0 * v.signum() + 3.0 * v,
            _ => 0.0,
        });
        let point = OperatingPoint::of(evidence.joints());
        let problem = evidence.problem(&point);
        let of = |slug: &str, joint: usize| {
            let is = |g: &Group| g.slug() == slug && g.site.joints == [joint];
            problem.groups.iter().position(is).unwrap()
        };
        let named = ["viscous_friction", "coulomb_friction"];
        let set = named.iter().flat_map(|slug| [of(slug, 0), of(slug, 1)]).collect();
        let viscous = of("viscous_friction", BENDS);
        let answer = answer_of(&problem.whitened(0.0, &[]), set).unwrap();
        let best = Predictor { answer: answer.clone(), scale: 0.0 };
        let (wide, doubtful) = (Vec::new(), Vec::new());
        let selection = Selection { problem, answer, scale: 0.0, wide, point, doubtful };

        let (problem, bent) = with_bends(&evidence, &selection, &best).unwrap();
        let bends: Vec<&Group> = bent
            .answer
            .set
            .iter()
            .map(|g| &problem.groups[*g])
            .filter(|g| is_bend(g.slug()))
            .collect();
        let [bend] = bends[..] else { panic!("{bends:?}") };
        assert_eq!(bend.site.joints, [BENDS]);
        let coefficient = bent.answer.fit.of_group(bend)[0];
        assert!((coefficient - 3.0).abs() < 0.05, "{coefficient}");

        // without the friction that was named its bend goes as well
        let metric = problem.whitened(0.0, &[]);
        let rest = selection.answer.set.iter().copied().filter(|g| *g != viscous).collect();
        let without = answer_of(&metric, rest).unwrap();
        let model = bent.beside(&metric, &selection.answer, &without).unwrap();
        assert!(model.set.iter().all(|g| !is_bend(problem.groups[*g].slug())));
    }
}
