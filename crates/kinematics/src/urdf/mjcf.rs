//! Reads MJCF, the format of MuJoCo, as a tree of links and joints: bodies, hinge and slide joints with their losses, gravity.
//!
//! Bodies become links, and the world is the root. A joint whose anchor is not the origin of its body, and each further joint of
//! a body, gets a link of its own without mass. Source: MuJoCo, XML Reference.

use std::collections::BTreeMap;

use nalgebra::{
    Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};
use roxmltree::Node;

use super::pose::roll_pitch_yaw;
use super::xml::UrdfText;
use crate::error::UrdfError;
use crate::{
    IgnoredElement, InertialDescription, JointDescription, JointDynamics, JointLimits,
    LinkDescription, RobotDescription, UrdfJointType, Warning,
};

/// A robot of MuJoCo.
#[derive(Debug, Clone)]
pub struct MjcfRobot {
    /// Bodies as links, joints as joints.
    pub description: RobotDescription,
    /// `<option gravity>` \[m/s2\] in the world.
    pub gravity: [f64; 3],
    /// What joints lose and their rotors add.
    pub joint_values: Vec<MjcfJointValue>,
}

/// An attribute of a joint that URDF does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct MjcfJointValue {
    /// Name of the joint.
    pub joint: String,
    /// `armature`, `damping`, `frictionloss` or `stiffness`.
    pub attribute: &'static str,
    /// Its value \[SI\].
    pub value: f64,
}

/// Attributes of joints that are laws of efforts.
const VALUES: [&str; 4] = ["armature", "damping", "frictionloss", "stiffness"];
/// Deepest nesting of bodies.
const DEEPEST: usize = 200;
/// Gravity of MuJoCo where the file has none \[m/s2\].
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
/// What resolves anything that MuJoCo's compiler knows.
const COMPILE: &str = "let MuJoCo write one plain file: `python -c \"import mujoco as m; \
                       m.mj_saveLastXML('plain.xml', m.MjModel.from_xml_path('robot.xml'))\"`";

/// Whether a text is MJCF: its first element is `<mujoco>`.
pub fn is_mjcf(text: &str) -> bool {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    loop {
        let skipped = match rest {
            comment if comment.starts_with("<!--") => comment.split_once("-->"),
            other if other.starts_with("<?") || other.starts_with("<!") => other.split_once('>'),
            other => {
                let tag = other.strip_prefix("<mujoco");
                return tag.is_some_and(|end| end.starts_with([' ', '>', '/', '\n', '\r', '\t']));
            }
        };
        match skipped {
            Some((_, behind)) => rest = behind.trim_start(),
            None => return false,
        }
    }
}

