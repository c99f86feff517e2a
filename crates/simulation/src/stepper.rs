//! One step of the motion that efforts cause.

use armident_effects::resting_links;
use nalgebra::{DMatrix, DVector};

use crate::dry_friction::{RowLevels, solve_dry_friction};
use crate::equations::{Equations, EquationsScratch, Rows, row_levels};
use crate::error::SimulationError;
use crate::simulated_arm::{EffectWithParameters, SimulatedArm};
use crate::step_effort::StepEffort;

/// Speed above which a motion counts as diverged \[rad/s or m/s\].
pub const HIGHEST_SPEED: f64 = 1e4;
/// Halvings of a step in which a joint with dry friction stops or reverses.
const HALVINGS: u32 = 4;
/// Longest part of a step, in radians of the fastest vibration of a transmission: twenty parts from
/// one impact to the next.
pub(crate) const LONGEST_VIBRATION: f64 = 0.15;
/// The same, in decay times of its damper.
pub(crate) const LONGEST_DECAY: f64 = 0.3;
/// Travel over which the stiffness of a deflection is taken \[rad or m\].
const SHORT_TRAVEL: f64 = 1e-9;
/// Share of its stiffness below which a deflection carries no vibration.
const SATURATED: f64 = 1e-3;
/// Rounds in which loads and the friction that depends on them agree; two or three are usual.
const LOAD_ROUNDS: usize = 100;
/// Rounds after which secants are given up, as they may circle about a load of 0, where friction has a kink; then each round
/// goes this share of the way, which ends for a load that falls by less than five times the friction that it adds.
const SECANT_ROUNDS: usize = 20;
const DAMPED: f64 = 1.0 / 3.0;
/// Agreement of friction levels between two rounds within a step, and in an instant.
const STEP_AGREEMENT: f64 = 1e-6;
const INSTANT_AGREEMENT: f64 = 1e-13;

/// Position and velocity of all joints: as recorded, of the motor where there is a transmission.
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
    rows: Rows,
    /// Position of every row: links, then motors.
    q: Vec<f64>,
    v: Vec<f64>,
    deflections: Vec<f64>,
    /// What each gear carries, from the last evaluation.
    loads: Vec<f64>,
    state: ArmState,
    time_s: f64,
    rubs: bool,
    scratch: EquationsScratch,
}

