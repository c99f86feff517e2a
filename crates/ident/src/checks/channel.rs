//! Which effort channel each column is.

use armident_effects::Admissible;
use armident_inference::log_sum;
use armident_numeric::NumericError;
use rayon::prelude::*;

use super::assignment::cheapest_assignment;
use super::explanations::Explained;
use super::likelihood::{JointModel, Relation};
use super::link_errors::{LARGEST_LOG_GAIN, LinkErrors, USUAL_LOG_GAIN};
use super::rows::ChannelRows;
use super::verdict::{PROBABLY_RIGHT, Verdict};
use crate::regression::{BatchProblem, Term};

/// Step of the logarithm of the gain, to find it, ...
const FINE: f64 = 0.1;
/// ... and to compare columns, in which any gain will do.
const COARSE: f64 = 0.3;
/// Largest ratio of the URDF's effort, times the gain, to the recorded one, by their standard deviations. Beyond it,
/// friction or much lighter links would have to cancel most of it: constants without bounds then imitate the residual of
/// the friction laws, the better the larger the gain.
const LARGEST_RATIO: f64 = 2.0;
/// Relative errors of link parameters, equally likely. At 1 a link may as well have no mass, or twice its mass; the least
/// is the error of a good CAD model once cables and covers are on.
const LINK_ERRORS: [f64; 3] = [0.1, 0.3, 1.0];
/// Masses of a payload that is not in the URDF, in mean links; equally likely.
const LOADS: [f64; 3] = [0.0, 0.1, 1.0];
/// Priors enough to compare columns: errors of a tenth and the whole of the links, without a payload and with a whole
/// mean link; indices over errors and payloads.
const FEW_PRIORS: [usize; 4] = [0, 2, 6, 8];
/// Probability that a joint's links have another error than those of the others.
const ODD_LINK: f64 = 0.01;
/// Prior probability of a column: as its header states, and each of the faults.
const AS_LABELLED: f64 = 0.96;
const EACH_FAULT: f64 = 0.01;
/// Probability of compensated gravity that is no larger than the prior one: gravity is not visible.
const NO_GRAVITY_VISIBLE: f64 = 0.0105;
/// Prior probability of an order of the columns other than the header's.
const OTHER_ORDER: f64 = 0.01;

/// What a column turns out to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelKind {
    /// The joint's effort, within the errors of drive gains and of the URDF.
    JointEffort,
    /// The joint's effort with the other sign.
    SignFlipped,
    /// A multiple of the effort: another unit, a current, the motor side of a gear.
    OtherGain,
    /// A multiple, with the other sign.
    OtherGainFlipped,
    /// The effort without its gravity part.
    WithoutGravity,
}

impl ChannelKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::JointEffort,
        Self::SignFlipped,
        Self::OtherGain,
        Self::OtherGainFlipped,
        Self::WithoutGravity,
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointEffort => "joint_effort",
            Self::SignFlipped => "sign_flipped",
            Self::OtherGain => "other_gain",
            Self::OtherGainFlipped => "other_gain_flipped",
            Self::WithoutGravity => "without_gravity",
        }
    }

    fn prior_probability(self) -> f64 {
        if self == Self::JointEffort { AS_LABELLED } else { EACH_FAULT }
    }
}

/// Evidence about one column.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelEvidence {
    /// Probability of each kind, in the order of [`ChannelKind::ALL`].
    pub probability: [f64; 5],
    /// Median of the gain, recorded over joint effort.
    pub gain: f64,
    /// 95 % interval of the gain with the sign of [`gain`](Self::gain); the ends are those of the
    /// range looked at where it is open.
    pub gain_95: [f64; 2],
    /// Standard deviation of the channel \[its unit\].
    pub sd: f64,
    /// RMS residual of the model with free parameters.
    pub residual_rms: f64,
    /// Share of the standard deviation of the column that its joint's terms leave, after degrees of freedom: 1 where nothing of
    /// the joint's motion is in it.
    pub residual_share: f64,
    /// Standard deviation of the URDF's effort of this joint on this motion \[N m or N\].
    pub urdf_sd: f64,
    /// Share of what friction leaves of the column that the URDF's effort explains, times any gain.
    pub urdf_share: f64,
    /// Share of the variance of the column that friction alone explains.
    pub friction_share: f64,
    /// Log likelihood of the signs of friction and rotor inertia, which drive nothing, with the sign flipped over that as it is.
    pub friction_flipped: f64,
}

