//! A springy transmission: the encoder is on the motor side.

use armident_dynamics::inverse_dynamics_of_motion;

use crate::arm_motion::{STEP, derivative, rate};
use crate::law::{ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Parameter, Place, Scope};

/// `J dω/dt + τ = effort`, `τ = K (θ - q) + D (ω - v)`.
pub struct JointElasticity;

const LAW: Law = Law {
    slug: "joint_elasticity",
    title: "joint elasticity",
    formula: "motor th (recorded), link q (hidden): J ddth + tJ = effort, tJ = K (th - q) + D (dth - dq), rigid(q) = tJ",
    scope: Scope::ThroughJoint,
    places: &[Place::Inertia],
    parameters: &[
        Parameter::non_negative("stiffness", "N m/rad", "N/m"),
        Parameter::non_negative("damping", "N m s/rad", "N s/m"),
        Parameter::non_negative("motor_inertia", "kg m2", "kg"),
    ],
    contains: &["rotor_inertia"],
    look_alikes: &[
        LookAlike {
            slug: "rotor_inertia",
            separated_by: "faster motion: elasticity resonates and moves the other joints",
        },
        LookAlike {
            slug: "backlash",
            separated_by: "with and without gravity load on the joint: play needs a change of sign of the transmitted effort",
        },
        LookAlike {
            slug: "time_delay",
            separated_by: "a fast excitation: elasticity has a peak, a delay has not",
        },
    ],
    export: Export::NONE,
};

impl Effect for JointElasticity {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// First order in the compliance: the rigid effort at the link's position, behind the motor by
    /// effort / K, minus that at the motor's position.
    fn arm_columns(&self, joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        let load = &motion.rigid_effort[joint];
        let speed = rate(load, motion.rate_hz);
        let curvature = rate(&speed, motion.rate_hz);
        let largest = load.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()));
        vec![derivative(motion, STEP / largest, |step| {
            let behind = |of: &[Vec<f64>], by: &[f64]| {
                let mut moved = of.to_vec();
                moved[joint].iter_mut().zip(by).for_each(|(x, by)| *x -= step * by);
                moved
            };
            inverse_dynamics_of_motion(
                motion.arm,
                &behind(motion.position, load),
                &behind(motion.velocity, &speed),
                &behind(motion.acceleration, &curvature),
            )
        })]
    }

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        let [stiffness, damping, motor_inertia] = [parameters[0], parameters[1], parameters[2]];
        let gap = 0.0;
        crate::Mechanism::Transmission(crate::Transmission {
            gap,
            stiffness,
            damping,
            motor_inertia,
        })
    }
}
