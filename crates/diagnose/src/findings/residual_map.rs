//! Residual map: joint, regime, symmetry.
//!
//! Model-free: the training residual of a model against the state of the joint, in bins and against single functions. The
//! symmetry of the residual excludes most look-alikes before anything is fitted.

use armident_dynamics::RigidArm;
use armident_inference::whiteness;
use armident_motion::differentiate;
use armident_numeric::dot;
use armident_recording::RecordingError;
use serde::Serialize;

use crate::design::compliant_link::Posed;
use crate::design::ripple::wave_gain;
use crate::design::training::Design;
use armident_model::ArmModel;

/// Bins of one variable: with 12 of some hundred rows each, means are known to a tenth of a deviation.
const BINS: usize = 12;

/// Observations of one bin of one variable.
#[derive(Debug, Clone, Serialize)]
pub struct Bin {
    /// Lower end of the variable.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Observations.
    pub rows: usize,
    /// Mean residual of the given model \[N m or N\].
    pub mean_before: f64,
    /// Its root mean square.
    pub rms_before: f64,
    /// Mean residual of the diagnosed model.
    pub mean_after: f64,
    /// Its root mean square.
    pub rms_after: f64,
}

/// Residual of one joint against one variable.
#[derive(Debug, Clone, Serialize)]
pub struct Regime {
    /// `speed`, `direction`, `load`, `position`, `acceleration`, `time_since_reversal`,
    /// `travel_since_reversal`, `time`.
    pub variable: &'static str,
    /// Share of the given model's residual variance that the means of the bins explain, adjusted for their number.
    pub share_before: f64,
    /// The same share for the diagnosed model.
    pub share_after: f64,
    /// Bins of about as many rows each; of `time`, of equal length over all recordings.
    pub bins: Vec<Bin>,
}

/// Residual against one function of the motion.
#[derive(Debug, Clone, Serialize)]
pub struct SymmetryTest {
    /// The function.
    pub function: &'static str,
    /// Share of the given model's residual variance explained by this regressor alone.
    pub share_before: f64,
    /// The same share for the diagnosed model.
    pub share_after: f64,
    /// Effects that a large share suggests.
    pub points_to: &'static str,
}

/// Residual of one joint.
#[derive(Debug, Clone, Serialize)]
pub struct JointAtlas {
    /// Joint.
    pub joint: String,
    /// In-band RMS residual of the given model \[N m or N\].
    pub before: f64,
    /// That of the links-only fit.
    pub rigid: f64,
    /// That of the diagnosed model.
    pub after: f64,
    /// Noise in the band.
    pub noise: f64,
    /// p-value of the Ljung-Box test that the residual of the diagnosed model is white.
    pub whiteness_p: f64,
    /// Largest share first.
    pub symmetries: Vec<SymmetryTest>,
    /// Largest share first.
    pub regimes: Vec<Regime>,
}

/// Multiple of the in-band noise below which a joint's efforts are explained: several times the uncertainty of the estimated
/// noise.
const EXPLAINED: f64 = 3.0;

impl JointAtlas {
    /// Residual of the diagnosed model, in units of the noise.
    pub fn left_over_noise(&self) -> f64 {
        self.after / self.noise.max(f64::MIN_POSITIVE)
    }

    /// Whether the residual of the diagnosed model is little more than noise.
    pub fn explained(&self) -> bool {
        self.left_over_noise() < EXPLAINED
    }
}

/// Character of an unmodelled structure.
#[derive(Debug, Clone, Serialize)]
pub struct Character {
    /// `dissipative` (it takes work in both directions), `conservative` (it returns the work it took), `neither`.
    pub kind: &'static str,
    /// Work it takes over all work it exchanges, -1 to 1.
    pub work_share: f64,
    /// Share of it explained by the time or the travel since the last reversal: state.
    pub memory_share: f64,
    /// Share of it explained by the time: drift.
    pub drift_share: f64,
    /// Cycles per turn (per metre) of the wave in the position that explains most of it, and the share
    /// that it explains.
    pub wave: [f64; 2],
}

/// Share of the exchanged work from which on structure is dissipative, and below which conservative.
const DISSIPATIVE: f64 = 0.5;
const CONSERVATIVE: f64 = 0.2;

