//! What effort channels report: gains of drives whose current is recorded, gears between a motor and a torque sensor, and dead zones.

mod dead_zone;
mod drive_gains;
mod sensed_gear;

pub use dead_zone::dead_zone_shares;
pub use drive_gains::{DriveGain, DriveGains};
pub(crate) use sensed_gear::sensed_gears;
pub use sensed_gear::{SensedGear, SensedValue};
