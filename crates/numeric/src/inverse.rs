//! Inverse of a square matrix.

use faer::Mat;
use faer::linalg::solvers::{DenseSolveCore, FullPivLu};

/// `A⁻¹` by LU with full pivoting; none if a pivot is at most `smallest_pivot` times the largest
/// entry of `A`, or an entry is not finite.
///
/// ```
/// use armident_numeric::{Mat, inverse};
///
/// let a = Mat::from_fn(2, 2, |i, j| [[0.0, 2.0], [4.0, 0.0]][i][j]);
/// let inverted = inverse(&a, 1e-6).unwrap();
/// assert_eq!((inverted[(0, 1)], inverted[(1, 0)]), (0.25, 0.5));
/// assert!(inverse(&Mat::from_fn(2, 2, |_, _| 1.0), 1e-6).is_none());
/// ```
pub fn inverse(a: &Mat<f64>, smallest_pivot: f64) -> Option<Mat<f64>> {
    let n = a.nrows();
    let entries = || (0..n).flat_map(|i| (0..n).map(move |j| a[(i, j)].abs()));
    if a.ncols() != n || !entries().all(f64::is_finite) {
        return None;
    }
    let largest = entries().fold(0.0, f64::max);
    let lu = FullPivLu::new(a.as_ref());
    let u = lu.U();
    let is_singular = (0..n).any(|k| u[(k, k)].abs() <= smallest_pivot * largest);
    (!is_singular).then(|| lu.inverse())
}
