//! One joint behind its position controller while the others move as recorded.

use armident_effects::PositionServo;

use crate::dry_friction::solve_one_row;
use crate::error::SimulationError;
use crate::lines;
use crate::simulated_arm::SimulatedArm;
use crate::stepper::secant;

/// Velocity over which the slope of friction is taken \[rad/s or m/s\].
const SMALL_VELOCITY: f64 = 1e-3;
/// Rounds in which friction and the load that it depends on agree, and their agreement: as in a step of the whole arm.
const LOAD_ROUNDS: usize = 20;
const AGREEMENT: f64 = 1e-6;

/// What moves a joint, at the stamps of a recording.
#[derive(Debug, Clone, Copy)]
pub struct JointDrive<'a> {
    /// Stamps \[s\].
    pub time_s: &'a [f64],
    /// Commands \[rad or m\].
    pub command: &'a [f64],
    /// Position in the recorded motion \[rad or m\].
    pub recorded: &'a [f64],
    /// Effort of the rigid body in the recorded motion, without the inertia of the joint itself \[N m or N\].
    pub load: &'a [f64],
    /// Its change by the position of the joint \[N m/rad or N/m\].
    pub load_slope: &'a [f64],
    /// Diagonal of the inertia matrix at the joint \[kg m2 or kg\].
    pub inertia: &'a [f64],
    /// Gain of the controller over that of the stiffness.
    pub gain: f64,
}

/// The effects on one joint of an arm, as the equations of a single coordinate.
///
/// ```text
/// (M + I) a + s(v) + load + λ = effort(c(t - T) - q),   λ ∈ F(v, load) Sign(v)
/// ```
///
/// It is one row of [`ForwardStepper`](crate::ForwardStepper), with the effects and the friction law of that. Steps are those of the
/// implicit midpoint rule, linearised: of second order (one of first order adds a damping of half a step to what is fitted), and
/// stiff controllers and light links need no short ones: a fit simulates thousands of recordings, and the whole arm would have
/// to be moved in steps of a fifth for each of them.
#[derive(Debug, Clone, Copy)]
pub struct ServoJoint<'a> {
    arm: &'a SimulatedArm,
    joint: usize,
    servo: PositionServo,
    added_inertia: f64,
    has_dry_friction: bool,
    has_load_friction: bool,
}

/// Between samples `k` and `k + 1` of a smooth series: the cubic through its neighbours' slopes (Catmull-Rom). A line between
/// samples far apart takes an acceleration for smaller than it is.
fn smooth_between(of: &[f64], k: usize, share: f64) -> f64 {
    let (from, to) = (of[k], of[k + 1]);
    let before = if k > 0 { of[k - 1] } else { 2.0 * from - to };
    let after = of.get(k + 2).copied().unwrap_or(2.0 * to - from);
    let (slope_from, slope_to) = (0.5 * (to - before), 0.5 * (after - from));
    let rise = to - from;
    let (a, b) = (slope_from - rise, rise - slope_to);
    from + share * (rise + (1.0 - share) * (a * (1.0 - share) + b * share))
}

impl<'a> ServoJoint<'a> {
    /// Joint `joint` of an arm, from 0.
    ///
    /// # Errors
    /// A joint without a position controller.
    pub fn of(arm: &'a SimulatedArm, joint: usize) -> Result<Self, SimulationError> {
        let servo = arm.servo_or_error(joint)?;
        let [free, loaded] = [0.0, 1.0].map(|load| arm.dry_friction(joint, 1.0, load));
        Ok(Self {
            arm,
            joint,
            servo,
            added_inertia: arm.added_inertia(joint),
            has_dry_friction: !free.is_none() || !loaded.is_none(),
            has_load_friction: free != loaded,
        })
    }

