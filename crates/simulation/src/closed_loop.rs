//! An arm whose joints have position controllers: commands in, motion out.

use std::ops::Range;

use armident_effects::PositionServo;
use armident_recording::{Quantity, Recording};

use crate::error::SimulationError;
use crate::forward::{check_step, scheme_note};
use crate::lines;
use crate::motion_log::MotionLog;
use crate::simulated_arm::SimulatedArm;
use crate::step_effort::StepEffort;
use crate::stepper::{ArmState, ForwardStepper};
use crate::trajectory::missing;

/// The motion that commands cause, from a state at the first stamp on; positions and efforts at each stamp of the commands.
///
/// `gain` is that of all controllers over the one that their stiffness belongs to; 1 unless it was changed since. Commands
/// between two stamps lie on a line, and before the first they are the first. The effort of a controller is formed
/// at the start of each step of at most `step_s` \[s\] and extrapolated along the step by the velocity.
///
/// # Errors
/// An inconsistent recording, a joint without commands or without a position controller, a start that is not one a joint, a
/// step that is not possible, [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite) and [`Diverged`](SimulationError::Diverged).
pub fn closed_loop(
    arm: &SimulatedArm,
    gain: f64,
    commands: &Recording,
    start: ArmState,
    step_s: f64,
) -> Result<Recording, SimulationError> {
    closed_loop_over(arm, gain, commands, 0..commands.time_s.len(), start, step_s)
}

/// The same over a span of samples, from a state at its first stamp on; commands before the span are known to the controllers.
///
/// # Errors
/// As [`closed_loop`]; a span that is empty or beyond the recording.
pub fn closed_loop_over(
    arm: &SimulatedArm,
    gain: f64,
    commands: &Recording,
    span: Range<usize>,
    start: ArmState,
    step_s: f64,
) -> Result<Recording, SimulationError> {
    commands.check()?;
    let arm = &*arm.at_known_temperatures(commands);
    let columns = arm.joints().iter().map(|name| {
        let column = commands.joint(name).and_then(|joint| joint.channel(Quantity::Command));
        column.ok_or_else(|| missing(commands, name, Quantity::Command))
    });
    let columns = columns.collect::<Result<Vec<&[f64]>, _>>()?;
    let servos = (0..arm.dof()).map(|j| arm.servo_or_error(j));
    let servos = servos.collect::<Result<Vec<PositionServo>, _>>()?;
    let stamps_s = &commands.time_s;
    check_step(step_s, stamps_s[stamps_s.len() - 1] - stamps_s[0])?;
    let effort = |time_s: f64, ahead_s: f64, state: &ArmState| -> Vec<f64> {
        let of_joint = |(j, servo): (usize, &PositionServo)| {
            let command = lines::at(stamps_s, columns[j], time_s + ahead_s - servo.delay_s);
            let position = state.position[j] + ahead_s * state.velocity[j];
            servo.effort(command - position, gain)
        };
        servos.iter().enumerate().map(of_joint).collect()
    };
    let moved_s = stamps_s.get(span).unwrap_or(&[]);
    let mut log = MotionLog::new(arm.dof(), moved_s.len());
    let source = format!("closed loop under {}", commands.source);
    let Some(&start_s) = moved_s.first() else {
        return log.into_recording(source, arm, Vec::new());
    };
    let mut stepper = ForwardStepper::new(arm, start, start_s)?;
    for (k, &stamp_s) in moved_s.iter().enumerate() {
        let now = effort(stamp_s, 0.0, stepper.state());
        let acceleration = stepper.acceleration(&now)?;
        log.push(stamp_s, stepper.state(), &acceleration, &now);
        let Some(next_s) = moved_s.get(k + 1) else { break };
        let cycle_s = next_s - stamp_s;
        let steps = (cycle_s / step_s - 1e-9).ceil().max(1.0);
        let h = cycle_s / steps;
        for part in 0..steps as usize {
            let time_s = stamp_s + part as f64 * h;
            let state = stepper.state();
            let [first, last] = [0.0, h].map(|ahead_s| effort(time_s, ahead_s, state));
            stepper.step(h, &StepEffort::linear(&first, &last))?;
        }
    }
    let mut notes = commands.notes.clone();
    notes.push(scheme_note(arm, step_s));
    log.into_recording(source, arm, notes)
}

#[cfg(test)]
mod tests {
    use armident_effects::{Effect, EffectOnJoint, LoadDependentFriction, PositionControl};
    use armident_recording::JointChannels;

    use super::*;
    use crate::servo_joint::{JointDrive, ServoJoint};
    use crate::test_arms::{effect, slider};

