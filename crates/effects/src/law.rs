//! What is written once about every effect.

use armident_kinematics::JointKind;

/// The sign a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Admissible {
    /// Any finite number.
    Any,
    /// Zero or more: a fit of the other sign refuses the effect's name.
    NonNegative,
}

impl Admissible {
    /// Whether a value is admissible.
    pub fn allows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Any || value >= 0.0)
    }
}

/// One number of a law.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name in files and tables.
    pub name: &'static str,
    /// Unit on a rotational joint.
    pub unit_rotational: &'static str,
    /// Unit on a translational joint.
    pub unit_translational: &'static str,
    /// Admissible sign.
    pub admissible: Admissible,
}

impl Parameter {
    /// Unit on a joint of this kind.
    pub fn unit(&self, kind: JointKind) -> &'static str {
        if kind.is_rotational() { self.unit_rotational } else { self.unit_translational }
    }
}

/// Another effect that can look the same, and the motion that tells them apart.
#[derive(Debug, Clone, Copy)]
pub struct LookAlike {
    /// Slug of the other effect, or a name of a rigid-body constant.
    pub slug: &'static str,
    /// The motion that separates the two.
    pub separated_by: &'static str,
}

/// How an effect is written into simulator formats.
#[derive(Debug, Clone, Copy)]
pub struct Export {
    /// Attribute of URDF's `<dynamics>`, if it can hold the effect.
    pub urdf: Option<&'static str>,
    /// Attribute of MJCF's `<joint>`, if it can hold the effect.
    pub mjcf: Option<&'static str>,
}

/// Everything about an effect that is not computed.
#[derive(Debug, Clone, Copy)]
pub struct Law {
    /// Name in files.
    pub slug: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// `f`, the effort the motor supplies on top of the rigid body, as a formula.
    pub formula: &'static str,
    /// Parameters in the order of every parameter vector.
    pub parameters: &'static [Parameter],
    /// What it can be confused with.
    pub look_alikes: &'static [LookAlike],
    /// What simulator formats hold of it.
    pub export: Export,
}

/// Motion of one joint over a recording: what columns are formed from. All slices have one length.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion<'a> {
    /// Time \[s\].
    pub time_s: &'a [f64],
    /// Position \[rad or m\].
    pub position: &'a [f64],
    /// Velocity \[rad/s or m/s\].
    pub velocity: &'a [f64],
    /// Acceleration \[rad/s2 or m/s2\].
    pub acceleration: &'a [f64],
    /// Speed under which the direction of motion is not known \[rad/s or m/s\]: signs fade to zero
    /// there instead of following the noise.
    pub speed_resolution: f64,
}

/// State of one joint at an instant of a simulation.
#[derive(Debug, Clone, Copy)]
pub struct JointState {
    /// Position \[rad or m\].
    pub position: f64,
    /// Velocity \[rad/s or m/s\].
    pub velocity: f64,
}

/// One physical effect on one joint, linear in its parameters.
///
/// Sign convention: `effort = rigid(q, q̇, q̈) + f`, `f` is what the motor has to supply on top.
pub trait Effect: Sync {
    /// What is written once.
    fn law(&self) -> &'static Law;

    /// Estimator: columns whose combination with the parameters is `f`, one per parameter.
    fn columns(&self, motion: &JointMotion<'_>) -> Vec<Vec<f64>>;

    /// Simulator: the part of `f` that is a smooth function of position and velocity.
    fn smooth_effort(&self, _parameters: &[f64], _state: &JointState) -> f64 {
        0.0
    }

    /// Simulator: dry friction level \[N m or N\]; at rest the effort is anything within it.
    fn dry_friction(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// Simulator: inertia added to the diagonal of `H` \[kg m2 or kg\].
    fn added_inertia(&self, _parameters: &[f64]) -> f64 {
        0.0
    }
}
