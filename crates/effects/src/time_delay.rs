//! Efforts recorded late.

use crate::arm_motion::rate;
use crate::law::{ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Parameter, Place, Scope};

/// `recorded effort(t) = true effort(t - delay)`.
pub struct TimeDelay;

const LAW: Law = Law {
    slug: "time_delay",
    title: "time delay",
    formula: "recorded effort(t) = true effort(t - delay), all joints",
    scope: Scope::Arm,
    places: &[Place::Time],
    parameters: &[Parameter::any("delay", "s", "s")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "viscous_friction",
            separated_by: "the same amplitude at two frequencies: friction grows with the speed, a delay with its cube",
        },
        LookAlike {
            slug: "rotor_inertia",
            separated_by: "efforts without acceleration: a delay shifts gravity too",
        },
    ],
    export: Export::NONE,
};

impl Effect for TimeDelay {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// The derivative of the effort by time, with the opposite sign.
    fn arm_columns(&self, _joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        let against =
            |effort: &Vec<f64>| rate(effort, motion.rate_hz).iter().map(|rate| -rate).collect();
        vec![motion.rigid_effort.iter().map(against).collect()]
    }

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::EffortDelay(parameters[0])
    }
}
