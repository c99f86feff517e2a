//! A low-pass in the drives, before the efforts are recorded.

use crate::effect::Effect;
use crate::law::{Law, LawRole, LocationKind, LookAlike, Naming, Parameter, Scope};

/// `time_constant d(recorded)/dt + recorded = true`. Its estimator is the likelihood of a lag in the input checks; a model keeps its
/// time constant beside the laws, because its efforts go through it after all of them.
pub struct DriveLowPass;

const LAW: Law = Law {
    slug: "drive_low_pass",
    title: "low-pass of the efforts",
    formula: "time_constant d(recorded effort)/dt + recorded effort = true effort, all joints",
    scope: Scope::Arm,
    roles: &[LawRole::Time],
    parameters: &[Parameter::non_negative("time_constant", "s", "s").main()],
    location: LocationKind::AllJoints,
    naming: Naming::FromChecks,
    look_alikes: &[LookAlike {
        slug: "time_delay",
        separated_by: "Move as fast as the arm can follow: a delay shifts fast and slow motion by the same time, a low-pass shifts fast motion less and damps it.",
    }],
    ..Law::BLANK
};

impl Effect for DriveLowPass {
    fn law(&self) -> &'static Law {
        &LAW
    }
}
