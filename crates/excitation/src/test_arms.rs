//! Arms for tests.

use armident_dynamics::RigidArm;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};

fn of(text: &str) -> DrivingAxisChain {
    let robot = parse_urdf(text, "test.urdf").unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

pub(crate) fn chain() -> DrivingAxisChain {
    of(include_str!("../../../urdf/ur5.urdf"))
}

pub(crate) fn arm() -> RigidArm {
    RigidArm::from_chain(&chain())
}

/// An arm with a slide.
pub(crate) fn stanford() -> RigidArm {
    RigidArm::from_chain(&of(include_str!("../../../urdf/stanford.urdf")))
}
