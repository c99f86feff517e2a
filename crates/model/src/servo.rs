//! The position controllers of a model's joints, as recordings of commands give them.

use armident_effects::PositionServo;
use serde::{Deserialize, Serialize};

/// The position controller of a joint in a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServoTerm {
    /// Joint.
    pub joint: String,
    /// The controller. Its stiffness is in the unit of the links' efforts, also where it is only a scale.
    #[serde(flatten)]
    pub servo: PositionServo,
    /// Whether the weight of the links determines the stiffness. If not, it is a scale: friction, inertia and offset of the
    /// joint are known over it, and positions do not depend on it.
    pub is_determined: bool,
    /// Standard error of the stiffness \[N m/rad or N/m\]; none where it is not determined.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_error: Option<f64>,
    /// Standard error of the delay \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_error_s: Option<f64>,
}

/// Checks the controllers of a file against its joints.
pub(crate) fn check_servos(servos: &[ServoTerm], joints: &[&str]) -> Result<(), String> {
    for (k, term) in servos.iter().enumerate() {
        if !joints.contains(&term.joint.as_str()) {
            return Err(format!("a servo is on unknown joint `{}`", term.joint));
        }
        if servos[..k].iter().any(|other| other.joint == term.joint) {
            return Err(format!("joint `{}` has two servos", term.joint));
        }
        if !term.servo.is_sound() {
            return Err(format!(
                "the servo of joint `{}` needs a positive stiffness, and no number below zero",
                term.joint
            ));
        }
    }
    Ok(())
}
