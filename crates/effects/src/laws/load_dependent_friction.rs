//! Dry friction that grows with the load the gear carries.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::column;
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{DryFriction, JointMotion, JointState};

/// `f = (Fc + µ |rigid|) sign(v)`.
pub struct LoadDependentFriction;

const LAW: Law = Law {
    slug: "load_dependent_friction",
    title: "load-dependent friction",
    formula: "f = (Fc + mu abs(rigid)) sign(v)",
    scope: Scope::Joint,
    roles: &[LawRole::Dry],
    follows_load: true,
    parameters: &[
        Parameter::non_negative("level", "N m", "N"),
        Parameter::non_negative("load_coefficient", "1", "1").main(),
    ],
    contains: &["coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "torque_scale",
            separated_by: "Move up and down through the same poses: friction changes sign with direction, a gain error does not.",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "Repeat the motion with another payload or in another pose.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Dry friction that grows with what the gear carries, as teeth press harder on each other.",
    sizes: &[
        "RMD-X8: about 10 % of the load (axol, issue 317)",
        "eRob80 with a gear of 100: about 5 %; MX-106: 20 % of the motor's share, 2 % of the load (BAM)",
        "Bittencourt and others (2010): load and temperature together take a factor of 6 off the average error of a friction model",
    ],
    signature: "The step at a reversal is higher where the joint carries more: points spread between two cones instead of two lines.",
    example: Example::new("elbow_joint", &[2.0, 0.12], Against::Load),
};

impl Effect for LoadDependentFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let load =
            column(motion.velocity.len(), |t| motion.direction[t] * motion.rigid_effort[t].abs());
        vec![motion.direction.to_vec(), load]
    }

    fn dry_friction(&self, parameters: &[f64], state: &JointState) -> DryFriction {
        DryFriction::both(parameters[0] + parameters[1] * state.load.abs())
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let ControllerVariables { direction, load, .. } = of;
        Some(format!("{direction} * ({:?} + {:?} * fabs({load}))", parameters[0], parameters[1]))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let level = context.joints[joint].visible_dry_level();
        Some(DrawnEffect::new(joint, 0.1, move |x| vec![level, x]).at_most(0.35))
    }
}
