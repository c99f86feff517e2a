//! What one recording says of the parameters: an information matrix and its moment, in units that make both of order one.
//!
//! Method: `Λ = Σ_j share RⱼᵀRⱼ / σⱼ²` over the joints' triangles, `share` being independent samples over samples. With random
//! differences between recordings, `u ~ N(0, T)`, the information on what recordings have in common is
//! `Λ* = (Λ⁻¹ + T)⁻¹ = Λ - Λ T½ (1 + T½ Λ T½)⁻¹ T½ Λ`, which exists where a recording does not determine all.
//!
//! References: W. H. Greene, Econometric Analysis (random effects by generalised least squares); N. M. Laird, J. H. Ware,
//! Random-effects models for longitudinal data, Biometrics 38 (1982).

use armident_ident::{BatchProblem, RecordingState};
use armident_numeric::{AccumulatedQr, Cholesky, Mat};

/// Share of a column, beyond earlier ones, below which it depends on them.
const DEPENDENT: f64 = 1e-9;

/// Information of one recording on the parameters.
#[derive(Debug, Clone)]
pub(crate) struct Information {
    pub(crate) matrix: Mat<f64>,
    pub(crate) moment: Vec<f64>,
}

/// Upper triangle of `[columns | effort]` of a joint, row by row, as a state has it.
struct Triangle<'a> {
    columns: usize,
    upper: &'a [f64],
}

impl Triangle<'_> {
    /// Row `i` from its diagonal on.
    fn row(&self, i: usize) -> &[f64] {
        let p = self.columns + 1;
        let start = i * p - i * i.saturating_sub(1) / 2;
        &self.upper[start..start + p - i]
    }

    /// Sum of squares that the columns do not explain.
    fn residual_squares(&self) -> f64 {
        let norm = |j: usize| (0..=j).map(|i| self.row(i)[j - i].powi(2)).sum::<f64>().sqrt();
        let last = self.row(self.columns)[0].powi(2);
        // a column that depends on earlier ones leaves a row that later columns explain in part
        if (0..self.columns).all(|j| self.row(j)[0].abs() > DEPENDENT * norm(j)) {
            return last;
        }
        let rows = AccumulatedQr::from_upper(self.columns, 0, self.upper);
        rows.solve(DEPENDENT).map_or(last, |solved| solved.residual_sum_of_squares)
    }
}

/// Noise of each joint over the recordings of a robot \[N m or N\]: what each recording's own fit leaves.
pub(crate) fn noise_of(problem: &BatchProblem, states: &[&RecordingState]) -> Vec<f64> {
    let joints = 0..problem.arm().dof();
    joints
        .map(|joint| {
            let columns = problem.terms_of_joint(joint).len();
            let (mut squares, mut freedom, mut efforts) = (0.0, 0.0, 0.0);
            for state in states {
                let of = &state.joints[joint];
                let triangle = Triangle { columns, upper: &of.triangle };
                let independent = of.rows as f64 * state.independent_share;
                squares += triangle.residual_squares() * state.independent_share;
                freedom += (independent - columns as f64).max(0.0);
                efforts += of.effort.2;
            }
            // not below rounding, where an effort is simulated without noise
            let least = 1e-9 * efforts.sqrt() + f64::MIN_POSITIVE.sqrt();
            (squares / freedom.max(1.0)).sqrt().max(least)
        })
        .collect()
}

impl Information {
    /// Of a recording at these noise levels of the joints, a parameter being `scale` times its number here.
    pub(crate) fn of(
        problem: &BatchProblem,
        state: &RecordingState,
        noise: &[f64],
        scale: &[f64],
    ) -> Self {
        let p = problem.terms.len();
        let (mut matrix, mut moment) = (Mat::zeros(p, p), vec![0.0; p]);
        for (joint, of) in state.joints.iter().enumerate() {
            let terms = problem.terms_of_joint(joint);
            let triangle = Triangle { columns: terms.len(), upper: &of.triangle };
            let weight = state.independent_share.sqrt() / noise[joint];
            let dense = Mat::from_fn(terms.len(), terms.len() + 1, |i, j| match j {
                _ if j < i => 0.0,
                _ if j == terms.len() => weight * triangle.row(i)[j - i],
                _ => weight * scale[terms[j]] * triangle.row(i)[j - i],
            });
            let products = dense.transpose() * &dense;
            for (a, &to) in terms.iter().enumerate() {
                for (b, &with) in terms.iter().enumerate() {
                    matrix[(to, with)] += products[(a, b)];
                }
                moment[to] += products[(a, terms.len())];
            }
        }
        Self { matrix, moment }
    }

    /// On what recordings have in common, each differing from it at random with these standard deviations.
    pub(crate) fn in_common(&self, deviations: &[f64]) -> Self {
        let p = deviations.len();
        let scaled = Mat::from_fn(p, p, |i, j| deviations[i] * self.matrix[(i, j)]);
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let Some(factor) = Cholesky::of(p, |i, j| unit(i, j) + scaled[(i, j)] * deviations[j])
        else {
            return self.clone();
        };
        let inverse = factor.inverse();
        let spread = &inverse * &scaled;
        let matrix = &self.matrix - scaled.transpose() * &spread;
        let own: Vec<f64> = deviations.iter().zip(&self.moment).map(|(d, b)| d * b).collect();
        let moment = (0..p)
            .map(|i| self.moment[i] - (0..p).map(|k| spread[(k, i)] * own[k]).sum::<f64>())
            .collect();
        Self { matrix, moment }
    }
}

/// Matrix times vector.
pub(crate) fn times(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; matrix.nrows()];
    for (j, &x) in x.iter().enumerate() {
        if x != 0.0 {
            y.iter_mut().enumerate().for_each(|(i, y)| *y += matrix[(i, j)] * x);
        }
    }
    y
}
