//! Writes a model as URDF, MJCF or C source for a controller and lists what these formats cannot hold.
//!
//! URDF and MJCF have the links and joints of the chain by their names, in the frames of the robot
//! description: every link frame lies on the axis of the joint that moves it. What was lumped into a
//! link (links behind fixed and locked joints, grippers) is part of its inertia.
//!
//! | | URDF | MJCF |
//! | --- | --- | --- |
//! | links, limits | yes | yes, and a motor per joint |
//! | viscous friction | `<dynamics damping>` | `damping` |
//! | Coulomb friction | `<dynamics friction>` | `frictionloss` |
//! | rotor inertia | omitted | `armature` |
//! | torque offset | omitted | omitted |
//! | gravity | omitted unless (0, 0, -9.81) | `<option gravity>` |
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
mod mjcf;
mod observer;
mod thresholds;
mod urdf;
mod xml;

pub use controller::{controller, controller_with_alarm};
pub use effects::{Held, Lost};
pub use mjcf::{mjcf, mjcf_in};
pub use observer::{ALARM_S, ObserverResidual, ThresholdError};
pub use thresholds::{AlarmThresholds, JointThresholds, ObservedAlarms};
pub use urdf::{urdf, urdf_in};

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
