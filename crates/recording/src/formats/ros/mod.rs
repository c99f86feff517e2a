//! Messages of ROS that hold joints, shared by the files that carry them.

mod diagnostics;
mod joint_state;
mod messages;
mod serialised;
mod topics;

pub(super) use diagnostics::{DEFINITION as DIAGNOSTICS_DEFINITION, NAME as DIAGNOSTICS, to_cdr};
pub(super) use joint_state::{
    DEFINITION as JOINT_STATE_DEFINITION, HELD, JointState, SCHEMA_NAME as JOINT_STATE,
};
pub(super) use serialised::HEADER_DEFINITION;
pub(super) use topics::{JOINT_STATES, Topics};
