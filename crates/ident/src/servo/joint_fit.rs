//! Controller and friction of one joint, by its simulated positions.
//!
//! Method: output error. The joint is simulated under its commands from its first position on, with the load of the recorded
//! motion of all joints; Levenberg-Marquardt with one-sided differences and the weights of Cauchy,
//! so that intervals in which something else holds the joint count little. Standard errors by the one-step jackknife over recordings, which are divided
//! where they are few. Laws of dry friction are added one after another as long as the 95 % interval of their parameter
//! excludes 0.
//!
//! References: L. Ljung, System Identification, 2nd ed. (1999), section 7.2; J. J. Moré, The Levenberg-Marquardt algorithm
//! (1978); for the errors B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap (1993), section 11.

use armident_dynamics::RigidArm;
use armident_effects::{
    CoulombFriction, Effect, EffectOnJoint, LoadDependentFriction, PositionControl, PositionServo,
    RotorInertia, StribeckFriction, TorqueOffset, ViscousFriction,
};
use armident_inference::{FEWEST_BLOCKS, student_t_975, variance};
use armident_numeric::Cholesky;
use armident_simulation::{ServoJoint, SimulatedArm};
use rayon::prelude::*;

use super::joint_data::JointData;
use super::start::{CAUCHY, Start, load_range};

/// Longest step of a simulation \[s\].
const STEP_S: f64 = 2.5e-3;
/// Most steps of Levenberg-Marquardt.
const MOST_STEPS: usize = 40;
/// Steps from each start, after which the best ones go on.
const ROUGH_STEPS: usize = 8;
/// Starts that go on.
const STARTS_KEPT: usize = 2;
/// A step that lowers the cost by less ends the fit: a hundredth of what a standard error away from the minimum costs is far
/// below it for any number of samples.
const LEAST_GAIN: f64 = 1e-4;
/// Fewest blocks that recordings are divided into: with so many the quantile of Student's t is within a tenth of the normal one.
const BLOCKS: usize = 16;
/// A stiffness whose 95 % interval has a larger ratio of its ends is not determined, as for drive gains.
const NOT_DETERMINED: f64 = 10.0;
/// Steps of its encoder by which the weight must move a joint to be felt: rounding alone makes one.
const FELT_STEPS: f64 = 4.0;
/// Standard deviation of rounding to steps of 1: an error below it is none.
pub const OF_ROUNDING: f64 = 0.288_675;
/// Largest share of the load that dry friction may take: at 1 a gear locks itself.
const MOST_LOAD_FRICTION: f64 = 0.95;

/// A parameter of a joint behind a controller. Of a stiffness `K` that is not determined, what is over `K` is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServoParameter {
    /// `1/K` \[rad/(N m) or m/N\].
    Compliance,
    /// Constant effort over `K` \[rad or m\].
    Offset,
    /// Coulomb friction over `K` \[rad or m\].
    DryFriction,
    /// Viscous friction, back-EMF and derivative gain over `K` \[s\].
    Damping,
    /// Inertia of the rotor over `K` \[s²\].
    Inertia,
    /// Delay of the command \[s\].
    Delay,
    /// Static friction beyond Coulomb friction over `K` \[rad or m\].
    StaticExcess,
    /// Stribeck velocity \[rad/s or m/s\].
    StribeckVelocity,
    /// Dry friction by load \[1\].
    LoadFriction,
}

const ALL: [ServoParameter; 9] = [
    ServoParameter::Compliance,
    ServoParameter::Offset,
    ServoParameter::DryFriction,
    ServoParameter::Damping,
    ServoParameter::Inertia,
    ServoParameter::Delay,
    ServoParameter::StaticExcess,
    ServoParameter::StribeckVelocity,
    ServoParameter::LoadFriction,
];

/// An estimate with its standard error; none where the parameter is not fitted or there are too few blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoValue {
    /// What is estimated.
    pub parameter: ServoParameter,
    /// In the unit of the parameter.
    pub value: f64,
    /// In the unit of the parameter.
    pub standard_error: Option<f64>,
}

