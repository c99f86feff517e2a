//! How an effect acts in a simulation.

use armident_dynamics::RigidArm;
use armident_kinematics::DrivingAxisChain;
use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::servo::PositionServo;
use crate::transmission::Transmission;

/// Where a simulation takes an effect into account; the numbers are those of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mechanism {
    /// Efforts of its own joint: [`smooth_effort`](crate::Effect::smooth_effort),
    /// [`dry_friction`](crate::Effect::dry_friction),
    /// [`added_inertia`](crate::Effect::added_inertia) and
    /// [`deflection_effort`](crate::Effect::deflection_effort).
    Joint,
    /// Friction of the common speed `s = v_b + ratio v_a` of two joints.
    Pair {
        /// `r`.
        ratio: f64,
        /// Friction by the speed \[N m s/rad or N s/m\].
        viscous: f64,
        /// Dry friction level \[N m or N\].
        coulomb: f64,
    },
    /// A motor of its own before the joint; positions and efforts are the motor's.
    Transmission(Transmission),
    /// A position controller that gives the effort of the motor from a command.
    Servo(PositionServo),
    /// Another arm: [`change_arm`](crate::Effect::change_arm).
    Arm,
    /// A force on the tip, in the axes of the base \[N\].
    TipForce(Vector3<f64>),
    /// The effort channel shows the true effort times this.
    EffortGain(f64),
    /// The effort channels show the true effort of this time before \[s\].
    EffortDelay(f64),
}

/// Frames of the URDF that some effects are given in.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmFrames {
    /// Pose of `E_0` in the base link.
    pub base_from_e0: Isometry3<f64>,
    /// Origin of the tip link in the frame of the last joint \[m\].
    pub tip_in_last_m: Vector3<f64>,
    /// Pose of the URDF frame of each joint's child link in `E_i`.
    pub link_in_e: Vec<Isometry3<f64>>,
}

impl ArmFrames {
    /// Those of a chain.
    pub fn of_chain(chain: &DrivingAxisChain) -> Self {
        Self {
            base_from_e0: chain.base_from_e0,
            tip_in_last_m: chain.tip_in_e.translation.vector,
            link_in_e: chain.joints.iter().map(|joint| joint.child_link_in_e).collect(),
        }
    }
}

/// Column j of the translational Jacobian of the tip, in the axes of the base link.
pub fn tip_jacobian(
    arm: &RigidArm,
    base_from_e0: &Isometry3<f64>,
    tip_in_last_m: &Vector3<f64>,
    position: &[f64],
) -> Vec<Vector3<f64>> {
    let mut pose = *base_from_e0;
    let axes: Vec<(Vector3<f64>, Vector3<f64>)> = arm
        .poses(position)
        .iter()
        .map(|joint| {
            pose *= Isometry3::from_parts(
                joint.s.into(),
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                    joint.rotation(),
                )),
            );
            (pose.rotation * Vector3::z(), pose.translation.vector)
        })
        .collect();
    let tip = pose * Point3::from(*tip_in_last_m);
    let joints = arm.joints.iter().zip(&axes);
    joints
        .map(
            |(joint, (axis, origin))| {
                if joint.kind.is_rotational() { axis.cross(&(tip.coords - origin)) } else { *axis }
            },
        )
        .collect()
}
