//! Least squares from a triangle, with rank, condition number and covariance.

use std::cell::OnceCell;

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{Qr, SolveLstsq};
use faer::{Accum, Mat, Par, Side};

use crate::gram::{Cholesky, dot};

/// Error of a decomposition.
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

/// Solution of `A x ≈ y` with its covariance, rank and condition number.
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

/// Relative norm up to which a column counts as zero and is not scaled up.
pub(crate) const ZERO_COLUMN: f64 = 1e-10;
/// Eigenvalues of a correlation matrix below this share of the largest are round-off.
const NOT_MEASURED: f64 = 1e-13;

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

/// `min |A x - b|² + |x - c|²` for several `b, c`.
///
/// Has a unique solution for any rank and scale of `A` (m x p). The small symmetric system
/// `(A Aᵀ + 1) w = b - A c`, `x = c + Aᵀ w` is used if iterative refinement converges, else orthogonal
/// transformations of `[A; 1]` with heavy rows first, so that light rows are not lost to round-off. Cost
/// `m² p` to decompose and `8 m p` per solution; several times that for heavy `A`.
#[derive(Debug, Clone)]
pub struct DampedLeastSquares {
    a: Mat<f64>,
    small: Option<Cholesky>,
    factors: OnceCell<Qr<f64>>,
}

/// Largest share of the energy `rᵀ (A Aᵀ + 1)⁻¹ r` of a solution in its last correction,
const RIGHT: f64 = 1e-20;
/// and its first one,
const NEARLY_RIGHT: f64 = 1e-8;
/// of so many.
const MOST_CORRECTIONS: usize = 3;

impl DampedLeastSquares {
    /// Decomposes `A Aᵀ + 1`.
    pub fn new(a: Mat<f64>) -> Self {
        let m = a.nrows();
        let mut gram = Mat::<f64>::zeros(m, m);
        matmul(gram.as_mut(), Accum::Replace, &a, a.transpose(), 1.0, Par::Seq);
        let small = Cholesky::of(m, |i, j| gram[(i, j)] + f64::from(u8::from(i == j)));
        Self { a, small, factors: OnceCell::new() }
    }

    /// The same only by orthogonal transformations: accurate to the last digit if `x` is small relative to `c`.
    pub fn accurate(a: Mat<f64>) -> Self {
        Self { a, small: None, factors: OnceCell::new() }
    }

    /// Solution for one pair of right-hand sides.
    ///
    /// # Errors
    /// [`NumericError::NotFinite`] when a number is not finite.
    ///
    /// # Panics
    /// When `b` does not have m entries or `c` not p.
    pub fn solve(&self, b: &[f64], c: &[f64]) -> Result<Vec<f64>, NumericError> {
        let (m, p) = (self.a.nrows(), self.a.ncols());
        assert!(b.len() == m && c.len() == p, "one right-hand side per row");
        // in the unknown x - c, which is small near a solution
        let mut left = b.to_vec();
        self.add_product(&mut left, c, -1.0);
        let moved = self.by_small(&left).unwrap_or_else(|| self.by_reflections(&left));
        let x: Vec<f64> = c.iter().zip(&moved).map(|(c, moved)| c + moved).collect();
        if x.iter().any(|x| !x.is_finite()) {
            return Err(NumericError::NotFinite);
        }
        Ok(x)
    }

    /// `Aᵀ (A Aᵀ + 1)⁻¹ r` with iterative refinement; `None` if round-off dominates.
    fn by_small(&self, r: &[f64]) -> Option<Vec<f64>> {
        let small = self.small.as_ref()?;
        let energy = |a: &[f64], b: &[f64]| dot(a, b).abs();
        let mut w = small.solve(r);
        let whole = energy(&w, r);
        for correction in 0..MOST_CORRECTIONS {
            let mut left: Vec<f64> = r.iter().zip(&w).map(|(r, w)| r - w).collect();
            self.add_product(&mut left, &self.transposed_times(&w), -1.0);
            let more = small.solve(&left);
            w.iter_mut().zip(&more).for_each(|(w, more)| *w += more);
            let share = energy(&more, &left) / whole;
            if share <= RIGHT {
                return Some(self.transposed_times(&w));
            }
            // NaN is not
            let nearly = share <= NEARLY_RIGHT;
            if correction == 0 && !nearly {
                return None;
            }
        }
        None
    }

    fn by_reflections(&self, r: &[f64]) -> Vec<f64> {
        let (m, p) = (self.a.nrows(), self.a.ncols());
        let factors = self.factors.get_or_init(|| {
            let stacked = Mat::from_fn(m + p, p, |i, j| match i < m {
                true => self.a[(i, j)],
                false => f64::from(u8::from(i - m == j)),
            });
            stacked.qr()
        });
        let rhs = Mat::from_fn(m + p, 1, |i, _| r.get(i).copied().unwrap_or(0.0));
        let moved = factors.solve_lstsq(&rhs);
        (0..p).map(|j| moved[(j, 0)]).collect()
    }

