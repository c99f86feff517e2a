//! Significance of changes against a reference that may not exclude them.
//!
//! Hypothesis: a change is zero; the same effect may have been present in the reference, with any size that this allows, and
//! what the model leaves over on a joint may be a function of its position, of the size that it has. F statistic of its
//! coefficients with their block-jackknife covariance, one family-wise level over all candidates (Bonferroni).
//! References: G. A. F. Seber, A. J. Lee, Linear regression analysis, 2003 (F test); own (the reference).

use std::collections::BTreeSet;

use armident_effects::BASELINE;
use armident_inference::f_tail;
use armident_inference::levels::CHANGE_ERROR;
use armident_numeric::Cholesky;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::link_error_prior::as_large_as;
use crate::design::observations::JointColumns;
use crate::design::rebuild::recreate_lasting;
use crate::design::smooth::functions_of_position;
use crate::design::training::Design;
use crate::regression::fit_set::{Estimate, fit_any_sign, fit_set};
use crate::regression::marginalised::Marginalised;
use crate::selection::materiality::{estimate_without, held};
use crate::uncertainty::jackknife::Jackknife;
use armident_model::OperatingPoint;

/// Largest p-value of an insignificant change that is listed as inconclusive.
const LISTED: f64 = 0.05;
/// Knots of the discrepancy over the range of a joint: what gravity, springs and cables leave over changes sign once or twice.
const DISCREPANCY_KNOTS: usize = 6;

/// A change that is not significant.
#[derive(Debug, Clone)]
pub(crate) struct Inconclusive {
    pub(crate) candidate: Candidate,
    /// p-value of the hypothesis that it is zero
    pub(crate) p_value: f64,
    /// whether it is inconclusive only because it may have been present in the reference
    pub(crate) maybe_before: bool,
}

