//! What an effort channel with a dead zone shows of the efforts.

use serde::{Deserialize, Serialize};

/// What a column that leaves small efforts out shows of the efforts: `share * effort + offset`, by least squares.
///
/// A model says what the body needs; this is what such a column will show of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DeadZone {
    /// 0 to 1.
    pub share: f64,
    /// \[N m or N\]
    pub offset: f64,
}

impl DeadZone {
    /// What the column shows of efforts.
    pub fn apply(self, effort: &mut [f64]) {
        effort.iter_mut().for_each(|e| *e = self.share * *e + self.offset);
    }

    /// Whether its numbers are such.
    pub fn is_sound(&self) -> bool {
        (0.0..=1.0).contains(&self.share) && self.offset.is_finite()
    }
}