/// The character of an effort on a joint, given at every sample of every recording.
pub(crate) fn character(
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    effort: &[Vec<f64>],
) -> Character {
    const HIGHEST_ORDER: usize = 60;
    let (mut taken, mut exchanged) = (0.0, 0.0);
    let mut rows = Vec::new();
    for (at, effort) in at.iter().zip(effort) {
        for (f, v) in effort.iter().zip(&at.signals.velocity[joint]) {
            taken += f * v;
            exchanged += (f * v).abs();
        }
        rows.extend(at.signals.band.rows(effort));
    }
    let work_share = taken / exchanged.max(f64::MIN_POSITIVE);
    let states = States::of(at, joint);
    let share_of = |names: &[&str]| {
        let found = states.columns.iter().filter(|(name, _)| names.contains(name));
        found
            .filter_map(|(name, column)| {
                regime(name, column, &rows, &rows, design.observations.weights.share)
            })
            .map(|regime| regime.share_before)
            .fold(0.0, f64::max)
    };
    let total = dot(&rows, &rows).max(f64::MIN_POSITIVE);
    let position = states.columns.iter().find(|(name, _)| *name == "position");
    let wave = (1..=HIGHEST_ORDER)
        .filter_map(|order| {
            let phase = |q: &f64| order as f64 * q;
            let sine: Vec<f64> = position?.1.iter().map(|q| phase(q).sin()).collect();
            let cosine: Vec<f64> = position?.1.iter().map(|q| phase(q).cos()).collect();
            Some([order as f64, wave_gain(&sine, &cosine, &rows) / total])
        })
        .max_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or([0.0; 2]);
    Character {
        kind: match work_share {
            w if w > DISSIPATIVE => "dissipative",
            w if w.abs() < CONSERVATIVE => "conservative",
            _ => "neither",
        },
        work_share,
        memory_share: share_of(&["time_since_reversal", "travel_since_reversal"]),
        drift_share: share_of(&["time"]),
        wave,
    }
}

/// State of a joint at the rows, one column for each variable.
struct States {
    columns: Vec<(&'static str, Vec<f64>)>,
    functions: Vec<(&'static str, &'static str, Vec<f64>)>,
}

/// The atlas of every joint with efforts.
pub(crate) fn atlas(
    design: &Design<'_>,
    before: &ArmModel,
    rigid: &ArmModel,
    after: &ArmModel,
) -> Result<Vec<JointAtlas>, RecordingError> {
    // with a reference, of the recordings after it
    let signals = &design.signals[design.observations.comparison.first_judged()..];
    let left = |model: &ArmModel| -> Result<Vec<Vec<Vec<f64>>>, RecordingError> {
        signals
            .iter()
            .map(|s| {
                let predicted = model.predict_in_band(s)?;
                let difference = |(p, e): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                    e.iter().zip(p).map(|(e, p)| e - p).collect()
                };
                Ok(predicted.iter().zip(&s.effort).map(difference).collect())
            })
            .collect()
    };
    let (of_before, of_rigid, of_after) = (left(before)?, left(rigid)?, left(after)?);
    let point = armident_model::OperatingPoint::of(design.joints());
    let arm = RigidArm::from_chain(design.chain);
    let at: Vec<Posed<'_>> =
        signals.iter().map(|s| Posed::new(design.chain, &arm, s, &point)).collect();
    let mut joints = Vec::new();
    for j in 0..design.joints() {
        if signals.iter().any(|s| s.effort[j].is_empty()) {
            continue;
        }
        let rows = |of: &[Vec<Vec<f64>>]| -> Vec<f64> {
            let pairs = signals.iter().zip(of);
            pairs.flat_map(|(s, left)| s.band.rows(&left[j])).collect()
        };
        let (b, r, a) = (rows(&of_before), rows(&of_rigid), rows(&of_after));
        let thinned: Vec<Vec<f64>> = signals
            .iter()
            .zip(&of_after)
            .map(|(s, left)| s.band.independent_rows(&left[j]))
            .collect();
        let states = States::of(&at, j);
        // share that independent rows would explain by chance
        let share = design.observations.weights.share;
        let mut regimes: Vec<Regime> = states
            .columns
            .iter()
            .filter_map(|(name, column)| regime(name, column, &b, &a, share))
            .collect();
        regimes.sort_by(|x, y| y.share_before.total_cmp(&x.share_before));
        let mut symmetries: Vec<SymmetryTest> = states
            .functions
            .iter()
            .map(|(function, points_to, column)| SymmetryTest {
                function,
                points_to,
                share_before: explained(column, &b),
                share_after: explained(column, &a),
            })
            .collect();
        symmetries.sort_by(|x, y| y.share_before.total_cmp(&x.share_before));
        let noise = &design.observations.deviation[j][design.observations.judged_from()..];
        joints.push(JointAtlas {
            joint: design.names[j].clone(),
            before: rms(&b),
            rigid: rms(&r),
            after: rms(&a),
            noise: rms(noise),
            whiteness_p: whiteness(&thinned).1,
            symmetries,
            regimes,
        });
    }
    Ok(joints)
}

