//! Isaac Lab: the actuators of a robot as Python source.

use std::fmt::Write as _;

use armident_effects::{Export, Library};
use armident_model::ArmModel;

use crate::chain::{Moved, moved};
use crate::servos::{lost_of_servo, servos};
use crate::xml::number;
use crate::{Exported, Held, effects};

/// Arguments by joint, with what they are.
const ARGUMENTS: [(&str, &str); 3] = [
    ("armature", "rotor inertia [kg m2 or kg]"),
    ("friction", "Coulomb friction [N m or N]"),
    ("viscous_friction", "viscous friction [N m s/rad or N s/m]"),
];

/// The joints of a model as `ImplicitActuatorCfg` of Isaac Lab 2.2 or newer.
///
/// Joints with a position controller have its stiffness, the others follow efforts. Links are not part of it: they are in the
/// USD of the robot ([`usd`](crate::usd)).
pub fn isaac_lab(model: &ArmModel) -> Exported {
    isaac_lab_in(Library::standard(), model)
}

/// The joints of a model for Isaac Lab, whose effects are of this library.
pub fn isaac_lab_in(library: &Library, model: &ArmModel) -> Exported {
    let (servos, others) = servos(library, &model.effects);
    let (mut held, mut lost) = effects::sorted(library, &others, argument_of);
    let mut remarks = vec![
        "an actuator has no links: write those with --format usd".to_owned(),
        "friction is an effort since Isaac Sim 5.0; before, it is a share of the joint's load"
            .to_owned(),
    ];
    let (chain, _) = moved(model);
    let mut text = source_head(model);
    let names: Vec<String> = chain.iter().map(|link| quoted(link.joint)).collect();
    let _ = writeln!(text, "        joint_names_expr=[{}],", names.join(", "));
    let limit = |link: &Moved<'_>| {
        let of_servo = servos.iter().find(|(on, _)| on.joint == link.joint);
        of_servo.and_then(|(_, servo)| servo.effort_limit).or(link.limits.effort)
    };
    let limits: [(&str, Vec<Option<f64>>); 2] = [
        ("effort_limit_sim", chain.iter().map(limit).collect()),
        ("velocity_limit_sim", chain.iter().map(|link| link.limits.velocity).collect()),
    ];
    for (name, values) in limits {
        // a joint that is not in a table would get the limit 0
        match values.iter().copied().collect::<Option<Vec<f64>>>() {
            Some(values) => by_joint(&mut text, name, &names, &values, ""),
            None => remarks.push(format!("{name} omitted: not every joint has the limit")),
        }
    }
    let stiffness: Vec<f64> = (chain.iter())
        .map(|link| {
            let servo = servos.iter().find(|(on, _)| on.joint == link.joint);
            servo.map_or(0.0, |(_, servo)| servo.stiffness)
        })
        .collect();
    by_joint(&mut text, "stiffness", &names, &stiffness, "of the position controller");
    by_joint(&mut text, "damping", &names, &vec![0.0; names.len()], "of the position controller");
    for (on, servo) in &servos {
        let (effect, joint) = (on.effect.clone(), on.joint.clone());
        held.push(Held { effect, joint, attribute: "stiffness", value: servo.stiffness });
        lost.extend(lost_of_servo(
            on,
            servo,
            "implicit actuators have no delay",
            "implicit actuators have no dead band",
        ));
    }
    for (name, what) in ARGUMENTS {
        let values: Vec<f64> = (chain.iter())
            .map(|link| {
                let found = effects::attributes(&held, link.joint);
                found.into_iter().find(|(argument, _)| *argument == name).map_or(0.0, |(_, v)| v)
            })
            .collect();
        by_joint(&mut text, name, &names, &values, what);
        if name == "friction" {
            by_joint(&mut text, "dynamic_friction", &names, &values, "the same: sliding");
        }
    }
    text += "    ),\n}\n";
    Exported { text, companion: None, held, lost, notes: remarks }
}

/// The argument that holds what MJCF holds in an attribute of a joint.
fn argument_of(export: &Export) -> Option<&'static str> {
    match export.mjcf? {
        "damping" => Some("viscous_friction"),
        "frictionloss" => Some("friction"),
        "armature" => Some("armature"),
        _ => None,
    }
}

fn source_head(model: &ArmModel) -> String {
    let mut text = format!("\"\"\"Actuators of {} for Isaac Lab.\n", in_text(&model.chain.robot));
    for line in &model.provenance {
        let _ = write!(text, "\n{}", in_text(line));
    }
    if !model.provenance.is_empty() {
        text += "\n";
    }
    text += "\n    ArticulationCfg(..., actuators=ACTUATORS)\n\"\"\"\n\nfrom isaaclab.actuators import \
             ImplicitActuatorCfg\n\nACTUATORS = {\n    \"arm\": ImplicitActuatorCfg(\n";
    text
}

/// A text within three quotation marks.
fn in_text(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "'")
}

/// A name as a regular expression that means it alone, in quotation marks.
fn quoted(name: &str) -> String {
    let mut text = "\"".to_owned();
    for letter in name.chars() {
        match letter {
            '"' => text += "\\\"",
            '\\' => text += "\\\\\\\\",
            letter if letter.is_alphanumeric() || letter == '_' => text.push(letter),
            letter => {
                text += "\\\\";
                text.push(letter);
            }
        }
    }
    text + "\""
}

fn by_joint(text: &mut String, argument: &str, names: &[String], values: &[f64], what: &str) {
    let remark = if what.is_empty() { String::new() } else { format!("  # {what}") };
    if values.iter().all(|value| *value == 0.0) {
        let _ = writeln!(text, "        {argument}=0.0,{remark}");
        return;
    }
    let _ = writeln!(text, "        {argument}={{{remark}");
    for (name, value) in names.iter().zip(values) {
        let value = if *value == 0.0 { "0.0".to_owned() } else { number(*value) };
        let _ = writeln!(text, "            {name}: {value},");
    }
    *text += "        },\n";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_mean_themselves_alone() {
        assert_eq!(quoted("elbow_joint"), "\"elbow_joint\"");
        assert_eq!(quoted("left/arm.2"), "\"left\\\\/arm\\\\.2\"");
    }
}
