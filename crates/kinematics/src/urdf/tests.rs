use crate::{
    ChainSelection, CollisionGeometry, DrivingAxisChain, JointDynamics, JointLimits, Mimic,
    RobotDescription, SerialChain, UrdfJointType, parse_urdf,
};

const ARM: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<!-- a joint before its links, and links not in the order of the chain -->
<robot name="test &amp; arm">
  <material name="grey"><color rgba="1 1 1 1"/></material>
  <joint name="slide" type="prismatic">
    <parent link="turret"/>
    <child link="boom"/>
    <origin xyz="0.1 -0.2 3e-1" rpy="0.5 0 -1.5707963267948966"/>
    <axis xyz="0 0 -2"/>
    <limit effort="900" velocity="0.5" lower="-0.1" upper="0.8"/>
    <mimic joint="turn" offset="0.25"/>
  </joint>
  <link name="boom">
    <inertial>
      <origin xyz="0.01 0.02 0.03" rpy="0.1 0.2 0.3"/>
      <mass value="4.5"/>
      <inertia ixx="0.3" ixy="-0.01" ixz="0.02" iyy="0.25" iyz="0.03" izz="0.2"/>
    </inertial>
    <visual><geometry><box size="not numbers"/></geometry></visual>
  </link>
  <transmission name="t"><joint name="slide"/></transmission>
  <link name="base"/>
  <link name="turret">
    <inertial>
      <mass value="0"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>
    </inertial>
  </link>
  <joint name="turn" type="continuous">
    <parent link="base"/>
    <child link="turret"/>
    <limit lower="-1" upper="1" effort="20" velocity="3"/>
    <dynamics damping="0.7"/>
  </joint>
  <gazebo/>
</robot>
"#;

fn read(text: &str) -> RobotDescription {
    parse_urdf(text, "test.urdf").unwrap()
}

#[test]
fn order_and_lines_match_the_file() {
    let robot = read(ARM);
    assert_eq!((robot.name.as_str(), robot.source.as_str()), ("test & arm", "test.urdf"));
    let links: Vec<_> = robot.links.iter().map(|l| (l.name.as_str(), l.line)).collect();
    assert_eq!(links, [("boom", 13), ("base", 22), ("turret", 23)]);
    let joints: Vec<_> = robot.joints.iter().map(|j| (j.name.as_str(), j.line)).collect();
    assert_eq!(joints, [("slide", 5), ("turn", 29)]);
    let ignored: Vec<_> = robot.ignored.iter().map(|i| (i.tag.as_str(), i.line)).collect();
    assert_eq!(ignored, [("transmission", 21), ("gazebo", 35)]);
    assert_eq!(robot.root, 1);
    assert_eq!((robot.joints[0].parent, robot.joints[0].child), (2, 0));
    assert_eq!((robot.joints[1].parent, robot.joints[1].child), (1, 2));
}

#[test]
fn numbers_match_the_file() {
    let robot = read(ARM);
    let boom = robot.links[0].inertial.unwrap();
    assert_eq!(boom.mass_kg, 4.5);
    assert_eq!(boom.com_in_link_m, [0.01, 0.02, 0.03]);
    assert_eq!(boom.rpy_rad, [0.1, 0.2, 0.3]);
    assert_eq!(boom.inertia_kgm2, [0.3, -0.01, 0.02, 0.25, 0.03, 0.2]);
    let slide = &robot.joints[0];
    assert_eq!(slide.joint_type, UrdfJointType::Prismatic);
    assert_eq!(slide.origin_xyz_m, [0.1, -0.2, 0.3]);
    assert_eq!(slide.origin_rpy_rad, [0.5, 0.0, -std::f64::consts::FRAC_PI_2]);
    assert_eq!(slide.axis, [0.0, 0.0, -1.0]);
    let limits = JointLimits {
        lower: Some(-0.1),
        upper: Some(0.8),
        effort: Some(900.0),
        velocity: Some(0.5),
    };
    assert_eq!(slide.limits, limits);
    let mimic = Mimic { master: "turn".to_owned(), multiplier: 1.0, offset: 0.25 };
    assert_eq!(slide.mimic, Some(mimic));
    assert_eq!(slide.dynamics, None);
    assert_eq!(robot.joints[1].dynamics, Some(JointDynamics { damping: 0.7, friction: 0.0 }));
}

#[test]
fn absent_and_zero_limits_differ() {
    let robot = read(ARM);
    assert!(robot.links[1].inertial.is_none());
    assert_eq!(robot.links[2].inertial.unwrap().mass_kg, 0.0);
    let turn = &robot.joints[1];
    // a continuous joint has no range, whatever the file says
    assert_eq!((turn.limits.lower, turn.limits.upper), (None, None));
    assert_eq!((turn.limits.effort, turn.limits.velocity), (Some(20.0), Some(3.0)));
    assert_eq!(turn.axis, [1.0, 0.0, 0.0]);
    assert_eq!((turn.origin_xyz_m, turn.origin_rpy_rad), ([0.0; 3], [0.0; 3]));
    assert_eq!(turn.mimic, None);
}

