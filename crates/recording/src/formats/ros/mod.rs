//! Messages of ROS that hold joints, shared by the files that carry them.

mod joint_state;
mod messages;
mod serialised;
mod topics;

pub(super) use joint_state::{HELD, JointState, SCHEMA_NAME};
pub(super) use topics::{JOINT_STATES, Topics};
