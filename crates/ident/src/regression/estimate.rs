//! Weighted least squares of a batch problem.
//!
//! Method: feasible generalised least squares. Each joint's rows are weighted by its noise level, which is estimated
//! from its residual and its share of the degrees of freedom until it moves no more; sign constraints by an active set,
//! priors as rows. Samples of a low-passed recording are dependent, so covariances count only independent ones.
//!
//! References: W. H. Greene, Econometric Analysis (feasible generalised least squares); M. Gautier, P. Poignet, Extended Kalman filtering
//! and weighted least squares dynamic identification of robot, Control Eng. Practice 9 (2001); C. L. Lawson, R. J.
//! Hanson, Solving Least Squares Problems (1974) for the bounds.

use armident_numeric::{AccumulatedQr, LeastSquares, Mat, NonNegative, NumericError};

use super::joint_rows::JointRows;
use super::prior::{BatchSettings, Regularisation, TermPrior, triangle_of};
use super::problem::BatchProblem;
use super::unknown::Term;
use armident_inference::student_t_975;

/// Relative rank cut of unit columns: only what is exactly undetermined is cut, what is badly
/// determined shows in its standard error.
pub(crate) const RANK_CUT: f64 = 1e-9;
/// Reweighting ends when no joint's noise level moves by more than this share.
const WEIGHT_TOLERANCE: f64 = 1e-6;
const MOST_REWEIGHTINGS: usize = 50;

/// Effort error of one joint on a set of recordings, on the filtered effort.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFit {
    /// Root mean square of the residual \[N m or N\].
    pub rmse: f64,
    /// `norm(residual) / norm(effort - mean)`.
    pub relative: f64,
}

/// Estimates with their covariance, and what the recordings determine.
#[derive(Debug, Clone)]
pub struct BatchEstimate {
    /// One value per term of the problem.
    pub values: Vec<f64>,
    /// Covariance of the values, counting only independent samples, the prior included; rows and
    /// columns of terms at their bound are zero.
    pub covariance: Mat<f64>,
    /// A root `R` of the information matrix `RᵀR`, which counts only independent samples, the prior
    /// included; without regard to bounds.
    pub information_root: Mat<f64>,
    /// Per term, whether its sign bound holds it at 0.
    pub at_bound: Vec<bool>,
    /// Per term, share of its information that comes from the prior, 0 to 1 (one minus the resolution of the
    /// recordings).
    pub prior_share: Vec<f64>,
    /// Half-width factor of 95 % intervals.
    pub quantile_95: f64,
    /// Noise level of each joint's filtered effort \[N m or N\].
    pub effort_noise: Vec<f64>,
    /// Numerical rank of the recordings alone.
    pub rank: usize,
    /// Condition number of the weighted unit columns, of the recordings alone.
    pub condition: f64,
    /// Per term: share of its direction that the recordings do not determine, 0 to 1.
    pub undetermined: Vec<f64>,
    /// Rows used, all joints.
    pub rows: usize,
    /// Independent samples over samples.
    pub independent_share: f64,
    /// Fit on the training recordings.
    pub train: Vec<JointFit>,
    /// By-products of the estimator.
    pub notes: Vec<EstimateNote>,
}

/// A by-product of an estimator.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum EstimateNote {
    /// Test of least squares against instrumental variables.
    Endogeneity(Endogeneity),
    /// A sentence for the reader.
    Remark(String),
}

/// Durbin-Wu-Hausman test, term by term.
///
/// Hypothesis: the regressors have no noise, so that least squares and instrumental variables agree. Statistic: their
/// difference over its standard error from blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Endogeneity {
    /// Term that differs most.
    pub term: usize,
    /// Instrumental minus weighted least-squares value, over the standard error of the difference.
    pub t: f64,
    /// Probability of as large a difference of any term under the hypothesis (Bonferroni).
    pub p: f64,
}

impl BatchEstimate {
    /// The endogeneity test, where the estimator has made one.
    pub fn endogeneity(&self) -> Option<Endogeneity> {
        self.notes.iter().find_map(|note| match note {
            EstimateNote::Endogeneity(found) => Some(*found),
            EstimateNote::Remark(_) => None,
        })
    }

    /// Correlation of every pair of terms; none of those at their bound, which do not vary.
    pub fn correlations(&self) -> Vec<Vec<Option<f64>>> {
        let of = |a: usize, b: usize| self.covariance[(a, b)];
        let pair = |a, b| {
            let correlation = of(a, b) / (of(a, a) * of(b, b)).sqrt();
            correlation.is_finite().then_some(correlation)
        };
        let count = self.values.len();
        (0..count).map(|a| (0..count).map(|b| pair(a, b)).collect()).collect()
    }

