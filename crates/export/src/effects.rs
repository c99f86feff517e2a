//! Effects by the attributes that hold them.

use armident_effects::{EffectOnJoint, Export, Library};
use serde::Serialize;

/// An effect that a format holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Held {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name.
    pub joint: String,
    /// Attribute of the file.
    pub attribute: &'static str,
    /// Its value \[SI\].
    pub value: f64,
}

/// An effect that a format cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lost {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name.
    pub joint: String,
    /// Its parameters, as in the model.
    pub parameters: Vec<f64>,
    /// Why.
    pub reason: &'static str,
}

/// Effects sorted by whether a format holds them.
pub(crate) fn sorted(
    library: &Library,
    effects: &[EffectOnJoint],
    attribute_of: fn(&Export) -> Option<&'static str>,
) -> (Vec<Held>, Vec<Lost>) {
    let (mut held, mut lost) = (Vec::new(), Vec::new());
    for on_joint in effects {
        let law = library.law(&on_joint.effect);
        let reason = match (law.and_then(|l| attribute_of(&l.export)), &on_joint.parameters[..]) {
            (Some(attribute), &[value]) if value >= 0.0 => {
                held.push(Held {
                    effect: on_joint.effect.clone(),
                    joint: on_joint.joint.clone(),
                    attribute,
                    value,
                });
                continue;
            }
            (Some(_), [_]) => "negative value, not accepted by simulators",
            _ => "not supported by the format",
        };
        // what is not there is not lost
        if on_joint.parameters.iter().any(|p| *p != 0.0) {
            lost.push(Lost {
                effect: on_joint.effect.clone(),
                joint: on_joint.joint.clone(),
                parameters: on_joint.parameters.clone(),
                reason,
            });
        }
    }
    (held, lost)
}

/// Attributes of one joint with their values; none when all are 0.
pub(crate) fn attributes(held: &[Held], joint: &str) -> Vec<(&'static str, f64)> {
    let mut list: Vec<(&'static str, f64)> = Vec::new();
    for one in held.iter().filter(|h| h.joint == joint && h.value != 0.0) {
        match list.iter_mut().find(|(name, _)| *name == one.attribute) {
            Some((_, value)) => *value += one.value,
            None => list.push((one.attribute, one.value)),
        }
    }
    list
}
