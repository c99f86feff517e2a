//! Output error of one joint: what its simulated positions leave of the recorded ones, at its minimum.
//!
//! Method: the joint is simulated under its commands with the load of the recorded motion of all joints; Levenberg-Marquardt with
//! one-sided differences and the weights of Cauchy, so that intervals in which something else holds the joint count little. The
//! position and velocity at the start of each recording are fitted too and eliminated (variable projection): a recorded start is
//! noisy, its velocity is known from one side only, and what follows from them looks like a delay. Standard errors by the
//! one-step jackknife over recordings, which are divided where they are few.
//!
//! References: L. Ljung, System Identification, 2nd ed. (1999), section 7.2; J. J. Moré, The Levenberg-Marquardt algorithm
//! (1978); G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973); for the errors B. Efron, R. J. Tibshirani, An Introduction to
//! the Bootstrap (1993), section 11.

use armident_dynamics::RigidArm;
use armident_effects::{Effect, EffectOnJoint, PositionControl, PositionServo};
use armident_inference::{FEWEST_BLOCKS, variance};
use armident_numeric::Cholesky;
use armident_simulation::{ServoJoint, SimulatedArm};
use rayon::prelude::*;

use super::commands::LONGEST_LAG_S;
use super::joint_data::JointData;
use super::parameters::{ServoParameter, Values, effects};
use super::start::{CAUCHY, Start, load_range};

/// Longest step of a simulation \[s\].
const STEP_S: f64 = 2.5e-3;
/// A step that lowers the cost by less than this share of what one sample costs ends the fit: a parameter one standard error away
/// from the minimum costs what one sample does.
const LEAST_GAIN: f64 = 1e-2;
/// Fewest blocks that recordings are divided into: with so many the quantile of Student's t is within a tenth of the normal one.
pub(super) const BLOCKS: usize = 16;
/// Largest share of the load that dry friction may take: at 1 a gear locks itself.
const MOST_LOAD_FRICTION: f64 = 0.95;

/// What a simulated joint is part of: an arm of one joint, whose own dynamics are never used.
#[derive(Debug, Clone)]
pub(super) struct Carrier(RigidArm);

const JOINT: &str = "joint";

impl Carrier {
    pub(super) fn of(data: &[JointData]) -> Self {
        use armident_kinematics::DrivingAxisFrame;
        let frame = DrivingAxisFrame { b_m: 0.0, d_m: 0.0, beta_rad: 0.0, theta_rad: 0.0 };
        let kind = data[0].kind;
        Self(RigidArm {
            joints: vec![armident_dynamics::JointGeometry::new(kind, frame)],
            links: vec![armident_kinematics::InertialParameters::from_array(&[0.0; 10])],
            gravity_e0: nalgebra::Vector3::zeros(),
        })
    }
}

/// Position and velocity at the start of a recording.
pub(super) type StartState = [f64; 2];

/// As they were recorded, the velocity low-passed.
pub(super) fn recorded_starts(data: &[JointData]) -> Vec<StartState> {
    data.iter().map(|d| [d.position[0], d.velocity[0]]).collect()
}

/// Simulated minus recorded positions: `[recording][sample]`.
pub(super) fn position_errors(
    arm: &Carrier,
    data: &[JointData],
    (x, starts): (&Values, &[StartState]),
    error_limit: Option<f64>,
) -> Vec<Vec<f64>> {
    let stiffness = 1.0 / x[ServoParameter::Compliance as usize];
    let servo = PositionServo {
        stiffness,
        delay_s: x[ServoParameter::Delay as usize],
        dead_band: 0.0,
        effort_limit: error_limit.map(|error| error * stiffness),
    };
    let mut effects = effects(x, stiffness, JOINT);
    effects.push(EffectOnJoint::new(PositionControl.slug(), JOINT, servo.parameters()));
    let impossible = || data.iter().map(|d| vec![f64::INFINITY; d.position.len()]).collect();
    let Ok(simulated) = SimulatedArm::new(arm.0.clone(), &[JOINT], &effects) else {
        return impossible();
    };
    let Ok(joint) = ServoJoint::of(&simulated, 0) else { return impossible() };
    let of = |(d, start): (&JointData, &StartState)| {
        let positions = joint.simulate(&d.drive(), *start, STEP_S);
        positions.iter().zip(&d.position).map(|(s, q)| s - q).collect()
    };
    data.par_iter().zip(starts).map(of).collect()
}

