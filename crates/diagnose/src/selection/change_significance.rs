//! What of a change is certain, with what its reference leaves open.

use crate::selection::levels::CHANCE;
use armident_effects::EVERYDAY;
use armident_numeric::Cholesky;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::design::candidate::{Group, Meaning};
use crate::design::compliant_link::Posed;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::design::link_error_prior::as_large_as;
use crate::design::observations::Blocks;
use crate::design::rebuild::recreate_lasting;
use crate::regression::fit_set::{Answer, answer, unnamed};
use crate::regression::marginalised::Whitened;
use crate::selection::materiality::{answer_without, held};
use crate::uncertainty::jackknife::Scatter;
use armident_model::OperatingPoint;

/// A change that is not named is told where it alone would be none less often than this.
const TOLD: f64 = 0.05;

/// A change that is not certain.
#[derive(Debug, Clone)]
pub(crate) struct Doubt {
    pub(crate) group: Group,
    /// chance that it is none
    pub(crate) chance: f64,
    /// whether it is in doubt only because it may have been there before
    pub(crate) maybe_before: bool,
}

/// Removes changes that may be none, the most doubtful first, and tells them. A change is certain where its
/// coefficients are far from nothing although the same effect may have been there before: a reference that does not
/// excite it says nothing of it, and a motion that does would then look like a change.
pub(crate) fn certain(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    metric: &Whitened<'_>,
    mut of: Answer,
    point: &OperatingPoint,
) -> (Answer, Vec<Doubt>) {
    let mut told: Vec<Doubt> = Vec::new();
    if of.set.is_empty() {
        return (of, told);
    }
    let groups = &metric.problem.groups;
    let open = LeftOpen::of(evidence, at, metric, &of);
    let most = CHANCE / groups.len() as f64;
    loop {
        let mut doubtful = open.chances(metric, &of, point);
        doubtful.retain(|(chance, _)| *chance > most);
        doubtful.sort_by(|a, b| b.0.total_cmp(&a.0));
        if doubtful.is_empty() {
            break;
        }
        let closed = LeftOpen::default().chances(metric, &of, point);
        // one that the others can do without, or else all of them
        let alone =
            doubtful.iter().find_map(|d| Some((answer_without(metric, &of, d.1)?, vec![*d])));
        let left = of.set.iter().copied().filter(|g| doubtful.iter().all(|d| d.1 != *g)).collect();
        let next = alone.or_else(|| Some((answer(metric, left)?, doubtful.clone())));
        let Some((next, gone)) = next else { break };
        for (chance, g) in gone {
            let group = groups[g].clone();
            let maybe_before = closed.iter().any(|(chance, c)| *c == g && *chance <= most);
            if told.iter().all(|doubt| !same(&doubt.group, &group)) {
                told.push(Doubt { group, chance, maybe_before });
            }
        }
        of = next;
    }
    told.retain(|doubt| doubt.maybe_before || doubt.chance < TOLD);
    told.retain(|doubt| of.set.iter().all(|g| !same(&groups[*g], &doubt.group)));
    told.sort_by(|a, b| a.chance.total_cmp(&b.chance));
    (of, told)
}

/// Whether two groups are one effect at one place.
fn same(a: &Group, b: &Group) -> bool {
    a.meaning == b.meaning && a.site == b.site
}

/// Effects that may have been there before.
#[derive(Default)]
pub(crate) struct LeftOpen {
    /// of laws
    columns: Vec<Blocks>,
}