/// The columns of all joints.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channels {
    pub(super) evidence: Vec<ChannelEvidence>,
    /// joint -> joint whose column holds its effort, in the most likely order
    pub(super) order: Vec<usize>,
    /// probability of the order of the header against the most likely one
    pub(super) order_probability: f64,
}

/// Prior odds at which nothing is reported about the order.
const UNDECIDED: f64 = 0.6;

impl Channels {
    pub(super) fn is_reordered(&self) -> bool {
        self.order.iter().enumerate().any(|(j, k)| j != *k)
    }

    /// Columns are in another order only where that explains all joints together: in every recording, with half of the
    /// error left at most; `confirmed` where that of the columns themselves does.
    pub(super) fn agree_with(&mut self, explained: &Explained, confirmed: bool) {
        let map = &explained.map;
        // columns by the joints that the recordings turned out to hold
        let found: Vec<usize> = (map.effort.iter())
            .map(|e| map.source.iter().position(|s| s == e).unwrap_or(*e))
            .collect();
        let moved = found.iter().enumerate().any(|(j, k)| j != *k);
        if moved {
            self.order = found;
            self.order_probability = explained.as_labelled;
        } else if self.is_reordered() && !confirmed {
            self.order_probability = self.order_probability.max(UNDECIDED);
        }
    }
}

/// Looks at every column against every joint.
///
/// The error of the URDF is common to all joints: each joint's column is judged with the priors that the columns of the
/// others make likely, as far as these are right themselves. Only columns that are `alive` are compared with each other; the others stay where their header
/// puts them.
pub(super) fn channels(
    problem: &BatchProblem,
    rows: &[ChannelRows],
    alive: &[bool],
) -> Result<Channels, NumericError> {
    let n = rows.len();
    let priors: Vec<LinkErrors> = LINK_ERRORS
        .iter()
        .flat_map(|&error| LOADS.iter().map(move |&load| LinkErrors::of(problem, error, load)))
        .collect();
    let models: Vec<Vec<JointModel>> = (0..n)
        .into_par_iter()
        .map(|j| {
            let terms = JointTerms::of(problem, j);
            priors.iter().map(|prior| terms.model(&rows[j], prior)).collect()
        })
        .collect::<Result<_, _>>()?;
    // equally likely, to begin with
    let even = vec![-(priors.len() as f64).ln(); priors.len()];
    let profiles: Vec<Vec<Profile>> = (0..n)
        .into_par_iter()
        .map(|j| {
            let of_model = |m: &JointModel| Profile::of(m, j, &rows[j], rows[j].urdf_sd, FINE);
            models[j].iter().map(of_model).collect()
        })
        .collect();
    let alone: Vec<ChannelEvidence> =
        (0..n).map(|j| ChannelEvidence::of(&profiles[j], &even, &rows[j]).0).collect();

    let cost: Vec<Vec<f64>> = (0..n)
        .into_par_iter()
        .map(|j| {
            (0..n)
                .map(|k| {
                    if j != k && !(alive[j] && alive[k]) {
                        return f64::INFINITY;
                    }
                    let coarse: Vec<Profile> = FEW_PRIORS
                        .iter()
                        .map(|&h| Profile::of(&models[j][h], k, &rows[k], rows[j].urdf_sd, COARSE))
                        .collect();
                    ChannelEvidence::of(&coarse, &[0.0; FEW_PRIORS.len()], &rows[k]).1
                })
                .collect()
        })
        .collect();
    let order = cheapest_assignment(&cost);
    let of = |order: &[usize]| -> f64 { order.iter().enumerate().map(|(j, &k)| cost[j][k]).sum() };
    let as_labelled: Vec<usize> = (0..n).collect();
    let odds = if order == as_labelled {
        0.0
    } else {
        let prior = OTHER_ORDER / arrangements(n, &order);
        prior / (1.0 - OTHER_ORDER) * (of(&as_labelled) - of(&order)).exp()
    };

    let evidence = (0..n)
        .map(|j| {
            let others = (0..n)
                .filter(|&k| k != j && order[k] == k && alone[k].as_labelled() == Verdict::Ok);
            let mut weights = even.clone();
            for k in others {
                for (weight, profile) in weights.iter_mut().zip(&profiles[k]) {
                    *weight += profile.by_kind()[0];
                }
            }
            let all = log_sum(&weights);
            let weights: Vec<f64> = (weights.iter().zip(&even))
                .map(|(weight, even)| {
                    log_sum(&[(1.0 - ODD_LINK).ln() + weight - all, ODD_LINK.ln() + even])
                })
                .collect();
            ChannelEvidence::of(&profiles[j], &weights, &rows[j]).0
        })
        .collect();
    Ok(Channels { evidence, order, order_probability: 1.0 / (1.0 + odds) })
}

