//! Effects that a case hides: their law, size and place.

pub(crate) mod hidden_effect;
pub(crate) mod variants;

/// Slug of laws that the library does not have; a diagnosis answers them as unmodelled dynamics.
pub(crate) const UNLISTED: &str = "unlisted";
