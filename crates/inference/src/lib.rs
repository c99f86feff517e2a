//! Statistics that know no robot: folds, paired gains, block jackknife, effective samples, exceedances, quantiles, medians, whiteness.
//!
//! `identify` and `diagnose` decide by the same statistics and the same [levels]. Their solvers are two: merged triangles of
//! a QR decomposition for one fit of hours of data ([`merged`], [`leave_one_out`]), products of columns for the thousands of
//! subsets of a selection, which take [`time_blocks`] of rows.

mod effective_sample_size;
mod exceedances;
mod folds;
mod jackknife;
pub mod levels;
mod log_sum;
mod median;
mod paired_gain;
mod quantiles;
mod whiteness;

pub use effective_sample_size::{correlation_time, independent_share};
pub use exceedances::{Tail, episodes};
pub use folds::{FOLDS, merged, time_blocks, without};
pub use jackknife::{FEWEST_BLOCKS, deviations, leave_one_out, standard_error, variance};
pub use log_sum::log_sum;
pub use median::{median, median_with_interval_95};
pub use paired_gain::{paired_t, significant_gain};
pub use quantiles::{chi_square_quantile, f_quantile, f_tail, student_t_975, student_t_tail};
pub use whiteness::whiteness;