/// Reads MJCF from its text; `source` is its label in messages.
///
/// Masses are those of `<inertial>`: bodies without it have none, with a warning where they have shapes. Defaults of joints by
/// class are read. Ball and free joints are kept as joints that no chain may contain. Ignored: shapes, sites, tendons, equality
/// constraints, actuators, sensors.
///
/// # Errors
/// The text is no MJCF, includes or repeats other content, or has values without meaning.
///
/// # Examples
/// ```
/// let text = r#"<mujoco model="pendulum"><compiler angle="radian"/><worldbody>
///   <body name="rod"><inertial pos="0 0 -0.5" mass="2" diaginertia="0.17 0.17 0.01"/>
///     <joint name="swing" axis="0 1 0" damping="0.1"/></body>
/// </worldbody></mujoco>"#;
/// let robot = armident_kinematics::parse_mjcf(text, "pendulum.xml")?;
/// assert_eq!(robot.description.joints[0].axis, [0.0, 1.0, 0.0]);
/// assert_eq!((robot.joint_values[0].attribute, robot.joint_values[0].value), ("damping", 0.1));
/// # Ok::<(), armident_kinematics::UrdfError>(())
/// ```
pub fn parse_mjcf(text: &str, source: &str) -> Result<MjcfRobot, UrdfError> {
    let text = UrdfText::new(text, source);
    let document = text.document()?;
    let root = document.root_element();
    if root.tag_name().name() != "mujoco" {
        let found = root.tag_name().name().to_owned();
        return Err(UrdfError::NotRobot { place: text.place_of(root), found });
    }
    let unread = ["include", "replicate", "attach", "composite", "flexcomp"];
    if let Some(node) = root.descendants().find(|node| unread.contains(&node.tag_name().name())) {
        let what = format!("`<{}>` of MJCF is not read", node.tag_name().name());
        return Err(UrdfError::Mjcf {
            place: text.place_of(node),
            what,
            advice: COMPILE.to_owned(),
        });
    }
    let mut reader = Reader::new(&text, root)?;
    let world = reader.link("world", root, None);
    for body in root.children().filter(|node| node.has_tag_name("worldbody")) {
        reader.content(body, world, Isometry3::identity(), None, 0)?;
    }
    Ok(MjcfRobot {
        description: RobotDescription {
            name: root.attribute("model").unwrap_or("mujoco").to_owned(),
            source: source.to_owned(),
            links: reader.links,
            joints: reader.joints,
            root: world,
            warnings: reader.warnings,
            ignored: reader.ignored,
        },
        gravity: reader.gravity,
        joint_values: reader.values,
    })
}

/// What is read so far, and what the compiler of MuJoCo is told.
struct Reader<'a, 'i> {
    text: &'a UrdfText<'a>,
    links: Vec<LinkDescription>,
    joints: Vec<JointDescription>,
    warnings: Vec<Warning>,
    ignored: Vec<IgnoredElement>,
    values: Vec<MjcfJointValue>,
    gravity: [f64; 3],
    /// attributes of joints by class, those of outer classes included
    classes: BTreeMap<String, BTreeMap<String, String>>,
    is_degrees: bool,
    /// axes of Euler angles; capital letters are of the fixed frame
    euler: String,
    has_automatic_limits: bool,
    document: std::marker::PhantomData<&'i ()>,
}

