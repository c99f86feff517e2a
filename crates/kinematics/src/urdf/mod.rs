//! Reads a URDF file into a checked [`RobotDescription`].
//!
//! Two readers share the work. `roxmltree` gives lines and presence: the file is compared with the
//! table of the format, so that every fault has a place and nothing is dropped silently. `urdf-rs`
//! then interprets the elements of the table.

mod check;
mod format;
mod hint;
mod joints;
mod links;
mod mjcf;
mod notes;
mod pose;
mod shapes;
mod tree;
mod xml;

#[cfg(test)]
mod tests;

pub(crate) use hint::hint;
pub use mjcf::{MjcfJointValue, MjcfRobot, is_mjcf, parse_mjcf};
pub use pose::roll_pitch_yaw;

use std::path::Path;

use roxmltree::Node;

use crate::error::UrdfError;
use crate::{IgnoredElement, RobotDescription};
use check::{check_element, write_element};
use format::{ElementRule, JOINT, LINK};
use notes::{Concerned, Notes};
use pose::UrdfVersion;
use tree::Tree;
use xml::{UrdfText, most_similar, qualified_tag, urdf_tag};

/// Reads a URDF file.
///
/// # Errors
/// Any [`UrdfError`]: the file cannot be read, or its text is refused as by [`parse_urdf`].
pub fn load_urdf(path: &Path) -> Result<RobotDescription, UrdfError> {
    let source = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => parse_urdf_bytes(&bytes, &source),
        Err(cause) => {
            Err(UrdfError::Unreadable { place: UrdfText::new("", &source).whole(), cause })
        }
    }
}

/// Reads a URDF from the bytes of a file; `source` is its label in messages.
///
/// # Errors
/// [`UrdfError::NotUtf8`] with the offset of the first wrong byte, else as [`parse_urdf`].
pub fn parse_urdf_bytes(bytes: &[u8], source: &str) -> Result<RobotDescription, UrdfError> {
    match std::str::from_utf8(bytes) {
        Ok(text) => parse_urdf(text, source),
        Err(error) => {
            let offset = error.valid_up_to();
            let valid = std::str::from_utf8(&bytes[..offset]).unwrap_or_default();
            let text = UrdfText::new(valid, source);
            Err(UrdfError::NotUtf8 {
                place: text.place(text.line_at(offset), None),
                offset,
                byte: bytes[offset],
                utf16: bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]),
            })
        }
    }
}

/// Reads a URDF from its text; `source` is its label in messages.
///
/// Shapes for collisions are read where they are primitives, and not checked ([`crate::CollisionGeometry::NotRead`]).
/// Not used, and therefore not checked: visual shapes, materials, calibration, safety controllers.
/// Elements outside links and joints are listed in [`RobotDescription::ignored`]; doubtful
/// but usable values give [`RobotDescription::warnings`].
///
/// # Errors
/// Any [`UrdfError`] but [`UrdfError::Unreadable`] and [`UrdfError::NotUtf8`].
///
/// # Examples
/// ```
/// let text = r#"<robot name="pendulum">
///   <link name="base"/>
///   <link name="rod">
///     <inertial>
///       <origin xyz="0 0 -0.5"/>
///       <mass value="2"/>
///       <inertia ixx="0.17" ixy="0" ixz="0" iyy="0.17" iyz="0" izz="0.01"/>
///     </inertial>
///   </link>
///   <joint name="swing" type="continuous">
///     <parent link="base"/> <child link="rod"/> <axis xyz="0 1 0"/>
///   </joint>
/// </robot>"#;
/// let robot = armident_kinematics::parse_urdf(text, "<memory>")?;
/// assert_eq!(robot.joints[0].axis, [0.0, 1.0, 0.0]);
///
/// let error = armident_kinematics::parse_urdf(&text.replace("\"2\"", "\"-2\""), "<memory>");
/// assert_eq!(error.unwrap_err().place(), "<memory>, line 6, link `rod`");
/// # Ok::<(), armident_kinematics::UrdfError>(())
/// ```
pub fn parse_urdf(text: &str, source: &str) -> Result<RobotDescription, UrdfError> {
    let text = UrdfText::new(text, source);
    let document = text.open()?;
    let robot = document.root_element();
    let mut notes = Notes::default();
    let content = check_robot(&text, robot, &mut notes)?;
    let tree = Tree::new(&text, &content.links, &content.joints).map_err(|error| match error {
        UrdfError::SeveralRoots { place, roots, .. } => {
            UrdfError::SeveralRoots { place, roots, misspelt: content.misspelt.clone() }
        }
        error => error,
    })?;
    let meaning = read_meaning(&text, robot, &content)?;

    let version = UrdfVersion::of(robot);
    let mut links = Vec::with_capacity(content.links.len());
    for (i, &node) in content.links.iter().enumerate() {
        let (urdf, name) = (&meaning.links[i], tree.link_names[i]);
        links.push(links::read_link(&text, node, urdf, version, name, &mut notes)?);
    }
    let mut joints = Vec::with_capacity(content.joints.len());
    for (i, &node) in content.joints.iter().enumerate() {
        let (urdf, name, ends) = (&meaning.joints[i], tree.joint_names[i], tree.ends[i]);
        joints.push(joints::read_joint(&text, node, urdf, version, name, ends, &mut notes)?);
    }
    let is_fixed = |joint: usize| joints[joint].joint_type == crate::UrdfJointType::Fixed;
    links::note_massless_bodies(&tree, &content.links, &links, is_fixed, &mut notes);
    Ok(RobotDescription {
        name: robot.attribute("name").unwrap_or_default().to_owned(),
        source: source.to_owned(),
        links,
        joints,
        root: tree.root,
        warnings: notes.into_warnings(),
        ignored: content.ignored,
    })
}

