//! Gram matrices of columns, and small symmetric systems that are solved many times.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// `AᵀA` of columns of one length.
pub fn gram_of_columns(columns: &[&[f64]]) -> Mat<f64> {
    let rows = columns.first().map_or(0, |c| c.len());
    let a = Mat::from_fn(rows, columns.len(), |i, j| columns[j][i]);
    let mut gram = Mat::zeros(columns.len(), columns.len());
    matmul(gram.as_mut(), Accum::Replace, a.transpose(), &a, 1.0, Par::Seq);
    gram
}

/// `AᵀB` of columns of one length.
pub fn products_of_columns(a: &[&[f64]], b: &[&[f64]]) -> Mat<f64> {
    let rows = a.first().map_or(0, |c| c.len());
    let [a, b] = [a, b].map(|columns| Mat::from_fn(rows, columns.len(), |i, j| columns[j][i]));
    let mut products = Mat::zeros(a.ncols(), b.ncols());
    matmul(products.as_mut(), Accum::Replace, a.transpose(), &b, 1.0, Par::Seq);
    products
}

/// Scalar product of columns, in several independent sums for instruction-level parallelism.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let (mut sums, whole) = ([0.0; SUMS], n - n % SUMS);
    for (a, b) in a.chunks_exact(SUMS).zip(b.chunks_exact(SUMS)) {
        for k in 0..SUMS {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a[whole..].iter().zip(&b[whole..]).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Eigenvalues (rising) and eigenvectors (columns) of a symmetric matrix.
///
/// # Errors
/// [`NumericError::NoConvergence`](crate::NumericError::NoConvergence).
pub fn symmetric_eigen(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), crate::NumericError> {
    // faer 0.24 counts below zero there
    if a.nrows() < 2 {
        let n = a.nrows();
        return Ok(((0..n).map(|k| a[(k, k)]).collect(), Mat::identity(n, n)));
    }
    let eigen =
        a.self_adjoint_eigen(faer::Side::Lower).map_err(|_| crate::NumericError::NoConvergence)?;
    let values = eigen.S().column_vector();
    Ok(((0..a.nrows()).map(|k| values[k]).collect(), eigen.U().to_owned()))
}

/// Lower triangle `L` with `L Lᵀ = A`, for systems of some dozen unknowns: written out, because the
/// set-up of a library call costs more than the work.
#[derive(Debug, Clone)]
pub struct Cholesky {
    order: usize,
    /// row-major lower triangle, `order x order`
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factor of the symmetric matrix with these entries; only `i >= j` is used. `None` if it is not
    /// positive definite.
    pub fn of(order: usize, entry: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut lower = vec![0.0; order * order];
        for i in 0..order {
            let (above, row) = lower.split_at_mut(i * order);
            let row = &mut row[..=i];
            for j in 0..i {
                let other = &above[j * order..j * order + j + 1];
                row[j] = (entry(i, j) - dot(&row[..j], &other[..j])) / other[j];
            }
            let pivot = entry(i, i) - dot(&row[..i], &row[..i]);
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            row[i] = pivot.sqrt();
        }
        Some(Self { order, lower })
    }

    /// `L⁻¹ b`.
    pub fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for i in 0..self.order {
            let row = &self.lower[i * self.order..i * self.order + i + 1];
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
        }
        x
    }

    /// `L⁻ᵀ b`.
    pub fn backward(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for i in (0..self.order).rev() {
            x[i] /= self.lower[i * self.order + i];
            let (row, last) = (&self.lower[i * self.order..i * self.order + i], x[i]);
            x[..i].iter_mut().zip(row).for_each(|(x, l)| *x -= l * last);
        }
        x
    }

    /// `A⁻¹ b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        self.backward(&self.forward(b))
    }

    /// Diagonal of `A⁻¹`.
    pub fn inverse_diagonal(&self) -> Vec<f64> {
        (0..self.order)
            .map(|k| {
                let unit: Vec<f64> = (0..self.order).map(|i| f64::from(u8::from(i == k))).collect();
                self.forward(&unit).iter().map(|x| x * x).sum()
            })
            .collect()
    }

    /// Row `i` of `L` up to its diagonal.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.lower[i * self.order..=i * self.order + i]
    }

    /// `A⁻¹`.
    pub fn inverse(&self) -> Mat<f64> {
        let n = self.order;
        // columns of L⁻¹, which begin at the diagonal
        let mut inverse = Mat::<f64>::zeros(n, n);
        let mut column = vec![0.0; n];
        for k in 0..n {
            column[k] = 1.0 / self.lower[k * n + k];
            for i in k + 1..n {
                let row = &self.lower[i * n + k..i * n + i];
                column[i] = -dot(row, &column[k..i]) / self.lower[i * n + i];
            }
            (k..n).for_each(|i| inverse[(i, k)] = column[i]);
        }
        inverse.transpose() * &inverse
    }

    /// `log det A`.
    pub fn log_determinant(&self) -> f64 {
        (0..self.order).map(|i| 2.0 * self.lower[i * self.order + i].ln()).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;

    #[test]
    fn cholesky_inverse_and_rows() {
        let entries = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.0], [0.6, 1.0, 3.0]];
        let factor = Cholesky::of(3, |i, j| entries[i][j]).unwrap();
        let inverse = factor.inverse();
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| entries[i][k] * inverse[(k, j)]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14);
                let square: f64 = (0..=i.min(j)).map(|k| factor.row(i)[k] * factor.row(j)[k]).sum();
                assert!((square - entries[i][j]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn cholesky_solves_and_gives_log_determinant() {
        let columns = [[1.0, 2.0, 0.5, -1.0], [0.3, -1.0, 2.0, 0.7], [1.1, 0.2, -0.4, 3.0]];
        let views: Vec<&[f64]> = columns.iter().map(|c| &c[..]).collect();
        let gram = gram_of_columns(&views);
        let cholesky = Cholesky::of(3, |i, j| gram[(i, j)]).unwrap();
        let x = cholesky.solve(&[1.0, -2.0, 0.5]);
        for (i, b) in [1.0, -2.0, 0.5].iter().enumerate() {
            let back: f64 = (0..3).map(|j| gram[(i, j)] * x[j]).sum();
            assert!((back - b).abs() < 1e-12);
        }
        let (values, vectors) = symmetric_eigen(&gram).unwrap();
        let log: f64 = values.iter().map(|v| v.ln()).sum();
        assert!((cholesky.log_determinant() - log).abs() < 1e-12);
        let inverse: f64 = (0..3).map(|k| vectors[(1, k)].powi(2) / values[k]).sum();
        assert!((cholesky.inverse_diagonal()[1] - inverse).abs() < 1e-12);
        assert!(Cholesky::of(2, |i, j| if i == j { 1.0 } else { 2.0 }).is_none());
    }
}
