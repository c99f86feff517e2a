//! SDFormat as Drake reads it: links in frames of one another, joints with rotor inertia, damping and springs.

use armident_effects::{Export, Library};
use armident_kinematics::{InertialParameters, roll_pitch_yaw};
use armident_model::ArmModel;
use nalgebra::Isometry3;

use crate::chain::{Moved, gravity_note, has_own_tip, inertia_about_com, moved, notes};
use crate::xml::Element;
use crate::{Exported, Held, effects};

/// Frame that every model of SDFormat has.
const WORLD: &str = "world";

/// The model as SDFormat for Drake; also read by Gazebo.
///
/// The base link is welded to the world. Rotor inertia is the tag `drake:rotor_inertia` with a gear ratio of 1. Joints without
/// limit of effort get an actuator without limit.
pub fn drake_sdf(model: &ArmModel) -> Exported {
    drake_sdf_in(Library::standard(), model)
}

/// The model as SDFormat, whose effects are of this library.
pub fn drake_sdf_in(library: &Library, model: &ArmModel) -> Exported {
    let (held, lost) = effects::sorted(library, &model.effects, element_of);
    let mut remarks = notes(model);
    remarks.extend(gravity_note(model, "SDFormat has no gravity outside of a world"));
    if held.iter().any(|one| one.attribute == "friction" && one.value != 0.0) {
        remarks.push("Drake ignores <friction> of joints; Gazebo reads it".to_owned());
    }
    let (chain, tip) = moved(model);
    let mut robot = Element::new("model").with("name", model.chain.robot.as_str());
    let mut before = model.chain.base_link.as_str();
    if before != WORLD {
        // without an inertial its mass would be 1 kg, which a weld hides
        robot.push(Element::new("link").with("name", before));
        robot.push(
            Element::new("joint")
                .with("name", format!("{WORLD}_to_{before}"))
                .with("type", "fixed")
                .child(text("parent", WORLD))
                .child(text("child", before)),
        );
    }
    for link in &chain {
        robot.push(body(link, before, &mut remarks));
        robot.push(joint(link, before, &held));
        before = link.link;
    }
    if has_own_tip(model) {
        robot.push(
            Element::new("frame")
                .with("name", model.chain.tip_link.as_str())
                .with("attached_to", before)
                .child(pose(&tip)),
        );
    }
    let root = Element::new("sdf")
        .with("version", "1.9")
        .with("xmlns:drake", "http://drake.mit.edu")
        .child(robot);
    Exported { text: root.document(&model.provenance), companion: None, held, lost, notes: remarks }
}

/// The element that holds what MJCF holds in an attribute of a joint.
fn element_of(export: &Export) -> Option<&'static str> {
    match export.mjcf? {
        "damping" => Some("damping"),
        "frictionloss" => Some("friction"),
        "armature" => Some("drake:rotor_inertia"),
        "stiffness" => Some("spring_stiffness"),
        _ => None,
    }
}

fn text(tag: &'static str, text: &str) -> Element {
    Element::new(tag).containing(text)
}

fn numbers(tag: &'static str, values: &[f64]) -> Element {
    Element::new(tag).containing_numbers(values)
}

fn pose(pose: &Isometry3<f64>) -> Element {
    let rpy = roll_pitch_yaw(&pose.rotation.to_rotation_matrix());
    let place = pose.translation.vector;
    numbers("pose", &[place.x, place.y, place.z, rpy[0], rpy[1], rpy[2]])
}

fn body(link: &Moved<'_>, before: &str, notes: &mut Vec<String>) -> Element {
    let mut place = pose(&link.pose);
    // a pose is in the frame of the model otherwise
    place = place.with("relative_to", before);
    let element = Element::new("link").with("name", link.link).child(place);
    if link.inertia == InertialParameters::zero() {
        notes.push(format!("link `{}` has no inertia; SDFormat then assumes 1 kg", link.link));
        return element;
    }
    let mut inertia = Element::new("inertia");
    let entries = inertia_about_com(link, notes);
    for (name, value) in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].into_iter().zip(entries) {
        inertia.push(numbers(name, &[value]));
    }
    let com = link.inertia.com_m();
    element.child(
        Element::new("inertial")
            .child(numbers("pose", &[com.x, com.y, com.z, 0.0, 0.0, 0.0]))
            .child(numbers("mass", &[link.inertia.mass_kg]))
            .child(inertia),
    )
}

fn joint(link: &Moved<'_>, parent: &str, held: &[Held]) -> Element {
    let limits = &link.limits;
    let kind = match link.kind.is_rotational() {
        true if limits.lower.is_some() || limits.upper.is_some() => "revolute",
        true => "continuous",
        false => "prismatic",
    };
    let mut limit = Element::new("limit");
    for (name, value) in [("lower", limits.lower), ("upper", limits.upper)] {
        limit.children_of(value.map(|value| numbers(name, &[value])));
    }
    // -1: without limit; 0 would be a joint without actuator
    limit.push(numbers("effort", &[limits.effort.unwrap_or(-1.0)]));
    limit.children_of(limits.velocity.map(|value| numbers("velocity", &[value])));
    let mut axis = Element::new("axis").child(numbers("xyz", link.axis.as_slice())).child(limit);
    let attributes = effects::attributes(held, link.joint);
    let (rotor, dynamics): (Vec<_>, Vec<_>) =
        attributes.into_iter().partition(|(name, _)| name.starts_with("drake:"));
    if !dynamics.is_empty() {
        let mut element = Element::new("dynamics");
        dynamics.into_iter().for_each(|(name, value)| element.push(numbers(name, &[value])));
        axis.push(element);
    }
    let mut element = Element::new("joint")
        .with("name", link.joint)
        .with("type", kind)
        .child(text("parent", parent))
        .child(text("child", link.link))
        .child(axis);
    rotor.into_iter().for_each(|(name, value)| element.push(numbers(name, &[value])));
    element
}
