//! `params`: the minimal set of an arm.

use armident_ident::MinimalSet;
use armident_report::ParamsReport;

use crate::failure::Failure;
use crate::robot::{GivenRobot, chain_notes};

/// The minimal set of an arm, and notes on its chain.
///
/// # Errors
/// A chain that cannot be chosen; extreme geometry.
pub fn params(robot: &GivenRobot) -> Result<(ParamsReport, Vec<String>), Failure> {
    let model = robot.arm(None)?;
    let set = MinimalSet::of(&model.rigid_arm())?;
    Ok((ParamsReport::new(&model, &set), chain_notes(&model)))
}
