//! An arm that a controller drives along a trajectory.

use armident_dynamics::{RigidArm, inertia_matrix, inverse_dynamics_of_motion};
use armident_recording::Recording;

use crate::error::SimulationError;
use crate::forward::{DEFAULT_STEP_S, scheme_note};
use crate::motion_log::MotionLog;
use crate::simulated_arm::SimulatedArm;
use crate::step_effort::StepEffort;
use crate::stepper::{ArmState, ForwardStepper};
use crate::trajectory::Trajectory;

/// Gains of a joint controller: `proportional (q_d - q) + derivative (q̇_d - q̇)`, one pair a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingGains {
    /// \[N m/rad or N/m\].
    pub proportional: Vec<f64>,
    /// \[N m s/rad or N s/m\].
    pub derivative: Vec<f64>,
}

impl TrackingGains {
    /// Critically damped joints of the given bandwidth \[Hz\] for the diagonal of the inertia matrix
    /// of `given` at `q`.
    pub fn of_bandwidth(given: &RigidArm, q: &[f64], bandwidth_hz: f64) -> Self {
        let omega = std::f64::consts::TAU * bandwidth_hz;
        let inertia = inertia_matrix(given, q).diagonal();
        Self {
            proportional: inertia.iter().map(|m| m * omega * omega).collect(),
            derivative: inertia.iter().map(|m| 2.0 * m * omega).collect(),
        }
    }
}

/// Drives the arm along a trajectory: feed-forward of the inverse dynamics of a given model, plus
/// a controller of each joint.
///
/// The effort is set at every stamp and held until the next one: the rate of the trajectory is that
/// of the control cycle. Each sample of the result has the state at the stamp, the effort set there as
/// its channel shows it, and the acceleration just after it. The arm starts in the first sample of the trajectory.
///
/// # Errors
/// A trajectory that is inconsistent or of other joints, gains that are not one finite number per
/// joint, a given model of another number of joints,
/// [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite) and
/// [`Diverged`](SimulationError::Diverged).
pub fn track(
    arm: &SimulatedArm,
    given: &RigidArm,
    trajectory: &Trajectory,
    gains: &TrackingGains,
) -> Result<Recording, SimulationError> {
    trajectory.recording()?;
    let n = arm.dof();
    if trajectory.joints != arm.joints() || given.dof() != n {
        return Err(SimulationError::OtherJoints {
            what: "the trajectory or the given model",
            found: trajectory.joints.clone(),
            known: arm.joints().to_vec(),
        });
    }
    for (what, found) in [
        ("the proportional gains", &gains.proportional),
        ("the derivative gains", &gains.derivative),
    ] {
        crate::stepper::check_numbers(what, n, found)?;
    }
    let Trajectory { time_s, position, velocity, acceleration, .. } = trajectory;
    let planned = inverse_dynamics_of_motion(given, position, velocity, acceleration);
    let start = ArmState {
        position: position.iter().map(|column| column[0]).collect(),
        velocity: velocity.iter().map(|column| column[0]).collect(),
    };
    let mut stepper = ForwardStepper::new(arm, start, time_s[0])?;
    let mut log = MotionLog::new(n, time_s.len());
    for k in 0..time_s.len() {
        let state = stepper.state();
        let effort: Vec<f64> = (0..n)
            .map(|j| {
                planned[j][k]
                    + gains.proportional[j] * (position[j][k] - state.position[j])
                    + gains.derivative[j] * (velocity[j][k] - state.velocity[j])
            })
            .collect();
        let reached = stepper.acceleration(&effort)?;
        log.push(time_s[k], stepper.state(), &reached, &effort);
        let Some(next_s) = time_s.get(k + 1) else { break };
        let cycle_s = next_s - time_s[k];
        let steps = (cycle_s / DEFAULT_STEP_S - 1e-9).ceil().max(1.0);
        let held = StepEffort::constant(&effort);
        for _ in 0..steps as usize {
            stepper.step(cycle_s / steps, &held)?;
        }
    }
    let mut notes = trajectory.notes.clone();
    notes.push(scheme_note(arm, DEFAULT_STEP_S));
    log.into_recording(format!("tracking of {}", trajectory.source), arm, notes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{effect, harmonic, stanford};

    fn largest_error(found: &Recording, trajectory: &Trajectory) -> f64 {
        let joints = found.joints.iter().zip(&trajectory.position);
        let errors = joints.flat_map(|(found, planned)| {
            found.position.as_ref().unwrap().iter().zip(planned).map(|(f, p)| (f - p).abs())
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn tracking_error_falls_with_bandwidth() {
        let arm = stanford(&[
            effect("coulomb_friction", "joint_2", 4.0),
            effect("viscous_friction", "joint_1", 3.0),
        ]);
        let trajectory = harmonic(arm.joints(), 1001, 1e-3);
        let start: Vec<f64> = trajectory.position.iter().map(|c| c[0]).collect();
        let error = |bandwidth_hz: f64| {
            let gains = TrackingGains::of_bandwidth(arm.rigid(), &start, bandwidth_hz);
            let found = track(&arm, arm.rigid(), &trajectory, &gains).unwrap();
            assert_eq!(found.time_s, trajectory.time_s);
            largest_error(&found, &trajectory)
        };
        let (slow, fast) = (error(2.0), error(8.0));
        assert!(fast < 0.01 && slow > 4.0 * fast, "{slow} {fast}");
    }

    #[test]
    fn exact_feed_forward_needs_no_controller() {
        let arm = stanford(&[]);
        let trajectory = harmonic(arm.joints(), 1001, 1e-3);
        let none = TrackingGains { proportional: vec![0.0; 6], derivative: vec![0.0; 6] };
        let found = track(&arm, arm.rigid(), &trajectory, &none).unwrap();
        // what is left is the effort that is held for one cycle
        let error = largest_error(&found, &trajectory);
        assert!(error < 5e-3, "{error}");
    }
}
