//! The number type of the kernels: one sample or a batch of samples.

use nalgebra::SimdRealField;
use simba::simd::{AutoF64x4, SimdValue};

/// `f64` for one sample, [`Batch`] for four samples at once; the kernels are written once for both.
pub trait Real: SimdRealField<Element = f64> + Copy + Send + Sync {}

impl<T: SimdRealField<Element = f64> + Copy + Send + Sync> Real for T {}

/// Four samples side by side: lane `l` of every number belongs to sample `l`.
pub type Batch = AutoF64x4;

/// Samples in a [`Batch`].
pub const BATCH: usize = 4;

/// Samples `start ..` of a column as one batch; lanes past the end repeat the last sample.
///
/// # Panics
/// When `start` is not inside the column.
pub fn load_batch(column: &[f64], start: usize) -> Batch {
    let last = column.len() - 1;
    AutoF64x4::from(std::array::from_fn::<f64, BATCH, _>(|lane| column[(start + lane).min(last)]))
}

/// Writes the lanes of a batch to samples `start ..` of a column, leaving out those past the end.
pub fn store_batch(value: Batch, column: &mut [f64], start: usize) {
    let end = (start + BATCH).min(column.len());
    for (lane, out) in column[start..end].iter_mut().enumerate() {
        *out = value.extract(lane);
    }
}
