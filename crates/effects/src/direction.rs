//! Directions of motion, and how dry friction follows them.

use crate::motion::MotionScale;

/// The direction of motion, fading linearly to zero below the resolved speed.
pub fn direction(velocity: f64, speed_resolution: f64) -> f64 {
    if velocity.abs() >= speed_resolution {
        if velocity == 0.0 { 0.0 } else { velocity.signum() }
    } else {
        velocity / speed_resolution
    }
}

/// [`direction`] of every velocity.
pub fn directions_with(velocity: &[f64], speed_resolution: f64) -> Vec<f64> {
    velocity.iter().map(|&v| direction(v, speed_resolution)).collect()
}

/// Directions with a speed resolution of [`LEAST_SPEED_SHARE`] of the root mean square speed.
pub fn directions(velocity: &[f64]) -> Vec<f64> {
    let mean_square = velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len().max(1) as f64;
    directions_with(velocity, LEAST_SPEED_SHARE * mean_square.sqrt())
}

/// Share of the root mean square speed under which a differentiated encoder has no sure sign.
pub const LEAST_SPEED_SHARE: f64 = 0.005;

/// Model of dry friction about a reversal.
///
/// Bristles bend before they slip, so that friction builds up over a travel (Dahl, A solid friction model, 1968); a drive train
/// that winds up, and an effort that lags, make it one of the speed where reversals are alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReversalModel {
    /// The sign of the velocity, linear below a speed.
    RegularisedSign {
        /// That speed \[rad/s or m/s\]; 0: the sign itself.
        below: f64,
    },
    /// Friction that approaches its level exponentially over the travel since the last reversal.
    Presliding {
        /// Travel in which the distance to the level falls to 1/e \[rad or m\].
        travel: f64,
    },
}

impl ReversalModel {
    /// Speeds to try below which the sign is regularised, as shares of the root mean square speed; the last two are of drive
    /// trains that wind up far.
    pub const SPEED_SHARES: [f64; 6] = [0.005, 0.02, 0.05, 0.1, 0.2, 0.3];

    /// Travels to try, as shares of the standard deviation of the position.
    pub const TRAVEL_SHARES: [f64; 4] = [0.001, 0.003, 0.01, 0.03];

    /// A model in shares, as it is on a joint.
    pub fn on(self, joint: &MotionScale) -> Self {
        match self {
            Self::RegularisedSign { below } => Self::regularised(below * joint.speed_rms),
            Self::Presliding { travel } => Self::presliding(travel * joint.position_deviation),
        }
    }

    /// The sign of the velocity, linear below this speed \[rad/s or m/s\].
    pub const fn regularised(below: f64) -> Self {
        Self::RegularisedSign { below }
    }

    /// Presliding over this travel \[rad or m\].
    pub const fn presliding(travel: f64) -> Self {
        Self::Presliding { travel }
    }

    /// Dry friction of level 1 at every sample.
    pub fn directions(self, position: &[f64], velocity: &[f64]) -> Vec<f64> {
        match self {
            Self::RegularisedSign { below } => {
                directions_with(velocity, below.max(f64::MIN_POSITIVE))
            }
            Self::Presliding { travel } => deflections(position, travel),
        }
    }

    /// Speed below which the sign is regularised \[rad/s or m/s\]; 0 for presliding.
    pub fn regularised_below(self) -> f64 {
        match self {
            Self::RegularisedSign { below } => below,
            Self::Presliding { .. } => 0.0,
        }
    }

    /// Travel of presliding \[rad or m\]; 0 for a regularised sign.
    pub fn presliding_travel(self) -> f64 {
        match self {
            Self::RegularisedSign { .. } => 0.0,
            Self::Presliding { travel } => travel,
        }
    }

    /// From a speed and a travel, of which one is 0.
    pub fn of(below: f64, travel: f64) -> Self {
        if travel > 0.0 { Self::Presliding { travel } } else { Self::RegularisedSign { below } }
    }
}

/// Deflections of bristles over their saturation, -1 to 1, not deflected at first: exact while a joint does not reverse
/// between two samples.
pub(crate) fn deflections(position: &[f64], saturation: f64) -> Vec<f64> {
    let mut z = 0.0;
    let mut before = position.first().copied().unwrap_or_default();
    let of = |&q: &f64| {
        let travel = (q - before) / saturation;
        before = q;
        z = deflected(z, travel);
        z
    };
    position.iter().map(of).collect()
}

/// Solution of `dz/dx = 1 - z sign(dx)` after a one-way travel `x`, both over the saturation
/// deflection `Fc / s0`: the speed drops out of the law, so this is exact for any speed.
pub(crate) fn deflected(deflection: f64, travel: f64) -> f64 {
    if travel == 0.0 {
        return deflection;
    }
    let side = travel.signum();
    side + (deflection - side) * (-travel.abs()).exp()
}
