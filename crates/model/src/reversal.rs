//! How dry friction reverses.

use armident_effects::{ReversalModel, direction};

/// The direction of motion, fading to zero below a speed.
pub fn regularised_sign(sharp: &[f64], velocity: &[f64], speed: f64) -> Vec<f64> {
    let fades =
        |(sharp, v): (&f64, &f64)| if v.abs() < speed { direction(*v, speed) } else { *sharp };
    sharp.iter().zip(velocity).map(fades).collect()
}

/// Friction that follows the sign of the velocity.
pub const SHARP: ReversalModel = ReversalModel::regularised(0.0);

#[cfg(test)]
mod tests {
    use super::regularised_sign;

    #[test]
    fn regularising_twice_equals_once() {
        let velocity = [-1.0, -0.0625, 0.0, 0.03125, 0.3];
        let sharp = [-1.0, -1.0, 0.0, 1.0, 1.0];
        let once = regularised_sign(&sharp, &velocity, 0.125);
        assert_eq!(once, [-1.0, -0.5, 0.0, 0.25, 1.0]);
        assert_eq!(regularised_sign(&once, &velocity, 0.125), once);
    }
}