/// How well a joint follows its recordings with and without a parameter, all others fitted again without it. Sizes of position
/// errors \[rad or m\] that grow with the logarithm of large errors, as the cost of the fit does; where errors are small they are
/// RMS errors.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoAblation {
    /// Without these: one, or delay and damping, which make up a lag together, or dry friction and that by load, or compliance and
    /// offset, which make up a sag where the weight hardly changes; of dry friction without its static part too.
    pub parameters: Vec<ServoParameter>,
    /// Training recordings: with it, without it.
    pub train: [f64; 2],
    /// Logarithm of the squared size without it over that with it, in each block of the training recordings in which the positions of
    /// the two differ by more than rounding: the others show nothing of it.
    pub block_gains: Vec<f64>,
    /// Hold-out recordings; none without any.
    pub holdout: Option<[f64; 2]>,
}

/// Estimate of one joint.
#[derive(Debug, Clone)]
pub(super) struct JointEstimate {
    /// K \[N m/rad or N/m\]
    pub(super) stiffness: f64,
    /// whether the load moves the joint by more than its encoder resolves
    pub(super) is_felt: bool,
    pub(super) is_determined: bool,
    /// position error at gain 1 beyond which the effort does not grow \[rad or m\]
    pub(super) error_limit: Option<f64>,
    x: [f64; 9],
    errors: [Option<f64>; 9],
    /// correlation of delay and damping between blocks of the recordings
    pub(super) delay_with_damping: Option<f64>,
    free: Vec<ServoParameter>,
    arm: Carrier,
}

/// What a simulated joint is part of: an arm of one joint, whose own dynamics are never used.
#[derive(Debug, Clone)]
struct Carrier(RigidArm);

const JOINT: &str = "joint";

