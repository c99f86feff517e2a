//! The text of each result: first lines, then its sections.

mod card;
mod check;
mod comparison;
mod diagnosis;
mod identification;
mod identify;
mod identify_notes;
mod servos;
mod validate;

pub use diagnosis::text_of_sections;
