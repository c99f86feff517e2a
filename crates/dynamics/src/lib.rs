//! Rigid-body dynamics of a serial arm through composite bodies.
//!
//! ```text
//! H(q) q̈ + τᶜ(q, q̇) + τᵍ(q) = τ                                    (29)
//! ĉ_i = k_i + ℓ_i(q),   Ĵ_i = U_i + V_i(q)                           (12), (13)
//! τ = Y(q, q̇, q̈) π
//! ```
//!
//! Equation numbers are those of S.-K. Lin, "An Identification Method for Estimating the Inertia
//! Parameters of a Manipulator", Journal of Robotic Systems 9(4), 505-528 (1992); where the print is
//! wrong the code says so. Joint indices run from 0 in code and from 1 in formulas.
//!
//! | symbol | meaning | where |
//! | --- | --- | --- |
//! | `m̂, ĉ, Ĵ` | mass, first moment, inertia of the links i..n about `O_i` | [`composite_bodies`] |
//! | `k, U` | their configuration-independent parts | [`constants_from_links`] |
//! | `ℓ, V` | their varying parts | [`varying_parts`] |
//! | `H` | inertia matrix, n x n | [`inertia_matrix`] |
//! | `τᵍ` | gravity effort | [`gravity_effort`] |
//! | `τ` | actuator effort, positive along the joint axis | [`inverse_dynamics`] |
//! | `Y` | regressor | [`standard_regressor`], [`ParameterColumns`] |
//!
//! Functions of one sample follow the paper; those of a motion ([`inverse_dynamics_of_motion`], [`ArmMotion`],
//! [`for_each_regressor_row`], [`inertia_matrices_of_motion`]) give the same by kernels on the lanes of the processor.
//! Not handled: branches and loops, more than one degree of freedom per joint, moving bases.
//!
//! ```
//! use armident_dynamics::{RigidArm, inverse_dynamics};
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//!
//! let urdf = r#"<robot name="pendulum">
//!   <link name="base"/>
//!   <link name="rod"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
//!     <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
//!   <joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/>
//!     <axis xyz="0 1 0"/></joint>
//! </robot>"#;
//! let robot = parse_urdf(urdf, "pendulum.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let arm = RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain));
//! // held level: the motor lifts 2 kg at 0.5 m, the axis points so that positive turns downward
//! let effort: Vec<f64> = inverse_dynamics(&arm, &[0.0], &[0.0], &[0.0]);
//! assert!((effort[0] + 2.0 * 9.81 * 0.5).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(test)]
extern crate self as armident_dynamics;

mod arm;
mod composite;
mod constants;
mod coriolis;
mod forward;
mod inertia_matrix;
mod kernels;
mod lanes;
mod motion;
mod newton_euler;
mod regressor;
mod sin_cos;

pub use arm::{JointGeometry, JointPose, RigidArm};
pub use composite::{CompositeBody, composite_bodies, pi, sigma};
pub use constants::{
    BodyConstants, VaryingParts, constants_from_links, links_from_constants, varying_parts,
};
pub use coriolis::{coriolis_effort, inertia_matrix_derivatives};
pub use forward::{NotPositiveDefinite, energy, forward_dynamics};
pub use inertia_matrix::{
    InertiaSweep, gravity_effort, inertia_matrices_of_motion, inertia_matrix, inertia_matrix_into,
    inertia_matrix_of,
};
pub use kernels::upper_triangle;
pub use motion::ArmMotion;
pub use newton_euler::{
    LinkMotion, Sweep, inverse_dynamics, inverse_dynamics_into, inverse_dynamics_of_motion,
};
pub use regressor::{
    ParameterColumns, RegressorRow, for_each_regressor_row, regressor_row_into, standard_regressor,
};
