//! Numerical rank with its gap, and elimination of dependent columns in a stated order.

use faer::Mat;

use crate::least_squares::{NumericError, ZERO_COLUMN, column_norms};

/// A numerical rank with its gap.
#[derive(Debug, Clone, PartialEq)]
pub struct RankDecision {
    /// The rank.
    pub rank: usize,
    /// Columns that are zero (relative norm at most 1e-10); they are never scaled up.
    pub zero_columns: usize,
    /// Smallest kept singular value of the unit-norm columns, relative to the largest.
    pub smallest_kept: f64,
    /// Largest dropped one, relative to the largest; 0 when nothing was dropped.
    pub largest_dropped: f64,
    /// The cut.
    pub tolerance: f64,
}

/// Rank by singular values of the columns scaled to unit norm; zero columns first.
///
/// # Errors
/// [`NumericError`] when a number is not finite.
pub fn rank_of_columns(a: &Mat<f64>, tolerance: f64) -> Result<RankDecision, NumericError> {
    let norms = column_norms(a, a.ncols());
    if norms.iter().any(|n| !n.is_finite()) {
        return Err(NumericError::NotFinite);
    }
    let largest = norms.iter().fold(0.0, |x: f64, &y| x.max(y));
    let kept: Vec<usize> = (0..a.ncols()).filter(|&j| norms[j] > ZERO_COLUMN * largest).collect();
    let scaled = Mat::from_fn(a.nrows(), kept.len(), |i, j| a[(i, kept[j])] / norms[kept[j]]);
    // reduce to the triangle first: the singular values are the same and cost less
    let triangle = if scaled.nrows() > scaled.ncols() {
        let qr = scaled.qr();
        let r = qr.thin_R();
        Mat::from_fn(r.nrows(), r.ncols(), |i, j| if i <= j { r[(i, j)] } else { 0.0 })
    } else {
        scaled
    };
    let values = triangle.singular_values().map_err(|_| NumericError::NoConvergence)?;
    let top = values.first().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|&&s| s > tolerance * top && s > 0.0).count();
    let relative = |s: f64| if top > 0.0 { s / top } else { 0.0 };
    Ok(RankDecision {
        rank,
        zero_columns: a.ncols() - kept.len(),
        smallest_kept: if rank == 0 { 0.0 } else { relative(values[rank - 1]) },
        largest_dropped: values.get(rank).map_or(0.0, |&s| relative(s)),
        tolerance,
    })
}

/// A column found to depend on kept ones.
#[derive(Debug, Clone, PartialEq)]
pub struct DependentColumn {
    /// Index of the dropped column.
    pub column: usize,
    /// `dropped = Σ factor · kept` over (kept column, factor); empty for a zero column.
    pub combination: Vec<(usize, f64)>,
}

/// Kept and dropped columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Elimination {
    /// Independent columns, in the order they were taken.
    pub kept: Vec<usize>,
    /// Dependent and zero columns.
    pub dropped: Vec<DependentColumn>,
    /// Smallest remainder of a kept column, relative to its norm.
    pub smallest_kept: f64,
    /// Largest remainder of a dropped column, relative to its norm.
    pub largest_dropped: f64,
}

/// Takes columns in the given order and drops each one that lies in the span of those before it.
///
/// Columns are scaled to unit norm and orthogonalised twice against the kept ones (theory of
/// Algorithm M); the norm of the remainder decides. Ordinary pivoting finds the same number but
/// chooses columns by their values; the order here makes the labels reproducible.
pub fn eliminate_in_order(a: &Mat<f64>, order: &[usize], tolerance: f64) -> Elimination {
    let norms = column_norms(a, a.ncols());
    let largest = norms.iter().fold(0.0, |x: f64, &y| x.max(y));
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // each basis vector as a combination of the unit-norm kept columns
    let mut as_kept: Vec<Vec<f64>> = Vec::new();
    let mut kept: Vec<usize> = Vec::new();
    let mut dropped = Vec::new();
    let (mut smallest_kept, mut largest_dropped) = (f64::INFINITY, 0.0_f64);
    for &column in order {
        if norms[column] <= ZERO_COLUMN * largest {
            dropped.push(DependentColumn { column, combination: Vec::new() });
            continue;
        }
        let mut w: Vec<f64> = (0..a.nrows()).map(|i| a[(i, column)] / norms[column]).collect();
        let mut on_kept = vec![0.0; kept.len()];
        for _ in 0..2 {
            for (b, combination) in basis.iter().zip(&as_kept) {
                let along: f64 = b.iter().zip(&w).map(|(x, y)| x * y).sum();
                w.iter_mut().zip(b).for_each(|(w, b)| *w -= along * b);
                for (total, c) in on_kept.iter_mut().zip(combination) {
                    *total += along * c;
                }
            }
        }
        let left = w.iter().map(|x| x * x).sum::<f64>().sqrt();
        if left > tolerance {
            smallest_kept = smallest_kept.min(left);
            w.iter_mut().for_each(|x| *x /= left);
            basis.push(w);
            let mut combination: Vec<f64> = on_kept.iter().map(|c| -c / left).collect();
            combination.push(1.0 / left);
            as_kept.push(combination);
            kept.push(column);
        } else {
            largest_dropped = largest_dropped.max(left);
            let combination = kept
                .iter()
                .zip(&on_kept)
                .map(|(&k, &c)| (k, c * norms[column] / norms[k]))
                .filter(|(_, c)| c.abs() >= 1e-9)
                .collect();
            dropped.push(DependentColumn { column, combination });
        }
    }
    Elimination { kept, dropped, smallest_kept, largest_dropped }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Structured low-rank matrices, where nalgebra's dynamic SVD fails: every entry 1, integers.
    #[test]
    fn rank_is_exact_for_structured_matrices() {
        for rows in 2..20 {
            for columns in 2..20 {
                let ones = Mat::from_fn(rows, columns, |_, _| 1.0);
                assert_eq!(rank_of_columns(&ones, 1e-9).unwrap().rank, 1);
                let sums = Mat::from_fn(rows, columns, |i, j| (i + j) as f64);
                assert_eq!(rank_of_columns(&sums, 1e-9).unwrap().rank, 2);
            }
        }
    }

    #[test]
    fn round_off_column_counts_as_zero() {
        let a = Mat::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { 1e-13 * (i as f64).sin() });
        let decision = rank_of_columns(&a, 1e-9).unwrap();
        assert_eq!((decision.rank, decision.zero_columns), (1, 1));
    }

    #[test]
    fn elimination_follows_order_and_returns_combinations() {
        // third column = 2 first - 5 second
        let a = Mat::from_fn(8, 3, |i, j| {
            let (x, y) = ((i as f64).sin(), (2.0 * i as f64).cos());
            [x, y, 2.0 * x - 5.0 * y][j]
        });
        let last_dropped = eliminate_in_order(&a, &[0, 1, 2], 1e-8);
        assert_eq!(last_dropped.kept, [0, 1]);
        let combination = &last_dropped.dropped[0].combination;
        assert!((combination[0].1 - 2.0).abs() < 1e-12 && (combination[1].1 + 5.0).abs() < 1e-12);
        assert_eq!(eliminate_in_order(&a, &[2, 1, 0], 1e-8).kept, [2, 1]);
    }
}