impl Carrier {
    fn of(data: &[JointData]) -> Self {
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

impl JointEstimate {
    pub(super) fn value(&self, parameter: ServoParameter) -> f64 {
        self.x[parameter as usize]
    }

    pub(super) fn error(&self, parameter: ServoParameter) -> Option<f64> {
        self.errors[parameter as usize]
    }

    /// Standard error of the stiffness \[N m/rad or N/m\].
    pub(super) fn stiffness_error(&self) -> Option<f64> {
        let error = self.error(ServoParameter::Compliance).filter(|_| self.is_determined);
        error.map(|error| error * self.stiffness.powi(2))
    }

    /// The parameters that the joint has.
    pub(super) fn values(&self) -> Vec<ServoValue> {
        let is_there = |p: &ServoParameter| match p {
            ServoParameter::Compliance => self.is_determined,
            ServoParameter::StaticExcess | ServoParameter::StribeckVelocity => {
                self.value(ServoParameter::StaticExcess) > 0.0
            }
            ServoParameter::LoadFriction => self.value(*p) > 0.0,
            _ => true,
        };
        let value = |p: ServoParameter| ServoValue {
            parameter: p,
            value: self.value(p),
            standard_error: self.error(p),
        };
        ALL.into_iter().filter(is_there).map(value).collect()
    }

    /// Effects on the joint in N m or N.
    pub(super) fn effects(&self, joint: &str) -> Vec<EffectOnJoint> {
        effects(&self.x, self.stiffness, joint)
    }

    /// Largest part of the position error that the load causes \[rad or m\].
    pub(super) fn sag(&self, data: &[JointData]) -> f64 {
        let loads = data.iter().flat_map(|d| &d.load);
        loads.fold(0.0_f64, |a, load| a.max(load.abs())) * self.value(ServoParameter::Compliance)
    }

    /// RMS position error of each recording in simulation \[rad or m\].
    pub(super) fn errors(&self, data: &[JointData]) -> Vec<f64> {
        let residuals = residuals(&self.arm, data, &self.x, self.error_limit);
        let rms = |r: &Vec<f64>| (r.iter().map(|x| x * x).sum::<f64>() / r.len() as f64).sqrt();
        residuals.iter().map(rms).collect()
    }
}

fn effects(x: &[f64; 9], stiffness: f64, joint: &str) -> Vec<EffectOnJoint> {
    let of = |p: ServoParameter| x[p as usize];
    let on =
        |law: &dyn Effect, parameters: Vec<f64>| EffectOnJoint::new(law.slug(), joint, parameters);
    let dry = of(ServoParameter::DryFriction) * stiffness;
    let excess = of(ServoParameter::StaticExcess) * stiffness;
    let by_load = of(ServoParameter::LoadFriction);
    let mut all = vec![
        on(&ViscousFriction, vec![of(ServoParameter::Damping) * stiffness]),
        on(&TorqueOffset, vec![of(ServoParameter::Offset) * stiffness]),
        on(&RotorInertia, vec![of(ServoParameter::Inertia) * stiffness]),
    ];
    let has_excess = excess > 0.0;
    if has_excess {
        let velocity = of(ServoParameter::StribeckVelocity);
        all.push(on(&StribeckFriction, vec![dry + excess, dry, velocity]));
    } else if by_load <= 0.0 {
        all.push(on(&CoulombFriction, vec![dry]));
    }
    if by_load > 0.0 {
        let level = if has_excess { 0.0 } else { dry };
        all.push(on(&LoadDependentFriction, vec![level, by_load]));
    }
    all
}

/// Simulated minus recorded positions: `[recording][sample]`.
fn residuals(
    arm: &Carrier,
    data: &[JointData],
    x: &[f64; 9],
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
    let of = |d: &JointData| {
        let start = [d.position[0], d.velocity[0]];
        let positions = joint.simulate(&d.drive(), start, STEP_S);
        positions.iter().zip(&d.position).map(|(s, q)| s - q).collect()
    };
    data.par_iter().map(of).collect()
}

/// Fits a joint; `held`: its stiffness where the load does not determine it \[N m/rad or N/m\].
pub(super) fn fit(data: &[JointData], held: Option<f64>) -> JointEstimate {
    let start = Start::of(data);
    let fitter = Fitter::of(data, &start);
    let Fitter { sample_s, resolution, error_limit, .. } = fitter;
    let load = load_range(data);
    let free_stiffness = held.is_none() && load > 0.0;
    // where the start shows no weight, one that the encoder just resolves
    let least = 10.0 * resolution / load.max(f64::MIN_POSITIVE);
    let compliance = held.map_or_else(|| start.compliance.unwrap_or(least), |k| 1.0 / k);
    let mut free = vec![
        ServoParameter::Offset,
        ServoParameter::DryFriction,
        ServoParameter::Damping,
        ServoParameter::Inertia,
        ServoParameter::Delay,
    ];
    if free_stiffness {
        free.push(ServoParameter::Compliance);
    }
    // a lag is delay or damping: both are tried as the larger part; so is a stiff controller beside the one of the start,
    // which a softness in motion is easily taken for
    let lags = [[sample_s, 1.0], [0.5 * sample_s, 2.0]];
    let stiff = free_stiffness.then_some(0.0);
    let starts = lags.into_iter().flat_map(|lag| {
        std::iter::once(compliance).chain(stiff).map(move |compliance| (lag, compliance))
    });
    let starts: Vec<([f64; 2], f64)> = starts.collect();
    let mut tried: Vec<Fit> = starts
        .par_iter()
        .map(|([delay_s, share], compliance)| {
            let damping = share * start.damping;
            let mut x = [0.0; 9];
            for (p, value) in [
                (ServoParameter::Compliance, *compliance),
                (ServoParameter::Offset, start.offset),
                (ServoParameter::DryFriction, start.dry),
                (ServoParameter::Damping, damping),
                (ServoParameter::Inertia, damping * sample_s),
                (ServoParameter::Delay, *delay_s),
                (ServoParameter::StribeckVelocity, resolution / sample_s),
            ] {
                x[p as usize] = value;
            }
            fitter.fit(x, &free, ROUGH_STEPS)
        })
        .collect();
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    tried.truncate(STARTS_KEPT);
    let mut best = (tried.par_iter().map(|rough| fitter.fit(rough.x, &free, MOST_STEPS)))
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .unwrap_or_else(|| fitter.fit([0.0; 9], &[], MOST_STEPS));
    // more dry friction as far as it is significant
    let excess = [ServoParameter::StaticExcess, ServoParameter::StribeckVelocity];
    let by_load = [ServoParameter::LoadFriction];
    for added in [&by_load[..], &excess[..]] {
        if added.contains(&ServoParameter::LoadFriction) && !free_stiffness {
            continue;
        }
        let mut x = best.x;
        let mut with = free.clone();
        with.extend(added);
        match added[0] {
            ServoParameter::StaticExcess => {
                x[added[0] as usize] = 0.1 * x[ServoParameter::DryFriction as usize];
            }
            _ => x[added[0] as usize] = 0.1,
        }
        let found = fitter.fit(x, &with, MOST_STEPS);
        let error = found.errors[added[0] as usize];
        let quantile = student_t_975(found.blocks.saturating_sub(1).max(1) as f64);
        let is_significant =
            error.is_none_or(|error| found.x[added[0] as usize] > quantile * error);
        if is_significant && found.cost < best.cost {
            best = found;
            free = with;
        }
    }
    let stiffness = 1.0 / best.x[ServoParameter::Compliance as usize];
    let error = best.errors[ServoParameter::Compliance as usize];
    let quantile = student_t_975(best.blocks.saturating_sub(1).max(1) as f64);
    let is_narrow = |error: f64| 2.0 * quantile * error * stiffness < NOT_DETERMINED.ln();
    let sag = load / stiffness;
    let is_felt = free_stiffness && sag > FELT_STEPS * resolution;
    let is_determined = is_felt && error.is_none_or(is_narrow);
    JointEstimate {
        stiffness,
        is_felt,
        is_determined,
        error_limit,
        x: best.x,
        errors: best.errors,
        delay_with_damping: best.delay_with_damping,
        free,
        arm: fitter.arm,
    }
}

struct Fitter<'a> {
    arm: Carrier,
    data: &'a [JointData],
    error_limit: Option<f64>,
    sample_s: f64,
    resolution: f64,
    load: f64,
    /// residual beyond which its size counts rather than its square \[rad or m\]: inside the band of dry friction a position
    /// depends on how it was reached, beyond it something else holds the joint
    scale: f64,
}

/// The fit without each parameter of an estimate.
pub(super) fn ablations(
    data: &[JointData],
    holdout: &[JointData],
    found: &JointEstimate,
) -> Vec<ServoAblation> {
    let fitter = Fitter::of(data, &Start::of(data));
    let parts = BLOCKS.div_ceil(data.len().max(1));
    let of = |data: &[JointData], x: &[f64; 9]| residuals(&fitter.arm, data, x, fitter.error_limit);
    // `[block][sample]`
    let blocks = |of: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let block = |recording: &Vec<f64>| -> Vec<Vec<f64>> {
            let length = recording.len().div_ceil(parts).max(1);
            recording.chunks(length).map(<[f64]>::to_vec).collect()
        };
        of.iter().flat_map(block).collect()
    };
    let held_out = |x: &[f64; 9]| (!holdout.is_empty()).then(|| fitter.size(&of(holdout, x)));
    let least = OF_ROUNDING * fitter.resolution;
    let gain = |(with, without): (Vec<f64>, Vec<f64>)| -> Option<f64> {
        let moved = with.iter().zip(&without).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let is_seen = moved > least.powi(2) * with.len() as f64;
        let size = |residual: Vec<f64>| fitter.size(&[residual]).max(least);
        is_seen.then(|| 2.0 * (size(without) / size(with)).ln())
    };
    let with = of(data, &found.x);
    let held_out_with = held_out(&found.x);
    let is_own = |p: &&ServoParameter| **p != ServoParameter::StribeckVelocity;
    let own: Vec<ServoParameter> = found.free.iter().filter(is_own).copied().collect();
    // what one of two may do for the other
    let either = [
        [ServoParameter::Delay, ServoParameter::Damping],
        [ServoParameter::DryFriction, ServoParameter::LoadFriction],
        [ServoParameter::Compliance, ServoParameter::Offset],
    ];
    let both = either.into_iter().filter(|pair| pair.iter().all(|p| own.contains(p)));
    let sets: Vec<Vec<ServoParameter>> =
        own.iter().map(|p| vec![*p]).chain(both.map(Vec::from)).collect();
    let without = |parameters: &Vec<ServoParameter>| {
        let has = |of: &[ServoParameter]| of.iter().any(|p| parameters.contains(p));
        let static_part = [ServoParameter::StaticExcess, ServoParameter::StribeckVelocity];
        let goes = |p: &ServoParameter| {
            parameters.contains(p)
                || static_part.contains(p)
                    && has(&[ServoParameter::DryFriction, ServoParameter::StaticExcess])
        };
        let mut x = found.x;
        parameters.iter().for_each(|p| x[*p as usize] = 0.0);
        if goes(&ServoParameter::StaticExcess) {
            x[ServoParameter::StaticExcess as usize] = 0.0;
        }
        let free: Vec<ServoParameter> = found.free.iter().filter(|p| !goes(p)).copied().collect();
        let x = fitter.fit(x, &free, MOST_STEPS).x;
        let without = of(data, &x);
        ServoAblation {
            parameters: parameters.clone(),
            train: [fitter.size(&with), fitter.size(&without)],
            block_gains: blocks(&with).into_iter().zip(blocks(&without)).filter_map(gain).collect(),
            holdout: held_out_with.zip(held_out(&x)).map(Into::into),
        }
    };
    sets.par_iter().map(without).collect()
}

