//! Controller and friction of one joint, by its simulated positions.
//!
//! Method: output error ([`super::output_error`]) from several starts. Laws of dry friction are added one after another as long as
//! the 95 % interval of their parameter excludes 0.
//!
//! References: those of output error; the order of the laws is own.

use armident_effects::EffectOnJoint;
use armident_inference::student_t_975;
use rayon::prelude::*;

use super::joint_data::JointData;
use super::output_error::{
    BLOCKS, Carrier, Minimum, OutputError, StartState, position_errors, recorded_starts,
};
use super::parameters::{ALL, ServoParameter, ServoValue, Values, effects};
use super::start::{Start, load_range};

/// Most steps of Levenberg-Marquardt.
const MOST_STEPS: usize = 40;
/// Steps from each start, after which the best ones go on.
const ROUGH_STEPS: usize = 8;
/// Starts that go on.
const STARTS_KEPT: usize = 2;
/// A stiffness whose 95 % interval has a larger ratio of its ends is not determined, as for drive gains.
const NOT_DETERMINED: f64 = 10.0;
/// Steps of its encoder by which the weight must move a joint to be felt: rounding alone makes one.
const FELT_STEPS: f64 = 4.0;
/// Standard deviation of rounding to steps of 1: an error below it is none.
pub const OF_ROUNDING: f64 = 0.288_675;

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
    /// of the fit
    pub(super) cost: f64,
    /// whether the load moves the joint by more than its encoder resolves
    pub(super) is_felt: bool,
    pub(super) is_determined: bool,
    /// position error at gain 1 beyond which the effort does not grow \[rad or m\]
    pub(super) error_limit: Option<f64>,
    x: Values,
    /// of each training recording
    starts: Vec<StartState>,
    errors: [Option<f64>; 9],
    /// correlation of delay and damping between blocks of the recordings
    pub(super) delay_with_damping: Option<f64>,
    free: Vec<ServoParameter>,
    arm: Carrier,
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
        let starts = recorded_starts(data);
        let residuals = position_errors(&self.arm, data, (&self.x, &starts), self.error_limit);
        let rms = |r: &Vec<f64>| (r.iter().map(|x| x * x).sum::<f64>() / r.len() as f64).sqrt();
        residuals.iter().map(rms).collect()
    }
}

/// Least stiffness of a joint whose load is not felt \[N m/rad or N/m\].
pub(super) fn least_unfelt_stiffness(data: &[JointData]) -> f64 {
    let resolution = data.iter().map(|d| d.resolution).fold(0.0, f64::max);
    load_range(data) / (FELT_STEPS * resolution)
}

/// Fits a joint; `held`: its stiffness where the load does not determine it \[N m/rad or N/m\].
pub(super) fn fit(data: &[JointData], held: Option<f64>) -> JointEstimate {
    let start = Start::of(data);
    let fitter = OutputError::of(data, &start);
    let OutputError { sample_s, resolution, error_limit, .. } = fitter;
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
    let recorded = recorded_starts(data);
    let mut tried: Vec<Minimum> = starts
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
            fitter.fit(x, &recorded, &free, ROUGH_STEPS)
        })
        .collect();
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    tried.truncate(STARTS_KEPT);
    let mut best =
        (tried.par_iter().map(|rough| fitter.fit(rough.x, &rough.starts, &free, MOST_STEPS)))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .unwrap_or_else(|| fitter.fit([0.0; 9], &recorded, &[], MOST_STEPS));
    let mut spread = fitter.spread(&best, &free);
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
        let found = fitter.fit(x, &best.starts, &with, MOST_STEPS);
        let of_found = fitter.spread(&found, &with);
        let error = of_found.errors[added[0] as usize];
        let quantile = student_t_975(of_found.blocks.saturating_sub(1).max(1) as f64);
        let is_significant =
            error.is_none_or(|error| found.x[added[0] as usize] > quantile * error);
        if is_significant && found.cost < best.cost {
            best = found;
            spread = of_found;
            free = with;
        }
    }
    let stiffness = 1.0 / best.x[ServoParameter::Compliance as usize];
    let error = spread.errors[ServoParameter::Compliance as usize];
    let quantile = student_t_975(spread.blocks.saturating_sub(1).max(1) as f64);
    let is_narrow = |error: f64| 2.0 * quantile * error * stiffness < NOT_DETERMINED.ln();
    let sag = load / stiffness;
    let is_felt = free_stiffness && sag > FELT_STEPS * resolution;
    let is_determined = is_felt && error.is_none_or(is_narrow);
    JointEstimate {
        stiffness,
        cost: best.cost,
        is_felt,
        is_determined,
        error_limit,
        x: best.x,
        starts: best.starts,
        errors: spread.errors,
        delay_with_damping: spread.delay_with_damping,
        free,
        arm: fitter.arm,
    }
}

/// The fit without each parameter of an estimate.
pub(super) fn ablations(
    data: &[JointData],
    holdout: &[JointData],
    found: &JointEstimate,
) -> Vec<ServoAblation> {
    let fitter = OutputError::of(data, &Start::of(data));
    let parts = BLOCKS.div_ceil(data.len().max(1));
    let of = |data: &[JointData], x: &Values, starts: &[StartState]| {
        position_errors(&fitter.arm, data, (x, starts), fitter.error_limit)
    };
    let held_out_starts = recorded_starts(holdout);
    // `[block][sample]`
    let blocks = |of: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let block = |recording: &Vec<f64>| -> Vec<Vec<f64>> {
            let length = recording.len().div_ceil(parts).max(1);
            recording.chunks(length).map(<[f64]>::to_vec).collect()
        };
        of.iter().flat_map(block).collect()
    };
    let held_out =
        |x: &Values| (!holdout.is_empty()).then(|| fitter.size(&of(holdout, x, &held_out_starts)));
    let least = OF_ROUNDING * fitter.resolution;
    let gain = |(with, without): (Vec<f64>, Vec<f64>)| -> Option<f64> {
        let moved = with.iter().zip(&without).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let is_seen = moved > least.powi(2) * with.len() as f64;
        let size = |residual: Vec<f64>| fitter.size(&[residual]).max(least);
        is_seen.then(|| 2.0 * (size(without) / size(with)).ln())
    };
    let with = of(data, &found.x, &found.starts);
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
        let Minimum { x, starts, .. } = fitter.fit(x, &found.starts, &free, MOST_STEPS);
        let without = of(data, &x, &starts);
        ServoAblation {
            parameters: parameters.clone(),
            train: [fitter.size(&with), fitter.size(&without)],
            block_gains: blocks(&with).into_iter().zip(blocks(&without)).filter_map(gain).collect(),
            holdout: held_out_with.zip(held_out(&x)).map(Into::into),
        }
    };
    sets.par_iter().map(without).collect()
}
