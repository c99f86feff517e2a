//! What effort channels report: gains of drives whose current is recorded, and dead zones.

mod dead_zone;
mod drive_gains;

pub use dead_zone::dead_zone_shares;
pub use drive_gains::{DriveGain, DriveGains};
