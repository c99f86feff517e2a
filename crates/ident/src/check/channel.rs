//! Which effort channel each column is.

use armident_effects::{Admissible, LIBRARY};
use armident_numeric::NumericError;

use super::likelihood::{JointModel, Relation};
use super::rows::JointRows;
use crate::batch::{BatchProblem, Term};
use crate::link_prior::{UNKNOWN, spread_of_links};

/// Gains looked at: a factor of ten thousand to either side of a joint's effort, which takes in gears,
/// currents, milli- and per-mille units.
pub(super) const LARGEST_LOG_GAIN: f64 = 9.210_340_371_976_184;
/// Step of the logarithm of the gain.
const LOG_GAIN_STEP: f64 = 0.1;
/// Standard deviation of the logarithm of the gain of a channel that is what it says: published drive
/// gains of one type of arm lie up to a third apart.
const USUAL_LOG_GAIN: f64 = 0.3;
/// What the numbers of links may be off, relative to their size; each as likely as the others. At 1 a
/// link may as well not be there, or be twice what is said; the least is what a good CAD model is.
const LINK_DOUBTS: [f64; 4] = [0.03, 0.1, 0.3, 1.0];
/// Loads that the URDF may not know, in mean links; each as likely as the others.
const LOADS: [f64; 3] = [0.0, 0.1, 1.0];
/// What is believed of a column before it is looked at: as it says, and each of the faults.
const AS_SAID: f64 = 0.96;
const EACH_FAULT: f64 = 0.01;
/// One arrangement of the channels in a hundred recordings is not the one its header says.
const OTHER_ORDER: f64 = 0.01;

/// What a column turns out to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelKind {
    /// The joint's effort, within the doubt of drive gains and of the URDF.
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

    fn believed(self) -> f64 {
        if self == Self::JointEffort { AS_SAID } else { EACH_FAULT }
    }
}

/// What the samples say about one column.
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
    /// Root mean square of what the model with free parameters leaves of it.
    pub residual_rms: f64,
    /// Standard deviation of the URDF's effort of this joint on this motion \[N m or N\].
    pub urdf_sd: f64,
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

pub(super) fn channels(
    problem: &BatchProblem<'_>,
    rows: &[JointRows],
) -> Result<Channels, NumericError> {
    let n = rows.len();
    let models: Vec<Vec<JointModel>> = (0..n)
        .map(|j| {
            let doubts = LINK_DOUBTS.iter().flat_map(|d| LOADS.iter().map(move |l| (*d, *l)));
            doubts.map(|doubt| joint_model(problem, &rows[j], j, doubt)).collect::<Result<_, _>>()
        })
        .collect::<Result<_, _>>()?;
    let mut evidence = Vec::with_capacity(n);
    let mut cost = vec![vec![0.0; n]; n];
    for (j, models) in models.iter().enumerate() {
        for k in 0..n {
            let profile = Profile::of(models, k, rows[k].effective);
            let log_likelihood = profile.by_kind();
            let believed: Vec<f64> = ChannelKind::ALL
                .iter()
                .zip(log_likelihood)
                .map(|(kind, l)| kind.believed().ln() + l)
                .collect();
            let all = log_sum(&believed);
            cost[j][k] = -all;
            if j == k {
                let (gain, gain_95) = profile.gain();
                let mut probability = [0.0; 5];
                for (p, l) in probability.iter_mut().zip(&believed) {
                    *p = (l - all).exp();
                }
                evidence.push(ChannelEvidence {
                    probability,
                    gain,
                    gain_95,
                    sd: rows[k].effort_sd,
                    residual_rms: rows[k].residual_rms,
                    urdf_sd: rows[k].urdf_sd,
                });
            }
        }
    }
    let order = cheapest_assignment(&cost);
    let of = |order: &[usize]| -> f64 { order.iter().enumerate().map(|(j, &k)| cost[j][k]).sum() };
    let as_said: Vec<usize> = (0..n).collect();
    let odds = if order == as_said {
        0.0
    } else {
        OTHER_ORDER / (1.0 - OTHER_ORDER) * (of(&as_said) - of(&order)).exp()
    };
    Ok(Channels { evidence, order, order_probability: 1.0 / (1.0 + odds) })
}

fn joint_model(
    problem: &BatchProblem<'_>,
    rows: &JointRows,
    joint: usize,
    (relative, load): (f64, f64),
) -> Result<JointModel, NumericError> {
    let (mut constants, mut friction) = (Vec::new(), Vec::new());
    let mut of_set = Vec::new();
    let mut dissipative = Vec::new();
    // offset first, rotor inertia last: what is dependent is decided in this order
    for (place, &k) in problem.terms_of_joint(joint).iter().enumerate() {
        match problem.terms[k] {
            Term::Constant(c) => {
                constants.push(place);
                of_set.push(c);
            }
            Term::Effect { effect, parameter, .. } => {
                let parameter = &LIBRARY[effect].law().parameters[parameter];
                if parameter.admissible == Admissible::NonNegative {
                    dissipative.push(friction.len());
                }
                friction.push(place);
            }
        }
    }
    let (arm, set) = (problem.arm(), problem.set());
    let all = set.values(&arm.constants());
    let pick = |x: &[f64]| -> Vec<f64> { of_set.iter().map(|&c| x[c]).collect() };
    let mut spread: Vec<Vec<f64>> = spread_of_links(arm, set, relative, load)
        .unwrap_or_default()
        .iter()
        .map(|column| pick(column))
        .collect();
    // rotors that are part of a constant may be of any size
    let with_rotor: Vec<usize> = problem.merged.iter().flat_map(|m| &m.into).map(|i| i.0).collect();
    for (place, &c) in of_set.iter().enumerate() {
        let merged = with_rotor.iter().any(|&k| problem.terms[k] == Term::Constant(c));
        if merged {
            let own = spread.iter().map(|column| column[place].powi(2)).sum::<f64>().sqrt();
            let mut alone = vec![0.0; of_set.len()];
            alone[place] = UNKNOWN * own;
            spread.push(alone);
        }
    }
    JointModel::new(rows, &friction, &constants, dissipative, &spread, &pick(&all))
}

