//! Directions of motion, and how dry friction follows them.

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
pub enum Turn {
    /// Linearly below a speed \[rad/s or m/s\]; 0: at once.
    Speed(f64),
    /// Exponentially over a travel since the last reversal \[rad or m\].
    Travel(f64),
}

impl Turn {
    /// Travels to try, as shares of the standard deviation of the position.
    pub const TRAVEL_SHARES: [f64; 4] = [0.001, 0.003, 0.01, 0.03];

    /// Dry friction of level 1 at every sample.
    pub fn directions(self, position: &[f64], velocity: &[f64]) -> Vec<f64> {
        match self {
            Self::Speed(speed) => directions_with(velocity, speed.max(f64::MIN_POSITIVE)),
            Self::Travel(travel) => deflections(position, travel),
        }
    }

    /// Speed below which it is regularised \[rad/s or m/s\]; 0 for presliding.
    pub fn speed(self) -> f64 {
        match self {
            Self::Speed(speed) => speed,
            Self::Travel(_) => 0.0,
        }
    }

    /// Travel of presliding \[rad or m\]; 0 for a regularised sign.
    pub fn travel(self) -> f64 {
        match self {
            Self::Speed(_) => 0.0,
            Self::Travel(travel) => travel,
        }
    }

    /// From a speed and a travel, of which one is 0.
    pub fn of(speed: f64, travel: f64) -> Self {
        if travel > 0.0 { Self::Travel(travel) } else { Self::Speed(speed) }
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
