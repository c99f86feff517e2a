//! Dense linear algebra that knows no robot: least squares, rank decisions, singular values.
//!
//! The only crate that uses faer. nalgebra's dynamic SVD is silently wrong on low-rank matrices
//! (dimforge/nalgebra#1172), and regressors of arms are exactly such matrices.
//!
//! | problem | function |
//! | --- | --- |
//! | `min |A x - y|`, rows in blocks, states merged | [`AccumulatedQr`] |
//! | the same with unknowns that must not be negative | [`AccumulatedQr::solve_non_negative`] |
//! | `A⁺` for several right-hand sides | [`PseudoInverse`] |
//! | `min |A x - b|² + |x - c|²` | [`DampedLeastSquares`] |
//! | `R` with `RᵀR` the inverse of a covariance | [`information_root`] |
//! | `A⁻¹` of a square matrix | [`inverse()`] |
//! | rank with its gap | [`rank_of_columns`] |
//! | linear dependence of columns, in a stated order | [`eliminate_in_order`] |
//! | products of columns with each other; many small symmetric systems | [`gram_of_columns`], [`Cholesky`] |
//! | medians and quantiles | [`order_statistic`] |
//!
//! ```
//! use armident_numeric::AccumulatedQr;
//!
//! // a line through three points
//! let mut rows = AccumulatedQr::new(2);
//! rows.push_rows(&[vec![0.0, 1.0, 1.0], vec![1.0, 1.0, 3.0], vec![2.0, 1.0, 5.0]]);
//! let line = rows.solve(1e-9)?;
//! assert!((line.solution[0] - 2.0).abs() < 1e-12 && (line.solution[1] - 1.0).abs() < 1e-12);
//! # Ok::<(), armident_numeric::NumericError>(())
//! ```

mod accumulate;
mod gram;
mod inverse;
mod least_squares;
mod non_negative;
mod order;
mod rank;
mod svd;

pub use accumulate::AccumulatedQr;
pub use faer::Mat;
pub use gram::{Cholesky, dot, gram_of_columns, products_of_columns, symmetric_eigen};
pub use inverse::inverse;
pub use least_squares::{
    DampedLeastSquares, LeastSquares, NumericError, PseudoInverse, information_root,
};
pub use non_negative::NonNegative;
pub use order::{extremes, order_statistic, range};
pub use rank::{DependentColumn, Elimination, RankDecision, eliminate_in_order, rank_of_columns};
pub use svd::ThinSvd;
