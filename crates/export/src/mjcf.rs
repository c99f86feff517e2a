//! MJCF, the format of MuJoCo: bodies in one another, joints with armature and losses, motors.

use armident_effects::{EffectOnJoint, Library, PositionServo};
use armident_model::ArmModel;
use nalgebra::Isometry3;

use crate::chain::{Moved, has_own_tip, inertia_about_com, moved, notes};
use crate::servos::{lost_of_servo, servos};
use crate::xml::Element;
use crate::{Exported, Held, Lost, effects};

/// Name of the body that every model of MuJoCo has.
const WORLD: &str = "world";

/// The model as MJCF.
///
/// Every joint has a motor of gear 1 (control is the effort), limited where the joint is; a joint with a position controller has
/// a position actuator (control is the command). A position actuator has no delay and no dead band.
pub fn mjcf(model: &ArmModel) -> Exported {
    mjcf_in(Library::standard(), model)
}

/// The model as MJCF, whose effects are of this library.
pub fn mjcf_in(library: &Library, model: &ArmModel) -> Exported {
    let (servos, others) = servos(library, &model.effects);
    let (mut held, mut lost) = effects::sorted(library, &others, |export| export.mjcf);
    let mut said = notes(model);
    let (chain, tip) = moved(model);
    let mut inner = has_own_tip(model)
        .then(|| place(Element::new("site").with("name", model.chain.tip_link.as_str()), &tip));
    for link in chain.iter().rev() {
        let mut body = body(link, &held, &mut said);
        if let Some(inner) = inner {
            body.push(inner);
        }
        inner = Some(body);
    }
    // the body of the world is there already, under this name
    let mut world = Element::new("worldbody");
    if model.chain.base_link == WORLD {
        inner.into_iter().for_each(|inner| world.push(inner));
    } else {
        let mut base = Element::new("body").with("name", model.chain.base_link.as_str());
        inner.into_iter().for_each(|inner| base.push(inner));
        world.push(base);
    }
    let mut actuators = Element::new("actuator");
    for link in &chain {
        let servo = servos.iter().find(|(on, _)| on.joint == link.joint);
        actuators.push(match servo {
            Some((on, servo)) => position(link, on, servo, &mut held, &mut lost),
            None => motor(link),
        });
    }
    let root = Element::new("mujoco")
        .with("model", model.chain.robot.as_str())
        .child(Element::new("compiler").with("angle", "radian").with("autolimits", "true"))
        .child(Element::new("option").vector("gravity", &model.chain.gravity_base))
        .child(world)
        .child(actuators);
    Exported { text: root.document(&model.provenance), companion: None, held, lost, notes: said }
}

fn motor(link: &Moved<'_>) -> Element {
    let motor = Element::new("motor").with("name", link.joint).with("joint", link.joint);
    match link.limits.effort {
        Some(limit) => motor.numbers("ctrlrange", &[-limit, limit]),
        None => motor,
    }
}

/// A position actuator, with what it holds and what it cannot.
fn position(
    link: &Moved<'_>,
    on: &EffectOnJoint,
    servo: &PositionServo,
    held: &mut Vec<Held>,
    lost: &mut Vec<Lost>,
) -> Element {
    let holds = |attribute, value| Held {
        effect: on.effect.clone(),
        joint: on.joint.clone(),
        attribute,
        value,
    };
    held.push(holds("kp", servo.stiffness));
    if let Some(limit) = servo.effort_limit {
        held.push(holds("forcerange", limit));
    }
    lost.extend(lost_of_servo(
        on,
        servo,
        "position actuators have no delay",
        "position actuators have no dead band",
    ));
    let actuator = Element::new("position")
        .with("name", link.joint)
        .with("joint", link.joint)
        .numbers("kp", &[servo.stiffness]);
    match servo.effort_limit.or(link.limits.effort) {
        Some(limit) => actuator.numbers("forcerange", &[-limit, limit]),
        None => actuator,
    }
}

fn place(element: Element, pose: &Isometry3<f64>) -> Element {
    let q = pose.rotation;
    element.vector("pos", &pose.translation.vector).numbers("quat", &[q.w, q.i, q.j, q.k])
}

fn body(link: &Moved<'_>, held: &[Held], notes: &mut Vec<String>) -> Element {
    let [xx, xy, xz, yy, yz, zz] = inertia_about_com(link, notes);
    let kind = if link.kind.is_rotational() { "hinge" } else { "slide" };
    let mut joint = Element::new("joint")
        .with("name", link.joint)
        .with("type", kind)
        .vector("axis", &link.axis);
    if let (Some(lower), Some(upper)) = (link.limits.lower, link.limits.upper) {
        joint = joint.numbers("range", &[lower, upper]);
    }
    for (name, value) in effects::attributes(held, link.joint) {
        joint = joint.numbers(name, &[value]);
    }
    let principal = link.inertia.inertia_com_kgm2().symmetric_eigenvalues();
    if link.inertia.is_physical() && (link.inertia.mass_kg <= 0.0 || principal.min() <= 0.0) {
        notes.push(format!(
            "link `{}` has no mass or no extent and is rejected by MuJoCo",
            link.link
        ));
    }
    let mut name = link.link.to_owned();
    if name == WORLD {
        name += "_link";
        notes.push(format!("link `{}` renamed to `{name}` (MuJoCo reserves `{WORLD}`)", link.link));
    }
    place(Element::new("body").with("name", name), &link.pose)
        .child(
            Element::new("inertial")
                .vector("pos", &link.inertia.com_m())
                .numbers("mass", &[link.inertia.mass_kg])
                .numbers("fullinertia", &[xx, yy, zz, xy, xz, yz]),
        )
        .child(joint)
}
