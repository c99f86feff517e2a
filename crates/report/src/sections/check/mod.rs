//! Sections of a check of recordings.

mod checks;
mod columns;
mod excitation;

pub(super) use checks::Checks;
pub(super) use columns::Columns;
pub(super) use excitation::Excitation;
