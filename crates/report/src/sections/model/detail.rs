//! What the details of a model have in common.

use crate::layout::Block;
use crate::results::ByJoint;

/// One entry under the common heading.
pub(super) fn detail(text: String) -> Vec<Block> {
    vec![Block::heading("Model details"), Block::item(text)]
}

/// Numbers above zero, one a joint; none where there is no such joint.
pub(super) fn above_zero(joints: &[String], numbers: &[f64]) -> Option<ByJoint> {
    let pairs = joints.iter().cloned().zip(numbers.iter().copied());
    let above: ByJoint = pairs.filter(|(_, number)| *number > 0.0).collect();
    (!above.is_empty()).then_some(above)
}
