//! Least squares with non-negativity constraints on some unknowns.

use faer::Mat;

use crate::accumulate::AccumulatedQr;
use crate::least_squares::{LeastSquares, NumericError};

/// An unknown leaves its bound when the residual falls along it by more than round-off: correlation
/// of its column with the residual.
const PULL: f64 = 1e-10;

/// Least squares with bounds.
#[derive(Debug, Clone)]
pub struct NonNegative {
    /// The solution; unknowns at their bound are 0, also in the covariance. Rank, condition number and
    /// undetermined directions are those without bounds: they describe the rows.
    pub answer: LeastSquares,
    /// Per unknown, whether its bound holds it at 0.
    pub at_bound: Vec<bool>,
}

impl AccumulatedQr {
    /// Solves `A x ≈ y` with `x_k >= 0` wherever `bound[k]`, by active sets.
    ///
    /// A feasible unconstrained solution is returned unchanged. Otherwise Lawson and Hanson's method
    /// starts from the clipped solution: the residual falls at every step, so no active set repeats.
    ///
    /// Source: C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974), chapter 23.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When `bound` does not have an entry per unknown.
    pub fn solve_non_negative(
        &self,
        bound: &[bool],
        rank_cut: f64,
    ) -> Result<NonNegative, NumericError> {
        let p = self.unknowns();
        assert_eq!(bound.len(), p, "one entry per unknown");
        let plain = self.solve(rank_cut)?;
        if (0..p).all(|k| !bound[k] || plain.solution[k] >= 0.0) {
            return Ok(NonNegative { answer: plain, at_bound: vec![false; p] });
        }
        let mut held: Vec<bool> = (0..p).map(|k| bound[k] && plain.solution[k] <= 0.0).collect();
        let mut x: Vec<f64> =
            (0..p).map(|k| if held[k] { 0.0 } else { plain.solution[k] }).collect();
        let norms = self.column_norms();
        let mut found = self.solve_free(&held, rank_cut)?;
        // each pass holds or releases at least one unknown; no set comes twice, few are ever seen
        for _ in 0..3 * p {
            loop {
                // share of the way to the solution at which each unknown would change its sign
                let steps: Vec<(usize, f64)> = (0..p)
                    .filter(|&k| bound[k] && !held[k] && found.solution[k] < 0.0)
                    .map(|k| (k, x[k] / (x[k] - found.solution[k])))
                    .collect();
                let Some(step) = steps.iter().map(|s| s.1).min_by(f64::total_cmp) else { break };
                for k in 0..p {
                    x[k] += step * (found.solution[k] - x[k]);
                }
                for (k, _) in steps.iter().filter(|s| s.1 <= step) {
                    held[*k] = true;
                    x[*k] = 0.0;
                }
                found = self.solve_free(&held, rank_cut)?;
            }
            x.clone_from(&found.solution);
            let pull = self.residual_moments(&x);
            let residual = self.residual_sum_of_squares(&x).sqrt();
            let release = (0..p)
                .filter(|&k| held[k] && norms[k] > 0.0 && pull[k] > PULL * norms[k] * residual)
                .max_by(|&a, &b| (pull[a] / norms[a]).total_cmp(&(pull[b] / norms[b])));
            let Some(release) = release else { break };
            held[release] = false;
            found = self.solve_free(&held, rank_cut)?;
            if found.solution[release] <= 0.0 {
                // pulled by round-off alone
                held[release] = true;
                found = self.solve_free(&held, rank_cut)?;
                break;
            }
        }
        let answer = LeastSquares {
            solution: x,
            unit_covariance: found.unit_covariance,
            residual_sum_of_squares: found.residual_sum_of_squares,
            ..plain
        };
        Ok(NonNegative { answer, at_bound: held })
    }

    /// Solves with some unknowns held at 0; they are 0 in solution and covariance.
    fn solve_free(&self, held: &[bool], rank_cut: f64) -> Result<LeastSquares, NumericError> {
        let p = self.unknowns();
        let free: Vec<usize> = (0..p).filter(|&k| !held[k]).collect();
        let found = self.with_unknowns(&free).solve(rank_cut)?;
        let place: Vec<Option<usize>> = (0..p).map(|k| free.iter().position(|&f| f == k)).collect();
        Ok(LeastSquares {
            solution: place.iter().map(|at| at.map_or(0.0, |i| found.solution[i])).collect(),
            unit_covariance: Mat::from_fn(p, p, |i, j| match (place[i], place[j]) {
                (Some(i), Some(j)) => found.unit_covariance[(i, j)],
                _ => 0.0,
            }),
            ..found
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of five columns, not orthogonal, whose solution without bounds is `x`.
    fn rows(x: [f64; 5], seed: f64) -> AccumulatedQr {
        let mut qr = AccumulatedQr::new(5);
        let lines: Vec<Vec<f64>> = (0..40)
            .map(|i| {
                let t = f64::from(i);
                let mut row: Vec<f64> =
                    (1..6).map(|k| 1.0 + (seed + 0.37 * t * f64::from(k)).sin()).collect();
                let y = row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
                row.push(y + 0.1 * (3.1 * t + seed).cos());
                row
            })
            .collect();
        qr.push_rows(&lines);
        qr
    }

    #[test]
    fn finds_best_active_set() {
        let bound = [true, true, false, true, true];
        for case in 0..20 {
            let seed = 0.7 * f64::from(case);
            let qr = rows([0.3 * seed.sin(), -0.2, -1.0, 0.4 * seed.cos(), -0.3], seed);
            let found = qr.solve_non_negative(&bound, 1e-12).unwrap();
            let mut best = f64::INFINITY;
            for set in 0..32_u32 {
                let held: Vec<bool> = (0..5).map(|k| bound[k] && set >> k & 1 == 1).collect();
                let tried = qr.solve_free(&held, 1e-12).unwrap();
                if (0..5).all(|k| !bound[k] || tried.solution[k] >= 0.0) {
                    best = best.min(tried.residual_sum_of_squares);
                }
            }
            let off = found.answer.residual_sum_of_squares - best;
            assert!(off.abs() <= 1e-10 * (1.0 + best), "case {case}: {off}");
            for k in 0..5 {
                let x = found.answer.solution[k];
                assert!(!bound[k] || x >= 0.0);
                assert_eq!(found.at_bound[k], x == 0.0, "case {case}, unknown {k}");
            }
        }
    }

    #[test]
    fn all_parameters_may_be_at_bound() {
        let qr = rows([-1.0; 5], 0.2);
        let found = qr.solve_non_negative(&[true; 5], 1e-12).unwrap();
        assert_eq!(found.answer.solution, vec![0.0; 5]);
        assert_eq!(found.at_bound, vec![true; 5]);
    }
}
