//! A position controller by its numbers; its law is [`PositionControl`](crate::PositionControl).
//!
//! ```text
//! effort = K gain dead(c(t - T) - q),   |effort| <= limit
//! ```
//!
//! `c` is the command, `T` its delay, `dead` the error less a dead band. The derivative part of the controller and the back-EMF
//! of the motor are proportional to the velocity, as viscous friction is: no motion separates the three, and the sum is the
//! viscous friction of the joint.
//!
//! Source of the form: M. Duclusaud et al., Extended Friction Models for the Physics Simulation of Servo Actuators, ICRA 2025.

use serde::{Deserialize, Serialize};

/// Position controller of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PositionServo {
    /// Effort by position error at gain 1 \[N m/rad or N/m\].
    pub stiffness: f64,
    /// Time from a command to its effort \[s\].
    pub delay_s: f64,
    /// Position error without effort \[rad or m\].
    #[serde(default)]
    pub dead_band: f64,
    /// Largest effort \[N m or N\]; none where it was never reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort_limit: Option<f64>,
}

impl PositionServo {
    /// From the parameters of its law, in their order; an effort limit of 0 is none.
    pub(crate) fn of_parameters(parameters: &[f64]) -> Self {
        let [stiffness, delay_s, dead_band, effort_limit] = [0, 1, 2, 3].map(|k| parameters[k]);
        let effort_limit = (effort_limit != 0.0).then_some(effort_limit);
        Self { stiffness, delay_s, dead_band, effort_limit }
    }

    /// The parameters of its law, in their order.
    pub fn parameters(&self) -> Vec<f64> {
        vec![self.stiffness, self.delay_s, self.dead_band, self.effort_limit.unwrap_or(0.0)]
    }

    /// Effort \[N m or N\] at a position error `c(t - T) - q` \[rad or m\], and its change by the error \[N m/rad or N/m\]: 0
    /// in the dead band and at the limit. `gain` is that of the controller over the one that the stiffness belongs to.
    pub fn effort_and_stiffness(&self, error: f64, gain: f64) -> (f64, f64) {
        let beyond = error.abs() - self.dead_band;
        if beyond <= 0.0 {
            return (0.0, 0.0);
        }
        let stiffness = gain * self.stiffness;
        let effort = stiffness * beyond;
        match self.effort_limit {
            Some(limit) if effort >= limit => (limit.copysign(error), 0.0),
            _ => (effort.copysign(error), stiffness),
        }
    }

    /// Effort \[N m or N\] at a position error \[rad or m\].
    pub fn effort(&self, error: f64, gain: f64) -> f64 {
        self.effort_and_stiffness(error, gain).0
    }

    /// Whether the numbers are those of a servo: all finite and none below zero, a stiffness above.
    pub fn is_sound(&self) -> bool {
        let all = [self.stiffness, self.delay_s, self.dead_band, self.effort_limit.unwrap_or(1.0)];
        all.iter().all(|x| x.is_finite() && *x >= 0.0)
            && self.stiffness > 0.0
            && self.effort_limit.is_none_or(|limit| limit > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effort_has_band_and_limit() {
        let servo = PositionServo {
            stiffness: 10.0,
            delay_s: 0.02,
            dead_band: 0.01,
            effort_limit: Some(2.0),
        };
        assert_eq!(servo.effort_and_stiffness(0.005, 1.0), (0.0, 0.0));
        let (effort, stiffness) = servo.effort_and_stiffness(-0.11, 1.0);
        assert!((effort + 1.0).abs() < 1e-12 && stiffness == 10.0);
        assert_eq!(servo.effort_and_stiffness(0.11, 4.0), (2.0, 0.0));
        assert_eq!(PositionServo::of_parameters(&servo.parameters()), servo);
        assert!(servo.is_sound());
        assert!(!PositionServo { stiffness: 0.0, ..servo }.is_sound());
        assert!(!PositionServo { delay_s: f64::NAN, ..servo }.is_sound());
    }
}
