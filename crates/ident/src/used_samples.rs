//! The samples of a motion that fits and their errors use: without the ends, which the filter spoils.

use std::ops::Range;

use armident_motion::Motion;

/// Periods of the cut-off frequency left out at both ends of a recording, of the fit and of its
/// errors alike: the filter does not know what came before, so accelerations are wrong there. The
/// slowest pole of the 4th-order low-pass decays with 0.42 periods: 3 % are left after 1.5.
pub(crate) const EDGE_PERIODS: f64 = 1.5;

/// Samples of a motion that fits use: without its ends, which the filter spoils.
pub fn used_samples(motion: &Motion) -> Range<usize> {
    let edge = match &motion.filter {
        Some(filter) => {
            let edge = (EDGE_PERIODS * motion.rate_hz / filter.cutoff_hz()).ceil() as usize;
            edge.min(motion.len() / 4)
        }
        None => 0,
    };
    edge..motion.len() - edge
}