/// The fit of one joint to its recordings.
pub(super) struct OutputError<'a> {
    pub(super) arm: Carrier,
    data: &'a [JointData],
    pub(super) error_limit: Option<f64>,
    pub(super) sample_s: f64,
    pub(super) resolution: f64,
    load: f64,
    /// residual beyond which its size counts rather than its square \[rad or m\]: inside the band of dry friction a position
    /// depends on how it was reached, beyond it something else holds the joint
    scale: f64,
}

/// A minimum of the cost.
pub(super) struct Minimum {
    pub(super) x: Values,
    /// of each recording
    pub(super) starts: Vec<StartState>,
    pub(super) cost: f64,
}

/// How well a minimum is known.
pub(super) struct Spread {
    /// standard errors of free parameters
    pub(super) errors: [Option<f64>; 9],
    /// correlation of delay and damping between blocks of the recordings
    pub(super) delay_with_damping: Option<f64>,
    pub(super) blocks: usize,
}

impl<'a> OutputError<'a> {
    pub(super) fn of(data: &'a [JointData], start: &Start) -> Self {
        let resolution = data.iter().map(|d| d.resolution).fold(0.0, f64::max);
        let limits: Vec<f64> = data.iter().filter_map(|d| d.error_limit).collect();
        let mean = |limits: &[f64]| limits.iter().sum::<f64>() / limits.len() as f64;
        Self {
            arm: Carrier::of(data),
            data,
            error_limit: (!limits.is_empty()).then(|| mean(&limits)),
            sample_s: data.iter().map(|d| d.sample_s).fold(f64::INFINITY, f64::min),
            resolution,
            load: load_range(data).max(f64::MIN_POSITIVE),
            scale: start.dry.max(CAUCHY * resolution),
        }
    }
}

