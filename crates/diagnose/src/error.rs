//! Why there is no diagnosis.

use armident_recording::{Recording, RecordingError};

use crate::checks::effort_columns::InputChecks;
use crate::checks::usable::Unusable;

/// Recordings whose columns leave nothing to diagnose.
#[derive(Debug, Clone)]
pub struct WrongColumns {
    /// The columns that fail.
    pub input_checks: InputChecks,
    /// The recordings that were to be fitted, currents and voltages as efforts.
    pub recordings: Vec<Recording>,
}

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// Recordings that cannot be diagnosed.
    #[error(transparent)]
    Unusable(#[from] Unusable),
    /// The problem could not be solved.
    #[error("no joint has both measured and predicted effort")]
    Unsolvable,
    /// The columns are not what their headers say, on too many joints to diagnose the others.
    #[error("input check failed: {} effort columns do not match their headers", .0.input_checks.faults.len())]
    WrongColumns(Box<WrongColumns>),
}

impl From<RecordingError> for DiagnoseError {
    fn from(error: RecordingError) -> Self {
        Self::Unusable(error.into())
    }
}
