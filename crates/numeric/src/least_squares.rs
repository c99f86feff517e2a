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

/// `A⁺` of a tall matrix by singular values of its unit-norm columns.
#[derive(Debug, Clone)]
pub struct PseudoInverse {
    inverse: Mat<f64>,
    /// Numerical rank at the cut used.
    pub rank: usize,
    /// Ratio of the largest to the smallest kept singular value of the unit-norm columns.
    pub condition: f64,
    /// Singular values of the unit-norm columns, largest first.
    pub singular_values: Vec<f64>,
    /// For each column, the share of its unit vector in the null space, 0 (determined) to 1.
    pub undetermined: Vec<f64>,
}

impl PseudoInverse {
    /// Decomposes `a` with relative rank cut `rank_cut`.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn of(a: &Mat<f64>, rank_cut: f64) -> Result<Self, NumericError> {
        let (m, p) = (a.nrows(), a.ncols());
        let norms = column_norms(a, p);
        if norms.iter().any(|n| !n.is_finite()) {
            return Err(NumericError::NotFinite);
        }
        let largest = norms.iter().fold(0.0, |a: f64, &b| a.max(b));
        let scale: Vec<f64> = norms
            .iter()
            .map(|&n| if n <= ZERO_COLUMN * largest || n == 0.0 { 0.0 } else { 1.0 / n })
            .collect();
        let scaled = Mat::from_fn(m, p, |i, j| a[(i, j)] * scale[j]);
        let svd = scaled.thin_svd().map_err(|_| NumericError::NoConvergence)?;
        let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
        let singular_values: Vec<f64> = (0..m.min(p)).map(|k| s[k]).collect();
        let top = singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values.iter().filter(|&&x| x > rank_cut * top && x > 0.0).count();
        let inverse = Mat::from_fn(p, m, |j, i| {
            scale[j] * (0..rank).map(|k| v[(j, k)] * u[(i, k)] / s[k]).sum::<f64>()
        });
        let undetermined = (0..p)
            .map(|j| (1.0 - (0..rank).map(|k| v[(j, k)].powi(2)).sum::<f64>()).clamp(0.0, 1.0))
            .collect();
        let condition = if rank == 0 { f64::INFINITY } else { top / singular_values[rank - 1] };
        Ok(Self { inverse, rank, condition, singular_values, undetermined })
    }

    /// `A⁺ b`.
    pub fn apply(&self, b: &[f64]) -> Vec<f64> {
        (0..self.inverse.nrows())
            .map(|j| b.iter().enumerate().map(|(i, b)| self.inverse[(j, i)] * b).sum())
            .collect()
    }

    /// `A⁺ A⁺ᵀ = (AᵀA)⁺`: covariance of `A⁺ b` for noise of variance 1, p x p.
    pub fn unit_covariance(&self) -> Mat<f64> {
        &self.inverse * self.inverse.transpose()
    }
}

/// Solves from the triangle of `[A | y]`.
pub(crate) fn solve_triangle(
    triangle: &Mat<f64>,
    rows: usize,
    rank_cut: f64,
) -> Result<LeastSquares, NumericError> {
    let p = triangle.ncols() - 1;
    let rhs: Vec<f64> = (0..p).map(|i| triangle[(i, p)]).collect();
    if rhs.iter().any(|x| !x.is_finite()) || !triangle[(p, p)].is_finite() {
        return Err(NumericError::NotFinite);
    }
    let inverse = PseudoInverse::of(&Mat::from_fn(p, p, |i, j| triangle[(i, j)]), rank_cut)?;
    let solution = inverse.apply(&rhs);
    let residual_sum_of_squares = (0..=p)
        .map(|i| {
            let fitted: f64 = (i..p).map(|j| triangle[(i, j)] * solution[j]).sum();
            (fitted - triangle[(i, p)]).powi(2)
        })
        .sum();
    Ok(LeastSquares {
        solution,
        unit_covariance: inverse.unit_covariance(),
        rank: inverse.rank,
        condition: inverse.condition,
        singular_values: inverse.singular_values,
        undetermined: inverse.undetermined,
        residual_sum_of_squares,
        rows,
    })
}

pub(crate) fn column_norms(a: &Mat<f64>, columns: usize) -> Vec<f64> {
    (0..columns).map(|j| (0..a.nrows()).map(|i| a[(i, j)].powi(2)).sum::<f64>().sqrt()).collect()
}