/// A minimum of the cost.
struct Fit {
    x: [f64; 9],
    errors: [Option<f64>; 9],
    delay_with_damping: Option<f64>,
    cost: f64,
    blocks: usize,
}

impl<'a> Fitter<'a> {
    fn of(data: &'a [JointData], start: &Start) -> Self {
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

impl Fitter<'_> {
    /// Size of residuals: of the same cost if all were equal \[rad or m\].
    fn size(&self, residual: &[Vec<f64>]) -> f64 {
        let samples = residual.iter().map(Vec::len).sum::<usize>().max(1);
        self.scale * (self.cost(residual) / samples as f64).exp_m1().sqrt()
    }

    fn residuals(&self, x: &[f64; 9]) -> Vec<Vec<f64>> {
        residuals(&self.arm, self.data, x, self.error_limit)
    }

    /// A change that recordings resolve.
    fn small_change(&self, x: &[f64; 9], p: ServoParameter) -> f64 {
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
    fn admissible(&self, mut x: [f64; 9]) -> [f64; 9] {
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

    fn fit(&self, x: [f64; 9], free: &[ServoParameter], most_steps: usize) -> Fit {
        let mut x = self.admissible(x);
        let mut residual = self.residuals(&x);
        let mut damping = 1e-2;
        for _ in 0..most_steps {
            let weights = self.weights(&residual);
            let cost = self.cost(&residual);
            let jacobian = self.jacobian(&x, &residual, free);
            let (matrix, gradient) = normal_equations(&jacobian, &residual, &weights);
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
                let changed = self.residuals(&next);
                let lower = self.cost(&changed);
                if lower < cost {
                    is_better = lower < (1.0 - LEAST_GAIN) * cost;
                    x = next;
                    residual = changed;
                    damping *= 0.2;
                    break;
                }
                damping *= 5.0;
            }
            if !is_better {
                break;
            }
        }
        let weights = self.weights(&residual);
        let cost = self.cost(&residual);
        let estimates = self.without_blocks(&x, &residual, &weights, free);
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
        Fit { x, errors, delay_with_damping, cost, blocks: estimates.len() }
    }

    /// `[parameter][recording][sample]`
    fn jacobian(
        &self,
        x: &[f64; 9],
        residual: &[Vec<f64>],
        free: &[ServoParameter],
    ) -> Vec<Vec<Vec<f64>>> {
        let column = |p: &ServoParameter| {
            let change = self.small_change(x, *p);
            let mut moved = *x;
            moved[*p as usize] += change;
            let other = self.residuals(&moved);
            let slope = |(a, b): (&Vec<f64>, &Vec<f64>)| {
                a.iter().zip(b).map(|(a, b)| (a - b) / change).collect()
            };
            other.iter().zip(residual).map(slope).collect()
        };
        free.par_iter().map(column).collect()
    }

    /// Changes of the estimates by one step without each block of the recordings; none where a block determines a parameter
    /// alone.
    fn without_blocks(
        &self,
        x: &[f64; 9],
        residual: &[Vec<f64>],
        weights: &[Vec<f64>],
        free: &[ServoParameter],
    ) -> Vec<Vec<f64>> {
        let jacobian = self.jacobian(x, residual, free);
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
    let weighted = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
        let values = a.iter().flatten().zip(b.iter().flatten()).zip(weights.iter().flatten());
        values.map(|((a, b), w)| w * a * b).sum()
    };
    let n = jacobian.len();
    let mut matrix = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            matrix[i][j] = weighted(&jacobian[i], &jacobian[j]);
            matrix[j][i] = matrix[i][j];
        }
    }
    (matrix, jacobian.iter().map(|column| weighted(column, residual)).collect())
}
