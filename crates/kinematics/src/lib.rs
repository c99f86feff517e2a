//! Reads a URDF into a checked serial chain and gives its normal driving-axis frames (b, d, β, θ).
//!
//! ```
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//!
//! let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let frames = DrivingAxisChain::from_chain(&chain);
//!
//! // the normal between the parallel axes of shoulder_lift and elbow is as long as the upper arm
//! assert_eq!(frames.joints[2].name, "elbow_joint");
//! assert!((frames.joints[2].frame.b_m.abs() - 0.425).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chain_error;
mod collision;
mod description;
mod driving_axis;
mod error;
mod inertial;
mod names;
mod serial_chain;
mod urdf;
mod warning;

pub use chain_error::ChainError;
pub use collision::{CollisionGeometry, CollisionShape};
pub use description::{
    IgnoredElement, InertialDescription, JointDescription, JointDynamics, JointLimits,
    LinkDescription, Mimic, RobotDescription, UrdfJointType,
};
pub use driving_axis::{
    AxisPair, DrivingAxisChain, DrivingAxisFrame, DrivingAxisJoint, LENGTH_TOLERANCE_M,
    PARALLEL_TOLERANCE_RAD,
};
pub use error::{UrdfError, UrdfPlace};
pub use inertial::InertialParameters;
pub use names::nearest;
pub use serial_chain::{ChainJoint, ChainSelection, JointKind, SerialChain};
pub use urdf::{
    MjcfJointValue, MjcfRobot, is_mjcf, load_urdf, parse_mjcf, parse_urdf, parse_urdf_bytes,
    roll_pitch_yaw,
};
pub use warning::Warning;
