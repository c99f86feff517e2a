//! An effort channel with a dead zone, as a linear map of the effort.
//!
//! Method: such a channel reports `share * effort + offset`, by least squares over the training recordings.
//!
//! References: own.

use serde::{Deserialize, Serialize};

/// What a channel with a dead zone reports of the efforts: `share * effort + offset`.
///
/// The model gives the effort that the body needs; predictions of the channel go through this map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DeadZone {
    /// 0 to 1.
    pub share: f64,
    /// \[N m or N\]
    pub offset: f64,
}

impl DeadZone {
    /// Replaces efforts by what the channel reports of them.
    pub fn apply(self, effort: &mut [f64]) {
        effort.iter_mut().for_each(|e| *e = self.share * *e + self.offset);
    }

    /// Whether the share is from 0 to 1 and the offset finite.
    pub(crate) fn is_sound(&self) -> bool {
        (0.0..=1.0).contains(&self.share) && self.offset.is_finite()
    }
}
