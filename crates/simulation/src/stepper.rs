//! One step of the motion that efforts cause.

use nalgebra::{DMatrix, DVector};

use crate::dry_friction::solve_dry_friction;
use crate::error::SimulationError;
use crate::simulated_arm::{EquationsScratch, SimulatedArm};
use crate::step_effort::StepEffort;

/// Speed above which a motion counts as diverged \[rad/s or m/s\].
pub const HIGHEST_SPEED: f64 = 1e4;
/// Halvings of a step in which a joint with dry friction stops or reverses.
const HALVINGS: u32 = 4;

/// Position and velocity of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmState {
    /// Position \[rad or m\].
    pub position: Vec<f64>,
    /// Velocity \[rad/s or m/s\].
    pub velocity: Vec<f64>,
}

impl ArmState {
    /// At a position without motion.
    pub fn at_rest(position: Vec<f64>) -> Self {
        let velocity = vec![0.0; position.len()];
        Self { position, velocity }
    }
}

/// An arm in motion, moved on by one step at a time: what a simulation is made of, and what a
/// controller closes its loop around. The scheme is that of the [crate page](crate#scheme).
#[derive(Debug, Clone)]
pub struct ForwardStepper<'a> {
    arm: &'a SimulatedArm,
    state: ArmState,
    time_s: f64,
    friction: Vec<f64>,
    scratch: EquationsScratch,
}

impl<'a> ForwardStepper<'a> {
    /// The arm in a state at a time \[s\].
    ///
    /// # Errors
    /// A state that is not one finite number per joint.
    pub fn new(
        arm: &'a SimulatedArm,
        start: ArmState,
        time_s: f64,
    ) -> Result<Self, SimulationError> {
        check_numbers("the start position", arm.dof(), &start.position)?;
        check_numbers("the start velocity", arm.dof(), &start.velocity)?;
        let friction = (0..arm.dof()).map(|j| arm.dry_friction(j)).collect();
        let scratch = EquationsScratch::new(arm.dof());
        Ok(Self { arm, state: start, time_s, friction, scratch })
    }

    /// Where the arm is and how it moves.
    pub fn state(&self) -> &ArmState {
        &self.state
    }

    /// Time \[s\].
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The present accelerations under the given efforts; a joint at rest accelerates only if its
    /// dry friction cannot hold it.
    ///
    /// # Errors
    /// Efforts that are not one finite number per joint, and
    /// [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite).
    pub fn acceleration(&mut self, effort: &[f64]) -> Result<Vec<f64>, SimulationError> {
        check_numbers("the effort", self.arm.dof(), effort)?;
        let ArmState { position: q, velocity: v } = self.state.clone();
        let acceleration = self.acceleration_at(&q, &v, effort, true)?;
        Ok(acceleration.as_slice().to_vec())
    }

    /// Moves on by `step_s` \[s\].
    ///
    /// # Errors
    /// A step that is not positive, efforts that are not one finite number per joint,
    /// [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite), and
    /// [`Diverged`](SimulationError::Diverged); the state is then of no use.
    pub fn step(&mut self, step_s: f64, effort: &StepEffort) -> Result<(), SimulationError> {
        if !(step_s > 0.0 && step_s.is_finite()) {
            return Err(SimulationError::Setting {
                setting: "the step [s]",
                value: step_s,
                range: "positive".to_owned(),
            });
        }
        for values in [&effort.start, &effort.middle, &effort.end] {
            check_numbers("the effort", self.arm.dof(), values)?;
        }
        if self.friction.iter().any(|level| *level > 0.0) {
            self.friction_step(step_s, effort, HALVINGS)
        } else {
            self.runge_kutta_step(step_s, effort)
        }
    }

