//! URDF: the chain with its inertials, and `<dynamics>`.

use armident_effects::Library;
use armident_kinematics::{InertialParameters, roll_pitch_yaw};
use armident_model::ArmModel;
use nalgebra::Isometry3;

use crate::chain::{Moved, gravity_note, has_own_tip, inertia_about_com, moved, notes};
use crate::xml::Element;
use crate::{Exported, Held, effects};

/// Limit where the robot description has none and the format requires one \[SI\].
const NO_LIMIT: f64 = 1e9;

/// The model as URDF.
pub fn urdf(model: &ArmModel) -> Exported {
    urdf_in(Library::standard(), model)
}

/// The model as URDF, whose effects are of this library.
pub fn urdf_in(library: &Library, model: &ArmModel) -> Exported {
    let (held, lost) = effects::sorted(library, &model.effects, |export| export.urdf);
    let mut said = notes(model);
    said.extend(gravity_note(model, "URDF has no gravity"));
    let (chain, tip) = moved(model);
    let mut robot = Element::new("robot").with("name", model.chain.robot.as_str());
    robot.push(Element::new("link").with("name", model.chain.base_link.as_str()));
    let mut before = model.chain.base_link.as_str();
    for link in &chain {
        robot.push(joint(link, before, &held, &mut said));
        robot.push(body(link, &mut said));
        before = link.link;
    }
    if has_own_tip(model) {
        let (name, base) = (model.chain.tip_link.as_str(), before);
        robot.push(
            Element::new("joint")
                .with("name", format!("{base}_to_{name}"))
                .with("type", "fixed")
                .child(origin(&tip))
                .child(Element::new("parent").with("link", base))
                .child(Element::new("child").with("link", name)),
        );
        robot.push(Element::new("link").with("name", name));
    }
    Exported { text: robot.document(&model.provenance), companion: None, held, lost, notes: said }
}

fn origin(pose: &Isometry3<f64>) -> Element {
    let rpy = roll_pitch_yaw(&pose.rotation.to_rotation_matrix());
    Element::new("origin").vector("xyz", &pose.translation.vector).numbers("rpy", &rpy)
}

fn joint(link: &Moved<'_>, parent: &str, held: &[Held], notes: &mut Vec<String>) -> Element {
    let has_range = link.limits.lower.is_some() || link.limits.upper.is_some();
    let kind = match link.kind.is_rotational() {
        true if has_range => "revolute",
        true => "continuous",
        false => "prismatic",
    };
    let mut made_up = Vec::new();
    let mut or_none = |name: &str, value: Option<f64>, otherwise: f64| {
        value.unwrap_or_else(|| {
            made_up.push(name.to_owned());
            otherwise
        })
    };
    let mut limit = Element::new("limit");
    if kind != "continuous" {
        let lower = or_none("lower", link.limits.lower, -NO_LIMIT);
        let upper = or_none("upper", link.limits.upper, NO_LIMIT);
        limit = limit.numbers("lower", &[lower]).numbers("upper", &[upper]);
    }
    let effort = or_none("effort", link.limits.effort, NO_LIMIT);
    let velocity = or_none("velocity", link.limits.velocity, NO_LIMIT);
    limit = limit.numbers("effort", &[effort]).numbers("velocity", &[velocity]);
    if !made_up.is_empty() {
        notes.push(format!(
            "joint `{}` has no {} limit; using {NO_LIMIT:e}",
            link.joint,
            made_up.join(", ")
        ));
    }
    let mut element = Element::new("joint")
        .with("name", link.joint)
        .with("type", kind)
        .child(origin(&link.pose))
        .child(Element::new("parent").with("link", parent))
        .child(Element::new("child").with("link", link.link))
        .child(Element::new("axis").vector("xyz", &link.axis))
        .child(limit);
    let attributes = effects::attributes(held, link.joint);
    if !attributes.is_empty() {
        let mut dynamics = Element::new("dynamics");
        for (name, value) in attributes {
            dynamics = dynamics.numbers(name, &[value]);
        }
        element.push(dynamics);
    }
    element
}

fn body(link: &Moved<'_>, notes: &mut Vec<String>) -> Element {
    let element = Element::new("link").with("name", link.link);
    if link.inertia == InertialParameters::zero() {
        return element;
    }
    let mut inertia = Element::new("inertia");
    for (name, value) in
        ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].into_iter().zip(inertia_about_com(link, notes))
    {
        inertia = inertia.numbers(name, &[value]);
    }
    element.child(
        Element::new("inertial")
            .child(
                Element::new("origin")
                    .vector("xyz", &link.inertia.com_m())
                    .numbers("rpy", &[0.0; 3]),
            )
            .child(Element::new("mass").numbers("value", &[link.inertia.mass_kg]))
            .child(inertia),
    )
}
