//! Efforts recorded late.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::rate;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LocationKind, LookAlike, OperatingTerm, Parameter, Scope};
use crate::mechanism::Mechanism;
use crate::motion::{ArmColumns, WholeArmMotion};

/// `recorded effort(t) = true effort(t - delay)`.
pub struct TimeDelay;

const LAW: Law = Law {
    slug: "time_delay",
    title: "effort delay",
    formula: "recorded effort(t) = true effort(t - delay), all joints",
    scope: Scope::Arm,
    roles: &[LawRole::Time],
    parameters: &[Parameter::any("delay", "s", "s").main()],
    location: LocationKind::AllJoints,
    operating: Some(OperatingTerm::Delay),
    look_alikes: &[
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Repeat the motion with the same amplitude at two frequencies: friction grows with the speed, the effect of a delay with its cube.",
        },
        LookAlike {
            slug: "rotor_inertia",
            separated_by: "Compare phases without acceleration: a delay also shifts the gravity effort.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Efforts and positions are not of the same instant: another bus, another filter.",
    sizes: &[
        "Franka, recorded through ROS: 0.53 s of transport (capture script of Isaac Sim)",
        "A user's fit of 9.5 ms that was probably another effect (PACE)",
    ],
    signature: "The change of the effort with time, on all joints, gravity included. At one frequency it looks like viscous friction; friction grows with the speed, a delay with its cube.",
    example: Example::new("", &[0.01], Against::Time),
};

impl Effect for TimeDelay {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// The derivative of the effort by time, with the opposite sign.
    fn arm_columns(&self, _joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let against =
            |effort: &Vec<f64>| rate(effort, motion.rate_hz).iter().map(|rate| -rate).collect();
        vec![motion.rigid_effort.iter().map(against).collect()]
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        Mechanism::EffortDelay(parameters[0])
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        Some(DrawnEffect::new(joint, 5e-3, move |x| vec![side * x]).at_most(0.015))
    }
}