impl<'a, 'i> Reader<'a, 'i> {
    fn new(text: &'a UrdfText<'a>, root: Node<'_, 'i>) -> Result<Self, UrdfError> {
        let mut reader = Self {
            text,
            links: Vec::new(),
            joints: Vec::new(),
            warnings: Vec::new(),
            ignored: Vec::new(),
            values: Vec::new(),
            gravity: GRAVITY,
            classes: BTreeMap::new(),
            is_degrees: true,
            euler: "xyz".to_owned(),
            has_automatic_limits: true,
            document: std::marker::PhantomData,
        };
        for node in root.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "compiler" => {
                    if let Some(angle) = node.attribute("angle") {
                        reader.is_degrees = angle != "radian";
                    }
                    if let Some(order) = node.attribute("eulerseq") {
                        order.clone_into(&mut reader.euler);
                    }
                    if let Some(limits) = node.attribute("autolimits") {
                        reader.has_automatic_limits = limits != "false";
                    }
                }
                "option" => {
                    if let Some(gravity) = reader.numbers::<3>(node, "gravity")? {
                        reader.gravity = gravity;
                    }
                }
                "default" => reader.class(node, &BTreeMap::new(), 0),
                "worldbody" => {}
                tag => {
                    let line = text.line(node);
                    reader.ignored.push(IgnoredElement { tag: tag.to_owned(), line });
                }
            }
        }
        Ok(reader)
    }

    /// Attributes of the joints of a class and of the classes in it.
    fn class(&mut self, node: Node<'_, '_>, outer: &BTreeMap<String, String>, depth: usize) {
        let mut own = outer.clone();
        for joint in node.children().filter(|child| child.has_tag_name("joint")) {
            own.extend(joint.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())));
        }
        let name = node.attribute("class").unwrap_or("main").to_owned();
        for inner in node.children().filter(|child| child.has_tag_name("default")) {
            if depth < DEEPEST {
                self.class(inner, &own, depth + 1);
            }
        }
        self.classes.insert(name, own);
    }

    /// Bodies and frames within a body, `at` in the frame of the link `parent`.
    fn content(
        &mut self,
        node: Node<'_, '_>,
        parent: usize,
        at: Isometry3<f64>,
        class: Option<&str>,
        depth: usize,
    ) -> Result<(), UrdfError> {
        if depth > DEEPEST {
            return Err(self.fault(
                node,
                format!("bodies are nested deeper than {DEEPEST}"),
                COMPILE,
            ));
        }
        let class = node.attribute("childclass").or(class);
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "frame" => {
                    let pose = at * self.pose(child)?;
                    self.content(child, parent, pose, class, depth + 1)?;
                }
                "body" => {
                    let pose = at * self.pose(child)?;
                    self.body(child, parent, pose, class, depth + 1)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn body(
        &mut self,
        node: Node<'_, '_>,
        parent: usize,
        pose: Isometry3<f64>,
        class: Option<&str>,
        depth: usize,
    ) -> Result<(), UrdfError> {
        let name = match node.attribute("name") {
            Some(name) => name.to_owned(),
            None => format!("body_{}", self.links.len()),
        };
        let class = node.attribute("childclass").or(class);
        let is_joint =
            |child: &Node<'_, '_>| child.has_tag_name("joint") || child.has_tag_name("freejoint");
        let joints: Vec<Node<'_, '_>> = node.children().filter(is_joint).collect();
        let (mut before, mut at) = (parent, pose);
        for (k, joint) in joints.iter().enumerate() {
            let anchor = self.read_joint(*joint, &name, k, class)?;
            let (place, rest) = anchor.place(&at);
            // the last joint moves the body itself where the frames agree
            let is_last = k + 1 == joints.len() && rest == Isometry3::identity();
            let link = match is_last {
                true => self.link_of_body(&name, node)?,
                false => self.link(&format!("{name}_{}", anchor.joint.name), *joint, None),
            };
            self.add_joint(anchor.joint, before, link, &place);
            (before, at) = (link, rest);
            if is_last {
                return self.content(node, link, Isometry3::identity(), class, depth);
            }
        }
        let link = self.link_of_body(&name, node)?;
        let fixed = self.plain_joint(format!("{name}_fixed"), UrdfJointType::Fixed, node);
        self.add_joint(fixed, before, link, &at);
        self.content(node, link, Isometry3::identity(), class, depth)
    }

    fn add_joint(
        &mut self,
        joint: JointDescription,
        parent: usize,
        child: usize,
        place: &Isometry3<f64>,
    ) {
        let origin_xyz_m = place.translation.vector.into();
        let origin_rpy_rad = roll_pitch_yaw(&place.rotation.to_rotation_matrix());
        self.joints.push(JointDescription { parent, child, origin_xyz_m, origin_rpy_rad, ..joint });
    }

    fn plain_joint(
        &self,
        name: String,
        joint_type: UrdfJointType,
        node: Node<'_, '_>,
    ) -> JointDescription {
        JointDescription {
            name,
            joint_type,
            parent: 0,
            child: 0,
            origin_xyz_m: [0.0; 3],
            origin_rpy_rad: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            limits: JointLimits::default(),
            dynamics: None,
            mimic: None,
            line: self.text.line(node),
        }
    }

    fn read_joint(
        &mut self,
        node: Node<'_, '_>,
        body: &str,
        number: usize,
        class: Option<&str>,
    ) -> Result<Anchored, UrdfError> {
        let name = match node.attribute("name") {
            Some(name) => name.to_owned(),
            None => format!("{body}_joint_{}", number + 1),
        };
        let class = node.attribute("class").or(class).unwrap_or("main");
        let defaults = self.classes.get(class).cloned().unwrap_or_default();
        let of = |attribute: &str| {
            node.attribute(attribute)
                .map(str::to_owned)
                .or_else(|| defaults.get(attribute).cloned())
        };
        let numbers = |attribute: &str, count: usize| -> Result<Option<Vec<f64>>, UrdfError> {
            of(attribute).map(|found| self.parsed(node, attribute, &found, count)).transpose()
        };
        let kind = of("type").unwrap_or_else(|| "hinge".to_owned());
        let joint_type = match (node.tag_name().name(), kind.as_str()) {
            ("freejoint", _) | (_, "free" | "ball") => UrdfJointType::Floating,
            (_, "slide") => UrdfJointType::Prismatic,
            (_, "hinge") => UrdfJointType::Revolute,
            (_, other) => {
                let what = format!("a joint must be hinge, slide, ball or free, found `{other}`");
                return Err(self.fault(node, what, "correct its attribute `type`"));
            }
        };
        let mut joint = self.plain_joint(name, joint_type, node);
        let mut anchored =
            Anchored { joint: joint.clone(), anchor: Vector3::zeros(), reference: 0.0 };
        if joint_type == UrdfJointType::Floating {
            return Ok(anchored);
        }
        if let Some(axis) = numbers("axis", 3)? {
            let axis = Vector3::new(axis[0], axis[1], axis[2]);
            let Some(axis) = Unit::try_new(axis, 1e-9) else {
                let advice = "set the direction of the joint, such as axis=\"0 0 1\"";
                return Err(self.fault(node, "the axis of a joint is zero".to_owned(), advice));
            };
            joint.axis = axis.into_inner().into();
        }
        if let Some(anchor) = numbers("pos", 3)? {
            anchored.anchor = Vector3::new(anchor[0], anchor[1], anchor[2]);
        }
        let is_hinge = joint_type == UrdfJointType::Revolute;
        let unit = if is_hinge && self.is_degrees { std::f64::consts::PI / 180.0 } else { 1.0 };
        if let Some(reference) = numbers("ref", 1)? {
            anchored.reference = unit * reference[0];
        }
        let range = numbers("range", 2)?.filter(|range| range[0] < range[1]);
        let is_limited = match of("limited").as_deref() {
            Some("true") => true,
            Some("false") => false,
            _ => self.has_automatic_limits,
        };
        if let Some(range) = range.filter(|_| is_limited) {
            (joint.limits.lower, joint.limits.upper) =
                (Some(unit * range[0]), Some(unit * range[1]));
        } else if is_hinge {
            joint.joint_type = UrdfJointType::Continuous;
        }
        if let Some(range) = numbers("actuatorfrcrange", 2)? {
            let largest = range[0].abs().max(range[1].abs());
            joint.limits.effort = (largest > 0.0).then_some(largest);
        }
        let mut values = Vec::new();
        for attribute in VALUES {
            let Some(found) = of(attribute) else { continue };
            // damping and stiffness may be polynomials, whose first number is the linear one
            let first = found.split_whitespace().next().unwrap_or_default().to_owned();
            let value = self.parsed(node, attribute, &first, 1)?[0];
            if value < 0.0 {
                let what = format!("`{attribute}` must be at least 0, found `{first}`");
                return Err(self.fault(node, what, "correct the value"));
            }
            if value > 0.0 {
                values.push(MjcfJointValue { joint: joint.name.clone(), attribute, value });
            }
        }
        let value = |attribute: &str| {
            values.iter().find(|one| one.attribute == attribute).map_or(0.0, |one| one.value)
        };
        let (damping, friction) = (value("damping"), value("frictionloss"));
        joint.dynamics =
            (damping != 0.0 || friction != 0.0).then_some(JointDynamics { damping, friction });
        self.values.extend(values);
        anchored.joint = joint;
        Ok(anchored)
    }

    fn link(
        &mut self,
        name: &str,
        node: Node<'_, '_>,
        inertial: Option<InertialDescription>,
    ) -> usize {
        let (name, line) = (name.to_owned(), self.text.line(node));
        self.links.push(LinkDescription { name, inertial, collisions: Vec::new(), line });
        self.links.len() - 1
    }

    /// The link of a body, with its `<inertial>`.
    fn link_of_body(&mut self, name: &str, node: Node<'_, '_>) -> Result<usize, UrdfError> {
        if self.links.iter().any(|link| link.name == name) {
            let what = format!("two bodies are named `{name}`");
            return Err(self.fault(node, what, "rename one of the two"));
        }
        let found = node.children().find(|child| child.has_tag_name("inertial"));
        let inertial = found.map(|inertial| self.inertial(inertial)).transpose()?;
        let has_shapes = node.children().any(|child| child.has_tag_name("geom"));
        if inertial.is_none() && has_shapes {
            self.warnings.push(
                Warning::new(
                    "mass-of-shapes",
                    format!(
                        "body `{name}` has no <inertial>: the mass of its shapes is not read; {COMPILE}"
                    ),
                )
                .about([name.to_owned()]),
            );
        }
        Ok(self.link(name, node, inertial))
    }

    fn inertial(&self, node: Node<'_, '_>) -> Result<InertialDescription, UrdfError> {
        let pose = self.pose(node)?;
        let mass_kg = match self.numbers::<1>(node, "mass")? {
            Some([mass]) if mass >= 0.0 => mass,
            _ => {
                let what = "`<inertial>` must have a `mass` of at least 0".to_owned();
                return Err(self.fault(node, what, "write `mass=\"...\"` in kg"));
            }
        };
        let inertia_kgm2 = match (
            self.numbers::<6>(node, "fullinertia")?,
            self.numbers::<3>(node, "diaginertia")?,
        ) {
            (Some([xx, yy, zz, xy, xz, yz]), _) => [xx, xy, xz, yy, yz, zz],
            (None, Some([xx, yy, zz])) => [xx, 0.0, 0.0, yy, 0.0, zz],
            (None, None) => [0.0; 6],
        };
        Ok(InertialDescription {
            mass_kg,
            com_in_link_m: pose.translation.vector.into(),
            rpy_rad: roll_pitch_yaw(&pose.rotation.to_rotation_matrix()),
            inertia_kgm2,
        })
    }

    /// `pos` and the orientation of an element, in any of its forms.
    fn pose(&self, node: Node<'_, '_>) -> Result<Isometry3<f64>, UrdfError> {
        let place = self.numbers::<3>(node, "pos")?.unwrap_or_default();
        let unit = if self.is_degrees { std::f64::consts::PI / 180.0 } else { 1.0 };
        let direction = |x: &[f64]| Unit::try_new(Vector3::new(x[0], x[1], x[2]), 1e-9);
        let zero = |attribute: &str| {
            self.fault(
                node,
                format!("`{attribute}` has a length of zero"),
                "correct it, or omit it",
            )
        };
        let turn = if let Some([w, x, y, z]) = self.numbers::<4>(node, "quat")? {
            let quaternion = Quaternion::new(w, x, y, z);
            UnitQuaternion::try_new(quaternion, 1e-9).ok_or_else(|| zero("quat"))?
        } else if let Some(found) = self.numbers::<4>(node, "axisangle")? {
            let axis = direction(&found).ok_or_else(|| zero("axisangle"))?;
            UnitQuaternion::from_axis_angle(&axis, unit * found[3])
        } else if let Some(angles) = self.numbers::<3>(node, "euler")? {
            self.euler(node, angles.map(|angle| unit * angle))?
        } else if let Some(found) = self.numbers::<6>(node, "xyaxes")? {
            let x = direction(&found).ok_or_else(|| zero("xyaxes"))?.into_inner();
            let y = Vector3::new(found[3], found[4], found[5]);
            let y = Unit::try_new(y - x * x.dot(&y), 1e-9).ok_or_else(|| zero("xyaxes"))?;
            let axes = Matrix3::from_columns(&[x, *y, x.cross(&y)]);
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
        } else if let Some(found) = self.numbers::<3>(node, "zaxis")? {
            let z = direction(&found).ok_or_else(|| zero("zaxis"))?;
            let half = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            UnitQuaternion::rotation_between(&Vector3::z(), &z).unwrap_or(half)
        } else {
            UnitQuaternion::identity()
        };
        Ok(Isometry3::from_parts(Translation3::new(place[0], place[1], place[2]), turn))
    }

    fn euler(
        &self,
        node: Node<'_, '_>,
        angles: [f64; 3],
    ) -> Result<UnitQuaternion<f64>, UrdfError> {
        let mut turn = UnitQuaternion::identity();
        let letters: Vec<char> = self.euler.chars().collect();
        if letters.len() != 3 {
            let what = format!("`eulerseq` must have three letters, found `{}`", self.euler);
            return Err(self.fault(node, what, "write eulerseq=\"xyz\""));
        }
        for (letter, angle) in letters.into_iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                'z' => Vector3::z_axis(),
                _ => {
                    let what = format!("`eulerseq` must be of x, y and z, found `{}`", self.euler);
                    return Err(self.fault(node, what, "write eulerseq=\"xyz\""));
                }
            };
            let next = UnitQuaternion::from_axis_angle(&axis, angle);
            turn = if letter.is_ascii_uppercase() { next * turn } else { turn * next };
        }
        Ok(turn)
    }

    /// The numbers of an attribute; none where it is absent.
    fn numbers<const N: usize>(
        &self,
        node: Node<'_, '_>,
        attribute: &str,
    ) -> Result<Option<[f64; N]>, UrdfError> {
        let Some(found) = node.attribute(attribute) else { return Ok(None) };
        let list = self.parsed(node, attribute, found, N)?;
        let mut numbers = [0.0; N];
        numbers.copy_from_slice(&list);
        Ok(Some(numbers))
    }

    fn parsed(
        &self,
        node: Node<'_, '_>,
        attribute: &str,
        found: &str,
        count: usize,
    ) -> Result<Vec<f64>, UrdfError> {
        let numbers: Option<Vec<f64>> = found
            .split_whitespace()
            .map(|word| word.parse::<f64>().ok().filter(|number| number.is_finite()))
            .collect();
        numbers.filter(|list| list.len() == count).ok_or_else(|| {
            let number = if count == 1 { "number" } else { "numbers" };
            let what = format!("`{attribute}` must be {count} {number}, found `{found}`");
            UrdfError::Mjcf {
                place: self.text.place_of_attribute(node, attribute),
                what,
                advice: "write numbers separated by spaces".to_owned(),
            }
        })
    }

    fn fault(&self, node: Node<'_, '_>, what: String, advice: &str) -> UrdfError {
        UrdfError::Mjcf { place: self.text.place_of(node), what, advice: advice.to_owned() }
    }
}

