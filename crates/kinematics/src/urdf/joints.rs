//! Origin, axis, limits, friction and coupling of the joints.

use roxmltree::Node;

use super::check::number;
use super::notes::{Concerned, Notes, four_digits};
use super::pose::{UrdfVersion, read_pose, unit_vector};
use super::tree::child;
use super::xml::UrdfText;
use crate::error::UrdfError;
use crate::{JointDescription, JointDynamics, JointLimits, Mimic, UrdfJointType};

/// Tolerance of the length of an axis: three printed digits.
const UNIT_TOLERANCE: f64 = 1e-3;

/// One joint, with notes on doubtful values.
pub(super) fn read_joint(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    joint: &urdf_rs::Joint,
    version: UrdfVersion,
    name: &str,
    (parent, child_link): (usize, usize),
    notes: &mut Notes,
) -> Result<JointDescription, UrdfError> {
    let joint_type = joint_type(text, node, &joint.joint_type)?;
    let line = text.line(node);
    let concerned = Concerned { kind: "joint", name: name.to_owned(), line };
    let mut note = |code: &'static str, sentence: String| {
        notes.add(code, concerned.clone(), sentence);
    };
    let origin = child(node, "origin");
    let (origin_xyz_m, origin_rpy_rad) =
        read_pose(text, origin, &joint.origin, version, &mut note)?;
    Ok(JointDescription {
        name: name.to_owned(),
        joint_type,
        parent,
        child: child_link,
        origin_xyz_m,
        origin_rpy_rad,
        axis: read_axis(text, node, *joint.axis.xyz, joint_type, &mut note)?,
        limits: read_limits(child(node, "limit"), joint_type, version, &mut note),
        dynamics: joint.dynamics.as_ref().map(|d| read_dynamics(d, &mut note)),
        mimic: read_mimic(node, joint, &mut note),
        line,
    })
}

fn joint_type(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    urdf: &urdf_rs::JointType,
) -> Result<UrdfJointType, UrdfError> {
    Ok(match urdf {
        urdf_rs::JointType::Revolute => UrdfJointType::Revolute,
        urdf_rs::JointType::Continuous => UrdfJointType::Continuous,
        urdf_rs::JointType::Prismatic => UrdfJointType::Prismatic,
        urdf_rs::JointType::Fixed => UrdfJointType::Fixed,
        urdf_rs::JointType::Floating => UrdfJointType::Floating,
        urdf_rs::JointType::Planar => UrdfJointType::Planar,
        urdf_rs::JointType::Spherical => {
            return Err(UrdfError::Refused {
                place: text.place_of(node),
                found: "spherical joints are not part of the URDF format".to_owned(),
            });
        }
    })
}

fn read_axis(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    xyz: [f64; 3],
    joint_type: UrdfJointType,
    note: &mut impl FnMut(&'static str, String),
) -> Result<[f64; 3], UrdfError> {
    const DEFAULT_AXIS: [f64; 3] = [1.0, 0.0, 0.0];
    let is_used = joint_type.is_movable() || joint_type == UrdfJointType::Planar;
    let Some(element) = child(node, "axis") else {
        if is_used {
            note("axis-missing", "no `<axis>`; using the default 1 0 0".to_owned());
        }
        return Ok(DEFAULT_AXIS);
    };
    let found = element.attribute("xyz").unwrap_or_default();
    match unit_vector(xyz) {
        Some((axis, norm)) => {
            if is_used && (norm - 1.0).abs() > UNIT_TOLERANCE {
                let length = four_digits(norm);
                let sentence = format!("axis ({found}) normalised (length {length})");
                note("axis-not-unit", sentence);
            }
            Ok(axis)
        }
        // exporters write 0 0 0 for joints that do not move
        None if !is_used => Ok(DEFAULT_AXIS),
        None => Err(UrdfError::ZeroAxis {
            place: text.place_of_attribute(element, "xyz"),
            found: found.to_owned(),
        }),
    }
}

/// Usable limits; `urdf-rs` returns zeros for a joint without any.
fn read_limits(
    limit: Option<Node<'_, '_>>,
    joint_type: UrdfJointType,
    version: UrdfVersion,
    note: &mut impl FnMut(&'static str, String),
) -> JointLimits {
    let has_range = matches!(joint_type, UrdfJointType::Revolute | UrdfJointType::Prismatic);
    let Some(limit) = limit else {
        if has_range {
            note("limit-missing", "no `<limit>`; treated as unlimited".to_owned());
        }
        return JointLimits::default();
    };
    if !joint_type.is_movable() {
        return JointLimits::default();
    }
    let mut limits = JointLimits::default();
    if has_range {
        let default = (version < UrdfVersion::OPEN_LIMITS).then_some(0.0);
        let lower = number(limit, "lower").or(default);
        let upper = number(limit, "upper").or(default);
        match (lower, upper) {
            (Some(low), Some(high)) if low >= high => note(
                "limit-empty",
                format!("empty range (lower {low}, upper {high}); treated as unlimited"),
            ),
            _ => (limits.lower, limits.upper) = (lower, upper),
        }
    }
    let (mut absent, mut useless) = (Vec::new(), Vec::new());
    let mut largest = |attribute: &str| match number(limit, attribute) {
        Some(value) if value > 0.0 => Some(value),
        Some(value) => {
            useless.push(format!("{attribute} is {value}"));
            None
        }
        None => {
            absent.push(format!("no `{attribute}`"));
            None
        }
    };
    limits.effort = largest("effort");
    limits.velocity = largest("velocity");
    if !useless.is_empty() {
        let sentence = format!("`<limit>` {}; treated as unspecified", useless.join(" and "));
        note("limit-empty", sentence);
    }
    if !absent.is_empty() && version < UrdfVersion::OPEN_LIMITS {
        let sentence = format!(
            "`<limit>` has {}; treated as unspecified, but other URDF readers reject the file",
            absent.join(" and ")
        );
        note("limit-incomplete", sentence);
    }
    limits
}

fn read_dynamics(
    dynamics: &urdf_rs::Dynamics,
    note: &mut impl FnMut(&'static str, String),
) -> JointDynamics {
    let (damping, friction) = (dynamics.damping, dynamics.friction);
    for (attribute, value) in [("damping", damping), ("friction", friction)] {
        if value < 0.0 {
            let sentence = format!("negative `{attribute}` ({value}) adds energy; used as is");
            note("dynamics-negative", sentence);
        }
    }
    JointDynamics { damping, friction }
}

fn read_mimic(
    node: Node<'_, '_>,
    joint: &urdf_rs::Joint,
    note: &mut impl FnMut(&'static str, String),
) -> Option<Mimic> {
    // the name comes from the checked document, as all names do
    let master = child(node, "mimic")?.attribute("joint")?.to_owned();
    let sentence = "`<mimic>` ignored; treated as an independent joint".to_owned();
    note("mimic-independent", sentence);
    let mimic = joint.mimic.as_ref();
    Some(Mimic {
        master,
        multiplier: mimic.and_then(|m| m.multiplier).unwrap_or(1.0),
        offset: mimic.and_then(|m| m.offset).unwrap_or(0.0),
    })
}
