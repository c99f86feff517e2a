//! Fourier motions that begin and end at rest.
//!
//! ```text
//! q(t) = start + Σ_l A_l sin(l ω t) + B_l (cos(l ω t) - 1),    Σ_l l A_l = 0,    Σ_l l² B_l = 0
//! ```
//!
//! With these two sums the velocity and the acceleration are zero at both ends of a period.
//!
//! References: J. Swevers, C. Ganseman, D. B. Tükel, J. De Schutter, H. Van Brussel, Optimal robot excitation and
//! identification, IEEE Trans. Robotics and Automation 13(5), 1997 (the series); the sums are own.

use std::f64::consts::TAU;

/// Samples of the shortest wave on which bounds are formed: their second differences are below 0.2 %.
const SAMPLES_OF_A_WAVE: usize = 64;

/// Motion of one joint over a period.
#[derive(Debug, Clone, PartialEq)]
pub struct FourierJoint {
    /// Position at both ends \[rad or m\].
    pub start: f64,
    /// `A_l` \[rad or m\].
    pub sine: Vec<f64>,
    /// `B_l` \[rad or m\].
    pub cosine: Vec<f64>,
}

/// Smallest and largest value of the position and its derivatives, between samples too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Of the position \[rad or m\].
    pub position: [f64; 2],
    /// Of velocity, acceleration and jerk: largest absolute values.
    pub derivatives: [f64; 3],
}

impl FourierJoint {
    /// The nearest coefficients with rest at both ends.
    pub fn at_rest(start: f64, mut sine: Vec<f64>, mut cosine: Vec<f64>) -> Self {
        to_rest(&mut sine, &mut cosine);
        Self { start, sine, cosine }
    }

    /// Position and its first three derivatives at a time of a period.
    pub fn at(&self, time_s: f64, period_s: f64) -> [f64; 4] {
        let omega = TAU / period_s;
        let mut values = [self.start, 0.0, 0.0, 0.0];
        for (l, (a, b)) in self.sine.iter().zip(&self.cosine).enumerate() {
            let rate = (l + 1) as f64 * omega;
            let (sin, cos) = (rate * time_s).sin_cos();
            values[0] += a * sin + b * (cos - 1.0);
            values[1] += rate * (a * cos - b * sin);
            values[2] -= rate * rate * (a * sin + b * cos);
            values[3] -= rate.powi(3) * (a * cos - b * sin);
        }
        values
    }

    /// Bounds that hold at every time: the extremes of samples at distance `h`, widened by `h²/8` times a bound of the
    /// second derivative (that of the sum of all waves), by which a function leaves the chord between two samples at most.
    pub fn bounds(&self, period_s: f64) -> Bounds {
        let omega = TAU / period_s;
        let samples = SAMPLES_OF_A_WAVE * self.sine.len().max(1);
        let step_s = period_s / samples as f64;
        let between = |derivative: i32| -> f64 {
            let waves = self.sine.iter().zip(&self.cosine).enumerate();
            let curvature: f64 = waves
                .map(|(l, (a, b))| ((l + 1) as f64 * omega).powi(derivative + 2) * a.hypot(*b))
                .sum();
            step_s * step_s / 8.0 * curvature
        };
        let mut position = [f64::INFINITY, f64::NEG_INFINITY];
        let mut derivatives = [0.0_f64; 3];
        for k in 0..samples {
            let values = self.at(k as f64 * step_s, period_s);
            position = [position[0].min(values[0]), position[1].max(values[0])];
            for (most, value) in derivatives.iter_mut().zip(&values[1..]) {
                *most = most.max(value.abs());
            }
        }
        position = [position[0] - between(0), position[1] + between(0)];
        for (derivative, most) in derivatives.iter_mut().enumerate() {
            *most += between(derivative as i32 + 1);
        }
        Bounds { position, derivatives }
    }

    /// The same shape with all coefficients times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |of: &[f64]| of.iter().map(|x| factor * x).collect();
        Self { start: self.start, sine: times(&self.sine), cosine: times(&self.cosine) }
    }
}

/// Removes from coefficients what leaves velocity or acceleration at the ends: an orthogonal projection, so that it is
/// applied to gradients as well.
pub(crate) fn to_rest(sine: &mut [f64], cosine: &mut [f64]) {
    let without = |values: &mut [f64], power: i32| {
        let weight = |l: usize| ((l + 1) as f64).powi(power);
        let square: f64 = (0..values.len()).map(|l| weight(l).powi(2)).sum();
        let sum: f64 = values.iter().enumerate().map(|(l, x)| weight(l) * x).sum();
        for (l, x) in values.iter_mut().enumerate() {
            *x -= sum / square * weight(l);
        }
    };
    without(sine, 1);
    without(cosine, 2);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joint() -> FourierJoint {
        FourierJoint::at_rest(0.3, vec![0.4, -0.2, 0.1, 0.05], vec![-0.3, 0.1, 0.2, -0.07])
    }

    #[test]
    fn both_ends_are_at_rest() {
        for t in [0.0, 8.0] {
            let [q, v, a, _] = joint().at(t, 8.0);
            assert!((q - 0.3).abs() < 1e-12 && v.abs() < 1e-12 && a.abs() < 1e-12, "{q} {v} {a}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_position() {
        let (h, joint) = (1e-4, joint());
        for t in [0.7, 3.1, 6.6] {
            let [before, now, after] = [t - h, t, t + h].map(|t| joint.at(t, 8.0));
            for k in 0..3 {
                let slope = (after[k] - before[k]) / (2.0 * h);
                assert!((slope - now[k + 1]).abs() < 1e-5 * (1.0 + now[k + 1].abs()), "{k} at {t}");
            }
        }
    }

    #[test]
    fn bounds_hold_on_a_finer_grid_and_are_tight() {
        let joint = joint();
        let bounds = joint.bounds(8.0);
        let mut most = [0.0_f64; 3];
        let mut position = [f64::INFINITY, f64::NEG_INFINITY];
        for k in 0..100_000 {
            let values = joint.at(8.0 * f64::from(k) / 100_000.0, 8.0);
            position = [position[0].min(values[0]), position[1].max(values[0])];
            for (most, value) in most.iter_mut().zip(&values[1..]) {
                *most = most.max(value.abs());
            }
        }
        assert!(bounds.position[0] <= position[0] && bounds.position[1] >= position[1]);
        assert!(bounds.position[1] - position[1] < 0.01);
        for (bound, most) in bounds.derivatives.iter().zip(most) {
            assert!(*bound >= most && *bound < 1.02 * most, "{bound} {most}");
        }
    }
}