    /// Classical Runge-Kutta of fourth order.
    fn runge_kutta_step(&mut self, h: f64, effort: &StepEffort) -> Result<(), SimulationError> {
        let q = DVector::from_column_slice(&self.state.position);
        let v = DVector::from_column_slice(&self.state.velocity);
        let mut slope = |q: DVector<f64>, v: DVector<f64>, effort: &[f64]| {
            self.acceleration_at(q.as_slice(), v.as_slice(), effort, false)
        };
        let half = 0.5 * h;
        let k1 = slope(q.clone(), v.clone(), &effort.start)?;
        let k2 = slope(&q + &v * half, &v + &k1 * half, &effort.middle)?;
        let k3 = slope(&q + &v * half + &k1 * (half * half), &v + &k2 * half, &effort.middle)?;
        let k4 = slope(&q + &v * h + &k2 * (h * half), &v + &k3 * h, &effort.end)?;
        let next_q = q + v.clone() * h + (&k1 + &k2 + &k3) * (h * h / 6.0);
        let next_v = v + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        self.move_to(h, &next_q, &next_v)
    }

    /// Midpoint rule with implicit dry friction.
    fn friction_step(
        &mut self,
        h: f64,
        effort: &StepEffort,
        halvings: u32,
    ) -> Result<(), SimulationError> {
        let ArmState { position: q, velocity: v } = self.state.clone();
        let half = 0.5 * h;
        let mid_v = self.impulse(&q, &v, &v, half, &effort.start)?;
        let mid_q: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + half * v).collect();
        let next_v = self.impulse(&mid_q, mid_v.as_slice(), &v, h, &effort.middle)?;
        let stops =
            (0..v.len()).any(|j| self.friction[j] > 0.0 && v[j] != 0.0 && v[j] * next_v[j] <= 0.0);
        if stops && halvings > 0 {
            let [first, second] = effort.halves();
            self.friction_step(half, &first, halvings - 1)?;
            return self.friction_step(half, &second, halvings - 1);
        }
        let next_q = q.iter().zip(&v).zip(&next_v).map(|((q, v), w)| q + half * (v + w));
        let next_q = DVector::from_iterator(q.len(), next_q);
        self.move_to(h, &next_q, &next_v)
    }

    /// Velocity after `h` from `before`: `M (w - before) = h (τ - b - λ)`, `λ_j ∈ Fc_j Sign(w_j)`,
    /// with `M` and `b` at `q`, `v`.
    fn impulse(
        &mut self,
        q: &[f64],
        v: &[f64],
        before: &[f64],
        h: f64,
        effort: &[f64],
    ) -> Result<DVector<f64>, SimulationError> {
        let (m, bias) = self.arm.equations(q, v, &mut self.scratch);
        let driving = (DVector::from_column_slice(effort) - bias) * h;
        let level: Vec<f64> = self.friction.iter().map(|level| level * h).collect();
        let r = &m * DVector::from_column_slice(before) + driving;
        solve_dry_friction(&m, &r, &level, before).ok_or_else(|| self.singular(q, v, &m))
    }

    /// Accelerations at any state, with or without dry friction.
    fn acceleration_at(
        &mut self,
        q: &[f64],
        v: &[f64],
        effort: &[f64],
        with_friction: bool,
    ) -> Result<DVector<f64>, SimulationError> {
        let (m, bias) = self.arm.equations(q, v, &mut self.scratch);
        let mut driving = DVector::from_column_slice(effort) - bias;
        let mut level = vec![0.0; v.len()];
        if with_friction {
            for j in 0..v.len() {
                if v[j] == 0.0 {
                    level[j] = self.friction[j];
                } else {
                    driving[j] -= self.friction[j] * v[j].signum();
                }
            }
        }
        let rest = vec![0.0; v.len()];
        solve_dry_friction(&m, &driving, &level, &rest).ok_or_else(|| self.singular(q, v, &m))
    }

    fn move_to(
        &mut self,
        h: f64,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> Result<(), SimulationError> {
        self.time_s += h;
        if q.iter().any(|q| !q.is_finite())
            || v.iter().any(|v| v.is_nan() || v.abs() > HIGHEST_SPEED)
        {
            return Err(self.diverged(v.as_slice()));
        }
        self.state.position.copy_from_slice(q.as_slice());
        self.state.velocity.copy_from_slice(v.as_slice());
        Ok(())
    }

    /// Why a matrix has no Cholesky factor.
    fn singular(&self, q: &[f64], v: &[f64], m: &DMatrix<f64>) -> SimulationError {
        if m.iter().all(|value| value.is_finite()) {
            SimulationError::NotPositiveDefinite { time_s: self.time_s, q: q.to_vec() }
        } else {
            self.diverged(v)
        }
    }

    fn diverged(&self, v: &[f64]) -> SimulationError {
        // a joint without a finite speed counts as the fastest
        let speed = |v: f64| if v.is_nan() { f64::INFINITY } else { v.abs() };
        let fastest = (0..v.len()).max_by(|&a, &b| speed(v[a]).total_cmp(&speed(v[b])));
        let fastest = fastest.unwrap_or(0);
        SimulationError::Diverged {
            joint: self.arm.joints()[fastest].clone(),
            time_s: self.time_s,
            speed: v[fastest].abs(),
        }
    }
}

