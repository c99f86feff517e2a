//! Efforts in, motion out.

use armident_recording::{Quantity, Recording};

use crate::error::SimulationError;
use crate::motion_log::MotionLog;
use crate::simulated_arm::SimulatedArm;
use crate::step_effort::StepEffort;
use crate::stepper::{ArmState, ForwardStepper};
use crate::trajectory::{even_times, missing};

/// Longest step of the integration unless another is chosen \[s\].
pub const DEFAULT_STEP_S: f64 = 5e-4;
/// Most steps of one simulation.
const MOST_STEPS: f64 = 1e9;

/// How [`forward`] integrates and what it writes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForwardSettings {
    /// Longest step \[s\]; the time between two samples is divided into the fewest equal steps that
    /// are not longer.
    pub step_s: f64,
    /// Samples per second of the result \[Hz\]; without it the result has the stamps of the efforts.
    pub rate_hz: Option<f64>,
}

impl Default for ForwardSettings {
    fn default() -> Self {
        Self { step_s: DEFAULT_STEP_S, rate_hz: None }
    }
}

/// The motion that recorded efforts cause, from a state at the first stamp on: efforts in and out are
/// what the channels show, positions those of the motors where there is a transmission.
///
/// Efforts between two samples lie on a line, so that samples at distance `Δ` of smooth efforts give
/// their motion back up to an error of order `Δ²`, however small the step is. Accelerations are those
/// of the written position, velocity and effort.
///
/// # Errors
/// An inconsistent recording, a joint without efforts, a start that is not one finite number per
/// joint, a step or rate that is not possible,
/// [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite) and
/// [`Diverged`](SimulationError::Diverged).
pub fn forward(
    arm: &SimulatedArm,
    efforts: &Recording,
    start: ArmState,
    settings: &ForwardSettings,
) -> Result<Recording, SimulationError> {
    efforts.check()?;
    let columns = arm.joints().iter().map(|name| {
        let column = efforts.joint(name).and_then(|joint| joint.channel(Quantity::Effort));
        column.map(<[f64]>::to_vec).ok_or_else(|| missing(efforts, name, Quantity::Effort))
    });
    let mut columns = columns.collect::<Result<Vec<_>, _>>()?;
    arm.to_true(&efforts.time_s, &mut columns);
    let samples = EffortSamples { time_s: &efforts.time_s, columns };
    let stamps_s = samples.time_s;
    check_step(settings.step_s, stamps_s[stamps_s.len() - 1] - stamps_s[0])?;
    let output_s = match settings.rate_hz {
        Some(rate_hz) => even_times(stamps_s, rate_hz)?,
        None => stamps_s.to_vec(),
    };
    let mut stepper = ForwardStepper::new(arm, start, output_s[0])?;
    let mut log = MotionLog::new(arm.dof(), output_s.len());
    for (k, &time_s) in output_s.iter().enumerate() {
        if k > 0 {
            samples.drive(&mut stepper, output_s[k - 1], time_s, settings.step_s)?;
        }
        let effort = samples.at(time_s);
        let acceleration = stepper.acceleration(&effort)?;
        log.push(time_s, stepper.state(), &acceleration, &effort);
    }
    let mut notes = efforts.notes.clone();
    notes.push(scheme_note(arm, settings.step_s));
    log.into_recording(format!("simulated from {}", efforts.source), arm, notes)
}

/// A step that is positive and does not take forever.
pub(crate) fn check_step(step_s: f64, duration_s: f64) -> Result<(), SimulationError> {
    if step_s > 0.0 && step_s.is_finite() && duration_s / step_s <= MOST_STEPS {
        return Ok(());
    }
    Err(SimulationError::Setting {
        setting: "the step [s]",
        value: step_s,
        range: format!("at least {:.1e} for {duration_s} s, and finite", duration_s / MOST_STEPS),
    })
}

/// How the motion was integrated.
pub(crate) fn scheme_note(arm: &SimulatedArm, step_s: f64) -> String {
    let scheme = if arm.has_dry_friction() {
        "midpoint steps with implicit dry friction"
    } else if arm.deflections().next().is_some() {
        "midpoint steps"
    } else {
        "Runge-Kutta steps of fourth order"
    };
    format!("integrated by {scheme} of at most {step_s} s")
}

/// Efforts with lines between the samples.
struct EffortSamples<'a> {
    time_s: &'a [f64],
    columns: Vec<Vec<f64>>,
}