    /// Adds `factor A x`.
    fn add_product(&self, to: &mut [f64], x: &[f64], factor: f64) {
        for (j, x) in x.iter().enumerate() {
            let step = factor * x;
            to.iter_mut().zip(self.a.col_as_slice(j)).for_each(|(y, a)| *y += step * a);
        }
    }

    fn transposed_times(&self, w: &[f64]) -> Vec<f64> {
        (0..self.a.ncols()).map(|j| dot(self.a.col_as_slice(j), w)).collect()
    }
}

/// A root `R` of the information matrix of a covariance `C`: `RᵀR = C⁺`, p x p.
///
/// Directions without variance (of the correlation matrix, below 1e-13 of the largest) count as not
/// measured, as in a pseudo-inverse solution.
///
/// # Errors
/// [`NumericError`] when a number is not finite.
pub fn information_root(covariance: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let p = covariance.nrows();
    let over_error: Vec<f64> = (0..p)
        .map(|i| if covariance[(i, i)] > 0.0 { covariance[(i, i)].sqrt().recip() } else { 0.0 })
        .collect();
    let correlation = Mat::from_fn(p, p, |i, j| {
        0.5 * (covariance[(i, j)] + covariance[(j, i)]) * over_error[i] * over_error[j]
    });
    if (0..p).any(|j| correlation.col_as_slice(j).iter().any(|x| !x.is_finite())) {
        return Err(NumericError::NotFinite);
    }
    let eigen =
        correlation.self_adjoint_eigen(Side::Lower).map_err(|_| NumericError::NoConvergence)?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let top = (0..p).fold(0.0, |top: f64, k| top.max(values[k]));
    Ok(Mat::from_fn(p, p, |k, i| {
        let measured = values[k] > NOT_MEASURED * top && values[k] > 0.0;
        if measured { vectors[(i, k)] * over_error[i] / values[k].sqrt() } else { 0.0 }
    }))
}

pub(crate) fn column_norms(a: &Mat<f64>, columns: usize) -> Vec<f64> {
    (0..columns).map(|j| (0..a.nrows()).map(|i| a[(i, j)].powi(2)).sum::<f64>().sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x + 2 y = 5` with weight 1e16 beside `x ≈ 1, y ≈ 1`: (1.4, 1.8), the nearest point of the line.
    #[test]
    fn heavy_rows_hold_with_small_correction() {
        let a = Mat::from_fn(1, 2, |_, j| 1e8 * (1.0 + j as f64));
        let damped = DampedLeastSquares::new(a);
        let x = damped.solve(&[5e8], &[1.0, 1.0]).unwrap();
        assert!((x[0] - 1.4).abs() < 1e-12 && (x[1] - 1.8).abs() < 1e-12, "{x:?}");
        let nan = damped.solve(&[f64::NAN], &[1.0, 1.0]);
        assert_eq!(nan.unwrap_err(), NumericError::NotFinite);
    }

    /// Both solvers agree for rows of very different weight.
    #[test]
    fn light_and_heavy_systems_agree() {
        let entry = |i: usize, j: usize| (1.0 + (3 * i * j + 7 * i + 5 * j) as f64).sin();
        for weight in [1e-3, 1.0, 1e4] {
            let a = Mat::from_fn(4, 9, |i, j| weight * entry(i, j) * 10.0_f64.powi(i as i32));
            let damped = DampedLeastSquares::new(a);
            let b: Vec<f64> = (0..4).map(|i| entry(i, 20)).collect();
            let c: Vec<f64> = (0..9).map(|j| entry(21, j)).collect();
            let mut left = b.clone();
            damped.add_product(&mut left, &c, -1.0);
            let small = damped.by_small(&left).unwrap();
            for (a, b) in small.iter().zip(damped.by_reflections(&left)) {
                assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{weight}: {a} {b}");
            }
        }
        // three rows alike of 1e9: only the reflections see the differences
        let a = Mat::from_fn(3, 4, |i, j| 1e9 * (1.0 + j as f64) + if i == j { 1.0 } else { 0.0 });
        assert!(DampedLeastSquares::new(a).by_small(&[1.0, -2.0, 1.5]).is_none());
    }

    #[test]
    fn information_root_squares_to_information() {
        let covariance = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 0) => 4e-6,
            (1, 1) => 9.0,
            (0, 1) | (1, 0) => 3e-3,
            // the third unknown is not measured
            _ => 0.0,
        });
        let root = information_root(&covariance).unwrap();
        let information = root.transpose() * &root;
        let product = &information * &covariance;
        for i in 0..3 {
            for j in 0..3 {
                let expected = f64::from(u8::from(i == j && i < 2));
                assert!((product[(i, j)] - expected).abs() < 1e-9, "{product:?}");
            }
        }
    }
}