impl ChannelEvidence {
    /// A column with rows `own`, from its profiles under priors of these logarithmic weights; and the
    /// negative logarithm of the likelihood of the column.
    fn of(profiles: &[Profile], log_weights: &[f64], own: &ChannelRows) -> (Self, f64) {
        let profile = Profile::mean(profiles, log_weights);
        let posterior: Vec<f64> = ChannelKind::ALL
            .iter()
            .zip(profile.by_kind())
            .map(|(kind, l)| kind.prior_probability().ln() + l)
            .collect();
        let all = log_sum(&posterior);
        let (gain, gain_95) = profile.gain();
        let mut probability = [0.0; 5];
        for (p, l) in probability.iter_mut().zip(&posterior) {
            *p = (l - all).exp();
        }
        let evidence = Self {
            probability,
            gain,
            gain_95,
            sd: own.effort_sd,
            residual_rms: own.residual_rms,
            residual_share: own.residual_share(),
            urdf_sd: own.urdf_sd,
            urdf_share: own.urdf_share,
            friction_share: own.friction_share,
            friction_flipped: profile.dissipation[1] - profile.dissipation[0],
        };
        (evidence, -all)
    }

    /// Whether the column is what its header states.
    pub fn as_labelled(&self) -> Verdict {
        let [as_labelled, flipped, other, other_flipped, without_gravity] = self.probability;
        // on a joint without gravity both are the same
        if without_gravity <= NO_GRAVITY_VISIBLE
            && flipped + other + other_flipped < 1.0 - PROBABLY_RIGHT
        {
            return Verdict::Ok;
        }
        Verdict::of_probability(as_labelled)
    }
}

/// Terms of one joint: positions among the joint's terms, and which constants they are.
struct JointTerms {
    friction: Vec<usize>,
    dissipative: Vec<usize>,
    constants: Vec<usize>,
    of_set: Vec<usize>,
}

impl JointTerms {
    fn of(problem: &BatchProblem, joint: usize) -> Self {
        let mut terms = Self {
            friction: Vec::new(),
            dissipative: Vec::new(),
            constants: Vec::new(),
            of_set: Vec::new(),
        };
        for (place, &k) in problem.terms_of_joint(joint).iter().enumerate() {
            match problem.terms[k] {
                Term::Constant(c) => {
                    terms.constants.push(place);
                    terms.of_set.push(c);
                }
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => {
                    let admissible = problem.terms[k].parameter().map(|p| p.admissible);
                    if admissible == Some(Admissible::NonNegative) {
                        terms.dissipative.push(terms.friction.len());
                    }
                    terms.friction.push(place);
                }
            }
        }
        terms
    }

    fn model(&self, rows: &ChannelRows, prior: &LinkErrors) -> Result<JointModel, NumericError> {
        let pick = |x: &[f64]| -> Vec<f64> { self.of_set.iter().map(|&c| x[c]).collect() };
        let spread: Vec<Vec<f64>> = prior.spread.iter().map(|column| pick(column)).collect();
        JointModel::new(
            rows,
            &self.friction,
            &self.constants,
            self.dissipative.clone(),
            &spread,
            &pick(&prior.mean),
        )
    }
}

/// Log likelihood of one column over the gain, for either sign.
struct Profile {
    /// logarithms of the gains
    log_gain: Vec<f64>,
    /// as recorded, with gravity: positive and negative gain
    with: [Vec<f64>; 2],
    /// gravity compensated, positive gain
    without: Vec<f64>,
    /// part of `with` that is of the signs of friction
    dissipation: [f64; 2],
}

impl Profile {
    /// The priors integrated out.
    fn mean(each: &[Self], log_weights: &[f64]) -> Self {
        let mean = |pick: &dyn Fn(&Self) -> &Vec<f64>| -> Vec<f64> {
            (0..pick(&each[0]).len())
                .map(|k| {
                    let all: Vec<f64> =
                        each.iter().zip(log_weights).map(|(p, w)| pick(p)[k] + w).collect();
                    log_sum(&all)
                })
                .collect()
        };
        Self {
            with: [mean(&|p| &p.with[0]), mean(&|p| &p.with[1])],
            without: mean(&|p| &p.without),
            dissipation: [0, 1]
                .map(|k| each.iter().map(|p| p.dissipation[k]).sum::<f64>() / each.len() as f64),
            log_gain: each[0].log_gain.clone(),
        }
    }