/// The children of `<robot>`, in file order.
#[derive(Default)]
struct RobotContent<'a, 'i> {
    links: Vec<Node<'a, 'i>>,
    joints: Vec<Node<'a, 'i>>,
    ignored: Vec<IgnoredElement>,
    /// The first ignored element with a tag like `link` or `joint`.
    misspelt: Option<IgnoredElement>,
}

/// Sorts the children of `<robot>` and compares each with the table of the format.
fn check_robot<'a, 'i>(
    text: &UrdfText<'_>,
    robot: Node<'a, 'i>,
    notes: &mut Notes,
) -> Result<RobotContent<'a, 'i>, UrdfError> {
    let mut content = RobotContent::default();
    let concerned = |kind: &'static str, node: Node<'_, '_>| {
        let name = node.attribute("name").unwrap_or_default().to_owned();
        Concerned { kind, name, line: text.line(node) }
    };
    if robot.attribute("name").is_none_or(|name| name.trim().is_empty()) {
        let sentence = "no name; other URDF readers reject the file";
        notes.add("robot-name-missing", concerned("robot", robot), sentence);
    }
    for child in robot.children().filter(Node::is_element) {
        match urdf_tag(child) {
            Some("link") => {
                check_element(text, child, &LINK, &concerned("link", child), notes)?;
                content.links.push(child);
            }
            Some("joint") => {
                check_element(text, child, &JOINT, &concerned("joint", child), notes)?;
                content.joints.push(child);
            }
            Some("material") => {}
            _ => {
                let element = IgnoredElement { tag: qualified_tag(child), line: text.line(child) };
                if let Some(meant) = most_similar(&element.tag, ["link", "joint"]) {
                    let sentence = format!("ignored; did you mean `<{meant}>`?");
                    let name = format!("<{}>", element.tag);
                    let concerned = Concerned { kind: "element", name, line: element.line };
                    notes.add("element-ignored", concerned, sentence);
                    content.misspelt.get_or_insert_with(|| element.clone());
                }
                content.ignored.push(element);
            }
        }
    }
    if content.links.is_empty() {
        return Err(UrdfError::NoLinks { place: text.place_of(robot), misspelt: content.misspelt });
    }
    Ok(content)
}

/// Lets `urdf-rs` read links and joints.
fn read_meaning(
    text: &UrdfText<'_>,
    robot: Node<'_, '_>,
    content: &RobotContent<'_, '_>,
) -> Result<urdf_rs::Robot, UrdfError> {
    let mut known = String::with_capacity(text.text.len());
    known.push_str("<robot name=\"robot\">");
    let mut write = |nodes: &[Node<'_, '_>], rule: &ElementRule| {
        for &node in nodes {
            write_element(&mut known, node, rule);
        }
    };
    write(&content.links, &LINK);
    write(&content.joints, &JOINT);
    known.push_str("</robot>");
    let refused = |found: String| UrdfError::Refused { place: text.place_of(robot), found };
    let meaning = urdf_rs::read_from_string(&known).map_err(|error| refused(error.to_string()))?;
    if (meaning.links.len(), meaning.joints.len()) != (content.links.len(), content.joints.len()) {
        return Err(refused("different number of links or joints".to_owned()));
    }
    Ok(meaning)
}
