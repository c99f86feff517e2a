//! Series of cases and their tables.

pub(crate) mod series;
pub(crate) mod study;
