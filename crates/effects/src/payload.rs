//! A load on the last link.

use crate::LinkInertiaError;
use crate::law::{ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Parameter, Place, Scope};

/// `f = Y_last π(m, com)`.
pub struct Payload;

const LAW: Law = Law {
    slug: "payload",
    title: "payload",
    formula: "a rigid mass fixed to the last link, not in the model",
    scope: Scope::Link,
    places: &[Place::Link],
    parameters: &[
        Parameter::non_negative("mass", "kg", "kg"),
        Parameter::any("com_x", "m", "m"),
        Parameter::any("com_y", "m", "m"),
        Parameter::any("com_z", "m", "m"),
    ],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "the same motion with and without the load",
        },
        LookAlike {
            slug: "gravity_direction",
            separated_by: "the first axis, if it is vertical: only a tilt loads it with gravity",
        },
    ],
    export: Export { urdf: Some("inertial"), mjcf: Some("inertial") },
};

impl Effect for Payload {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// The ten columns of the last link's standard parameters.
    fn arm_columns(&self, _joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        LinkInertiaError.arm_columns(motion.arm.dof() - 1, motion)
    }
}
