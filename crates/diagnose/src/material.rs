//! Materiality: an effect is named when the recordings are worse explained without it by an amount that
//! matters, not when it is merely significant. With some thousand independent samples everything is
//! significant, the imperfection of the model first.

use armident_effects::effect;

use crate::problem::{Meaning, Problem, Whitened};
use crate::search::{Answer, answer};

/// Least root mean square effort, in standard deviations of one recorded sample, that must come back
/// when an effect is removed and all others are fitted again.
pub(crate) const LEAST: f64 = 0.8;
/// The same where inertial errors are fitted too: they absorb part of what comes back.
pub(crate) const LEAST_BESIDE_INERTIA: f64 = 0.6;
/// What a joint's own leftover hides: nothing smaller is named there.
const SHARE_OF_EXCESS: f64 = 0.9;

/// How much an effect matters, on the joint where it matters most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Materiality {
    /// standard deviations of one recorded sample
    pub(crate) value: f64,
    /// least value that is named on that joint
    pub(crate) least: f64,
    pub(crate) joint: usize,
}

impl Materiality {
    pub(crate) fn ratio(&self) -> f64 {
        self.value / self.least
    }
}

/// What is left on each joint beyond its noise, in standard deviations of one recorded sample.
pub(crate) fn excess(problem: &Problem, residual: &[Vec<f64>]) -> Vec<f64> {
    // 1.1: what the estimate of the noise is uncertain by
    const UNCERTAINTY: f64 = 1.1;
    (0..residual.len())
        .map(|j| {
            let left = problem.rows.in_sample_noise(j, &residual[j]);
            let ones: Vec<f64> = problem.rows.weight(j).to_vec();
            let band: Vec<f64> =
                ones.iter().zip(&problem.rows.deviation[j]).map(|(w, d)| w * d).collect();
            let noise = problem.rows.in_sample_noise(j, &band);
            (left * left - UNCERTAINTY * noise * noise).max(0.0).sqrt()
        })
        .collect()
}

/// How much a group of an answer matters: against the answer without it, its simpler relative in its
/// place.
pub(crate) fn materiality(
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
) -> (Materiality, Option<Answer>) {
    let problem = metric.problem;
    let with = metric.residual(&of.fit);
    let left = excess(problem, &with);
    let without = reduced(metric, of, group);
    let least = if metric.scale > 0.0 { LEAST_BESIDE_INERTIA } else { LEAST };
    let mut worst = Materiality { value: 0.0, least, joint: 0 };
    if let Some(without) = &without {
        let rest = metric.residual(&without.fit);
        for j in 0..with.len() {
            let square = |r: &[f64]| problem.rows.in_sample_noise(j, r).powi(2);
            let value = (square(&rest[j]) - square(&with[j])).max(0.0).sqrt();
            let found =
                Materiality { value, least: least.max(SHARE_OF_EXCESS * left[j]), joint: j };
            if found.ratio() > worst.ratio() {
                worst = found;
            }
        }
    }
    (worst, without)
}

/// The answer without a group, its simpler relative in its place where that is admissible.
fn reduced(metric: &Whitened<'_>, of: &Answer, group: usize) -> Option<Answer> {
    let groups = &metric.problem.groups;
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != group).collect();
    let relative = match groups[group].meaning {
        Meaning::Law(slug) => effect(slug).and_then(|law| law.law().contains),
        Meaning::Flexible(_) => None,
    };
    let relative = relative.and_then(|slug| {
        (0..groups.len())
            .find(|&g| groups[g].slug() == slug && groups[g].site == groups[group].site)
    });
    let with_relative = relative.and_then(|g| answer(metric, [rest.clone(), vec![g]].concat()));
    with_relative.or_else(|| {
        // without the name what is left may be inadmissible: the sizes count, not the names
        let columns = metric.columns_of(&rest);
        let count = columns.len();
        let fit = metric.fit(columns)?;
        let score = metric.score(fit.sum_of_squares, count, &rest);
        Some(Answer { set: rest, fit, score })
    })
}

/// Removes what does not matter, the least first; `kept` are never removed.
pub(crate) fn prune(metric: &Whitened<'_>, mut of: Answer, kept: impl Fn(usize) -> bool) -> Answer {
    loop {
        let least = of
            .set
            .iter()
            .filter(|g| !kept(**g))
            .filter_map(|&g| {
                let (size, without) = materiality(metric, &of, g);
                without.map(|without| (size.ratio(), without))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((ratio, without)) if ratio < 1.0 => of = without,
            _ => return of,
        }
    }
}