    /// Whether term `k` is significant: its 95 % interval excludes 0.
    pub fn is_significant(&self, k: usize) -> bool {
        self.standard_error(k).is_some_and(|error| self.values[k].abs() > self.quantile_95 * error)
    }

    /// Standard error of term `k`; none is claimed for a term at its bound.
    pub fn standard_error(&self, k: usize) -> Option<f64> {
        (!self.at_bound[k]).then(|| self.covariance[(k, k)].sqrt())
    }
}

impl BatchProblem {
    /// Solves for all terms, each joint weighted by its own noise, with the default settings.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate(&self, rows: &JointRows) -> Result<BatchEstimate, NumericError> {
        self.estimate_with(rows, &BatchSettings::default())
    }

    /// Solves for all terms, each joint weighted by its own noise.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate_with(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, NumericError> {
        let n = self.arm().dof();
        let count = |joint: usize| rows.effort[joint].0 as f64;
        let regularisation = self.regularisation(settings)?;
        let least = self.least_noise(rows)?;
        // first weights: what each joint alone cannot fit
        let mut noise = self.noise_alone(rows)?;
        let mut solved = self.weighted(rows, &noise, &regularisation)?;
        let mut freedom = 0.0;
        for _ in 0..MOST_REWEIGHTINGS {
            let mut moved = 0.0_f64;
            freedom = 0.0;
            for joint in 0..n {
                let terms = &self.by_joint[joint];
                let pick = |v: &[f64]| terms.iter().map(|&k| v[k]).collect::<Vec<_>>();
                let own = Mat::from_fn(terms.len(), terms.len(), |i, j| {
                    solved.answer.unit_covariance[(terms[i], terms[j])]
                });
                let paid = rows.triangles[joint].trace_with(&own) / noise[joint].powi(2);
                let squares =
                    rows.triangles[joint].residual_sum_of_squares(&pick(&solved.answer.solution));
                let independent = count(joint) * rows.share;
                let left = (independent - paid).max(1.0);
                freedom += left;
                let level = (squares * rows.share / left).sqrt().max(least[joint]);
                moved = moved.max((level / noise[joint] - 1.0).abs());
                noise[joint] = level;
            }
            solved = self.weighted(rows, &noise, &regularisation)?;
            if moved < WEIGHT_TOLERANCE {
                break;
            }
        }
        self.finished(rows, &regularisation, noise, freedom, solved)
    }

    /// Root mean square of what the columns of each joint alone leave of its effort, or the least noise.
    pub(crate) fn noise_alone(&self, rows: &JointRows) -> Result<Vec<f64>, NumericError> {
        let least = self.least_noise(rows)?;
        let joints = rows.triangles.iter().enumerate().zip(least);
        joints.map(|((j, triangle), least)| Ok(noise_of(triangle, rows, j)?.max(least))).collect()
    }

    /// Lower bound of each joint's noise: with a dead zone, the residual of the URDF's body beside the joint's own terms; else
    /// rounding.
    fn least_noise(&self, rows: &JointRows) -> Result<Vec<f64>, NumericError> {
        let described = self.set().values(&self.arm().constants());
        let of_joint = |(joint, triangle): (usize, &AccumulatedQr)| {
            if !self.has_dead_zone[joint] {
                return Ok(rounding(rows, joint));
            }
            let terms = &self.by_joint[joint];
            let body = terms.iter().map(|&k| match self.terms[k] {
                Term::Constant(c) => described[c],
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
            });
            let beyond = triangle.beyond(&body.collect::<Vec<_>>());
            let own: Vec<usize> = (0..terms.len())
                .filter(|&place| !matches!(self.terms[terms[place]], Term::Constant(_)))
                .collect();
            noise_of(&beyond.with_unknowns(&own), rows, joint)
        };
        rows.triangles.iter().enumerate().map(of_joint).collect()
    }

    /// Solves for all terms at given noise levels of the joints \[N m or N\].
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate_at_noise(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
        noise: Vec<f64>,
    ) -> Result<BatchEstimate, NumericError> {
        self.solve_at_noise(rows, &self.regularisation(settings)?, noise)
    }

    /// The same with a regularisation that is formed already.
    pub(crate) fn solve_at_noise(
        &self,
        rows: &JointRows,
        regularisation: &Regularisation,
        noise: Vec<f64>,
    ) -> Result<BatchEstimate, NumericError> {
        let solved = self.weighted(rows, &noise, regularisation)?;
        let independent = rows.share * rows.effort.iter().map(|e| e.0 as f64).sum::<f64>();
        let freedom = (independent - self.terms.len() as f64).max(1.0);
        self.finished(rows, regularisation, noise, freedom, solved)
    }

    /// The estimate of a solution: covariance, rank, and fit.
    pub(crate) fn finished(
        &self,
        rows: &JointRows,
        regularisation: &Regularisation,
        noise: Vec<f64>,
        freedom: f64,
        solved: NonNegative,
    ) -> Result<BatchEstimate, NumericError> {
        let NonNegative { answer, at_bound } = solved;
        let p = self.terms.len();
        let covariance = Mat::from_fn(p, p, |i, j| answer.unit_covariance[(i, j)] / rows.share);
        let information_root =
            self.information(rows, &noise, regularisation).0.root(rows.share.sqrt());
        let train = self.fit(rows, &answer.solution);
        // rank and the like are of the recordings, whatever the prior
        let (prior_share, recorded) = match &regularisation.prior {
            Some(prior) => {
                let recorded = self.recorded(rows, &noise).solve(RANK_CUT)?;
                (prior.share_of(&covariance), recorded)
            }
            None => (vec![0.0; p], answer.clone()),
        };
        let LeastSquares { rank, condition, undetermined, .. } = recorded;
        Ok(BatchEstimate {
            values: answer.solution,
            covariance,
            information_root,
            at_bound,
            prior_share,
            quantile_95: student_t_975(freedom),
            effort_noise: noise,
            rank,
            condition,
            undetermined,
            rows: rows.effort.iter().map(|e| e.0).sum(),
            independent_share: rows.share,
            train,
            notes: Vec::new(),
        })
    }

    /// All joints' rows, each over its noise. Errors of a dead zone do not average out over samples: they count as one.
    fn recorded(&self, rows: &JointRows, noise: &[f64]) -> AccumulatedQr {
        let mut all = AccumulatedQr::new(self.terms.len());
        for (joint, triangle) in rows.triangles.iter().enumerate() {
            let independent = (rows.share * rows.effort[joint].0 as f64).max(1.0);
            let alike = if self.has_dead_zone[joint] { independent.sqrt() } else { 1.0 };
            all.merge_weighted(triangle, &self.by_joint[joint], 1.0 / (alike * noise[joint]));
        }
        all
    }

    /// All joints' rows and the prior's. With a prior, unknowns are distances from its mean, which is
    /// given back: what neither determines stays at the mean.
    pub(crate) fn information(
        &self,
        rows: &JointRows,
        noise: &[f64],
        regularisation: &Regularisation,
    ) -> (AccumulatedQr, Option<Vec<f64>>) {
        let mut all = self.recorded(rows, noise);
        let Some(TermPrior { mean, rows: prior_rows }) = &regularisation.prior else {
            return (all, None);
        };
        all = all.beyond(mean);
        let prior = triangle_of(prior_rows, self.terms.len());
        let terms: Vec<usize> = (0..self.terms.len()).collect();
        // rows of samples count for more than they know by the dependent ones among them
        all.merge_weighted(&prior, &terms, 1.0 / rows.share.sqrt());
        (all, Some(mean.clone()))
    }

    pub(crate) fn weighted(
        &self,
        rows: &JointRows,
        noise: &[f64],
        regularisation: &Regularisation,
    ) -> Result<NonNegative, NumericError> {
        let (all, _) = self.information(rows, noise, regularisation);
        let mut solved = match &regularisation.bound {
            // effects, the only terms with bounds, are at 0 in the prior
            Some(bound) => all.solve_non_negative(bound, RANK_CUT)?,
            None => NonNegative {
                answer: all.solve(RANK_CUT)?,
                at_bound: vec![false; self.terms.len()],
            },
        };
        if let Some(prior) = &regularisation.prior {
            for (x, mean) in solved.answer.solution.iter_mut().zip(&prior.mean) {
                *x += mean;
            }
        }
        Ok(solved)
    }

    /// Effort error of given values on accumulated recordings, per joint.
    pub fn fit(&self, rows: &JointRows, values: &[f64]) -> Vec<JointFit> {
        rows.triangles
            .iter()
            .zip(&self.by_joint)
            .zip(&rows.effort)
            .map(|((triangle, terms), &(count, sum, squares))| {
                let x: Vec<f64> = terms.iter().map(|&k| values[k]).collect();
                let residual = triangle.residual_sum_of_squares(&x);
                let varying = squares - sum * sum / count as f64;
                JointFit {
                    rmse: (residual / count as f64).sqrt(),
                    relative: (residual / varying).sqrt(),
                }
            })
            .collect()
    }
}

/// Root mean square of what the columns of a joint leave of its effort.
pub(crate) fn noise_of(
    triangle: &AccumulatedQr,
    rows: &JointRows,
    joint: usize,
) -> Result<f64, NumericError> {
    let left = triangle.solve(RANK_CUT)?.residual_sum_of_squares;
    Ok((left / rows.effort[joint].0 as f64).sqrt().max(rounding(rows, joint)))
}

/// What rounding leaves of the effort of a joint.
fn rounding(rows: &JointRows, joint: usize) -> f64 {
    f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE
}
