//! The surroundings push the tip for a while.

use nalgebra::Vector3;

use crate::law::{
    ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Onset, Parameter, Place, Scope,
};
use crate::mechanism::tip_jacobian;

/// `f = -Jᵀ F`.
pub struct ExternalContact;

const LAW: Law = Law {
    slug: "external_contact",
    title: "external contact",
    formula: "f = -J(q)^T F in a time window, F constant in the world, at the origin of the tip link",
    scope: Scope::Arm,
    places: &[Place::Contact],
    parameters: &[
        Parameter::non_negative("force", "N", "N"),
        Parameter::any("force_x", "N", "N"),
        Parameter::any("force_y", "N", "N"),
        Parameter::any("force_z", "N", "N"),
    ],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "the same motion without the surroundings",
        },
        LookAlike { slug: "payload", separated_by: "the time: a contact ends" },
    ],
    export: Export::NONE,
};

impl Effect for ExternalContact {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// `-Jᵀ e_x`, `-Jᵀ e_y`, `-Jᵀ e_z` at every sample, without the window.
    fn arm_columns(&self, _joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
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

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::TipForce(Vector3::from_column_slice(&parameters[1..4]))
    }
}
