//! Algorithm 2 of Lin 1992: off-line identification, one joint at a time.

mod equations;
mod estimate;
mod plan;
mod projection;
mod step_motion;
mod task;

pub use equations::{Equation, single_motion_row};
pub use estimate::{Algorithm2Error, Algorithm2Estimate, StepResult, algorithm2};
pub use plan::{
    Dither, Experiment, PLAN_SCHEMA, Plan, PlanSettings, PlannedTrajectory, Step, plan,
};
pub use step_motion::StepMotion;
pub use task::{Task, tasks};