impl LeftOpen {
    /// Those of an answer. The everyday terms of joints are free in all recordings anyway; a contact comes and goes; a
    /// description without a name is none of an effect.
    pub(crate) fn of(
        evidence: &Evidence<'_>,
        at: &[Posed<'_>],
        metric: &Whitened<'_>,
        of: &Answer,
    ) -> Self {
        let throughout = evidence.acting_throughout();
        let mut all = throughout.problem_of_arm(at);
        let mut open = Self::default();
        for &g in &of.set {
            let group = &metric.problem.groups[g];
            let everyday = EVERYDAY.iter().any(|law| law.law().slug == group.slug());
            if everyday
                || group.site.window.is_some()
                || matches!(group.meaning, Meaning::SmoothDirections(_))
            {
                continue;
            }
            if let Some(id) = recreate_lasting(&throughout, at, &mut all, group) {
                let columns = all.groups[id].columns.iter();
                open.columns.extend(columns.map(|c| all.columns[*c].clone()));
            }
        }
        open
    }

    /// Chances that groups of an answer are none; a description without a name has none.
    fn chances(
        &self,
        metric: &Whitened<'_>,
        of: &Answer,
        point: &OperatingPoint,
    ) -> Vec<(f64, usize)> {
        let mut problem = self.problem(metric, of);
        // how far from nothing is asked of a size as well that is held at 1 elsewhere
        problem.groups.iter_mut().for_each(|group| group.is_of_size_one = false);
        let named = of.set.iter().enumerate().filter(|(_, g)| {
            !matches!(metric.problem.groups[**g].meaning, Meaning::SmoothDirections(_))
        });
        let Some((opened, fitted)) = fitted(&problem, metric) else {
            return named.map(|(_, g)| (1.0, *g)).collect();
        };
        let scatter = Scatter::of(&opened, &fitted);
        let mut told = Scatter::of(metric, of);
        self.widen(&mut told, metric, of);
        let chance = |(k, g): (usize, usize)| {
            let free = chance(&opened, &fitted, k, &scatter, point).unwrap_or(1.0);
            // nor may the numbers as they are told be none: where the size is held they do not say
            if metric.problem.groups[g].is_of_size_one {
                return free;
            }
            free.max(chance(metric, of, g, &told, point).unwrap_or(1.0))
        };
        named.map(|(k, g)| (chance((k, *g)), *g)).collect()
    }

    /// How far coefficients of an answer can be trusted where this is free.
    pub(crate) fn widen(&self, scatter: &mut Scatter, metric: &Whitened<'_>, of: &Answer) {
        let problem = self.problem(metric, of);
        let Some((opened, fitted)) = fitted(&problem, metric) else { return };
        for (g, here) in of.set.iter().zip(&problem.groups) {
            let covariance = opened.covariance(&fitted.fit, &here.columns);
            let columns = metric.problem.groups[*g].columns.iter().zip(&here.columns);
            for (k, (column, here)) in columns.enumerate() {
                let change = fitted.fit.coefficient(*here) - of.fit.coefficient(*column);
                scatter.leave_open(*column, covariance[k][k], change);
            }
        }
    }

    /// The problem of an answer's groups, in their order, in which these effects are free in all recordings.
    fn problem(&self, metric: &Whitened<'_>, of: &Answer) -> Problem {
        let problem = metric.problem;
        let (small, _) = problem.restricted(&of.set);
        let rigid = problem.rigid;
        let mut background = problem.background.clone();
        let deviations: Vec<f64> =
            self.columns.iter().map(|c| as_large_as(&problem.effort, c)).collect();
        background.extend(&deviations);
        let (known, own) = small.columns.split_at(rigid);
        let columns = known.iter().chain(&self.columns).chain(own).cloned().collect();
        let mut opened =
            Problem::new(small.rows.clone(), small.effort.clone(), columns, background);
        opened.rigid = rigid + self.columns.len();
        opened.groups = small.groups;
        for column in opened.groups.iter_mut().flat_map(|group| &mut group.columns) {
            *column += self.columns.len();
        }
        opened.known = small.known;
        opened
    }
}

/// A problem in which a reference leaves effects open, with links that are no better known than a URDF's, and the fit
/// of its groups.
fn fitted<'p>(problem: &'p Problem, metric: &Whitened<'_>) -> Option<(Whitened<'p>, Answer)> {
    let opened = problem.whitened(metric.scale.max(REFERENCE_SCALE), &metric.wide);
    // signs are asked of what is named, not of this
    let (fitted, _) = unnamed(&opened, (0..problem.groups.len()).collect())?;
    Some((opened, fitted))
}

/// Probability that coefficients of nothing are as far from zero as those of a law: all of them together, or one of
/// them alone. The size of what the model leaves over is known from the independent samples of the reference. None
/// where they are numerically dependent.
fn chance(
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
    scatter: &Scatter,
    point: &OperatingPoint,
) -> Option<f64> {
    let group = &metric.problem.groups[group];
    let mut coefficients = of.fit.of_group(group);
    for (column, amount) in held(group, point) {
        let place = group.columns.iter().position(|c| *c == column)?;
        coefficients[place] += amount;
    }
    let (covariance, _) = scatter.covariance(metric, of, group);
    let count = coefficients.len();
    let cholesky = Cholesky::of(count, |i, j| covariance[i][j])?;
    let samples = samples_before(metric.problem, group);
    let tail = |squares: f64, freedom: usize| -> Option<f64> {
        let freedom = freedom as f64;
        Some(FisherSnedecor::new(freedom, samples).ok()?.sf(squares / freedom))
    };
    let together = cholesky.forward(&coefficients).iter().map(|x| x * x).sum();
    let largest =
        (0..count).map(|k| coefficients[k].powi(2) / covariance[k][k]).fold(0.0, f64::max);
    Some(tail(together, count)?.min(count as f64 * tail(largest, 1)?))
}