impl OutputError<'_> {
    /// Size of residuals: of the same cost if all were equal \[rad or m\].
    pub(super) fn size(&self, residual: &[Vec<f64>]) -> f64 {
        let samples = residual.iter().map(Vec::len).sum::<usize>().max(1);
        self.scale * (self.cost(residual) / samples as f64).exp_m1().sqrt()
    }

    /// Position errors, and how far the velocity at the start of each recording is from the recorded one, as the path of a sample:
    /// it is known about as well as one difference of positions.
    fn residuals(&self, x: &Values, starts: &[StartState]) -> Vec<Vec<f64>> {
        let mut all = position_errors(&self.arm, self.data, (x, starts), self.error_limit);
        for ((residual, d), start) in all.iter_mut().zip(self.data).zip(starts) {
            residual.push((start[1] - d.velocity[0]) * d.sample_s);
        }
        all
    }

    /// A change that recordings resolve.
    fn small_change(&self, x: &Values, p: ServoParameter) -> f64 {
        let size = x[p as usize].abs();
        let least = match p {
            ServoParameter::Compliance => self.resolution / self.load,
            ServoParameter::Offset | ServoParameter::DryFriction | ServoParameter::StaticExcess => {
                self.resolution
            }
            ServoParameter::Damping | ServoParameter::Delay => self.sample_s,
            ServoParameter::Inertia => self.sample_s.powi(2),
            ServoParameter::StribeckVelocity => self.resolution / self.sample_s,
            ServoParameter::LoadFriction => 0.1,
        };
        0.05 * size.max(least)
    }

    /// Into what a joint may have. An inertia whose time constant with the damping is below a quarter of a sample is not seen,
    /// and a Stribeck velocity below a step of the encoder a sample neither.
    fn admissible(&self, mut x: Values) -> Values {
        let floor = |x: &mut f64, least: f64| *x = x.max(least);
        floor(&mut x[ServoParameter::Compliance as usize], 1e-3 * self.resolution / self.load);
        for p in [
            ServoParameter::DryFriction,
            ServoParameter::Damping,
            ServoParameter::Delay,
            ServoParameter::StaticExcess,
            ServoParameter::LoadFriction,
        ] {
            floor(&mut x[p as usize], 0.0);
        }
        let delay = &mut x[ServoParameter::Delay as usize];
        *delay = delay.min(LONGEST_LAG_S);
        let damping = x[ServoParameter::Damping as usize];
        let least = 0.25 * self.sample_s * damping.max(0.25 * self.sample_s);
        floor(&mut x[ServoParameter::Inertia as usize], least);
        floor(
            &mut x[ServoParameter::StribeckVelocity as usize],
            0.25 * self.resolution / self.sample_s,
        );
        let by_load = &mut x[ServoParameter::LoadFriction as usize];
        *by_load = by_load.min(MOST_LOAD_FRICTION);
        x
    }

    /// Weights of Cauchy.
    fn weights(&self, residuals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let weight = |r: &f64| 1.0 / (1.0 + (r / self.scale).powi(2));
        residuals.iter().map(|r| r.iter().map(weight).collect()).collect()
    }

    /// The cost that these weights minimise.
    fn cost(&self, residual: &[Vec<f64>]) -> f64 {
        let of = |r: &f64| (r / self.scale).powi(2).ln_1p();
        let sum: f64 = residual.iter().flatten().map(of).sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    }

    /// The minimum near a point over the free parameters and the starts of the recordings.
    pub(super) fn fit(
        &self,
        x: Values,
        starts: &[StartState],
        free: &[ServoParameter],
        most_steps: usize,
    ) -> Minimum {
        let mut x = self.admissible(x);
        let mut starts = starts.to_vec();
        let mut residual = self.residuals(&x, &starts);
        let samples = residual.iter().map(Vec::len).sum::<usize>().max(1);
        let least_gain = LEAST_GAIN / samples as f64;
        let mut damping = 1e-2;
        for _ in 0..most_steps {
            let weights = self.weights(&residual);
            let cost = self.cost(&residual);
            let jacobian = self.jacobian(&x, &starts, &residual, free);
            let of_starts = self.start_columns(&x, &starts, &residual, &weights);
            let without = without_starts(jacobian.clone(), &of_starts, &weights);
            let (matrix, gradient) = normal_equations(&without, &residual, &weights);
            let mut is_better = false;
            while damping < 1e8 {
                let entry = |i: usize, j: usize| {
                    if i == j {
                        matrix[i][j] * (1.0 + damping) + f64::MIN_POSITIVE
                    } else {
                        matrix[i][j]
                    }
                };
                let Some(factor) = Cholesky::of(free.len(), entry) else {
                    damping = (10.0 * damping).max(1e-6);
                    continue;
                };
                let step = factor.solve(&gradient);
                let mut next = x;
                for (p, step) in free.iter().zip(&step) {
                    next[*p as usize] -= step;
                }
                let next = self.admissible(next);
                let mut next_starts = starts.clone();
                for (r, start) in next_starts.iter_mut().enumerate() {
                    let mut expected = residual[r].clone();
                    for (column, step) in jacobian.iter().zip(&step) {
                        expected.iter_mut().zip(&column[r]).for_each(|(e, c)| *e -= step * c);
                    }
                    let change = of_starts[r].coefficients(&expected, &weights[r]);
                    start.iter_mut().zip(change).for_each(|(s, c)| *s -= c / (1.0 + damping));
                }
                let changed = self.residuals(&next, &next_starts);
                let lower = self.cost(&changed);
                if lower < cost {
                    is_better = lower < (1.0 - least_gain) * cost;
                    (x, starts, residual) = (next, next_starts, changed);
                    damping *= 0.2;
                    break;
                }
                damping *= 5.0;
            }
            if !is_better {
                break;
            }
        }
        let cost = self.cost(&residual);
        Minimum { x, starts, cost }
    }

    /// Standard errors of a minimum, by the jackknife.
    pub(super) fn spread(&self, minimum: &Minimum, free: &[ServoParameter]) -> Spread {
        let estimates = self.without_blocks(minimum, free);
        let column = |p: ServoParameter| -> Option<Vec<f64>> {
            let at = free.iter().position(|other| *other == p)?;
            Some(estimates.iter().map(|e| e[at]).collect())
        };
        let mut errors = [None; 9];
        let mut delay_with_damping = None;
        if estimates.len() >= FEWEST_BLOCKS {
            for p in free {
                errors[*p as usize] = column(*p).map(|of| variance(&of).sqrt());
            }
            delay_with_damping = column(ServoParameter::Delay)
                .zip(column(ServoParameter::Damping))
                .and_then(|(delay, damping)| correlation(&delay, &damping));
        }
        Spread { errors, delay_with_damping, blocks: estimates.len() }
    }

    /// `[parameter][recording][sample]`
    fn jacobian(
        &self,
        x: &Values,
        starts: &[StartState],
        residual: &[Vec<f64>],
        free: &[ServoParameter],
    ) -> Vec<Vec<Vec<f64>>> {
        let column = |p: &ServoParameter| {
            let change = self.small_change(x, *p);
            let mut moved = *x;
            moved[*p as usize] += change;
            slopes(&self.residuals(&moved, starts), residual, change)
        };
        free.par_iter().map(column).collect()
    }

    /// Columns of the state at the start of each recording.
    fn start_columns(
        &self,
        x: &Values,
        starts: &[StartState],
        residual: &[Vec<f64>],
        weights: &[Vec<f64>],
    ) -> Vec<StartColumns> {
        let moved = |part: usize, change: f64| {
            let mut moved = starts.to_vec();
            moved.iter_mut().for_each(|start| start[part] += change);
            slopes(&self.residuals(x, &moved), residual, change)
        };
        let change = 0.05 * self.resolution;
        let position = moved(0, change);
        let velocity = moved(1, change / self.sample_s);
        let columns = position.into_iter().zip(velocity).zip(weights);
        columns.map(|((q, v), weights)| StartColumns::of([q, v], weights)).collect()
    }

    /// Changes of the estimates by one step without each block of the recordings; none where a block determines a parameter
    /// alone.
    fn without_blocks(&self, minimum: &Minimum, free: &[ServoParameter]) -> Vec<Vec<f64>> {
        let Minimum { x, starts, .. } = minimum;
        let residual = &self.residuals(x, starts)[..];
        let weights = &self.weights(residual)[..];
        let of_starts = self.start_columns(x, starts, residual, weights);
        let jacobian = self.jacobian(x, starts, residual, free);
        let jacobian = without_starts(jacobian, &of_starts, weights);
        let parts = BLOCKS.div_ceil(self.data.len().max(1));
        let mut estimates: Vec<Vec<f64>> = Vec::new();
        let (whole, _) = normal_equations(&jacobian, residual, weights);
        for recording in 0..residual.len() {
            let n = residual[recording].len();
            for part in 0..parts {
                let of = part * n / parts..(part + 1) * n / parts;
                let cut = |all: &[Vec<f64>]| vec![all[recording][of.clone()].to_vec()];
                let columns: Vec<Vec<Vec<f64>>> = jacobian.iter().map(|c| cut(c)).collect();
                let (own, gradient) = normal_equations(&columns, &cut(residual), &cut(weights));
                let entry = |i: usize, j: usize| {
                    let rest = whole[i][j] - own[i][j];
                    if i == j { rest + 1e-9 * whole[i][i] + f64::MIN_POSITIVE } else { rest }
                };
                // without a block the gradient at the minimum is the negative of the block's
                let Some(factor) = Cholesky::of(free.len(), entry) else { return Vec::new() };
                estimates.push(factor.solve(&gradient));
            }
        }
        estimates
    }
}