impl<'a> ForwardStepper<'a> {
    /// The arm in a state at a time \[s\]. Links behind a transmission start where their weight
    /// twists it, memory starts empty.
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
        let rows = Rows::of(arm);
        let mut q = resting_links(arm.rigid(), arm.transmissions(), &start.position);
        let mut v = start.velocity.clone();
        q.resize(rows.count, 0.0);
        v.resize(rows.count, 0.0);
        for (joint, &row) in rows.recorded.iter().enumerate() {
            q[row] = start.position[joint];
            v[row] = start.velocity[joint];
        }
        Ok(Self {
            arm,
            q,
            v,
            deflections: vec![0.0; arm.deflections().count()],
            loads: vec![0.0; arm.dof()],
            state: start,
            time_s,
            rubs: arm.has_dry_friction() || arm.deflections().next().is_some(),
            scratch: EquationsScratch::new(arm.dof()),
            rows,
        })
    }

    /// Where the arm is and how it moves, as recorded.
    pub fn state(&self) -> &ArmState {
        &self.state
    }

    /// Positions of the links; behind a transmission they are not those of the motors.
    pub fn link_positions(&self) -> &[f64] {
        &self.q[..self.arm.dof()]
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
        let (q, v) = (self.q.clone(), self.v.clone());
        let acceleration = self.instant(&q, &v, self.time_s, effort)?;
        Ok(self.rows.recorded.iter().map(|&row| acceleration[row]).collect())
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
        let parts = self.parts(step_s)?;
        if parts == 1 {
            return self.one_step(step_s, effort);
        }
        self.in_parts(parts, step_s, effort, Self::one_step)
    }

    /// Steps of equal length in place of one.
    fn in_parts(
        &mut self,
        parts: usize,
        h: f64,
        effort: &StepEffort,
        step: impl Fn(&mut Self, f64, &StepEffort) -> Result<(), SimulationError>,
    ) -> Result<(), SimulationError> {
        let share = |k: usize| k as f64 / parts as f64;
        for k in 0..parts {
            step(self, h / parts as f64, &effort.part(share(k), share(k + 1)))?;
        }
        Ok(())
    }

    fn one_step(&mut self, h: f64, effort: &StepEffort) -> Result<(), SimulationError> {
        if self.rubs {
            self.friction_step(h, effort, HALVINGS)
        } else {
            self.smooth_step(h, effort)
        }
    }

    /// Parts of a step that are short beside the vibrations of the transmissions, and of the deflections that
    /// carry on their way.
    fn parts(&mut self, step_s: f64) -> Result<usize, SimulationError> {
        let carries: Vec<bool> = self
            .arm
            .deflections()
            .zip(&self.deflections)
            .map(|((joint, law), &deflection)| {
                let velocity = self.v[self.rows.recorded[joint]];
                let [now, full] = [deflection, -velocity.signum()]
                    .map(|deflection| stiffness(law, deflection, velocity.signum()));
                velocity == 0.0 || now > SATURATED * full
            })
            .collect();
        if !self.arm.has_transmissions() && !carries.contains(&true) {
            return Ok(1);
        }
        self.parts_at(step_s, |k| carries[k])
    }

    /// The same where these deflections carry as on the way back from their saturation.
    fn parts_at(
        &mut self,
        step_s: f64,
        carries: impl Fn(usize) -> bool,
    ) -> Result<usize, SimulationError> {
        let (q, v) = (self.q.clone(), self.v.clone());
        let inertia = self.equations(&q, &v, self.time_s, &self.deflections.clone()).inertia;
        let factor = inertia.clone().cholesky().ok_or_else(|| self.singular(&q, &v, &inertia))?;
        let mobility = factor.inverse();
        let mut parts = 1.0_f64;
        let mut divide = |stiffness: f64, damping: f64, mobility: f64| {
            let vibration = (stiffness * mobility).sqrt() / LONGEST_VIBRATION;
            let decay = damping * mobility / LONGEST_DECAY;
            parts = parts.max(step_s * vibration).max(step_s * decay);
        };
        for (joint, &row) in self.rows.recorded.iter().enumerate() {
            let Some(transmission) = self.arm.transmission(joint) else { continue };
            let twist =
                mobility[(joint, joint)] + mobility[(row, row)] - 2.0 * mobility[(joint, row)];
            divide(transmission.stiffness, transmission.damping, twist);
        }
        for (_, (joint, law)) in self.arm.deflections().enumerate().filter(|(k, _)| carries(*k)) {
            let row = self.rows.recorded[joint];
            let damping = law.effect.deflection_effort(&law.parameters, -1.0, 1.0)
                - law.effect.deflection_effort(&law.parameters, -1.0, 0.0);
            divide(stiffness(law, -1.0, 1.0), damping, mobility[(row, row)]);
        }
        Ok(parts.ceil() as usize)
    }

    /// Classical Runge-Kutta of fourth order.
    fn smooth_step(&mut self, h: f64, effort: &StepEffort) -> Result<(), SimulationError> {
        let q = DVector::from_column_slice(&self.q);
        let v = DVector::from_column_slice(&self.v);
        let start_s = self.time_s;
        let mut slope = |q: DVector<f64>, v: DVector<f64>, share: f64, effort: &[f64]| {
            self.smooth_instant(q.as_slice(), v.as_slice(), start_s + share * h, effort)
        };
        let half = 0.5 * h;
        let k1 = slope(q.clone(), v.clone(), 0.0, &effort.start)?;
        let k2 = slope(&q + &v * half, &v + &k1 * half, 0.5, &effort.middle)?;
        let mid_q = &q + &v * half + &k1 * (half * half);
        let k3 = slope(mid_q, &v + &k2 * half, 0.5, &effort.middle)?;
        let k4 = slope(&q + &v * h + &k2 * (h * half), &v + &k3 * h, 1.0, &effort.end)?;
        let next_q = q + v.clone() * h + (&k1 + &k2 + &k3) * (h * h / 6.0);
        let next_v = v + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        self.move_to(h, &next_q, &next_v)
    }

    /// Midpoint rule with implicit dry friction; deflections follow the travel exactly.
    fn friction_step(
        &mut self,
        h: f64,
        effort: &StepEffort,
        halvings: u32,
    ) -> Result<(), SimulationError> {
        let (q, v, z) = (self.q.clone(), self.v.clone(), self.deflections.clone());
        let (half, start_s) = (0.5 * h, self.time_s);
        let (mid_v, _) = self.impulse(start_s, &q, &v, &z, &v, half, &effort.start)?;
        let mid_q: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + half * v).collect();
        let mid_z = self.deflected(&z, &q, &mid_q);
        let (next_v, levels) =
            self.impulse(start_s + half, &mid_q, mid_v.as_slice(), &mid_z, &v, h, &effort.middle)?;
        if halvings > 0 && levels.stops(&v, next_v.as_slice()) {
            let [first, second] = effort.halves();
            self.friction_step(half, &first, halvings - 1)?;
            return self.friction_step(half, &second, halvings - 1);
        }
        // a deflection lets go before a reversal and carries after it: too much of it may undo the reversal
        if self.turns(&v, mid_v.as_slice()) || self.turns(&v, next_v.as_slice()) {
            let parts = self.parts_at(h, |_| true)?;
            if parts > 1 {
                return self.in_parts(parts, h, effort, |s, h, e| s.friction_step(h, e, halvings));
            }
        }
        let next_q = q.iter().zip(&v).zip(&next_v).map(|((q, v), w)| q + half * (v + w));
        let next_q = DVector::from_iterator(q.len(), next_q);
        self.deflections = self.deflected(&z, &q, next_q.as_slice());
        self.move_to(h, &next_q, &next_v)
    }

    /// Whether a joint with a deflection reverses between two velocities.
    fn turns(&self, before: &[f64], after: &[f64]) -> bool {
        self.arm.deflections().any(|(joint, _)| {
            let row = self.rows.recorded[joint];
            before[row] * after[row] < 0.0
        })
    }

    /// Deflections after a travel of all rows.
    fn deflected(&self, deflections: &[f64], from: &[f64], to: &[f64]) -> Vec<f64> {
        let laws = self.arm.deflections().zip(deflections);
        laws.map(|((joint, law), &deflection)| {
            let row = self.rows.recorded[joint];
            law.effect.deflection_after(&law.parameters, deflection, to[row] - from[row])
        })
        .collect()
    }

    fn equations(&mut self, q: &[f64], v: &[f64], time_s: f64, z: &[f64]) -> Equations {
        Equations::at(self.arm, &self.rows, time_s, q, v, z, &mut self.scratch)
    }

    /// Efforts on their rows.
    fn on_rows(&self, effort: &[f64]) -> DVector<f64> {
        let mut on_rows = DVector::zeros(self.rows.count);
        self.rows.recorded.iter().zip(effort).for_each(|(&row, effort)| on_rows[row] = *effort);
        on_rows
    }

    /// Velocity after `h` from `before`: `M (w - before) = h (τ - b - λ)`, `λ_j ∈ level_j Sign(w_j)`,
    /// with `M`, `b` and the levels at `q`, `v`; and these levels.
    fn impulse(
        &mut self,
        time_s: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
        before: &[f64],
        h: f64,
        effort: &[f64],
    ) -> Result<(DVector<f64>, RowLevels), SimulationError> {
        let equations = self.equations(q, v, time_s, z);
        let m = &equations.inertia;
        let before_v = DVector::from_column_slice(before);
        let free = self.on_rows(effort) - &equations.bias;
        let driving = free.amax();
        let r = m * &before_v + free * h;
        let mut secant = Secant::default();
        for _ in 0..LOAD_ROUNDS {
            let levels = row_levels(self.arm, &self.rows, v, &self.loads);
            let w = solve_dry_friction(m, &r, &levels.times(h), before)
                .ok_or_else(|| self.singular(q, v, m))?;
            let acceleration = (&w - &before_v) / h;
            let found = equations.loads(self.arm, acceleration.as_slice());
            let next = row_levels(self.arm, &self.rows, v, &found);
            if agree(&levels, &next, STEP_AGREEMENT, driving) {
                self.loads = found;
                return Ok((w, levels));
            }
            self.loads = secant.next(&self.loads, &found);
        }
        Err(self.diverged(v))
    }

    /// Accelerations at a state without dry friction.
    fn smooth_instant(
        &mut self,
        q: &[f64],
        v: &[f64],
        time_s: f64,
        effort: &[f64],
    ) -> Result<DVector<f64>, SimulationError> {
        let equations = self.equations(q, v, time_s, &[]);
        let driving = self.on_rows(effort) - &equations.bias;
        let factor = equations.inertia.clone().cholesky();
        let factor = factor.ok_or_else(|| self.singular(q, v, &equations.inertia))?;
        Ok(factor.solve(&driving))
    }

    /// Accelerations at a state: rows in motion have their friction, rows at rest may stick.
    fn instant(
        &mut self,
        q: &[f64],
        v: &[f64],
        time_s: f64,
        effort: &[f64],
    ) -> Result<DVector<f64>, SimulationError> {
        let equations = self.equations(q, v, time_s, &self.deflections.clone());
        let m = &equations.inertia;
        let free = self.on_rows(effort) - &equations.bias;
        let rest = vec![0.0; v.len()];
        let mut secant = Secant::default();
        for _ in 0..LOAD_ROUNDS {
            let levels = row_levels(self.arm, &self.rows, v, &self.loads);
            let mut driving = free.clone();
            let mut resting = RowLevels::none(v.len());
            for (row, level) in levels.rows.iter().enumerate() {
                driving[row] -= level.effort(v[row]);
                if v[row] == 0.0 {
                    resting.rows[row] = *level;
                }
            }
            for pair in &levels.pairs {
                let speed = pair.speed(v);
                if pair.rests(v) {
                    resting.pairs.push(*pair);
                } else {
                    driving[pair.b] -= pair.level * speed.signum();
                    driving[pair.a] -= pair.ratio * pair.level * speed.signum();
                }
            }
            let acceleration = solve_dry_friction(m, &driving, &resting, &rest)
                .ok_or_else(|| self.singular(q, v, m))?;
            let found = equations.loads(self.arm, acceleration.as_slice());
            let next = row_levels(self.arm, &self.rows, v, &found);
            if agree(&levels, &next, INSTANT_AGREEMENT, free.amax()) {
                self.loads = found;
                return Ok(acceleration);
            }
            self.loads = secant.next(&self.loads, &found);
        }
        Err(self.diverged(v))
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
        self.q.copy_from_slice(q.as_slice());
        self.v.copy_from_slice(v.as_slice());
        for (joint, &row) in self.rows.recorded.iter().enumerate() {
            self.state.position[joint] = self.q[row];
            self.state.velocity[joint] = self.v[row];
        }
        Ok(())
    }

    /// Why a matrix has no Cholesky factor.
    fn singular(&self, q: &[f64], v: &[f64], m: &DMatrix<f64>) -> SimulationError {
        if m.iter().all(|value| value.is_finite()) {
            let q = q[..self.arm.dof()].to_vec();
            SimulationError::NotPositiveDefinite { time_s: self.time_s, q }
        } else {
            self.diverged(v)
        }
    }

    fn diverged(&self, v: &[f64]) -> SimulationError {
        // a joint without a finite speed counts as the fastest
        let speed = |joint: usize| {
            let v = v[self.rows.recorded[joint]];
            if v.is_nan() { f64::INFINITY } else { v.abs() }
        };
        let fastest = (0..self.arm.dof()).max_by(|&a, &b| speed(a).total_cmp(&speed(b)));
        let fastest = fastest.unwrap_or(0);
        SimulationError::Diverged {
            joint: self.arm.joints()[fastest].clone(),
            time_s: self.time_s,
            speed: v[self.rows.recorded[fastest]].abs(),
        }
    }
}

