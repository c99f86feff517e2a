//! The quantities of a joint that are recorded.

use std::fmt;

use serde::Serialize;

/// Physical quantity of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Joint position, rad (revolute) or m (prismatic).
    Position,
    /// Joint velocity, rad/s or m/s.
    Velocity,
    /// Joint acceleration, rad/s² or m/s².
    Acceleration,
    /// Joint torque or force on the joint side, N m or N.
    Effort,
    /// Motor current, A.
    Current,
    /// Motor voltage, V.
    Voltage,
    /// Position of the encoder on the motor side, divided by the gear ratio: equal to that of the
    /// joint without elasticity and backlash, rad or m.
    MotorPosition,
    /// Temperature of motor or drive, °C.
    Temperature,
    /// Position that a controller is given to reach, rad or m.
    Command,
}

impl Quantity {
    /// All quantities, in the order in which they are written.
    pub const ALL: [Self; 9] = [
        Self::Position,
        Self::Velocity,
        Self::Acceleration,
        Self::Effort,
        Self::Current,
        Self::Voltage,
        Self::MotorPosition,
        Self::Temperature,
        Self::Command,
    ];

    /// Whether it is the effort of a joint, or a signal of its drive that is a multiple of it.
    pub fn is_of_drive(self) -> bool {
        matches!(self, Self::Effort | Self::Current | Self::Voltage)
    }

    /// The last part of a column's name: `position` in `elbow/position`.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Effort => "effort",
            Self::Current => "current",
            Self::Voltage => "voltage",
            Self::MotorPosition => "motor_position",
            Self::Temperature => "temperature",
            Self::Command => "command",
        }
    }

    /// The quantity of a column suffix, exactly as [`suffix`](Self::suffix) writes it.
    pub fn from_suffix(suffix: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.suffix() == suffix)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.suffix())
    }
}
