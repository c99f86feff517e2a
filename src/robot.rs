//! From a URDF or a model file and the chain options to the arm.

use std::path::Path;

use armident_commands::{ChainOptions, Failure, GivenRobot};

use crate::args::ChainArgs;

/// Reads the robot of a command line.
pub(crate) fn open(path: &Path, chain: &ChainArgs) -> Result<GivenRobot, Failure> {
    let ChainArgs { base, tip, lock, gravity, snap_rpy } = chain;
    let options = ChainOptions {
        base: base.clone(),
        tip: tip.clone(),
        lock: lock.clone(),
        gravity: *gravity,
        snap_rpy_rad: *snap_rpy,
    };
    GivenRobot::open(path, options)
}