/// Effort that a deflection gains by a short travel in a direction, over the travel.
fn stiffness(law: &EffectWithParameters, deflection: f64, direction: f64) -> f64 {
    let after = law.effect.deflection_after(&law.parameters, deflection, direction * SHORT_TRAVEL);
    let [before, after] = [deflection, after]
        .map(|deflection| law.effect.deflection_effort(&law.parameters, deflection, 0.0));
    (after - before).abs() / SHORT_TRAVEL
}

/// Loads that give themselves back: the secant of each joint. While directions hold, a load is linear
/// in the friction that depends on it, so that for one such joint the second round is exact.
#[derive(Default)]
struct Secant {
    before: Option<(Vec<f64>, Vec<f64>)>,
    rounds: usize,
}

impl Secant {
    fn next(&mut self, tried: &[f64], found: &[f64]) -> Vec<f64> {
        self.rounds += 1;
        let before = self.before.replace((tried.to_vec(), found.to_vec()));
        if self.rounds > SECANT_ROUNDS {
            let damped = |(t, f): (&f64, &f64)| t + DAMPED * (f - t);
            return tried.iter().zip(found).map(damped).collect();
        }
        let Some((tried_before, found_before)) = before else { return found.to_vec() };
        let next = |j: usize| secant([tried_before[j], found_before[j]], [tried[j], found[j]]);
        (0..tried.len()).map(next).collect()
    }
}

