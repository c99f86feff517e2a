//! The motion of one joint in an experiment: a critically damped step there and back.

use serde::{Deserialize, Serialize};

/// `q = q₀ + A f(t)`, `f = 1 - (1 + σ t) e^{-σ t}` (64)-(66), started after a rest and taken back
/// half-way by subtracting the same step, so that both directions of motion occur.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepMotion {
    /// `q₀` \[rad or m\].
    pub start: f64,
    /// `A` \[rad or m\]; the paper takes π/6.
    pub amplitude: f64,
    /// `σ` \[1/s\]; the paper takes 10.
    pub sigma_per_s: f64,
}

impl StepMotion {
    /// Rest before the motion and after it \[s\].
    pub const REST_S: f64 = 0.1;

    /// Time from the step to its return \[s\]: 12/σ leaves 8e-5 of the amplitude.
    pub fn half_s(&self) -> f64 {
        12.0 / self.sigma_per_s
    }

    /// Whole duration \[s\].
    pub fn duration_s(&self) -> f64 {
        2.0 * (self.half_s() + Self::REST_S)
    }

    /// Position, velocity and acceleration at a time.
    pub fn at(&self, time_s: f64) -> (f64, f64, f64) {
        let there = self.unit_step(time_s - Self::REST_S);
        let back = self.unit_step(time_s - Self::REST_S - self.half_s());
        let of = |k: usize| self.amplitude * (there[k] - back[k]);
        (self.start + of(0), of(1), of(2))
    }

    fn unit_step(&self, t: f64) -> [f64; 3] {
        if t <= 0.0 {
            return [0.0; 3];
        }
        let s = self.sigma_per_s;
        let decay = (-s * t).exp();
        [1.0 - (1.0 + s * t) * decay, s * s * t * decay, s * s * (1.0 - s * t) * decay]
    }
}
