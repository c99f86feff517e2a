//! The surroundings push the tip for a while.

use nalgebra::Vector3;

use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::{Effect, ShapeStep};
use crate::law::{Law, LawRole, LocationKind, LookAlike, Onset, Parameter, Scan, Scope};
use crate::mechanism::{Mechanism, tip_jacobian};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `f = -Jᵀ F`.
pub struct ExternalContact;

const LAW: Law = Law {
    slug: "external_contact",
    title: "external contact",
    formula: "f = -J(q)^T F in a time window, F constant in the world, at the origin of the tip link",
    scope: Scope::Arm,
    roles: &[LawRole::Contact],
    parameters: &[
        Parameter::non_negative("force", "N", "N").main(),
        Parameter::any("force_x", "N", "N"),
        Parameter::any("force_y", "N", "N"),
        Parameter::any("force_z", "N", "N"),
    ],
    location: LocationKind::TipLink,
    scan: Scan::Residual,
    look_alikes: &[
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "Repeat the motion away from obstacles.",
        },
        LookAlike { slug: "payload", separated_by: "A contact ends; a payload does not." },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Something pushes on the arm for a while.",
    sizes: &[
        "No typical size. How small a contact is seen depends on the model: Mamedov and Mikhel (2020) find on a UR10e that the step of identification decides it",
    ],
    signature: "Begins and ends at a time; the joints feel it by their levers about the tip.",
    example: Example {
        window_s: Some([4.0, 6.0]),
        ..Example::new("", &[15.0, 9.0, 0.0, 12.0], Against::Time)
    },
};

impl Effect for ExternalContact {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// `-Jᵀ e_x`, `-Jᵀ e_y`, `-Jᵀ e_z` at every sample, without the window.
    fn arm_columns(&self, _joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let (n, samples) = (motion.arm.dof(), motion.position[0].len());
        let mut columns = vec![vec![vec![0.0; samples]; n]; 3];
        let mut position = vec![0.0; n];
        for t in 0..samples {
            for j in 0..n {
                position[j] = motion.position[j][t];
            }
            let jacobian =
                tip_jacobian(motion.arm, &motion.base_from_e0, &motion.tip_in_last_m, &position);
            for (j, torque) in jacobian.iter().enumerate() {
                for axis in 0..3 {
                    columns[axis][j][t] = -torque[axis];
                }
            }
        }
        columns
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let force = Vector3::from_column_slice(&coefficients[..3]);
        vec![force.norm(), force.x, force.y, force.z]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), parameters[1..].to_vec())
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        Mechanism::TipForce(Vector3::from_column_slice(&parameters[1..4]))
    }

    fn shape_step(&self, _constant: usize) -> Option<ShapeStep> {
        Some(ShapeStep::absolute(0.16, 0.01))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let towards: [f64; 3] = std::array::from_fn(|_| random.normal());
        let length_s = random.between(1.4, 3.0);
        let start_s = random.between(2.0, context.duration_s - length_s - 1.0);
        let force = move |x: f64| {
            let [a, b, c] = towards;
            let size = (a * a + b * b + c * c).sqrt();
            vec![x, x * a / size, x * b / size, x * c / size]
        };
        let recording = random.index(context.recordings);
        Some(
            DrawnEffect::new(joint, 5.0, force).in_window(recording, [start_s, start_s + length_s]),
        )
    }
}
