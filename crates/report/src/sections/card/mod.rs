//! Sections of a model card.

mod effort;
mod inputs;
mod links;
mod parameters;

pub(super) use effort::Effort;
pub(super) use inputs::Inputs;
pub(super) use links::Links;
pub(super) use parameters::Parameters;