#[test]
fn warnings_merge_by_reason() {
    let codes: Vec<_> = read(ARM).warnings.iter().map(|w| w.code).collect();
    assert_eq!(codes, ["axis-not-unit", "mimic-independent", "axis-missing"]);
}

#[test]
fn missing_limits_follow_the_version() {
    let one_sided = ARM.replace("lower=\"-0.1\" ", "");
    assert_eq!(read(&one_sided).joints[0].limits.lower, Some(0.0));
    let newer = one_sided.replace("arm\">", "arm\" version=\"1.2\">");
    assert_eq!(read(&newer).joints[0].limits.lower, None);
    assert_eq!(read(&newer).joints[0].limits.upper, Some(0.8));
}

#[test]
fn quaternions_require_version_1_1() {
    let old = ARM.replace("rpy=\"0.5 0 -1.5707963267948966\"", "quat_xyzw=\"0 0 2 2\"");
    assert_eq!(read(&old).joints[0].origin_rpy_rad, [0.0; 3]);
    let new = old.replace("arm\">", "arm\" version=\"1.1\">");
    let [roll, pitch, yaw] = read(&new).joints[0].origin_rpy_rad;
    assert!(roll.abs() < 1e-15 && pitch.abs() < 1e-15);
    assert!((yaw - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn floating_and_planar_joints_are_read() {
    for (name, joint_type) in
        [("floating", UrdfJointType::Floating), ("planar", UrdfJointType::Planar)]
    {
        let robot = read(&ARM.replace("\"prismatic\"", &format!("\"{name}\"")));
        assert_eq!(robot.joints[0].joint_type, joint_type);
        assert_eq!(robot.joints[0].limits, JointLimits::default());
    }
}

#[test]
fn printed_numbers_parse_exactly() {
    // every digit of a calibrated file counts
    let text =
        ARM.replace("4.5", "0.1234567890123456789").replace("-0.01", "-1.7976931348623157e308");
    let boom = read(&text).links[0].inertial.unwrap();
    assert_eq!(boom.mass_kg, 0.123_456_789_012_345_68);
    assert_eq!(boom.inertia_kgm2[1], -f64::MAX);
}

/// Primitives are read with their pose in the body that moves; all else is listed, and does not make the file wrong.
#[test]
fn collision_primitives_follow_their_link() {
    let text = r#"<robot name="arm"><link name="base">
        <collision><geometry><box size="2 1 0.5"/></geometry></collision></link>
      <link name="rod">
        <collision><origin xyz="0 0 1"/><geometry><cylinder radius="0.1" length="2"/></geometry></collision>
        <collision><geometry><mesh filename="rod.stl"/></geometry></collision>
        <collision><geometry><sphere radius="-1"/></geometry></collision></link>
      <link name="tool"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
      <joint name="swing" type="continuous"><parent link="base"/><child link="rod"/>
        <origin xyz="0 0 3"/><axis xyz="0 1 0"/></joint>
      <joint name="flange" type="fixed"><parent link="rod"/><child link="tool"/>
        <origin xyz="0 0 2"/></joint></robot>"#;
    let chain = SerialChain::from_description(&read(text), &ChainSelection::default()).unwrap();
    assert_eq!(
        chain.base_shapes[0].geometry,
        CollisionGeometry::Cuboid { half_edges_m: [1.0, 0.5, 0.25] }
    );
    let chain = DrivingAxisChain::from_chain(&chain);
    let joint = &chain.joints[0];
    // back in the base at q = 0
    let place = |k: usize| {
        let pose = chain.base_from_e0 * chain.parent_from_e(0, 0.0) * joint.shapes[k].pose;
        pose.translation.vector.z
    };
    let found: Vec<(&str, &CollisionGeometry)> =
        joint.shapes.iter().map(|s| (s.link.as_str(), &s.geometry)).collect();
    assert_eq!(found[0], ("rod", &CollisionGeometry::Cylinder { radius_m: 0.1, length_m: 2.0 }));
    assert_eq!(found[1], ("rod", &CollisionGeometry::NotRead("mesh".to_owned())));
    assert_eq!(found[2], ("rod", &CollisionGeometry::NotRead("sphere".to_owned())));
    assert_eq!(found[3], ("tool", &CollisionGeometry::Sphere { radius_m: 0.2 }));
    assert!((place(0) - 4.0).abs() < 1e-12 && (place(3) - 5.0).abs() < 1e-12);
}