impl EffortSamples<'_> {
    /// Efforts at a time inside the recording.
    fn at(&self, time_s: f64) -> Vec<f64> {
        self.columns.iter().map(|column| crate::lines::at(self.time_s, column, time_s)).collect()
    }

    /// Moves the arm from one time to another. Steps end at the stamps in between, so that the
    /// efforts have no corner inside a step.
    fn drive(
        &self,
        stepper: &mut ForwardStepper<'_>,
        from_s: f64,
        to_s: f64,
        longest_step_s: f64,
    ) -> Result<(), SimulationError> {
        let next = self.time_s.partition_point(|stamp| *stamp <= from_s);
        // stamps that differ from the ends by rounding only make no step of their own
        let rounding_s = 1e-6 * longest_step_s.min(to_s - from_s);
        let corners = self.time_s[next..].iter().copied().take_while(|stamp| *stamp < to_s);
        let corners =
            corners.filter(|stamp| *stamp > from_s + rounding_s && *stamp < to_s - rounding_s);
        let mut begin_s = from_s;
        for end_s in corners.chain([to_s]) {
            let length_s = end_s - begin_s;
            let steps = (length_s / longest_step_s - 1e-9).ceil().max(1.0);
            let (first, last) = (self.at(begin_s), self.at(end_s));
            let at = |share: f64| -> Vec<f64> {
                first.iter().zip(&last).map(|(f, l)| f + share * (l - f)).collect()
            };
            for k in 0..steps as usize {
                let (k, step_s) = (k as f64, length_s / steps);
                let effort = StepEffort::linear(&at(k / steps), &at((k + 1.0) / steps));
                stepper.step(step_s, &effort)?;
            }
            begin_s = end_s;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use armident_dynamics::energy;
    use armident_recording::JointChannels;

    use super::*;
    use crate::inverse::inverse;
    use crate::test_arms::{effect, harmonic, planar, slider, stanford};
    use crate::trajectory::Trajectory;

    fn start_of(trajectory: &Trajectory) -> ArmState {
        let first = |columns: &[Vec<f64>]| columns.iter().map(|c| c[0]).collect();
        ArmState { position: first(&trajectory.position), velocity: first(&trajectory.velocity) }
    }

    fn efforts(arm: &SimulatedArm, samples: usize, effort: impl Fn(f64) -> f64) -> Recording {
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * 0.01).collect();
        let joints = arm.joints().iter().map(|name| JointChannels {
            effort: Some(time_s.iter().map(|t| effort(*t)).collect()),
            ..JointChannels::new(name)
        });
        let joints = joints.collect();
        Recording::new("efforts.csv", time_s, joints).unwrap()
    }

    /// The way there and back; halving the sample distance quarters the error.
    #[test]
    fn forward_reproduces_driving_trajectory() {
        let arm = stanford(&[
            effect("viscous_friction", "joint_1", 2.0),
            effect("rotor_inertia", "joint_4", 0.02),
        ]);
        let error = |samples: usize, step_s: f64| {
            let trajectory = harmonic(arm.joints(), samples, step_s);
            let efforts = inverse(&arm, &trajectory).unwrap();
            let start = start_of(&trajectory);
            let found = forward(&arm, &efforts, start, &ForwardSettings::default()).unwrap();
            assert_eq!(found.time_s, trajectory.time_s);
            let joints = found.joints.iter().zip(&trajectory.position);
            let errors = joints.flat_map(|(found, expected)| {
                found.position.as_ref().unwrap().iter().zip(expected).map(|(f, e)| (f - e).abs())
            });
            errors.fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(101, 0.01), error(201, 0.005));
        assert!(fine < 1e-3 && (coarse / fine - 4.0).abs() < 0.5, "{coarse:.1e} {fine:.1e}");
    }

    /// With efforts that really are lines between their samples nothing but the step is left.
    #[test]
    fn step_order_is_independent_of_output_rate() {
        let arm = planar(&[]);
        let efforts = efforts(&arm, 101, |t| 0.5 - t);
        let run = |step_s: f64, rate_hz: Option<f64>| {
            let start = ArmState { position: vec![0.4, 0.9], velocity: vec![0.0, -1.0] };
            forward(&arm, &efforts, start, &ForwardSettings { step_s, rate_hz }).unwrap()
        };
        let last = |recording: &Recording| {
            let position = |j: &JointChannels| *j.position.as_ref().unwrap().last().unwrap();
            recording.joints.iter().map(position).collect::<Vec<_>>()
        };
        let exact = last(&run(1e-4, None));
        let error = |recording: &Recording| {
            let errors = last(recording).into_iter().zip(&exact).map(|(f, e)| (f - e).abs());
            errors.fold(0.0, f64::max)
        };
        let order = (error(&run(0.005, None)) / error(&run(0.0025, None))).log2();
        assert!((order - 4.0).abs() < 0.4, "{order}");
        // 64 Hz: a step ends between two stamps and the next one at a stamp
        let other_rate = run(1e-3, Some(64.0));
        assert_eq!(other_rate.len(), 65);
        assert!(error(&other_rate) < 1e-9, "{}", error(&other_rate));
    }

    #[test]
    fn free_swing_conserves_energy() {
        let arm = planar(&[]);
        let start = ArmState::at_rest(vec![1.2, 0.8]);
        let swing = efforts(&arm, 1001, |_| 0.0);
        let found = forward(&arm, &swing, start, &ForwardSettings::default()).unwrap();
        let energy_at = |k: usize| {
            let at = |column: &Option<Vec<f64>>| column.as_ref().unwrap()[k];
            let q: Vec<f64> = found.joints.iter().map(|j| at(&j.position)).collect();
            let v: Vec<f64> = found.joints.iter().map(|j| at(&j.velocity)).collect();
            (energy(arm.rigid(), &q, &v), v[0].abs())
        };
        let (first, _) = energy_at(0);
        let mut fastest = 0.0_f64;
        for k in 0..found.len() {
            let (now, speed) = energy_at(k);
            fastest = fastest.max(speed);
            assert!((now - first).abs() < 1e-8, "{k}: {now} {first}");
        }
        assert!(fastest > 2.0);
        assert_eq!(
            found.notes,
            ["integrated by Runge-Kutta steps of fourth order of at most 0.0005 s"]
        );
    }

    /// A force that grows at 10 N/s moves the mass when it reaches 3 N, not before.
    #[test]
    fn joint_breaks_away_at_friction_level() {
        let arm = slider(&[effect("coulomb_friction", "rail", 3.0)]);
        let ramp = efforts(&arm, 101, |t| 10.0 * t);
        let start = ArmState::at_rest(vec![0.0]);
        let found = forward(&arm, &ramp, start, &ForwardSettings::default()).unwrap();
        let joint = &found.joints[0];
        let (position, acceleration) =
            (joint.position.as_ref().unwrap(), joint.acceleration.as_ref().unwrap());
        for (k, t) in found.time_s.iter().enumerate() {
            let sliding_s = (t - 0.3).max(0.0);
            assert!((position[k] - 10.0 / 12.0 * sliding_s.powi(3)).abs() < 1e-5, "at {t} s");
            assert!((acceleration[k] - 5.0 * sliding_s).abs() < 1e-9, "at {t} s");
            assert!(*t > 0.3 || position[k] == 0.0);
        }
    }

    /// What comes out of a simulation with stick and slip satisfies the equations in every sample.
    #[test]
    fn samples_satisfy_equations_of_motion() {
        let rubbing = [
            effect("coulomb_friction", "joint_1", 5.0),
            effect("coulomb_friction", "joint_2", 3.0),
        ];
        let arm = planar(&rubbing);
        let shaken = efforts(&arm, 301, |t| 6.0 * (5.0 * t).sin());
        let start = ArmState::at_rest(vec![0.5, 0.0]);
        let found = forward(&arm, &shaken, start, &ForwardSettings::default()).unwrap();
        let joints = arm.joints().to_vec();
        let held = std::collections::BTreeMap::new();
        let trajectory = Trajectory::from_recording(&found, &joints, &held).unwrap();
        let back = inverse(&arm, &trajectory).unwrap();
        let (mut slips, mut sticks) = (0, 0);
        for (j, (found, back)) in found.joints.iter().zip(&back.joints).enumerate() {
            for k in 0..301 {
                let at = |column: &Option<Vec<f64>>| column.as_ref().unwrap()[k];
                let difference = at(&found.effort) - at(&back.effort);
                if at(&found.velocity) == 0.0 {
                    sticks += 1;
                    assert!(difference.abs() <= arm.dry_friction(j, 0.0, 0.0).forward + 1e-9);
                } else {
                    slips += 1;
                    assert!(difference.abs() < 1e-9, "{difference}");
                }
            }
        }
        assert!(sticks > 20 && slips > 200, "{sticks} {slips}");
    }
}
