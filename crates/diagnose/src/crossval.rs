//! Blocked cross-validation: what an effect explains must also be explained in stretches of the
//! recordings that its coefficients have not seen.

use crate::evidence::OperatingPoint;
use crate::material::{held, unnamed_rest};
use crate::problem::{Problem, Whitened};
use crate::rows::Blocks;
use crate::search::{Answer, answer};

/// Stretches that each recording is cut into.
const BLOCKS_PER_RECORDING: usize = 3;

/// The problem of an answer cut into what is fitted and what is predicted.
struct Fold {
    fitted: Problem,
    predicted: Problem,
}

/// Removes effects that do not lower the error of unseen stretches by more than its standard error,
/// the least useful first. Windows are exempt: no other stretch has seen them; so is what the operating
/// point holds.
pub(crate) fn confirm(metric: &Whitened<'_>, mut of: Answer, point: &OperatingPoint) -> Answer {
    loop {
        let (small, ids) = metric.problem.restricted(&with_relatives(metric.problem, &of.set));
        let folds = folds(&small);
        // ids of the restricted problem stand in the order of the groups they were made from
        let originals = with_relatives(metric.problem, &of.set);
        let small_id = |g: usize| originals.iter().position(|o| *o == g).map(|k| ids[k]);
        let set: Vec<usize> = of.set.iter().filter_map(|g| small_id(*g)).collect();
        let errors = |set: &[usize]| -> Vec<Vec<f64>> {
            folds.iter().map(|f| f.errors(set, metric)).collect()
        };
        let with = errors(&set);
        let mut worst: Option<(f64, usize)> = None;
        for &g in &of.set {
            let group = &metric.problem.groups[g];
            if group.site.window.is_some() || !held(group, point).is_empty() {
                continue;
            }
            let rest: Vec<usize> = unnamed_rest(metric.problem, &of.set, g)
                .iter()
                .filter_map(|g| small_id(*g))
                .collect();
            // on the joints where it acts; as a ratio, so that no stretch outweighs the others
            let joints: Vec<usize> = if group.site.joints.is_empty() || group.transform.is_some() {
                (0..metric.problem.rows.joints()).collect()
            } else {
                group.site.joints.clone()
            };
            let total = |errors: &[f64]| joints.iter().map(|j| errors[*j]).sum::<f64>();
            let gains: Vec<f64> = errors(&rest)
                .iter()
                .zip(&with)
                .map(|(without, with)| (total(without) / total(with)).ln())
                .filter(|gain| gain.is_finite())
                .collect();
            if gains.len() < 2 {
                continue;
            }
            let count = gains.len() as f64;
            let mean = gains.iter().sum::<f64>() / count;
            let variance =
                gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
            let ratio = mean / (variance / count).sqrt().max(f64::MIN_POSITIVE);
            if ratio < 1.0 && worst.is_none_or(|w| ratio < w.0) {
                worst = Some((ratio, g));
            }
        }
        let Some((_, g)) = worst else { return of };
        let rest = unnamed_rest(metric.problem, &of.set, g);
        let plain: Vec<usize> = of.set.iter().copied().filter(|o| *o != g).collect();
        match answer(metric, rest).or_else(|| answer(metric, plain)) {
            Some(next) => of = next,
            None => return of,
        }
    }
}

/// The groups of a set and the simpler relatives that could take their places.
fn with_relatives(problem: &Problem, set: &[usize]) -> Vec<usize> {
    let mut all = set.to_vec();
    for &g in set {
        all.extend(unnamed_rest(problem, set, g));
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// One fold for every stretch.
fn folds(problem: &Problem) -> Vec<Fold> {
    let mut folds = Vec::new();
    for pair in problem.rows.starts.windows(2) {
        let length = pair[1] - pair[0];
        for block in 0..BLOCKS_PER_RECORDING {
            let at = |k: usize| pair[0] + k * length / BLOCKS_PER_RECORDING;
            let inside = at(block)..at(block + 1);
            folds.push(Fold {
                fitted: problem.of_rows(|row| !inside.contains(&row)),
                predicted: problem.of_rows(|row| inside.contains(&row)),
            });
        }
    }
    folds
}

impl Fold {
    /// Sum of weighted squares of the stretch that was not fitted, by joint.
    fn errors(&self, set: &[usize], like: &Whitened<'_>) -> Vec<f64> {
        let metric = self.fitted.whitened(like.scale, &like.wide);
        let joints = self.predicted.effort.len();
        let Some(fit) = metric.fit(metric.columns_of(set)) else {
            return vec![f64::INFINITY; joints];
        };
        let errors = metric.inertial_errors(&fit);
        let rigid = errors.iter().enumerate().filter(|(_, x)| **x != 0.0);
        let mut residual: Blocks = self.predicted.effort.clone();
        for (k, x) in rigid.chain(fit.columns.iter().copied().zip(&fit.coefficients)) {
            for (residual, column) in residual.iter_mut().zip(&self.predicted.columns[k]) {
                for (r, c) in residual.iter_mut().zip(column) {
                    *r -= x * c;
                }
            }
        }
        residual.iter().map(|r| r.iter().map(|x| x * x).sum()).collect()
    }
}
