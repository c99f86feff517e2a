//! Motions and states that laws are evaluated on.

use armident_dynamics::RigidArm;
use armident_kinematics::JointKind;
use nalgebra::{Isometry3, Vector3};

/// Motion of one joint over a recording: what columns are formed from. All slices have one length.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion<'a> {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Time since the start of the recording \[s\].
    pub time_s: &'a [f64],
    /// Position \[rad or m\].
    pub position: &'a [f64],
    /// Velocity \[rad/s or m/s\].
    pub velocity: &'a [f64],
    /// Acceleration \[rad/s2 or m/s2\].
    pub acceleration: &'a [f64],
    /// Direction of motion, -1 to 1: the sign of the velocity where it is resolved; what it is
    /// between is the maker's choice ([`directions`](crate::directions)).
    pub direction: &'a [f64],
    /// Effort of the rigid body at this joint \[N m or N\]; empty where no law needs it.
    pub rigid_effort: &'a [f64],
    /// Temperature of the drive \[°C\]; empty where it is not recorded.
    pub temperature_c: &'a [f64],
}

/// Size of a joint's motion, from which constants to try are scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionScale {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Root mean square speed \[rad/s or m/s\].
    pub speed_rms: f64,
    /// Standard deviation of the position \[rad or m\].
    pub position_deviation: f64,
    /// Length of the longest recording \[s\].
    pub duration_s: f64,
    /// Lowest and highest temperature of its drive \[°C\]; none where some recording lacks it.
    pub temperature_c: Option<[f64; 2]>,
}

/// Motion of the whole arm over a recording, joint-major.
#[derive(Debug, Clone, Copy)]
pub struct WholeArmMotion<'a> {
    /// The arm.
    pub arm: &'a RigidArm,
    /// Pose of the frame `E_0` in the base link.
    pub base_from_e0: Isometry3<f64>,
    /// Origin of the tip link in the frame of the last joint \[m\].
    pub tip_in_last_m: Vector3<f64>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Positions \[rad or m\].
    pub position: &'a [Vec<f64>],
    /// Velocities \[rad/s or m/s\].
    pub velocity: &'a [Vec<f64>],
    /// Accelerations \[rad/s2 or m/s2\].
    pub acceleration: &'a [Vec<f64>],
    /// Effort of the rigid body for this motion \[N m or N\].
    pub rigid_effort: &'a [Vec<f64>],
}

/// Columns of the whole arm: `[column][joint][sample]`.
pub type ArmColumns = Vec<Vec<Vec<f64>>>;

/// State of one joint at an instant of a simulation.
#[derive(Debug, Clone, Copy)]
pub struct JointState {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Time since the start of the recording \[s\].
    pub time_s: f64,
    /// Position \[rad or m\].
    pub position: f64,
    /// Velocity \[rad/s or m/s\].
    pub velocity: f64,
    /// Effort that the gear carries, that of the rigid body at this joint \[N m or N\].
    pub load: f64,
    /// Temperature of the drive \[°C\]; none where it is not known.
    pub temperature_c: Option<f64>,
}

/// Levels of dry friction; at rest the effort is anything between `-backward` and `forward`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DryFriction {
    /// Effort it takes to move forward \[N m or N\].
    pub forward: f64,
    /// Effort it takes to move backward \[N m or N\], positive.
    pub backward: f64,
}

impl DryFriction {
    /// The same level in both directions.
    pub fn both(level: f64) -> Self {
        Self { forward: level, backward: level }
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { forward: self.forward + other.forward, backward: self.backward + other.backward }
    }

    /// The effort while moving at this velocity; zero at rest.
    pub fn effort(self, velocity: f64) -> f64 {
        if velocity > 0.0 {
            self.forward
        } else if velocity < 0.0 {
            -self.backward
        } else {
            0.0
        }
    }

    /// Whether both levels are zero.
    pub fn is_none(self) -> bool {
        self.forward == 0.0 && self.backward == 0.0
    }
}