/// A joint with its anchor in the frame of its body.
struct Anchored {
    joint: JointDescription,
    anchor: Vector3<f64>,
    /// position of the joint in the configuration of the file
    reference: f64,
}

impl Anchored {
    /// Origin of the joint where the body is `at`, and the pose of the body behind the joint.
    fn place(&self, at: &Isometry3<f64>) -> (Isometry3<f64>, Isometry3<f64>) {
        let anchor = Translation3::from(self.anchor);
        let axis = Vector3::from(self.joint.axis);
        let back = match self.joint.joint_type {
            UrdfJointType::Prismatic => Isometry3::from(Translation3::from(-self.reference * axis)),
            UrdfJointType::Revolute | UrdfJointType::Continuous if self.reference != 0.0 => {
                let turn =
                    UnitQuaternion::from_axis_angle(&Unit::new_unchecked(axis), -self.reference);
                Isometry3::from_parts(Translation3::identity(), turn)
            }
            _ => Isometry3::identity(),
        };
        (at * anchor * back, Isometry3::from(anchor.inverse()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_element_decides() {
        assert!(is_mjcf("\u{feff}<?xml version=\"1.0\"?>\n<!-- <robot> -->\n<mujoco model=\"x\">"));
        assert!(
            is_mjcf("<mujoco/>")
                && !is_mjcf("<robot name=\"mujoco\">")
                && !is_mjcf("<mujocoinclude/>")
        );
        assert!(!is_mjcf("") && !is_mjcf("<!-- <mujoco>"));
    }

    #[test]
    fn defaults_degrees_and_anchors_are_read() {
        let text = r#"<mujoco model="m"><option gravity="0 0 -1"/>
<default><joint damping="1"/><default class="big"><joint armature="0.5" axis="1 0 0"/></default></default>
<worldbody><frame pos="0 0 1"><body name="a" pos="1 0 0" childclass="big"><joint name="j" pos="0 0 2" range="-90 90"/>
<inertial pos="0 0 0" mass="1" fullinertia="1 2 3 0.1 0.2 0.3"/>
<body name="b" euler="90 0 0"><joint name="k" class="main" type="slide" axis="0 0 2" frictionloss="3"/><joint name="l"/></body>
</body></frame></worldbody><actuator/></mujoco>"#;
        let MjcfRobot { description, gravity, joint_values } = parse_mjcf(text, "m.xml").unwrap();
        assert_eq!(gravity, [0.0, 0.0, -1.0]);
        let names = |list: Vec<&str>| list.join(" ");
        assert_eq!(
            names(description.links.iter().map(|l| l.name.as_str()).collect()),
            "world a_j a b_k b"
        );
        assert_eq!(
            names(description.joints.iter().map(|j| j.name.as_str()).collect()),
            "j a_fixed k l"
        );
        let [j, fixed, k, l] = &description.joints[..] else { panic!("four joints") };
        assert_eq!((j.origin_xyz_m, j.axis), ([1.0, 0.0, 3.0], [1.0, 0.0, 0.0]));
        assert_eq!(j.limits.upper, Some(std::f64::consts::FRAC_PI_2));
        assert_eq!(fixed.origin_xyz_m, [0.0, 0.0, -2.0]);
        assert_eq!((k.joint_type, k.axis), (UrdfJointType::Prismatic, [0.0, 0.0, 1.0]));
        assert!((k.origin_rpy_rad[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(l.joint_type, UrdfJointType::Continuous);
        let inertia = description.links[2].inertial.unwrap().inertia_kgm2;
        assert_eq!(inertia, [1.0, 0.1, 0.2, 2.0, 0.3, 3.0]);
        let of = |joint: &str| -> Vec<(&str, f64)> {
            let of_joint = joint_values.iter().filter(|v| v.joint == joint);
            of_joint.map(|v| (v.attribute, v.value)).collect()
        };
        assert_eq!(of("j"), [("armature", 0.5), ("damping", 1.0)]);
        assert_eq!(of("k"), [("damping", 1.0), ("frictionloss", 3.0)]);
    }

    #[test]
    fn faults_have_place_and_hint() {
        let message = |body: &str| {
            let text = format!("<mujoco><worldbody>\n{body}\n</worldbody></mujoco>");
            let error = parse_mjcf(&text, "m.xml").unwrap_err();
            format!("{error} | {} | {}", error.place(), error.hint().unwrap_or_default())
        };
        insta::assert_snapshot!(
            [
                "<include file=\"x.xml\"/>",
                "<body name=\"a\"><joint axis=\"0 0 0\"/></body>",
                "<body name=\"a\"><joint type=\"screw\"/></body>",
                "<body name=\"a\" pos=\"1 2\"/>",
                "<body name=\"a\" quat=\"0 0 0 0\"/>",
                "<body name=\"a\"><inertial pos=\"0 0 0\" mass=\"nan\"/></body>",
                "<body name=\"a\"><joint damping=\"-1\"/></body>",
                "<body name=\"a\"/><body name=\"a\"/>",
                "<body name=\"a\">",
            ]
            .map(message)
            .join("\n")
        );
    }
}
