//! Directions of motion from velocities.

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