impl States {
    fn of(at: &[Posed<'_>], joint: usize) -> Self {
        let n = at.iter().map(|at| at.signals.band.kept.len()).sum();
        let mut columns: Vec<(&'static str, Vec<f64>)> = [
            "speed",
            "direction",
            "load",
            "position",
            "acceleration",
            "time_since_reversal",
            "travel_since_reversal",
            "time",
        ]
        .map(|name| (name, Vec::with_capacity(n)))
        .to_vec();
        // each with the effects that it suggests
        let mut functions: Vec<(&'static str, &'static str, Vec<f64>)> = [
            ("sign(v)", "Coulomb friction"),
            ("v", "viscous friction or effort delay"),
            ("v abs(v)", "quadratic drag"),
            ("1", "offset or gravity"),
            ("q", "joint spring or gravity"),
            ("rigid", "effort gain or mass error"),
            ("abs(rigid) sign(v)", "load-dependent friction"),
            ("a", "rotor inertia"),
            ("d rigid/dt", "effort delay"),
            ("v (1 - 2 t/T)", "friction drift"),
        ]
        .map(|(name, points_to)| (name, points_to, Vec::with_capacity(n)))
        .to_vec();
        let mut start_s = 0.0;
        for at in at {
            let s = at.signals;
            let (v, q, a) = (&s.velocity[joint], &at.position[joint], &s.acceleration[joint]);
            let (load, direction) = (&at.rigid[joint], &s.direction[joint]);
            let rate = differentiate(load, s.rate_hz);
            let last = s.time_s.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
            let reversal = since_reversal(direction, &s.time_s, q);
            let bands: Vec<Vec<f64>> = vec![
                direction.clone(),
                v.clone(),
                v.iter().map(|v| v * v.abs()).collect(),
                vec![1.0; v.len()],
                q.clone(),
                load.clone(),
                load.iter().zip(direction).map(|(l, d)| l.abs() * d).collect(),
                a.clone(),
                rate,
                v.iter().zip(&s.time_s).map(|(v, t)| v * (1.0 - 2.0 * t / last)).collect(),
            ];
            for ((_, _, to), column) in functions.iter_mut().zip(&bands) {
                to.extend(s.band.rows(column));
            }
            for &k in &s.band.kept {
                let values = [
                    v[k].abs(),
                    direction[k].signum() * f64::from(u8::from(direction[k] != 0.0)),
                    load[k],
                    q[k],
                    a[k],
                    reversal[k].0,
                    reversal[k].1,
                    start_s + s.time_s[k],
                ];
                for ((_, to), value) in columns.iter_mut().zip(values) {
                    to.push(value);
                }
            }
            start_s += last;
        }
        Self { columns, functions }
    }
}

/// Time and travel since the direction changed last.
fn since_reversal(direction: &[f64], time_s: &[f64], position: &[f64]) -> Vec<(f64, f64)> {
    let mut from = 0;
    let mut sign = 0.0;
    direction
        .iter()
        .enumerate()
        .map(|(k, d)| {
            if d.abs() == 1.0 && *d != sign {
                (from, sign) = (k, *d);
            }
            (time_s[k] - time_s[from], (position[k] - position[from]).abs())
        })
        .collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Share of the mean square of `left` that one column explains alone.
fn explained(column: &[f64], left: &[f64]) -> f64 {
    let (cc, cl, ll) = (dot(column, column), dot(column, left), dot(left, left));
    if cc > 0.0 && ll > 0.0 { cl * cl / (cc * ll) } else { 0.0 }
}

/// Bins of a variable; none where it has one value.
fn regime(
    variable: &'static str,
    column: &[f64],
    before: &[f64],
    after: &[f64],
    share: f64,
) -> Option<Regime> {
    let n = column.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|x, y| column[*x].total_cmp(&column[*y]));
    let (low, high) = (column[*order.first()?], column[*order.last()?]);
    if low == high {
        return None;
    }
    // a bin ends at its quantile, or where the next value is another one; of time, at equal lengths
    let bin_of = |place: usize, value: f64| match variable {
        "time" => (((value - low) / (high - low) * BINS as f64) as usize).min(BINS - 1),
        "direction" => (value + 1.0) as usize,
        _ => place * BINS / n,
    };
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); BINS];
    for (place, &k) in order.iter().enumerate() {
        members[bin_of(place, column[k])].push(k);
    }
    let bins: Vec<Bin> = members
        .iter()
        .filter(|m| !m.is_empty())
        .map(|m| {
            let of = |left: &[f64]| -> (f64, f64) {
                let values: Vec<f64> = m.iter().map(|k| left[*k]).collect();
                (values.iter().sum::<f64>() / values.len() as f64, rms(&values))
            };
            let ((mean_before, rms_before), (mean_after, rms_after)) = (of(before), of(after));
            let (from, to) = (column[m[0]], column[m[m.len() - 1]]);
            Bin { from, to, rows: m.len(), mean_before, rms_before, mean_after, rms_after }
        })
        .collect();
    let between = |left: &[f64], mean: &dyn Fn(&Bin) -> f64| -> f64 {
        let total = left.iter().map(|x| x * x).sum::<f64>();
        let of_bins: f64 = bins.iter().map(|b| b.rows as f64 * mean(b).powi(2)).sum();
        if total == 0.0 {
            return 0.0;
        }
        // as adjusted R²: each bin takes one independent row
        let free = (n as f64 * share - bins.len() as f64).max(1.0) / (n as f64 * share);
        (1.0 - (1.0 - of_bins / total) / free).max(0.0)
    };
    Some(Regime {
        variable,
        share_before: between(before, &|b| b.mean_before),
        share_after: between(after, &|b| b.mean_after),
        bins,
    })
}
