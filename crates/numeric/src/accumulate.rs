//! Accumulation of least-squares rows by orthogonal transformations: the state is one triangle,
//! independent of the number of rows.

use faer::Mat;

use crate::least_squares::{LeastSquares, NumericError, column_norms, solve_triangle};

/// The triangle `R` of the QR factors of all rows `[A | y]` pushed so far.
///
/// Blocks of rows may be pushed and states merged in any order: the result is the same to round-off
/// (orthogonal transformations, no normal equations). Memory is `(p + 1)²` numbers for
/// `p` unknowns, cost `2 (p + 1)²` operations a row.
#[derive(Debug, Clone)]
pub struct AccumulatedQr {
    unknowns: usize,
    triangle: Mat<f64>,
    rows: usize,
}

impl AccumulatedQr {
    /// Rows reduced at a time: long enough for blocked reflections, short enough for the cache.
    pub const BLOCK_ROWS: usize = 512;

    /// An empty state for `unknowns` columns.
    pub fn new(unknowns: usize) -> Self {
        Self { unknowns, triangle: Mat::zeros(unknowns + 1, unknowns + 1), rows: 0 }
    }

    /// The triangle of [`Self::upper`], with the number of rows that it stands for.
    ///
    /// # Panics
    /// When the triangle does not have `(p + 1)(p + 2) / 2` numbers.
    pub fn from_upper(columns: usize, rows: usize, upper: &[f64]) -> Self {
        let p = columns + 1;
        assert_eq!(upper.len(), p * (p + 1) / 2, "a triangle of p + 1 columns");
        // row i begins behind rows of p, p - 1, ... numbers
        let place = |i: usize, j: usize| i * p - i * (i + 1) / 2 + j;
        let entry = |i, j| if i <= j { upper[place(i, j)] } else { 0.0 };
        Self { unknowns: columns, triangle: Mat::from_fn(p, p, entry), rows }
    }

    /// The upper triangle of `[A | y]`, row by row.
    pub fn upper(&self) -> Vec<f64> {
        let p = self.unknowns + 1;
        (0..p).flat_map(|i| (i..p).map(move |j| self.triangle[(i, j)])).collect()
    }

    /// Number of unknowns `p`.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Rows pushed so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds the rows of `A` given by columns, with their right-hand side.
    ///
    /// # Panics
    /// When the number of columns is not `p` or the lengths differ.
    pub fn push_columns<C: AsRef<[f64]>>(&mut self, columns: &[C], rhs: &[f64]) {
        let columns: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
        assert_eq!(columns.len(), self.unknowns, "one column per unknown");
        assert!(columns.iter().all(|c| c.len() == rhs.len()), "columns of one length");
        let mut start = 0;
        while start < rhs.len() {
            let end = (start + Self::BLOCK_ROWS).min(rhs.len());
            self.push(end - start, |row, column| {
                columns.get(column).map_or(rhs[start + row], |c| c[start + row])
            });
            start = end;
        }
        self.rows += rhs.len();
    }

    /// Adds single rows, each of `p` coefficients and a right-hand side.
    ///
    /// # Panics
    /// When a row does not have `p + 1` entries.
    pub fn push_rows(&mut self, rows: &[Vec<f64>]) {
        assert!(rows.iter().all(|r| r.len() == self.unknowns + 1), "rows of p + 1 entries");
        for block in rows.chunks(Self::BLOCK_ROWS) {
            self.push(block.len(), |row, column| block[row][column]);
        }
        self.rows += rows.len();
    }

    /// Adds all rows of another state, every one scaled by `weight`, its unknown `k` being
    /// unknown `columns[k]` here.
    ///
    /// # Panics
    /// When `columns` does not name one of this state's unknowns for each of the other's.
    pub fn merge_weighted(&mut self, other: &Self, columns: &[usize], weight: f64) {
        assert_eq!(columns.len(), other.unknowns, "one target column per unknown");
        let mut scattered = Mat::<f64>::zeros(other.unknowns + 1, self.unknowns + 1);
        for row in 0..=other.unknowns {
            for (from, &to) in columns.iter().chain(std::iter::once(&self.unknowns)).enumerate() {
                scattered[(row, to)] += weight * other.triangle[(row, from)];
            }
        }
        self.push(other.unknowns + 1, |row, column| scattered[(row, column)]);
        self.rows += other.rows;
    }

