//! Reads a URDF into a checked serial chain and gives its normal driving-axis frames (b, d, β, θ).

mod chain_error;
mod description;
mod driving_axis;
mod error;
mod inertial;
mod names;
mod serial_chain;
mod urdf;
mod warning;

pub use chain_error::ChainError;
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
pub use urdf::{load_urdf, parse_urdf, parse_urdf_bytes, roll_pitch_yaw};
pub use warning::Warning;
