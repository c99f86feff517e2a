//! Play in the transmission: the encoder is on the motor side.

use crate::law::{Effect, Export, Law, LookAlike, Onset, Parameter, Place, Scope};

/// `as elasticity, with no effort while `|θ - q| < gap / 2`.
pub struct Backlash;

const LAW: Law = Law {
    slug: "backlash",
    title: "backlash",
    formula: "as elasticity, with tJ = 0 while abs(th - q) < gap/2 and a stiff contact outside",
    scope: Scope::ThroughJoint,
    places: &[Place::Inertia],
    parameters: &[
        Parameter::non_negative("gap", "rad", "m"),
        Parameter::non_negative("contact_stiffness", "N m/rad", "N/m"),
        Parameter::non_negative("contact_damping", "N m s/rad", "N s/m"),
        Parameter::non_negative("motor_inertia", "kg m2", "kg"),
    ],
    contains: &["rotor_inertia"],
    look_alikes: &[
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "with and without gravity load: hysteresis stays at reversals, play moves to where the transmitted effort changes sign",
        },
        LookAlike {
            slug: "joint_elasticity",
            separated_by: "with and without gravity load on the joint",
        },
    ],
    export: Export::NONE,
};

impl Effect for Backlash {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        let [gap, stiffness, damping] = [parameters[0], parameters[1], parameters[2]];
        let motor_inertia = parameters[3];
        crate::Mechanism::Transmission(crate::Transmission {
            gap,
            stiffness,
            damping,
            motor_inertia,
        })
    }
}