/// `[recording][sample]`
fn slopes(moved: &[Vec<f64>], residual: &[Vec<f64>], change: f64) -> Vec<Vec<f64>> {
    let slope =
        |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) / change).collect();
    moved.iter().zip(residual).map(slope).collect()
}

/// What the state at the start of a recording does to its residuals: columns of position and velocity, made orthogonal.
struct StartColumns {
    /// of unit weighted length; empty where a state does nothing
    unit: [Vec<f64>; 2],
    /// columns = unit · upper triangle
    triangle: [f64; 3],
}

impl StartColumns {
    fn of([position, mut velocity]: [Vec<f64>; 2], weights: &[f64]) -> Self {
        let unit = |mut column: Vec<f64>| -> (Vec<f64>, f64) {
            let length = weighted(&column, &column, weights).sqrt();
            if !(length > 0.0 && length.is_finite()) {
                return (Vec::new(), 0.0);
            }
            column.iter_mut().for_each(|x| *x /= length);
            (column, length)
        };
        let (position, length) = unit(position);
        let shared = weighted(&position, &velocity, weights);
        velocity.iter_mut().zip(&position).for_each(|(v, q)| *v -= shared * q);
        let (velocity, rest) = unit(velocity);
        Self { unit: [position, velocity], triangle: [length, shared, rest] }
    }

