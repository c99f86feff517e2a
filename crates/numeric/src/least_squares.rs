//! Least squares from a triangle, with rank, condition number and covariance.

use faer::Mat;

/// Why a decomposition has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NumericError {
    /// The input holds NaN or an infinity.
    #[error("the least-squares problem holds a number that is not finite")]
    NotFinite,
    /// The singular value iteration did not converge.
    #[error("the singular value decomposition did not converge")]
    NoConvergence,
}

/// Solution of `A x ≈ y` with what is known about its trust.
#[derive(Debug, Clone)]
pub struct LeastSquares {
    /// Minimum-norm solution in the scaled unknowns (unit-norm columns), length p.
    pub solution: Vec<f64>,
    /// `(AᵀA)⁺`: covariance of the solution for noise of variance 1, p x p.
    pub unit_covariance: Mat<f64>,
    /// Numerical rank at the cut used.
    pub rank: usize,
    /// Ratio of the largest to the smallest kept singular value of the unit-norm columns.
    pub condition: f64,
    /// Singular values of the unit-norm columns, largest first.
    pub singular_values: Vec<f64>,
    /// For each unknown, the share of its unit vector in the null space, 0 (determined) to 1.
    pub undetermined: Vec<f64>,
    /// `|A x - y|²`.
    pub residual_sum_of_squares: f64,
    /// Rows of `A`.
    pub rows: usize,
}

/// Columns whose norm is at most this times the largest are zero: never scaled up.
pub(crate) const ZERO_COLUMN: f64 = 1e-10;

/// Solves from the triangle of `[A | y]`.
pub(crate) fn solve_triangle(
    triangle: &Mat<f64>,
    rows: usize,
    rank_cut: f64,
) -> Result<LeastSquares, NumericError> {
    let p = triangle.ncols() - 1;
    for j in 0..=p {
        for i in 0..=p {
            if !triangle[(i, j)].is_finite() {
                return Err(NumericError::NotFinite);
            }
        }
    }
    let norms = column_norms(triangle, p);
    let largest = norms.iter().fold(0.0, |a: f64, &b| a.max(b));
    let scale: Vec<f64> = norms
        .iter()
        .map(|&n| if n <= ZERO_COLUMN * largest || n == 0.0 { 0.0 } else { 1.0 / n })
        .collect();
    let scaled = Mat::from_fn(p, p, |i, j| triangle[(i, j)] * scale[j]);
    let svd = scaled.thin_svd().map_err(|_| NumericError::NoConvergence)?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let singular_values: Vec<f64> = (0..p).map(|k| s[k]).collect();
    let top = singular_values.first().copied().unwrap_or(0.0);
    let rank = singular_values.iter().filter(|&&x| x > rank_cut * top && x > 0.0).count();

    let projected: Vec<f64> = (0..rank)
        .map(|k| (0..p).map(|i| u[(i, k)] * triangle[(i, p)]).sum::<f64>() / s[k])
        .collect();
    let solution: Vec<f64> = (0..p)
        .map(|j| scale[j] * (0..rank).map(|k| v[(j, k)] * projected[k]).sum::<f64>())
        .collect();
    let unit_covariance = Mat::from_fn(p, p, |i, j| {
        scale[i] * scale[j] * (0..rank).map(|k| v[(i, k)] * v[(j, k)] / (s[k] * s[k])).sum::<f64>()
    });
    let undetermined = (0..p)
        .map(|j| (1.0 - (0..rank).map(|k| v[(j, k)].powi(2)).sum::<f64>()).clamp(0.0, 1.0))
        .collect();
    let residual_sum_of_squares = (0..=p)
        .map(|i| {
            let fitted: f64 = (i..p).map(|j| triangle[(i, j)] * solution[j]).sum();
            (fitted - triangle[(i, p)]).powi(2)
        })
        .sum();
    let condition = if rank == 0 { f64::INFINITY } else { top / singular_values[rank - 1] };
    Ok(LeastSquares {
        solution,
        unit_covariance,
        rank,
        condition,
        singular_values,
        undetermined,
        residual_sum_of_squares,
        rows,
    })
}

pub(crate) fn column_norms(a: &Mat<f64>, columns: usize) -> Vec<f64> {
    (0..columns).map(|j| (0..a.nrows()).map(|i| a[(i, j)].powi(2)).sum::<f64>().sqrt()).collect()
}
