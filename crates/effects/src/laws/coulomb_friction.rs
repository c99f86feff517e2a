//! Coulomb friction.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Baseline, Export, Law, LawRole, LookAlike, Onset, Parameter, Scope};
use crate::motion::{DryFriction, JointMotion, JointState};

/// `f = Fc sign(v)`; at rest anything within `±Fc`.
pub struct CoulombFriction;

const LAW: Law = Law {
    slug: "coulomb_friction",
    title: "Coulomb friction",
    formula: "f = Fc sign(v); at rest anything within +-Fc",
    scope: Scope::Joint,
    roles: &[LawRole::Dry],
    parameters: &[Parameter::non_negative("level", "N m", "N").main()],
    baseline: Some(Baseline::Coulomb),
    look_alikes: &[
        LookAlike {
            slug: "torque_offset",
            separated_by: "Move in both directions through the same positions: friction changes sign, an offset does not.",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Move slowly and fast: at a single speed the two are collinear.",
        },
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "Make small, slow reversals: presliding friction depends on the travel since the reversal.",
        },
    ],
    export: Export { urdf: Some("friction"), mjcf: Some("frictionloss") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Resistance that depends on the direction of motion and not on the speed: dry contact in gears and seals. At rest it takes any value up to its level.",
    sizes: &[
        "Staubli TX40, joints 1 to 6: 7.0, 8.1, 6.3, 2.5, 3.0, 0.24 N m (FIGAROH); 7.0, 7.8, 6.2, 2.4, 3.4, 1.8 (BIRDy, where joints 5 and 6 are apart)",
        "KUKA LWR, joint 1: about 11.6 N m (issue 6 of the Panda dynamics repository)",
        "eRob80 with a gear of 100: 5.6 N m (BAM)",
        "PUMA 560, brought to the joints: 25 to 27, 8 to 14, 6 to 7, wrist 0.3 to 1.3 N m (numbers of the Robotics Toolbox)",
    ],
    signature: "A step at every reversal, of one height at any speed and load.",
    example: Example::new("elbow_joint", &[3.3], Against::Speed),
};

impl Effect for CoulombFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.direction.to_vec()]
    }

    fn dry_friction(&self, parameters: &[f64], _state: &JointState) -> DryFriction {
        DryFriction::both(parameters[0])
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        Some(format!("{:?} * {}", parameters[0], of.direction))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        Some(DrawnEffect::new(joint, 4.0 * size.noise, |x| vec![x]))
    }
}
