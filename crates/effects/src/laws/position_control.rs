//! The position controller of a joint.

use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Naming, Parameter, Scope};
use crate::mechanism::Mechanism;
use crate::servo::PositionServo;

/// The effort of the motor follows from the command and the position: the one law that gives the effort of a joint instead of
/// adding to it. Its parameters are the numbers of a [`PositionServo`], whose estimator is an output-error fit.
pub struct PositionControl;

const LAW: Law = Law {
    slug: "position_control",
    title: "position controller",
    formula: "effort = stiffness dead(command(t - delay) - position), abs(effort) <= effort_limit unless that is 0",
    scope: Scope::Joint,
    roles: &[LawRole::Drive],
    parameters: &[
        Parameter::non_negative("stiffness", "N m/rad", "N/m").main(),
        Parameter::non_negative("delay", "s", "s").main(),
        Parameter::non_negative("dead_band", "rad", "m"),
        Parameter::non_negative("effort_limit", "N m", "N"),
    ],
    naming: Naming::FromCommands,
    look_alikes: &[
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Record a second gain of the controller: the derivative part of a controller and a delay grow with it, viscous friction does not.",
        },
        LookAlike {
            slug: "rotor_inertia",
            separated_by: "Record quick reversals: a delay moves the whole response, inertia only its accelerated part.",
        },
        LookAlike {
            slug: "torque_offset",
            separated_by: "Rest in poses in which the weight on the joint differs, best with its other sign: a sag follows the weight, an offset does not.",
        },
    ],
    ..Law::BLANK
};

impl Effect for PositionControl {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        Mechanism::Servo(PositionServo::of_parameters(parameters))
    }
}
