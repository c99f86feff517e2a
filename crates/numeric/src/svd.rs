//! Singular value decomposition.

use faer::Mat;

use crate::least_squares::NumericError;

/// `A = U diag(s) Vᵀ` with as many singular values as the shorter side, the largest first.
#[derive(Debug, Clone)]
pub struct ThinSvd {
    /// Left vectors, one column per singular value.
    pub u: Mat<f64>,
    /// Singular values.
    pub s: Vec<f64>,
    /// Right vectors, one column per singular value.
    pub v: Mat<f64>,
}

impl ThinSvd {
    /// Decomposes a matrix.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn of(a: &Mat<f64>) -> Result<Self, NumericError> {
        if (0..a.nrows()).any(|i| (0..a.ncols()).any(|j| !a[(i, j)].is_finite())) {
            return Err(NumericError::NotFinite);
        }
        let svd = a.thin_svd().map_err(|_| NumericError::NoConvergence)?;
        let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
        let k = s.nrows();
        Ok(Self {
            u: Mat::from_fn(a.nrows(), k, |i, j| u[(i, j)]),
            s: (0..k).map(|i| s[i]).collect(),
            v: Mat::from_fn(a.ncols(), k, |i, j| v[(i, j)]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_reconstruct_the_matrix() {
        for (rows, columns) in [(3, 5), (6, 4), (4, 4)] {
            let a = Mat::from_fn(rows, columns, |i, j| ((i * 7 + j * 3) % 5) as f64);
            let ThinSvd { u, s, v } = ThinSvd::of(&a).unwrap();
            assert_eq!(s.len(), rows.min(columns));
            for i in 0..rows {
                for j in 0..columns {
                    let back: f64 = (0..s.len()).map(|k| u[(i, k)] * s[k] * v[(j, k)]).sum();
                    assert!((back - a[(i, j)]).abs() < 1e-12);
                }
            }
        }
        assert!(ThinSvd::of(&Mat::from_fn(2, 2, |_, _| f64::NAN)).is_err());
    }
}