    /// Adds all rows of another state of the same unknowns.
    pub fn merge(&mut self, other: &Self) {
        self.merge_weighted(other, &(0..other.unknowns).collect::<Vec<_>>(), 1.0);
    }

    fn push(&mut self, rows: usize, entry: impl Fn(usize, usize) -> f64) {
        let p = self.unknowns + 1;
        let stacked =
            Mat::from_fn(
                p + rows,
                p,
                |i, j| {
                    if i < p { self.triangle[(i, j)] } else { entry(i - p, j) }
                },
            );
        let factors = stacked.qr();
        let r = factors.thin_R();
        // the library leaves reflectors below the diagonal
        self.triangle = Mat::from_fn(p, p, |i, j| if i <= j { r[(i, j)] } else { 0.0 });
    }

    /// Solves `A x ≈ y` with relative rank cut `rank_cut` on unit-norm columns.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn solve(&self, rank_cut: f64) -> Result<LeastSquares, NumericError> {
        solve_triangle(&self.triangle, self.rows, rank_cut)
    }

    /// `|A x - y|²` for any `x` of length `p`, from the triangle alone.
    pub fn residual_sum_of_squares(&self, x: &[f64]) -> f64 {
        let p = self.unknowns;
        (0..=p)
            .map(|i| {
                let fitted: f64 = (i..p).map(|j| self.triangle[(i, j)] * x[j]).sum();
                (fitted - self.triangle[(i, p)]).powi(2)
            })
            .sum()
    }

    /// Gradient `Aᵀ (y - A x)`, length p.
    pub fn residual_moments(&self, x: &[f64]) -> Vec<f64> {
        let p = self.unknowns;
        let residual: Vec<f64> = (0..p)
            .map(|i| {
                let fitted: f64 = (i..p).map(|j| self.triangle[(i, j)] * x[j]).sum();
                self.triangle[(i, p)] - fitted
            })
            .collect();
        (0..p).map(|j| (0..=j).map(|i| self.triangle[(i, j)] * residual[i]).sum()).collect()
    }

    /// `w R` with `RᵀR = AᵀA`, p x p.
    pub fn root(&self, w: f64) -> Mat<f64> {
        let p = self.unknowns;
        Mat::from_fn(p, p, |i, j| w * self.triangle[(i, j)])
    }

    /// Norms of the columns of `A`.
    pub fn column_norms(&self) -> Vec<f64> {
        column_norms(&self.triangle, self.unknowns)
    }

    /// The same rows with some unknowns only, in the order given: the others are 0.
    ///
    /// # Panics
    /// When an index is not below `p`.
    #[must_use]
    pub fn with_unknowns(&self, unknowns: &[usize]) -> Self {
        let (p, q) = (self.unknowns, unknowns.len());
        let mut picked = Self::new(q);
        let column = |j: usize| if j < q { unknowns[j] } else { p };
        picked.push(p + 1, |i, j| self.triangle[(i, column(j))]);
        picked.rows = self.rows;
        picked
    }

    /// The triangle of the same rows with the columns in another order, column `p` being the right-hand
    /// side; columns may be omitted. Leading columns are projected out of those behind them, so one
    /// state serves many choices of unknowns and right-hand sides.
    ///
    /// # Panics
    /// When an index is above `p`.
    pub fn reordered(&self, columns: &[usize]) -> Mat<f64> {
        let picked =
            Mat::from_fn(self.unknowns + 1, columns.len(), |i, j| self.triangle[(i, columns[j])]);
        let factors = picked.qr();
        let r = factors.thin_R();
        let rows = r.nrows();
        Mat::from_fn(
            columns.len(),
            columns.len(),
            |i, j| {
                if i <= j && i < rows { r[(i, j)] } else { 0.0 }
            },
        )
    }

    /// The same rows with right-hand sides `y - A x`.
    ///
    /// # Panics
    /// When `x` does not have `p` entries.
    #[must_use]
    pub fn beyond(&self, x: &[f64]) -> Self {
        let p = self.unknowns;
        assert_eq!(x.len(), p, "one value per unknown");
        let mut left = self.clone();
        for i in 0..p {
            left.triangle[(i, p)] -= (i..p).map(|j| self.triangle[(i, j)] * x[j]).sum::<f64>();
        }
        left
    }

    /// `tr(A C Aᵀ)` for a p x p matrix `C`: with the covariance of the unknowns, the effective number of
    /// parameters that these rows determine.
    pub fn trace_with(&self, c: &Mat<f64>) -> f64 {
        let p = self.unknowns;
        let r = Mat::from_fn(p, p, |i, j| self.triangle[(i, j)]);
        let rc = &r * c;
        (0..p).map(|i| (0..p).map(|j| rc[(i, j)] * r[(i, j)]).sum::<f64>()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(rows: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
        let t: Vec<f64> = (0..rows).map(|i| i as f64 * 0.01).collect();
        let a = vec![
            t.iter().map(|t| t.sin()).collect(),
            t.iter().map(|t| 100.0 * (1.7 * t).cos()).collect(),
            vec![1.0; rows],
        ];
        let y = t.iter().map(|t| 2.0 * t.sin() - (1.7 * t).cos() + 0.3 * (9.0 * t).sin()).collect();
        (a, y)
    }

    #[test]
    fn qr_is_invariant_to_row_partition() {
        let (a, y) = columns(3000);
        let mut whole = AccumulatedQr::new(3);
        whole.push_columns(&a, &y);
        let mut parts = AccumulatedQr::new(3);
        for (start, end) in [(1700, 3000), (0, 3), (3, 1700)] {
            let mut part = AccumulatedQr::new(3);
            let block: Vec<Vec<f64>> = a.iter().map(|c| c[start..end].to_vec()).collect();
            part.push_columns(&block, &y[start..end]);
            parts.merge(&part);
        }
        let (x, z) = (whole.solve(1e-9).unwrap(), parts.solve(1e-9).unwrap());
        for (a, b) in x.solution.iter().zip(&z.solution) {
            assert!((a - b).abs() < 1e-12);
        }
        assert_eq!(parts.rows(), 3000);
    }

    /// With the first two columns in front, what is below them in the third is the residual of the
    /// third on the first two.
    #[test]
    fn reordered_columns_give_projected_triangle() {
        let (a, y) = columns(700);
        let mut qr = AccumulatedQr::new(3);
        qr.push_columns(&a, &y);
        let triangle = qr.reordered(&[0, 1, 3, 2]);
        let mut alone = AccumulatedQr::new(2);
        alone.push_columns(&a[..2], &y);
        let expected = alone.solve(1e-12).unwrap().residual_sum_of_squares;
        assert!((triangle[(2, 2)].powi(2) / expected - 1.0).abs() < 1e-9);
        alone = AccumulatedQr::new(2);
        alone.push_columns(&a[..2], &a[2]);
        let expected = alone.solve(1e-12).unwrap().residual_sum_of_squares;
        let found = triangle[(2, 3)].powi(2) + triangle[(3, 3)].powi(2);
        assert!((found / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn triangle_residual_equals_row_residual() {
        let (a, y) = columns(700);
        let mut qr = AccumulatedQr::new(3);
        qr.push_columns(&a, &y);
        let x = [1.5, -0.02, 0.4];
        let direct: f64 = (0..700)
            .map(|i| (a[0][i] * x[0] + a[1][i] * x[1] + a[2][i] * x[2] - y[i]).powi(2))
            .sum();
        assert!((qr.residual_sum_of_squares(&x) / direct - 1.0).abs() < 1e-12);
    }
}