    /// Rows `own` of a column against a joint whose effort by the URDF has the standard deviation
    /// `urdf_sd`.
    fn of(model: &JointModel, channel: usize, own: &ChannelRows, urdf_sd: f64, step: f64) -> Self {
        let usual = 4.0 * USUAL_LOG_GAIN;
        let largest = (LARGEST_RATIO * own.effort_sd / urdf_sd).ln().max(usual);
        let steps = (LARGEST_LOG_GAIN / step).round() as i32;
        let log_gain: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * step).collect();
        let along = |sign: f64, without_gravity: bool, least: f64, most: f64| -> (Vec<f64>, f64) {
            let mut of_friction = 0.0;
            let relation = |u: f64| Relation { gain: sign * u.exp(), without_gravity };
            let mut profile: Vec<f64> = log_gain
                .iter()
                .map(|&u| {
                    if !(least..=most).contains(&u) {
                        return f64::NEG_INFINITY;
                    }
                    -0.5 * model.deviance(channel, relation(u), own)
                })
                .collect();
            // the friction's sign hardly depends on the size of the gain
            if let Some(best) = highest(&profile) {
                let off = model.against_dissipation(channel, relation(log_gain[best]), own);
                of_friction = -0.5 * off;
                profile.iter_mut().for_each(|l| *l += of_friction);
            }
            (profile, of_friction)
        };
        let [(with, of_with), (against, of_against)] =
            [1.0, -1.0].map(|sign| along(sign, false, f64::NEG_INFINITY, largest));
        let (without, _) = along(1.0, true, -usual, usual);
        Self { with: [with, against], without, dissipation: [of_with, of_against], log_gain }
    }

    /// Log likelihood of each kind, the gain integrated out.
    fn by_kind(&self) -> [f64; 5] {
        let usual = |profile: &[f64]| {
            let weighted: Vec<f64> = profile
                .iter()
                .zip(&self.log_gain)
                .map(|(l, u)| l - 0.5 * (u / USUAL_LOG_GAIN).powi(2))
                .collect();
            let norm: Vec<f64> =
                self.log_gain.iter().map(|u| -0.5 * (u / USUAL_LOG_GAIN).powi(2)).collect();
            log_sum(&weighted) - log_sum(&norm)
        };
        let any = |profile: &[f64]| log_sum(profile) - (profile.len() as f64).ln();
        [
            usual(&self.with[0]),
            usual(&self.with[1]),
            any(&self.with[0]),
            any(&self.with[1]),
            usual(&self.without),
        ]
    }

    /// Median gain and its 95 % interval, given its sign.
    fn gain(&self) -> (f64, [f64; 2]) {
        let top = |profile: &Vec<f64>| profile.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let flipped = top(&self.with[1]) > top(&self.with[0]);
        let (sign, profile) = if flipped { (-1.0, &self.with[1]) } else { (1.0, &self.with[0]) };
        let all = log_sum(profile);
        let step = self.log_gain[1] - self.log_gain[0];
        let quantile = |p: f64| {
            let mut below = 0.0;
            for (l, u) in profile.iter().zip(&self.log_gain) {
                let here = (l - all).exp();
                if below + here >= p {
                    // within the step, evenly
                    return sign * (u + ((p - below) / here - 0.5) * step).exp();
                }
                below += here;
            }
            sign * LARGEST_LOG_GAIN.exp()
        };
        let (low, high) = (quantile(0.025), quantile(0.975));
        (quantile(0.5), [low.min(high), low.max(high)])
    }
}

fn highest(values: &[f64]) -> Option<usize> {
    (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]))
}

/// Arrangements of `n` columns that are as likely as this one before they are looked at: as many columns in a
/// wrong place are as likely as any other number, and the arrangements of that number as each other.
fn arrangements(n: usize, order: &[usize]) -> f64 {
    let moved = (0..n).filter(|&j| order[j] != j).count();
    // ways without a column in its place
    let mut ways = vec![1.0, 0.0];
    for m in 2..=moved {
        ways.push((m - 1) as f64 * (ways[m - 1] + ways[m - 2]));
    }
    let chosen: f64 = (0..moved).map(|k| (n - k) as f64 / (k + 1) as f64).product();
    (n.max(2) - 1) as f64 * chosen * ways[moved]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrangements_of_four() {
        // 6 pairs, 8 rings of three, 9 of all four; each number of columns a third
        for (order, count) in [([1, 0, 2, 3], 6.0), ([1, 2, 0, 3], 8.0), ([1, 2, 3, 0], 9.0)] {
            assert!((arrangements(4, &order) - 3.0 * count).abs() < 1e-12);
        }
    }
}
