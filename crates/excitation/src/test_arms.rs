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

/// A rotating column with two arms of boxes; the column stands on the origin.
pub(crate) fn boxes() -> DrivingAxisChain {
    let link = |name: &str, length: f64| {
        format!(
            r#"<link name="{name}"><inertial><origin xyz="0 0 {half}"/><mass value="4"/>
              <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.01"/></inertial>
              <collision><origin xyz="0 0 {half}"/><geometry><box size="0.08 0.08 {length}"/></geometry></collision></link>"#,
            half = 0.5 * length
        )
    };
    let joint = |name: &str, parent: &str, child: &str, z: f64, axis: &str, most: f64| {
        format!(
            r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
              <origin xyz="0 0 {z}"/><axis xyz="{axis}"/>
              <limit lower="-{most}" upper="{most}" velocity="2" effort="120"/></joint>"#
        )
    };
    of(&[
        r#"<robot name="boxes"><link name="base"/>"#,
        &link("column", 0.4),
        &link("upper_arm", 0.5),
        &link("forearm", 0.4),
        &joint("turn", "base", "column", 0.0, "0 0 1", 3.0),
        &joint("shoulder", "column", "upper_arm", 0.4, "0 1 0", 2.0),
        &joint("elbow", "upper_arm", "forearm", 0.5, "0 1 0", 2.6),
        "</robot>",
    ]
    .concat())
}