/// Independent samples of the joints of a group before the change, of the joint that has the fewest.
fn samples_before(problem: &Problem, group: &Group) -> f64 {
    let rows = &problem.rows;
    let of_joint = |j: usize| {
        let before = &rows.weight(j)[..rows.judged_from()];
        before.iter().filter(|w| **w > 0.0).count() as f64 * rows.share
    };
    let everywhere = group.site.joints.is_empty() || group.transform.is_some();
    let joints = if everywhere { (0..rows.joints()).collect() } else { group.site.joints.clone() };
    joints.into_iter().map(of_joint).filter(|n| *n > 0.0).fold(f64::INFINITY, f64::min).max(1.0)
}

/// Relative inertial error with which the reference is looked at first: what a URDF is off by.
pub(crate) const REFERENCE_SCALE: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::transmission::push_transmission;
    use armident_dynamics::RigidArm;

    use crate::test_arms::{swung, ur5};
    use armident_model::Spring;
    use armident_model::Transmission;
    use armident_motion::Signals;

    /// What stays of these changes, as joints.
    fn stays(
        before: Signals,
        after: Signals,
        wanted: impl Fn(&Group) -> bool,
    ) -> (Vec<Vec<usize>>, Vec<Doubt>) {
        let chain = ur5();
        let mut evidence = Evidence::new(&chain, vec![before, after]);
        evidence.seek_change(1);
        let point = OperatingPoint::of(evidence.joints());
        let problem = evidence.problem(&point);
        let at = evidence.at(&point);
        let all = (0..problem.groups.len()).filter(|g| wanted(&problem.groups[*g])).collect();
        let metric = problem.whitened(0.0, &[]);
        let found = answer(&metric, all).unwrap();
        let (certain, doubts) = certain(&evidence, &at, &metric, found, &point);
        let joints = certain.set.iter().map(|g| problem.groups[*g].site.joints.clone());
        (joints.collect(), doubts)
    }

    /// An offset that came stays, and those that are fitted to noise go, whatever else is in the answer.
    #[test]
    fn what_may_be_chance_goes() {
        let chain = ur5();
        let before = swung(&chain, 0.1, |_, _| 0.0);
        let after = swung(&chain, 0.1, |j, _| if j == 2 { 0.3 } else { 0.0 });
        let (joints, doubts) = stays(before, after, |group| group.slug() == "torque_offset");
        assert_eq!(joints, [[2]]);
        assert!(doubts.iter().all(|doubt| doubt.chance > 1e-4), "{doubts:?}");
        assert!(doubts.iter().all(|doubt| !doubt.maybe_before));
    }

    /// Two joints that a transmission couples: a reference full of noise does not say whether they were coupled
    /// before, whether they were or not; another one does.
    #[test]
    fn what_may_have_been_before_goes() {
        let chain = ur5();
        let friction = |v: f64| 0.5 * v + 0.5 * v.signum();
        let coupled = |j: usize, v: &[f64]| if j >= 4 { friction(v[4] + v[5]) } else { 0.0 };
        let is_coupling = |group: &Group| {
            group.slug() == "joint_coupling" && group.site.joints == [4, 5] && group.shape == [1.0]
        };
        let after = || swung(&chain, 0.1, coupled);
        let uncoupled = |j: usize, v: &[f64]| if j >= 4 { friction(v[j]) } else { 0.0 };
        for before in [swung(&chain, 50.0, coupled), swung(&chain, 50.0, uncoupled)] {
            let (joints, doubts) = stays(before, after(), is_coupling);
            assert!(joints.is_empty(), "{joints:?}");
            assert!(doubts[0].maybe_before, "{}", doubts[0].chance);
        }
        let (joints, _) = stays(swung(&chain, 0.1, uncoupled), after(), is_coupling);
        assert_eq!(joints, [[4, 5]]);
    }

    /// A joint that has become soft stays, though the size of what its spring does is no longer fitted.
    #[test]
    fn a_spring_of_size_one_stays() {
        const JOINT: usize = 1;
        const MOTOR_INERTIA: f64 = 0.2;
        let chain = ur5();
        let transmission = Transmission { gap: 0.0, stiffness: 900.0, damping: 2.0 };
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
        let mut evidence = Evidence::new(&chain, vec![before, after]);
        evidence.seek_change(1);
        let at = evidence.at(&point);
        let mut problem = evidence.problem(&point);
        let shape = [transmission.stiffness, transmission.damping];
        let pushed = push_transmission(
            &evidence,
            &at,
            &mut problem,
            "joint_elasticity",
            JOINT,
            &shape,
            &mut Vec::new(),
        );
        let group = pushed.unwrap();
        assert!(problem.groups[group].is_of_size_one);
        let metric = problem.whitened(0.0, &[]);
        let found = answer(&metric, vec![group]).unwrap();
        let (certain, doubts) = certain(&evidence, &at, &metric, found, &point);
        assert_eq!(certain.set, [group], "{doubts:?}");
    }
}
