//! A link whose mass, centre of mass or inertia are not those of the model.

use armident_dynamics::{ParameterColumns, RigidArm};
use armident_kinematics::InertialParameters;

use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{
    Equivalent, Export, Law, LawRole, LocationKind, LookAlike, Onset, Parameter, Scope, Where,
};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `f = Y_link Δπ`.
pub struct LinkInertiaError;

const LAW: Law = Law {
    slug: "link_inertia_error",
    title: "link inertia error",
    formula: "f = Y_link delta_pi",
    scope: Scope::Link,
    roles: &[LawRole::Link],
    parameters: &[
        Parameter::any("delta_mass", "kg", "kg"),
        Parameter::any("delta_mcx", "kg m", "kg m"),
        Parameter::any("delta_mcy", "kg m", "kg m"),
        Parameter::any("delta_mcz", "kg m", "kg m"),
    ],
    location: LocationKind::Link,
    companions: &["link_inertia_error"],
    equivalents: &[Equivalent { laws: &["payload"], on: Where::LastJoint }],
    fits_alone: true,
    look_alikes: &[
        LookAlike {
            slug: "payload",
            separated_by: "On the last link they are equivalent; otherwise repeat the motion with and without the payload.",
        },
        LookAlike {
            slug: "torque_scale",
            separated_by: "Compare the joints before the link: a link inertia loads all of them.",
        },
    ],
    export: Export { urdf: Some("inertial"), mjcf: Some("inertial") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The mass, centre of mass or inertia of a link differs from the URDF.",
    sizes: &[
        "UR10 (public recordings of UNISA): the URDF alone errs by 52 to 141 % of the efforts' variation on the joints; a fit of links and friction leaves 7 to 21 % (see the case studies)",
    ],
    signature: "Gravity and inertia of one link, on the joints that move it. Only what the minimal set holds can be seen: mass along a joint's axis cannot.",
    example: Example::new("elbow_joint", &[0.6, 0.14, 0.0, 0.0], Against::Position),
};

impl Effect for LinkInertiaError {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::OftenOfLastLink
    }

    /// The ten columns of the link's standard parameters.
    fn arm_columns(&self, joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let columns = ParameterColumns::standard(motion.arm.dof());
        let wanted: Vec<usize> = (10 * joint..10 * (joint + 1)).collect();
        let by_joint: Vec<Vec<Vec<f64>>> = (0..motion.arm.dof())
            .map(|row| {
                let (q, v, a) = (motion.position, motion.velocity, motion.acceleration);
                columns.of_motion(motion.arm, row, q, v, a, &wanted)
            })
            .collect();
        (0..10).map(|k| by_joint.iter().map(|joint| joint[k].clone()).collect()).collect()
    }

    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Arm
    }

    /// Mass and first moment in the URDF frame of the link; the inertia changes as if the mass were in
    /// one point.
    fn change_arm(&self, parameters: &[f64], joint: usize, frames: &ArmFrames, arm: &mut RigidArm) {
        let [mass, x, y, z] = [parameters[0], parameters[1], parameters[2], parameters[3]];
        let mut change = [0.0; 10];
        change[..4].copy_from_slice(&[mass, x, y, z]);
        if mass != 0.0 {
            let inertia = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
            change[4..].iter_mut().zip(inertia).for_each(|(c, i)| *c = i / mass);
        }
        let change = InertialParameters::from_array(&change);
        arm.links[joint] = arm.links[joint].plus(&change.expressed_in(&frames.link_in_e[joint]));
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        let link = context.arm.links[joint];
        let own = link.expressed_in(&context.link_in_e[joint].inverse()).com_m();
        let reach = 0.5 * own.norm() + 0.03;
        let at = own.map(|c| c + reach * random.between(-0.7, 0.7));
        let share = if side < 0.0 { 0.4 } else { 1.5 };
        let parameters = move |x: f64| {
            let mass = side * x;
            vec![mass, mass * at.x, mass * at.y, mass * at.z]
        };
        Some(DrawnEffect::new(joint, 0.2 * link.mass_kg, parameters).at_most(share * link.mass_kg))
    }
}
