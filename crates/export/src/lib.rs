//! Writes a model as URDF, MJCF, SDFormat, USD, actuators of Isaac Lab, or C source for a controller, and lists what these
//! formats cannot hold.
//!
//! URDF and MJCF have the links and joints of the chain by their names, in the frames of the robot
//! description: every link frame lies on the axis of the joint that moves it. What was lumped into a
//! link (links behind fixed and locked joints, grippers) is part of its inertia.
//!
//! | | URDF | MJCF | SDFormat (Drake) | USD overlay | Isaac Lab |
//! | --- | --- | --- | --- | --- | --- |
//! | links | yes | yes | yes | yes | omitted |
//! | limits | yes | yes, and a motor per joint | yes, and an actuator per joint | omitted | effort, speed |
//! | viscous friction | `<dynamics damping>` | `damping` | `<damping>` | `viscousFrictionCoefficient` | `viscous_friction` |
//! | Coulomb friction | `<dynamics friction>` | `frictionloss` | `<friction>`, which Drake ignores | `dynamicFrictionEffort` | `friction` |
//! | rotor inertia | omitted | `armature` | `<drake:rotor_inertia>` | `armature` | `armature` |
//! | torque offset | omitted | omitted | omitted | omitted | omitted |
//! | gravity | omitted | `<option gravity>` | omitted | omitted | omitted |
//!
//! What holds an effect is written once, in its law ([`armident_effects::Export`]).
//!
//! ```
//! use armident_model::ArmModel;
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//!
//! let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
//! let written = armident_export::mjcf(&model);
//! assert!(written.text.contains("<joint name=\"elbow_joint\""));
//! assert!(written.lost.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not handled: visual and collision shapes, meshes, transmissions and sensors of the robot
//! description.

mod chain;
mod controller;
mod effects;
mod isaac_lab;
mod mjcf;
mod observer;
mod sdf;
mod servos;
mod thresholds;
mod urdf;
mod usd;
mod xml;

pub use controller::{controller, controller_with_alarm};
pub use effects::{Held, Lost};
pub use isaac_lab::{isaac_lab, isaac_lab_in};
pub use mjcf::{mjcf, mjcf_in};
pub use observer::{ALARM_S, ObserverResidual, ThresholdError};
pub use sdf::{drake_sdf, drake_sdf_in};
pub use thresholds::{AlarmThresholds, JointThresholds, ObservedAlarms};
pub use urdf::{urdf, urdf_in};
pub use usd::{usd, usd_in};

/// A model in another format.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// A second file beside it.
    pub companion: Option<Companion>,
    /// Effects that the format holds.
    pub held: Vec<Held>,
    /// Effects that it cannot hold.
    pub lost: Vec<Lost>,
    /// Other omissions and assumed values, a sentence each.
    pub notes: Vec<String>,
}

/// A file that another one needs beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Companion {
    /// Its name, by which the other one refers to it.
    pub file: String,
    /// What is in it.
    pub text: String,
}
