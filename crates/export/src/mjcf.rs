//! MJCF, the format of MuJoCo: bodies in one another, joints with armature and losses, motors.

use armident_effects::{Effect, EffectOnJoint, Library, PositionServo, TorqueOffset};
use armident_model::ArmModel;
use nalgebra::Isometry3;

use crate::chain::{Moved, has_own_tip, inertia_about_com, moved, notes};
use crate::servos::servos;
use crate::xml::Element;
use crate::{Exported, Held, Lost, effects};

/// Name of the body that every model of MuJoCo has.
const WORLD: &str = "world";
/// Shortest step of a simulation \[s\] whose commands the memory of a delay holds: a quarter of MuJoCo's own.
const SHORTEST_STEP_S: f64 = 5e-4;

/// The model as MJCF.
///
/// Every joint has a motor of gear 1 (control is the effort), limited where the joint is; a joint with a position controller has
/// a position actuator (control is the command), or a general one where its effort has an offset. Neither has a dead band, and
/// delays need MuJoCo 3.5 or newer.
pub fn mjcf(model: &ArmModel) -> Exported {
    mjcf_in(Library::standard(), model)
}

/// The model as MJCF, whose effects are of this library.
pub fn mjcf_in(library: &Library, model: &ArmModel) -> Exported {
    let (servos, others) = servos(library, &model.effects);
    let (controllers, others) = with_offsets(servos, others);
    let (mut held, mut lost) = effects::sorted(library, &others, |export| export.mjcf);
    let mut said = notes(model);
    if controllers.iter().any(|controller| controller.servo.delay_s > 0.0) {
        said.push("actuators have delays: needs MuJoCo 3.5 or newer".to_owned());
    }
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
        let controller = controllers.iter().find(|controller| controller.on.joint == link.joint);
        actuators.push(match controller {
            Some(controller) => controller.actuator(link, &mut held, &mut lost),
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

/// A position controller of a joint.
struct Controller {
    on: EffectOnJoint,
    servo: PositionServo,
    /// constant effort that the joint takes \[N m or N\]
    offset: f64,
}

/// Controllers with the offsets of their joints, and the other effects.
fn with_offsets(
    servos: Vec<(EffectOnJoint, PositionServo)>,
    mut others: Vec<EffectOnJoint>,
) -> (Vec<Controller>, Vec<EffectOnJoint>) {
    let of = |(on, servo)| Controller { on, servo, offset: 0.0 };
    let mut controllers: Vec<Controller> = servos.into_iter().map(of).collect();
    others.retain(|on| {
        let controller = controllers.iter_mut().find(|controller| controller.on.joint == on.joint);
        let Some(controller) = controller.filter(|_| on.effect == TorqueOffset.slug()) else {
            return true;
        };
        controller.offset += on.parameters[0];
        false
    });
    (controllers, others)
}

fn motor(link: &Moved<'_>) -> Element {
    let motor = Element::new("motor").with("name", link.joint).with("joint", link.joint);
    match link.limits.effort {
        Some(limit) => motor.numbers("ctrlrange", &[-limit, limit]),
        None => motor,
    }
}

impl Controller {
    /// With what it holds and what it cannot.
    fn actuator(&self, link: &Moved<'_>, held: &mut Vec<Held>, lost: &mut Vec<Lost>) -> Element {
        let Self { on, servo, offset } = self;
        let holds = |effect: &str, attribute, value| Held {
            effect: effect.to_owned(),
            joint: on.joint.clone(),
            attribute,
            value,
        };
        let tag = if *offset == 0.0 { "position" } else { "general" };
        let actuator = Element::new(tag).with("name", link.joint).with("joint", link.joint);
        let mut actuator = if *offset == 0.0 {
            held.push(holds(&on.effect, "kp", servo.stiffness));
            actuator.numbers("kp", &[servo.stiffness])
        } else {
            // effort = kp command - offset - kp position
            held.push(holds(&on.effect, "gainprm", servo.stiffness));
            held.push(holds(TorqueOffset.slug(), "biasprm", -offset));
            actuator
                .numbers("gainprm", &[servo.stiffness])
                .with("biastype", "affine")
                .numbers("biasprm", &[-offset, -servo.stiffness, 0.0])
        };
        if servo.delay_s > 0.0 {
            held.push(holds(&on.effect, "delay", servo.delay_s));
            let steps = (servo.delay_s / SHORTEST_STEP_S).ceil() + 2.0;
            actuator = actuator
                .numbers("delay", &[servo.delay_s])
                .numbers("nsample", &[steps])
                .with("interp", "linear");
        }
        if servo.dead_band != 0.0 {
            let (effect, joint) = (on.effect.clone(), on.joint.clone());
            let reason = "position actuators have no dead band";
            lost.push(Lost { effect, joint, parameters: vec![servo.dead_band], reason });
        }
        if let Some(limit) = servo.effort_limit {
            held.push(holds(&on.effect, "forcerange", limit));
        }
        match servo.effort_limit.or(link.limits.effort) {
            Some(limit) => actuator.numbers("forcerange", &[-limit, limit]),
            None => actuator,
        }
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