    /// Position at each stamp \[rad or m\], from a start (position, velocity) on; steps of at most `step_s` \[s\].
    pub fn simulate(&self, drive: &JointDrive<'_>, start: [f64; 2], step_s: f64) -> Vec<f64> {
        let [mut q, mut v] = start;
        let stamps = drive.time_s;
        let mut commands = lines::Forward::new(stamps, drive.command);
        let mut positions = Vec::with_capacity(stamps.len());
        for k in 0..stamps.len() {
            positions.push(q);
            let Some(next_s) = stamps.get(k + 1) else { break };
            let cycle_s = next_s - stamps[k];
            let steps = (cycle_s / step_s - 1e-9).ceil().max(1.0);
            let h = cycle_s / steps;
            for part in 1..=steps as usize {
                // midpoint of the step
                let share = (part as f64 - 0.5) / steps;
                let between = |of: &[f64]| of[k] + share * (of[k + 1] - of[k]);
                let time_s = stamps[k] + share * cycle_s;
                let command = commands.at(time_s - self.servo.delay_s);
                let slope = between(drive.load_slope);
                let carried = smooth_between(drive.load, k, share);
                let load = carried + slope * (q - between(drive.recorded));
                let inertia = between(drive.inertia);
                let drive_now = [command, load, slope, inertia];
                let mean = self.mean_velocity(drive.gain, [q, v], drive_now, h);
                q += h * mean;
                let end = 2.0 * mean - v;
                // where dry friction holds it, a joint comes to rest within the step and does not turn back
                v = if self.has_dry_friction && end * mean <= 0.0 { 0.0 } else { end };
            }
        }
        positions
    }

    /// Over the next `h` \[s\], with everything but the position at its value in the midpoint.
    fn mean_velocity(
        &self,
        gain: f64,
        [q, v]: [f64; 2],
        [command, load, load_slope, inertia]: [f64; 4],
        h: f64,
    ) -> f64 {
        let half = 0.5 * h;
        let (effort, stiffness) = self.servo.effort_and_stiffness(command - q, gain);
        let smooth = |velocity: f64| self.arm.smooth_effort(self.joint, 0.0, q, velocity);
        let friction = smooth(v);
        let slope = ((smooth(v + SMALL_VELOCITY) - friction) / SMALL_VELOCITY).max(0.0);
        let mass = (inertia + self.added_inertia) / half;
        let driving = mass * v + effort - load - friction + slope * v;
        // a load that falls with the position is left to the next step
        let matrix = mass + slope + half * (stiffness + load_slope.max(0.0));
        let mut dry = self.arm.dry_friction(self.joint, v, load);
        let mut mean = solve_one_row(matrix, driving, dry);
        if !self.has_load_friction {
            return mean;
        }
        let mut tried = load;
        let mut before: Option<[f64; 2]> = None;
        for _ in 0..LOAD_ROUNDS {
            // the gear accelerates the links too
            let carried = load + inertia * (mean - v) / half;
            let found = self.arm.dry_friction(self.joint, v, carried);
            let change =
                (found.forward - dry.forward).abs() + (found.backward - dry.backward).abs();
            if change <= AGREEMENT * (found.forward + found.backward) {
                break;
            }
            let round = [tried, carried];
            tried = before.map_or(carried, |before| secant(before, round));
            before = Some(round);
            dry = self.arm.dry_friction(self.joint, v, tried);
            mean = solve_one_row(matrix, driving, dry);
        }
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::smooth_between;

    /// Parabolas are reproduced, and a wave of six samples is followed four times as well as by lines.
    #[test]
    fn series_is_smooth_between_samples() {
        let squares: Vec<f64> = (0..5).map(|k| f64::from(k * k)).collect();
        for share in [0.0, 0.3, 0.5, 1.0] {
            let found = smooth_between(&squares, 2, share);
            assert!((found - (2.0 + share).powi(2)).abs() < 1e-12, "{found}");
        }
        let wave: Vec<f64> = (0..40).map(|k| f64::from(k).sin()).collect();
        let (mut smooth, mut lines) = (0.0, 0.0);
        for k in 1..38 {
            let exact = (k as f64 + 0.5).sin();
            smooth += (smooth_between(&wave, k, 0.5) - exact).powi(2);
            lines += (0.5 * (wave[k] + wave[k + 1]) - exact).powi(2);
        }
        assert!(lines > 16.0 * smooth, "{lines} {smooth}");
        // at the ends it goes on as a line
        assert!((smooth_between(&[1.0, 3.0], 0, 0.25) - 1.5).abs() < 1e-12);
    }
}
