//! Which structure the recordings call for: reversal of dry friction, shared transmissions, sublinear viscous friction.

mod choose;
mod coupling;
mod fold_errors;
mod reversal;
mod sublinear;

pub use choose::{Structure, StructureSearch};
pub use coupling::CouplingFound;
pub use reversal::ReversalCandidates;
pub use sublinear::SublinearFound;
