//! Reads a URDF into a checked serial chain and gives its normal driving-axis frames (b, d, β, θ).

mod description;
mod warning;

pub use description::{
    IgnoredElement, InertialDescription, JointDescription, JointDynamics, JointLimits,
    LinkDescription, Mimic, RobotDescription, UrdfJointType,
};
pub use warning::Warning;
