//! Input checks: are the effort columns what their headers say.

pub(crate) mod effort_columns;
pub(crate) mod reporting;
pub(crate) mod usable;