    /// The change of position and velocity that explains most of a series.
    fn coefficients(&self, series: &[f64], weights: &[f64]) -> StartState {
        let [position, velocity] = [0, 1].map(|k| weighted(&self.unit[k], series, weights));
        let [length, shared, rest] = self.triangle;
        let over = |x: f64, length: f64| if length > 0.0 { x / length } else { 0.0 };
        let velocity = over(velocity, rest);
        [over(position - shared * velocity, length), velocity]
    }

    fn remove_from(&self, series: &mut [f64], weights: &[f64]) {
        for unit in &self.unit {
            let shared = weighted(unit, series, weights);
            series.iter_mut().zip(unit).for_each(|(x, u)| *x -= shared * u);
        }
    }
}

/// Columns of parameters without what the starts of the recordings explain.
fn without_starts(
    mut jacobian: Vec<Vec<Vec<f64>>>,
    of_starts: &[StartColumns],
    weights: &[Vec<f64>],
) -> Vec<Vec<Vec<f64>>> {
    for column in &mut jacobian {
        for ((series, of_start), weights) in column.iter_mut().zip(of_starts).zip(weights) {
            of_start.remove_from(series, weights);
        }
    }
    jacobian
}

fn weighted(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), w)| w * a * b).sum()
}

/// Correlation of two series; none of a constant one.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (a_mean, b_mean) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| of(a - a_mean, b - b_mean)).sum()
    };
    let size = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    (size > 0.0).then(|| sum(&|a, b| a * b) / size)
}

/// `JᵀWJ` and `JᵀWr`.
fn normal_equations(
    jacobian: &[Vec<Vec<f64>>],
    residual: &[Vec<f64>],
    weights: &[Vec<f64>],
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let product = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
        a.iter().zip(b).zip(weights).map(|((a, b), w)| weighted(a, b, w)).sum()
    };
    let n = jacobian.len();
    let mut matrix = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            matrix[i][j] = product(&jacobian[i], &jacobian[j]);
            matrix[j][i] = matrix[i][j];
        }
    }
    (matrix, jacobian.iter().map(|column| product(column, residual)).collect())
}