/// Removes insignificant changes, largest p-value first, and returns them as inconclusive. A change is significant only with
/// the same effect free in the reference: where the reference does not excite it, a motion that does would look like a
/// change.
pub(crate) fn certain(
    design: &Design<'_>,
    at: &[Posed<'_>],
    metric: &Marginalised<'_>,
    mut of: Estimate,
    point: &OperatingPoint,
) -> (Estimate, Vec<Inconclusive>) {
    let mut removed: Vec<Inconclusive> = Vec::new();
    if of.set.is_empty() {
        return (of, removed);
    }
    let candidates = &metric.problem.candidates;
    let open = ReferenceUncertainty::of(design, at, metric, &of);
    let most = CHANGE_ERROR / candidates.len() as f64;
    loop {
        let mut inconclusive = open.p_values(metric, &of, point);
        inconclusive.retain(|(p_value, _)| *p_value > most);
        inconclusive.sort_by(|a, b| b.0.total_cmp(&a.0));
        if inconclusive.is_empty() {
            break;
        }
        let closed = ReferenceUncertainty::default().p_values(metric, &of, point);
        // one without which the others have a fit, or else all of them
        let alone =
            inconclusive.iter().find_map(|d| Some((estimate_without(metric, &of, d.1)?, vec![*d])));
        let left =
            of.set.iter().copied().filter(|g| inconclusive.iter().all(|d| d.1 != *g)).collect();
        let next = alone.or_else(|| Some((fit_set(metric, left)?, inconclusive.clone())));
        let Some((next, gone)) = next else { break };
        for (p_value, g) in gone {
            let candidate = candidates[g].clone();
            let maybe_before = closed.iter().any(|(p_value, c)| *c == g && *p_value <= most);
            if removed.iter().all(|inconclusive| !same(&inconclusive.candidate, &candidate)) {
                removed.push(Inconclusive { candidate, p_value, maybe_before });
            }
        }
        of = next;
    }
    removed.retain(|inconclusive| inconclusive.maybe_before || inconclusive.p_value < LISTED);
    removed.retain(|inconclusive| {
        of.set.iter().all(|g| !same(&candidates[*g], &inconclusive.candidate))
    });
    removed.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    (of, removed)
}

/// Whether two candidates are one effect at one place.
fn same(a: &Candidate, b: &Candidate) -> bool {
    a.kind == b.kind && a.location == b.location
}

/// Effects that the reference may have without determining them.
#[derive(Default)]
pub(crate) struct ReferenceUncertainty {
    /// of laws, and of discrepancy
    columns: Vec<JointColumns>,
    /// of each column's coefficient
    deviations: Vec<f64>,
}

impl ReferenceUncertainty {
    /// Those of an estimate. The baseline terms of joints are free in all recordings anyway; contacts are temporary; a
    /// smooth term is no effect.
    pub(crate) fn of(
        design: &Design<'_>,
        at: &[Posed<'_>],
        metric: &Marginalised<'_>,
        of: &Estimate,
    ) -> Self {
        let throughout = design.acting_throughout();
        let mut all = throughout.problem_of_arm(at);
        let mut open = Self::default();
        for &g in &of.set {
            let candidate = &metric.problem.candidates[g];
            let baseline = BASELINE.iter().any(|law| law.law().slug == candidate.slug());
            if baseline
                || candidate.location.window.is_some()
                || matches!(candidate.kind, CandidateKind::SmoothDirections(_))
            {
                continue;
            }
            if let Some(id) = recreate_lasting(&throughout, at, &mut all, candidate) {
                for column in all.candidates[id].columns.iter().map(|c| &all.columns[*c]) {
                    open.deviations.push(as_large_as(&metric.problem.effort, column));
                    open.columns.push(column.clone());
                }
            }
        }
        open.free_discrepancy(&throughout, at, metric, of);
        open
    }

    /// What the model leaves over on the joint of a law may depend on the position: at positions that the reference did not
    /// visit, it would look like a change. It is free in all recordings with the deviation that it has there.
    fn free_discrepancy(
        &mut self,
        throughout: &Design<'_>,
        at: &[Posed<'_>],
        metric: &Marginalised<'_>,
        of: &Estimate,
    ) {
        let candidates = of.set.iter().map(|g| &metric.problem.candidates[*g]);
        let of_one_joint = candidates.filter_map(|candidate| match candidate.location.joints[..] {
            [joint] if candidate.transform.is_none() && !candidate.is_of_link() => Some(joint),
            _ => None,
        });
        let joints: BTreeSet<usize> = of_one_joint.collect();
        if joints.is_empty() {
            return;
        }
        let residual = metric.residual(&of.fit);
        let rows = &metric.problem.observations;
        for joint in joints {
            let in_noise = rows.in_band_noise(joint, &residual[joint]).max(1.0);
            let size = rows.in_sample_noise(joint, &residual[joint]) * rows.sample_deviation[joint];
            let deviation = size * (1.0 - in_noise.powi(-2)).sqrt();
            if deviation == 0.0 {
                continue;
            }
            for column in functions_of_position(throughout, at, joint, DISCREPANCY_KNOTS) {
                let mut columns = vec![Vec::new(); rows.joints()];
                columns[joint] = column;
                self.columns.push(columns);
                self.deviations.push(deviation);
            }
        }
    }

    /// p-values of the candidates of an estimate; a smooth term has none.
    fn p_values(
        &self,
        metric: &Marginalised<'_>,
        of: &Estimate,
        point: &OperatingPoint,
    ) -> Vec<(f64, usize)> {
        let mut problem = self.problem(metric, of);
        // the size of a transmission, elsewhere held at 1, is tested too
        problem.candidates.iter_mut().for_each(|candidate| candidate.is_of_size_one = false);
        let named = of.set.iter().enumerate().filter(|(_, g)| {
            !matches!(metric.problem.candidates[**g].kind, CandidateKind::SmoothDirections(_))
        });
        let Some((opened, fitted)) = fitted(&problem, metric) else {
            return named.map(|(_, g)| (1.0, *g)).collect();
        };
        let jackknife = Jackknife::of(&opened, &fitted);
        let mut reported = Jackknife::of(metric, of);
        self.widen(&mut reported, metric, of);
        let p_value = |(k, g): (usize, usize)| {
            let free = p_value(&opened, &fitted, k, &jackknife, point).unwrap_or(1.0);
            // the reported parameters must differ from zero as well
            if metric.problem.candidates[g].is_of_size_one {
                return free;
            }
            free.max(p_value(metric, of, g, &reported, point).unwrap_or(1.0))
        };
        named.map(|(k, g)| (p_value((k, *g)), *g)).collect()
    }

    /// Widens the standard errors of an estimate to those with these effects free.
    pub(crate) fn widen(
        &self,
        jackknife: &mut Jackknife,
        metric: &Marginalised<'_>,
        of: &Estimate,
    ) {
        let problem = self.problem(metric, of);
        let Some((opened, fitted)) = fitted(&problem, metric) else { return };
        for (g, here) in of.set.iter().zip(&problem.candidates) {
            let covariance = opened.covariance(&fitted.fit, &here.columns);
            let columns = metric.problem.candidates[*g].columns.iter().zip(&here.columns);
            for (k, (column, here)) in columns.enumerate() {
                let change = fitted.fit.coefficient(*here) - of.fit.coefficient(*column);
                jackknife.leave_open(*column, covariance[k][k], change);
            }
        }
    }

    /// The problem of an estimate's candidates, in their order, in which these effects are free in all recordings.
    fn problem(&self, metric: &Marginalised<'_>, of: &Estimate) -> LinearProblem {
        let problem = metric.problem;
        let (small, _) = problem.restricted(&of.set);
        let rigid = problem.rigid;
        let mut link_error_prior = problem.link_error_prior.clone();
        link_error_prior.extend(&self.deviations);
        let (known, own) = small.columns.split_at(rigid);
        let columns = known.iter().chain(&self.columns).chain(own).cloned().collect();
        let mut opened = LinearProblem::new(
            small.observations.clone(),
            small.effort.clone(),
            columns,
            link_error_prior,
        );
        opened.rigid = rigid + self.columns.len();
        opened.candidates = small.candidates;
        for column in opened.candidates.iter_mut().flat_map(|candidate| &mut candidate.columns) {
            *column += self.columns.len();
        }
        opened.known = small.known;
        opened.library = small.library;
        opened
    }
}

/// A problem with effects free in the reference, at the prior scale of a URDF, and the fit of its candidates.
fn fitted<'p>(
    problem: &'p LinearProblem,
    metric: &Marginalised<'_>,
) -> Option<(Marginalised<'p>, Estimate)> {
    let opened = problem.marginalised(metric.scale.max(REFERENCE_SCALE), &metric.inflated);
    // admissibility holds for findings, not for this fit
    let (fitted, _) = fit_any_sign(&opened, (0..problem.candidates.len()).collect())?;
    Some((opened, fitted))
}

/// p-value of the coefficients of a law, all of them together or one of them alone. The residual variance is estimated from
/// the independent samples of the reference. None where they are numerically dependent.
fn p_value(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    jackknife: &Jackknife,
    point: &OperatingPoint,
) -> Option<f64> {
    let candidate = &metric.problem.candidates[candidate];
    let mut coefficients = of.fit.of_candidate(candidate);
    for (column, amount) in held(candidate, point) {
        let place = candidate.columns.iter().position(|c| *c == column)?;
        coefficients[place] += amount;
    }
    let (covariance, _) = jackknife.covariance(metric, of, candidate);
    let count = coefficients.len();
    let cholesky = Cholesky::of(count, |i, j| covariance[i][j])?;
    let samples = samples_before(metric.problem, candidate);
    let tail = |squares: f64, freedom: usize| -> Option<f64> {
        let freedom = freedom as f64;
        f_tail(squares / freedom, freedom, samples)
    };
    let together = cholesky.forward(&coefficients).iter().map(|x| x * x).sum();
    let largest =
        (0..count).map(|k| coefficients[k].powi(2) / covariance[k][k]).fold(0.0, f64::max);
    Some(tail(together, count)?.min(count as f64 * tail(largest, 1)?))
}

/// Independent samples of the joints of a candidate before the change, of the joint that has the fewest.
fn samples_before(problem: &LinearProblem, candidate: &Candidate) -> f64 {
    let rows = &problem.observations;
    let of_joint = |j: usize| {
        let before = &rows.weight(j)[..rows.judged_from()];
        before.iter().filter(|w| **w > 0.0).count() as f64 * rows.weights.share
    };
    let everywhere = candidate.location.joints.is_empty() || candidate.transform.is_some();
    let joints =
        if everywhere { (0..rows.joints()).collect() } else { candidate.location.joints.clone() };
    joints.into_iter().map(of_joint).filter(|n| *n > 0.0).fold(f64::INFINITY, f64::min).max(1.0)
}

/// Prior scale of the first fit of the reference: that of a typical URDF.
pub(crate) const REFERENCE_SCALE: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::transmission::push_transmission;
    use armident_dynamics::RigidArm;

    use crate::test_arms::{swung, ur5};
    use armident_effects::JointElasticity;
    use armident_model::FittedTransmission;
    use armident_model::Spring;
    use armident_motion::BandMotion;

    /// Joints of the changes that stay significant.
    fn stays(
        before: BandMotion,
        after: BandMotion,
        wanted: impl Fn(&Candidate) -> bool,
    ) -> (Vec<Vec<usize>>, Vec<Inconclusive>) {
        let chain = ur5();
        let (design, _) = Design::new(&chain, vec![before, after]).against_reference(1);
        let point = OperatingPoint::of(design.joints());
        let problem = design.problem(&point);
        let at = design.at(&point);
        let all =
            (0..problem.candidates.len()).filter(|g| wanted(&problem.candidates[*g])).collect();
        let metric = problem.marginalised(0.0, &[]);
        let found = fit_set(&metric, all).unwrap();
        let (certain, inconclusive) = certain(&design, &at, &metric, found, &point);
        let joints = certain.set.iter().map(|g| problem.candidates[*g].location.joints.clone());
        (joints.collect(), inconclusive)
    }

    /// A true offset stays, and those that fit noise are removed, whatever else is in the estimate.
    #[test]
    fn insignificant_changes_are_removed() {
        let chain = ur5();
        let before = swung(&chain, 0.1, |_, _| 0.0);
        let after = swung(&chain, 0.1, |j, _| if j == 2 { 0.3 } else { 0.0 });
        let (joints, inconclusive) =
            stays(before, after, |candidate| candidate.slug() == "torque_offset");
        assert_eq!(joints, [[2]]);
        assert!(
            inconclusive.iter().all(|inconclusive| inconclusive.p_value > 1e-4),
            "{inconclusive:?}"
        );
        assert!(inconclusive.iter().all(|inconclusive| !inconclusive.maybe_before));
    }

    /// Two joints that a transmission couples: a noisy reference does not determine whether they were coupled before; a
    /// precise one does.
    #[test]
    fn changes_not_excluded_by_reference_are_removed() {
        let chain = ur5();
        let friction = |v: f64| 0.5 * v + 0.5 * v.signum();
        let coupled = |j: usize, v: &[f64]| if j >= 4 { friction(v[4] + v[5]) } else { 0.0 };
        let is_coupling = |candidate: &Candidate| {
            candidate.slug() == "joint_coupling"
                && candidate.location.joints == [4, 5]
                && candidate.shape == [1.0]
        };
        let after = || swung(&chain, 0.1, coupled);
        let uncoupled = |j: usize, v: &[f64]| if j >= 4 { friction(v[j]) } else { 0.0 };
        for before in [swung(&chain, 50.0, coupled), swung(&chain, 50.0, uncoupled)] {
            let (joints, inconclusive) = stays(before, after(), is_coupling);
            assert!(joints.is_empty(), "{joints:?}");
            assert!(inconclusive[0].maybe_before, "{}", inconclusive[0].p_value);
        }
        let (joints, _) = stays(swung(&chain, 0.1, uncoupled), after(), is_coupling);
        assert_eq!(joints, [[4, 5]]);
    }

    /// A joint that became compliant stays, though the size of its transmission is held at 1.
    #[test]
    fn spring_of_size_one_stays() {
        const JOINT: usize = 1;
        const MOTOR_INERTIA: f64 = 0.2;
        let chain = ur5();
        let transmission = FittedTransmission { gap: 0.0, stiffness: 900.0, damping: 2.0 };
        let spring = Spring { joint: JOINT, transmission, share: 1.0 };
        let point =
            OperatingPoint { springs: vec![spring], ..OperatingPoint::of(chain.joints.len()) };
        let (before, mut after) = (swung(&chain, 0.1, |_, _| 0.0), swung(&chain, 0.1, |_, _| 0.0));
        let rigid = RigidArm::from_chain(&chain);
        let softer =
            transmission.difference(&Posed::new(&chain, &rigid, &after, &point), JOINT).unwrap();
        for (effort, more) in after.effort.iter_mut().zip(softer) {
            effort.iter_mut().zip(more).for_each(|(e, m)| *e += m);
        }
        let accelerated = after.effort[JOINT].iter_mut().zip(&after.acceleration[JOINT]);
        accelerated.for_each(|(e, a)| *e += MOTOR_INERTIA * a);
        let (design, _) = Design::new(&chain, vec![before, after]).against_reference(1);
        let at = design.at(&point);
        let mut problem = design.problem(&point);
        let shape = [transmission.stiffness, transmission.damping];
        let pushed = push_transmission(
            &design,
            &at,
            &mut problem,
            &JointElasticity,
            JOINT,
            &shape,
            &mut Vec::new(),
        );
        let candidate = pushed.unwrap();
        assert!(problem.candidates[candidate].is_of_size_one);
        let metric = problem.marginalised(0.0, &[]);
        let found = fit_set(&metric, vec![candidate]).unwrap();
        let (certain, inconclusive) = certain(&design, &at, &metric, found, &point);
        assert_eq!(certain.set, [candidate], "{inconclusive:?}");
    }
}