    const SERVO: PositionServo =
        PositionServo { stiffness: 400.0, delay_s: 0.03, dead_band: 0.0, effort_limit: Some(60.0) };

    /// The slider with friction behind its controller.
    fn controlled_slider() -> SimulatedArm {
        let servo = EffectOnJoint::new(PositionControl.slug(), "rail", SERVO.parameters());
        slider(&[
            effect("viscous_friction", "rail", 30.0),
            effect("coulomb_friction", "rail", 8.0),
            servo,
        ])
    }

    fn commands(joints: &[String], of: impl Fn(f64) -> f64) -> Recording {
        let time_s: Vec<f64> = (0..300).map(|k| 0.02 * f64::from(k)).collect();
        let channels = joints.iter().map(|name| {
            let command = time_s.iter().map(|t| of(*t)).collect();
            JointChannels { command: Some(command), ..JointChannels::new(name) }
        });
        Recording::new("commands", time_s.clone(), channels.collect()).unwrap()
    }

    #[test]
    fn servo_reaches_its_command_inside_friction() {
        let arm = controlled_slider();
        let given = commands(arm.joints(), |t| if t < 1.0 { 0.0 } else { 0.1 });
        let start = ArmState::at_rest(vec![0.0; arm.dof()]);
        let motion = closed_loop(&arm, 1.0, &given, start, 5e-4).unwrap();
        let position = motion.joints[0].position.as_ref().unwrap();
        // the command leaves 0 at 0.98 s, and the delay is over at 1.01 s
        assert_eq!(position[50], 0.0);
        let error = 0.1 - position[299];
        assert!(error.abs() <= 8.0 / 400.0 + 1e-6 && error.abs() > 1e-3, "{error}");
    }

    #[test]
    fn one_joint_moves_as_in_the_arm() {
        let arm = controlled_slider();
        let given = commands(arm.joints(), |t| 0.2 * (2.0 * t).sin());
        let start = ArmState::at_rest(vec![0.0; arm.dof()]);
        let whole = closed_loop(&arm, 1.0, &given, start, 5e-4).unwrap();
        let command = given.joints[0].command.as_ref().unwrap();
        let inertia = vec![armident_dynamics::inertia_matrix(arm.rigid(), &[0.0])[(0, 0)]; 300];
        let zero = vec![0.0; 300];
        let drive = JointDrive {
            time_s: &given.time_s,
            command,
            recorded: &zero,
            load: &zero,
            load_slope: &zero,
            inertia: &inertia,
            gain: 1.0,
        };
        let alone = ServoJoint::of(&arm, 0).unwrap().simulate(&drive, [0.0, 0.0], 1e-3);
        let position = whole.joints[0].position.as_ref().unwrap();
        for (k, (a, b)) in alone.iter().zip(position).enumerate() {
            assert!((a - b).abs() < 2e-3, "{k}: {a} {b}");
        }
    }

    /// What the gear carries is the weight and the acceleration of the links, as in the whole arm.
    #[test]
    fn friction_of_one_joint_follows_its_load_as_in_the_arm() {
        let servo = EffectOnJoint::new(PositionControl.slug(), "rail", SERVO.parameters());
        let by_load = EffectOnJoint::new(LoadDependentFriction.slug(), "rail", [2.0, 0.4]);
        let arm = slider(&[effect("viscous_friction", "rail", 30.0), by_load, servo]);
        let given = commands(arm.joints(), |t| 0.2 * (5.0 * t).sin());
        let start = ArmState::at_rest(vec![0.0; arm.dof()]);
        let whole = closed_loop(&arm, 1.0, &given, start, 2e-4).unwrap();
        let zero = vec![0.0; 300];
        let drive = JointDrive {
            time_s: &given.time_s,
            command: given.joints[0].command.as_ref().unwrap(),
            recorded: &zero,
            load: &zero,
            load_slope: &zero,
            inertia: &vec![armident_dynamics::inertia_matrix(arm.rigid(), &[0.0])[(0, 0)]; 300],
            gain: 1.0,
        };
        let alone = ServoJoint::of(&arm, 0).unwrap().simulate(&drive, [0.0, 0.0], 2e-4);
        let position = whole.joints[0].position.as_ref().unwrap();
        let error = alone.iter().zip(position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // of a swing of 0.2 m
        assert!(error < 1e-3, "{error}");
    }

    #[test]
    fn commands_need_a_controller() {
        let arm = slider(&[]);
        let given = commands(arm.joints(), |_| 0.0);
        let start = ArmState::at_rest(vec![0.0; arm.dof()]);
        let error = closed_loop(&arm, 1.0, &given, start, 5e-4).unwrap_err().to_string();
        assert!(error.contains("rail") && error.contains("no position controller"), "{error}");
    }
}
