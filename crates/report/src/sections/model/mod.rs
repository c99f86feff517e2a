//! Sections on what the diagnosed model holds beside the findings.

mod bandwidth;
mod link_errors;
mod presliding;
mod projection;
mod regularised_coulomb;
mod small_terms;
mod sublinear_viscous;
mod transmissions;

pub(super) use bandwidth::ComparisonBandwidth;
pub(super) use link_errors::LinkErrors;
pub(super) use presliding::Presliding;
pub(super) use projection::Projection;
pub(super) use regularised_coulomb::RegularisedCoulomb;
pub(super) use small_terms::SmallTerms;
pub(super) use sublinear_viscous::SublinearViscous;
pub(super) use transmissions::Transmissions;

use crate::layout::Block;
use crate::results::ByJoint;

/// One entry under the common heading.
fn detail(text: String) -> Vec<Block> {
    vec![Block::heading("Model details"), Block::item(text)]
}

/// Numbers above zero, one a joint; none where there is no such joint.
fn above_zero(joints: &[String], numbers: &[f64]) -> Option<ByJoint> {
    let pairs = joints.iter().cloned().zip(numbers.iter().copied());
    let above: ByJoint = pairs.filter(|(_, number)| *number > 0.0).collect();
    (!above.is_empty()).then_some(above)
}