/// One finite number per joint.
pub(crate) fn check_numbers(
    what: &'static str,
    expected: usize,
    found: &[f64],
) -> Result<(), SimulationError> {
    if found.len() == expected && found.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(SimulationError::State { what, expected, found: found.to_vec() })
}

#[cfg(test)]
mod tests {
    use armident_dynamics::inverse_dynamics;

    use super::*;
    use crate::test_arms::{effect, harmonic_at, planar, slider, stanford};

    fn states(dof: usize, t: f64) -> [Vec<f64>; 3] {
        std::array::from_fn(|d| (0..dof).map(|j| harmonic_at(j, t)[d]).collect())
    }

    /// Largest position error at t = 1 s when the exact efforts of the harmonics drive the arm.
    fn error_after_one_second(arm: &SimulatedArm, steps: usize) -> f64 {
        let effort = |t: f64| {
            let [q, v, a] = states(arm.dof(), t);
            let rigid = inverse_dynamics(arm.rigid(), &q, &v, &a);
            (0..arm.dof())
                .map(|j| rigid[j] + arm.smooth_effort(j, q[j], v[j]) + arm.added_inertia(j) * a[j])
                .collect::<Vec<f64>>()
        };
        let [position, velocity, _] = states(arm.dof(), 0.0);
        let start = ArmState { position, velocity };
        let mut stepper = ForwardStepper::new(arm, start, 0.0).unwrap();
        let h = 1.0 / steps as f64;
        for k in 0..steps {
            let t = k as f64 * h;
            let effort =
                StepEffort { start: effort(t), middle: effort(t + 0.5 * h), end: effort(t + h) };
            stepper.step(h, &effort).unwrap();
        }
        let [expected, _, _] = states(arm.dof(), 1.0);
        let errors = stepper.state().position.iter().zip(expected).map(|(f, e)| (f - e).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn fourth_order_without_dry_friction() {
        for (name, arm) in [
            ("planar", planar(&[effect("viscous_friction", "joint_1", 0.4)])),
            ("stanford", stanford(&[effect("rotor_inertia", "joint_5", 0.05)])),
        ] {
            let (coarse, fine) =
                (error_after_one_second(&arm, 100), error_after_one_second(&arm, 200));
            let order = (coarse / fine).log2();
            assert!((order - 4.0).abs() < 0.3, "{name}: order {order}, {coarse:.1e} {fine:.1e}");
            assert!(fine < 1e-6, "{name}: {fine:.1e}");
        }
    }

    /// While no joint changes its direction, Coulomb friction is an offset, which Runge-Kutta can
    /// integrate.
    #[test]
    fn smooth_sliding_agrees_with_runge_kutta_to_second_order() {
        let rubbing = planar(&[
            effect("coulomb_friction", "joint_1", 1.5),
            effect("coulomb_friction", "joint_2", 0.8),
        ]);
        let offset = planar(&[
            effect("torque_offset", "joint_1", 1.5),
            effect("torque_offset", "joint_2", -0.8),
        ]);
        let run = |arm: &SimulatedArm, steps: usize| {
            let start = ArmState { position: vec![0.3, -0.5], velocity: vec![8.0, -6.0] };
            let mut stepper = ForwardStepper::new(arm, start, 0.0).unwrap();
            for _ in 0..steps {
                stepper.step(0.05 / steps as f64, &StepEffort::constant(&[2.0, -1.5])).unwrap();
                assert!(stepper.state().velocity[0] > 0.5 && stepper.state().velocity[1] < -0.5);
            }
            stepper.state().clone()
        };
        let exact = run(&offset, 1000);
        let error = |steps: usize| {
            let found = run(&rubbing, steps);
            let both = found.position.iter().chain(&found.velocity);
            let expected = exact.position.iter().chain(&exact.velocity);
            both.zip(expected).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(50), error(100));
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.2, "order {order}, {coarse:.1e} {fine:.1e}");
    }

    #[test]
    fn friction_above_the_effort_holds_exactly() {
        let arm = planar(&[
            effect("coulomb_friction", "joint_1", 40.0),
            effect("coulomb_friction", "joint_2", 40.0),
        ]);
        let start = ArmState::at_rest(vec![0.7, -0.4]);
        let mut stepper = ForwardStepper::new(&arm, start.clone(), 0.0).unwrap();
        for k in 0..2000 {
            let wobble = 20.0 * (0.01 * f64::from(k)).sin();
            stepper.step(1e-3, &StepEffort::constant(&[wobble, -wobble])).unwrap();
        }
        assert_eq!(*stepper.state(), start);
        assert_eq!(stepper.acceleration(&[10.0, -10.0]).unwrap(), [0.0, 0.0]);
        // one joint breaks away, the other is carried along at rest
        stepper.step(1e-3, &StepEffort::constant(&[0.0, 44.0])).unwrap();
        let velocity = &stepper.state().velocity;
        assert!(velocity[0] == 0.0 && velocity[1] > 0.0, "{velocity:?}");
    }

    #[test]
    fn sliding_mass_stops_at_the_right_time_and_place() {
        let (mass, friction, speed) = (2.0, 3.0, 0.7);
        let arm = slider(&[effect("coulomb_friction", "rail", friction)]);
        let start = ArmState { position: vec![0.1], velocity: vec![speed] };
        let mut stepper = ForwardStepper::new(&arm, start, 0.0).unwrap();
        let step_s = 1e-3;
        let mut stopped_s = 0.0;
        while stepper.time_s() < 1.0 {
            if stepper.state().velocity[0] > 0.0 {
                stopped_s = stepper.time_s();
            }
            stepper.step(step_s, &StepEffort::constant(&[0.0])).unwrap();
        }
        let (time_s, distance) = (mass * speed / friction, mass * speed * speed / (2.0 * friction));
        assert!((stopped_s - time_s).abs() <= step_s, "{stopped_s} {time_s}");
        let found = stepper.state().position[0] - 0.1;
        assert!((found - distance).abs() < 1e-7, "{found} {distance}");
        assert_eq!(stepper.state().velocity, [0.0]);
        assert_eq!(stepper.acceleration(&[2.9]).unwrap(), [0.0]);
        assert!((stepper.acceleration(&[5.0]).unwrap()[0] - 1.0).abs() < 1e-12);
    }

    /// Reversal by a constant force: decelerated by force and friction, accelerated by their
    /// difference.
    #[test]
    fn reversing_mass_keeps_its_time() {
        let arm = slider(&[effect("coulomb_friction", "rail", 3.0)]);
        let start = ArmState { position: vec![0.0], velocity: vec![1.0] };
        let mut stepper = ForwardStepper::new(&arm, start, 0.0).unwrap();
        for _ in 0..1000 {
            stepper.step(1e-3, &StepEffort::constant(&[-5.0])).unwrap();
        }
        // 0.25 s to the stop at 0.125 m, then 0.75 s with 1 m/s2
        let ArmState { position, velocity } = stepper.state();
        assert!((velocity[0] + 0.75).abs() < 1e-4, "{velocity:?}");
        assert!((position[0] - (0.125 - 0.5 * 0.75 * 0.75)).abs() < 1e-4, "{position:?}");
    }
}
