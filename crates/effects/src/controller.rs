//! A law as C source for a controller.

use armident_kinematics::JointKind;

/// Names of the variables in which a law is written as a C99 expression.
#[derive(Debug, Clone, Copy)]
pub struct ControllerVariables<'a> {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Position \[rad or m\].
    pub position: &'a str,
    /// Velocity \[rad/s or m/s\].
    pub velocity: &'a str,
    /// Direction of dry friction, -1 to 1.
    pub direction: &'a str,
    /// Effort of the rigid body at this joint \[N m or N\].
    pub load: &'a str,
}
