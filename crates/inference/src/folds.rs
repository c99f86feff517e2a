//! Contiguous folds of time for cross-validation of least squares.
//!
//! Method: leave-one-fold-out cross-validation with blocks of neighbouring samples, because residuals of a
//! low-passed recording are autocorrelated and single left-out samples would be predicted by their neighbours.
//!
//! References: C.-K. Chu, J. S. Marron, Comparison of two bandwidth selectors with dependent errors, Annals of
//! Statistics 19 (1991).

use std::ops::Range;

use armident_numeric::AccumulatedQr;

/// Folds that are left out in turn.
pub const FOLDS: usize = 5;

/// Merges the triangles of blocks in the order of time into [`FOLDS`] triangles.
///
/// `count` is the number of blocks that decides where folds begin, at most `blocks.len()`; blocks beyond it belong to no
/// fold.
pub fn merged(blocks: &[AccumulatedQr], count: usize) -> Vec<AccumulatedQr> {
    let sum = |fold: usize| {
        let mut sum = AccumulatedQr::new(blocks[0].unknowns());
        for (_, block) in blocks.iter().enumerate().filter(|(b, _)| b * FOLDS / count == fold) {
            sum.merge(block);
        }
        sum
    };
    (0..FOLDS).map(sum).collect()
}

/// The triangle of all folds but one.
pub fn without(folds: &[AccumulatedQr], left_out: usize) -> AccumulatedQr {
    let mut sum = AccumulatedQr::new(folds[0].unknowns());
    for (_, fold) in folds.iter().enumerate().filter(|(f, _)| *f != left_out) {
        sum.merge(fold);
    }
    sum
}

/// Observations of so many blocks of each recording.
pub fn time_blocks(starts: &[usize], blocks: usize) -> Vec<Range<usize>> {
    let of_recording = |pair: &[usize]| {
        let (from, length) = (pair[0], pair[1] - pair[0]);
        (0..blocks).map(move |k| from + k * length / blocks..from + (k + 1) * length / blocks)
    };
    starts.windows(2).flat_map(of_recording).collect()
}