/// Log likelihood of one column over the gain, for either sign.
struct Profile {
    /// logarithms of the gains
    log_gain: Vec<f64>,
    /// as recorded, with gravity: positive and negative gain
    with: [Vec<f64>; 2],
    /// gravity taken off, positive gain
    without: Vec<f64>,
}

impl Profile {
    /// `models` differ in how far the URDF is doubted, which is integrated out.
    fn of(models: &[JointModel], channel: usize, effective: f64) -> Self {
        let each: Vec<Self> =
            models.iter().map(|m| Self::of_model(m, channel, effective)).collect();
        let mean = |pick: &dyn Fn(&Self) -> &Vec<f64>| -> Vec<f64> {
            (0..pick(&each[0]).len())
                .map(|k| {
                    let all: Vec<f64> = each.iter().map(|p| pick(p)[k]).collect();
                    log_sum(&all) - (each.len() as f64).ln()
                })
                .collect()
        };
        Self {
            with: [mean(&|p| &p.with[0]), mean(&|p| &p.with[1])],
            without: mean(&|p| &p.without),
            log_gain: each[0].log_gain.clone(),
        }
    }

    fn of_model(model: &JointModel, channel: usize, effective: f64) -> Self {
        let steps = (LARGEST_LOG_GAIN / LOG_GAIN_STEP).round() as i32;
        let log_gain: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * LOG_GAIN_STEP).collect();
        let along = |sign: f64, without_gravity: bool, range: f64| -> Vec<f64> {
            let relation = |u: f64| Relation { gain: sign * u.exp(), without_gravity };
            let mut profile: Vec<f64> = log_gain
                .iter()
                .map(|&u| {
                    if u.abs() > range {
                        return f64::NEG_INFINITY;
                    }
                    -0.5 * model.deviance(channel, relation(u), effective)
                })
                .collect();
            // the friction's sign hardly depends on the size of the gain
            if let Some(best) = highest(&profile) {
                let off = model.against_dissipation(channel, relation(log_gain[best]), effective);
                profile.iter_mut().for_each(|l| *l -= 0.5 * off);
            }
            profile
        };
        Self {
            with: [along(1.0, false, f64::INFINITY), along(-1.0, false, f64::INFINITY)],
            without: along(1.0, true, 4.0 * USUAL_LOG_GAIN),
            log_gain,
        }
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
        let quantile = |p: f64| {
            let mut below = 0.0;
            for (l, u) in profile.iter().zip(&self.log_gain) {
                let here = (l - all).exp();
                if below + here >= p {
                    // within the step, evenly
                    return sign * (u + ((p - below) / here - 0.5) * LOG_GAIN_STEP).exp();
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

fn log_sum(logs: &[f64]) -> f64 {
    let top = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + logs.iter().map(|l| (l - top).exp()).sum::<f64>().ln()
}

/// Row -> column of the assignment with the least sum; the one of the header where there are more than
/// sixteen rows.
fn cheapest_assignment(cost: &[Vec<f64>]) -> Vec<usize> {
    let n = cost.len();
    if n > 16 {
        return (0..n).collect();
    }
    // least cost of the first rows on a set of columns
    let mut least = vec![(f64::INFINITY, 0); 1 << n];
    least[0].0 = 0.0;
    for set in 0..(1_usize << n) - 1 {
        let row = set.count_ones() as usize;
        for column in (0..n).filter(|c| set >> c & 1 == 0) {
            let next = set | 1 << column;
            let total = least[set].0 + cost[row][column];
            if total < least[next].0 {
                least[next] = (total, column);
            }
        }
    }
    let mut order = vec![0; n];
    let mut set = (1_usize << n) - 1;
    for row in (0..n).rev() {
        order[row] = least[set].1;
        set &= !(1 << order[row]);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_assignment_of_small_cases() {
        assert_eq!(cheapest_assignment(&[vec![1.0]]), [0]);
        let cost = [vec![9.0, 1.0, 5.0], vec![1.0, 9.0, 5.0], vec![5.0, 5.0, 1.0]];
        assert_eq!(cheapest_assignment(&cost), [1, 0, 2]);
        let cycle = [vec![9.0, 0.0, 9.0], vec![9.0, 9.0, 0.0], vec![0.0, 9.0, 9.0]];
        assert_eq!(cheapest_assignment(&cycle), [1, 2, 0]);
        // equal costs leave the header's order
        assert_eq!(cheapest_assignment(&vec![vec![0.0; 4]; 4]).len(), 4);
    }

    #[test]
    fn sums_of_logarithms() {
        assert!((log_sum(&[0.0, 0.0]) - 2.0_f64.ln()).abs() < 1e-15);
        assert!((log_sum(&[-1e4, -1e4]) + 1e4 - 2.0_f64.ln()).abs() < 1e-9);
        assert_eq!(log_sum(&[f64::NEG_INFINITY]), f64::NEG_INFINITY);
    }
}