/// Where a number gives itself back, from two rounds, each of what was tried and what was found.
pub(crate) fn secant([tried_before, found_before]: [f64; 2], [tried, found]: [f64; 2]) -> f64 {
    let slope = (found - found_before) / (tried - tried_before);
    // a slope near 1 has no fixed point nearby
    if slope.is_finite() && (1.0 - slope).abs() > 0.05 {
        tried + (found - tried) / (1.0 - slope)
    } else {
        found
    }
}

/// Whether the levels of all rows are the same up to a relative difference, or up to the rounding of the efforts that drive the
/// arm: where a load passes through 0, so does the friction that depends on it.
fn agree(a: &RowLevels, b: &RowLevels, tolerance: f64, driving: f64) -> bool {
    let rounding = INSTANT_AGREEMENT * driving;
    let near = |a: f64, b: f64| (a - b).abs() <= tolerance * a.abs().max(b.abs()) + rounding;
    let rows = a.rows.iter().zip(&b.rows);
    rows.into_iter().all(|(a, b)| near(a.forward, b.forward) && near(a.backward, b.backward))
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
    use armident_effects::{DryFriction, EffectOnJoint};

    use super::*;
    use crate::test_arms::{effect, harmonic_at, planar, slider, stanford};

    /// Friction of a load that passes through 0 is equal up to the rounding of what drives the arm, and no further.
    #[test]
    fn levels_near_zero_agree_up_to_rounding() {
        let of = |level: f64| RowLevels { rows: vec![DryFriction::both(level)], pairs: Vec::new() };
        let (a, b) = (of(1e-12), of(1e-12 + 1e-16));
        assert!(agree(&a, &b, INSTANT_AGREEMENT, 0.5));
        assert!(!agree(&a, &b, INSTANT_AGREEMENT, 1e-6));
        assert!(!agree(&of(1.0), &of(1.0 + 1e-12), INSTANT_AGREEMENT, 0.5));
    }

    fn states(dof: usize, t: f64) -> [Vec<f64>; 3] {
        std::array::from_fn(|d| (0..dof).map(|j| harmonic_at(j, t)[d]).collect())
    }

    /// Largest position error at t = 1 s when the exact efforts of the harmonics drive the arm.
    fn error_after_one_second(arm: &SimulatedArm, steps: usize) -> f64 {
        let effort = |t: f64| {
            let [q, v, a] = states(arm.dof(), t);
            let rigid = inverse_dynamics(arm.rigid(), &q, &v, &a);
            (0..arm.dof())
                .map(|j| {
                    rigid[j] + arm.smooth_effort(j, t, q[j], v[j]) + arm.added_inertia(j) * a[j]
                })
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
    fn smooth_sliding_agrees_with_runge_kutta() {
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
    fn friction_above_effort_holds_exactly() {
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
    fn sliding_mass_stops_at_exact_time_and_place() {
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

    /// Bristles of a micrometre, far stiffer than a step can follow: the motion is that of Coulomb friction but for
    /// the travel of the bristle at each reversal.
    #[test]
    fn stiff_bristles_move_like_dry_friction() {
        let (level, travel) = (3.0, 1e-6);
        let run = |law: EffectOnJoint, steps: usize| {
            let arm = slider(&[law]);
            let start = ArmState::at_rest(vec![0.0]);
            let mut stepper = ForwardStepper::new(&arm, start, 0.0).unwrap();
            let h = 2.0 / steps as f64;
            let mut positions = Vec::new();
            for k in 0..steps {
                let effort = |t: f64| vec![if t < 1.6 { 8.0 * (9.0 * t).sin() } else { 0.0 }];
                let t = k as f64 * h;
                let effort = StepEffort {
                    start: effort(t),
                    middle: effort(t + 0.5 * h),
                    end: effort(t + h),
                };
                stepper.step(h, &effort).unwrap();
                positions.push(stepper.state().position[0]);
            }
            positions
        };
        let every = |positions: Vec<f64>, n: usize| -> Vec<f64> {
            positions.into_iter().skip(n - 1).step_by(n).collect()
        };
        let largest =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let dry = run(effect("coulomb_friction", "rail", level), 2000);
        assert!(largest(&dry, &[0.0; 2000]) > 0.1);
        let stiffness = level / travel;
        for damping in [0.0, 1e-3 * stiffness] {
            let bristle =
                EffectOnJoint::new("presliding_hysteresis", "rail", [level, stiffness, damping]);
            let found = run(bristle.clone(), 2000);
            let by_short_steps = every(run(bristle, 40_000), 20);
            let off = largest(&found, &by_short_steps);
            assert!(off < 1e-5, "{damping}: {off:.1e} m off short steps");
            let off = largest(&found, &dry);
            assert!(off < 1e-3, "{damping}: {off:.1e} m off dry friction");
        }
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
