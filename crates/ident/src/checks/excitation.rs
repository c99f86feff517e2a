//! Which constants a recording determines, and why not the others.

use armident_motion::{Motion, RESTING_RANGE};
use armident_numeric::{AccumulatedQr, NumericError, range};

use super::rows::ChannelRows;
use super::verdict::Verdict;
use crate::regression::{BatchProblem, RANK_CUT, Term, spread_of_numbers};

/// Standard error of a well determined constant, as a share of its size, ...
const WELL_DETERMINED: f64 = 0.1;
/// ... and of a poorly determined one; beyond, it is not determined.
const POORLY_DETERMINED: f64 = 1.0;
/// Signal over noise below which a constant is poorly determined even alone.
const LOW_SIGNAL: f64 = 1.0 / WELL_DETERMINED;
/// Share of a constant's direction that counts as not determined at all.
const OPEN: f64 = 1e-3;

/// How well a recording determines one constant.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ConstantCheck {
    /// Label of the constant.
    pub label: String,
    /// Joint it belongs to.
    pub joint: String,
    /// SI unit.
    pub unit: &'static str,
    /// Size by the robot description: what all its links, each off by its size, add up to.
    pub size: f64,
    /// Standard error from the recordings alone, counting independent samples; none where they leave
    /// the constant open.
    pub standard_error: Option<f64>,
    /// `ok` up to a tenth of the size, `doubtful` up to the size, `cannot_tell` beyond.
    pub verdict: Verdict,
    /// Why it is not determined well.
    pub reason: Option<String>,
}

/// Motion of one joint over all recordings.
pub(super) struct JointActivity {
    /// largest less smallest position \[rad or m\]
    pub(super) range: f64,
    /// share of the moving time in the rarer direction
    pub(super) rarer_direction: f64,
}

pub(super) fn activity(motions: &[Motion], joint: usize) -> JointActivity {
    let all = |pick: &dyn Fn(&Motion) -> &[f64]| -> Vec<f64> {
        motions.iter().flat_map(|m| pick(m).to_vec()).collect()
    };
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let position = all(&|m| &m.position[joint]);
    let velocity = all(&|m| &m.velocity[joint]);
    let speed_rms = rms(&velocity);
    let forth = velocity.iter().filter(|v| **v > 0.1 * speed_rms).count() as f64;
    let back = velocity.iter().filter(|v| **v < -0.1 * speed_rms).count() as f64;
    JointActivity {
        range: range(&position),
        rarer_direction: if forth + back > 0.0 { forth.min(back) / (forth + back) } else { 0.0 },
    }
}

/// The constants in the order of the minimal set, and how many of the unknowns have full rank.
pub(super) fn excitation(
    problem: &BatchProblem,
    names: &[&str],
    rows: &[ChannelRows],
    motions: &[Motion],
    is_mute: &[bool],
) -> Result<(Vec<ConstantCheck>, usize), NumericError> {
    let set = problem.set();
    let mut all = AccumulatedQr::new(problem.terms.len());
    let mut signal = vec![0.0; problem.terms.len()];
    for (joint, of_joint) in rows.iter().enumerate().filter(|(joint, _)| !is_mute[*joint]) {
        let terms = problem.terms_of_joint(joint);
        let own: Vec<usize> = (0..terms.len()).collect();
        let triangle = of_joint.triangle.with_unknowns(&own);
        let freedom = (of_joint.effective - terms.len() as f64).max(1.0);
        let noise = of_joint.residual_rms * (of_joint.effective / freedom).max(1.0).sqrt();
        let floor = f64::EPSILON * of_joint.effort_sd + f64::MIN_POSITIVE;
        let weight = (of_joint.effective / of_joint.samples).sqrt() / noise.max(floor);
        for (&k, norm) in terms.iter().zip(triangle.column_norms()) {
            signal[k] += (weight * norm).powi(2);
        }
        all.merge_weighted(&triangle, terms, weight);
    }
    let solved = all.solve(RANK_CUT)?;
    let sizes = spread_of_numbers(problem.arm(), set, 1.0, 0.0).unwrap_or_default();
    let resting: Vec<bool> =
        (0..names.len()).map(|j| activity(motions, j).range < RESTING_RANGE).collect();
    let covariance = &solved.unit_covariance;
    let mut checks = Vec::new();
    for (k, term) in problem.terms.iter().enumerate() {
        let Term::Constant(c) = *term else { continue };
        let constant = &set.constants[c];
        let size = sizes.iter().map(|column| column[c].powi(2)).sum::<f64>().sqrt();
        let open = solved.undetermined[k] > OPEN;
        let standard_error = (!open).then(|| covariance[(k, k)].max(0.0).sqrt());
        let relative = standard_error.map_or(f64::INFINITY, |s| s / size);
        let verdict = match relative {
            r if r <= WELL_DETERMINED => Verdict::Ok,
            r if r <= POORLY_DETERMINED => Verdict::Doubtful,
            _ => Verdict::Inconclusive,
        };
        let reason = (verdict != Verdict::Ok).then(|| {
            let joint = constant.joint;
            let over_noise = signal[k].sqrt() * size;
            if resting[joint] {
                return format!("{} does not move", names[joint]);
            }
            if over_noise < LOW_SIGNAL {
                let why = match constant.unit() {
                    "kg m2" => "low acceleration",
                    "kg m" => "little change in gravity load",
                    _ => "low acceleration",
                };
                return format!("{why} (effort {over_noise:.1} times its noise)");
            }
            let correlation = |l: usize| {
                let spread = (covariance[(k, k)] * covariance[(l, l)]).sqrt();
                if spread > 0.0 { (covariance[(k, l)] / spread).abs() } else { 0.0 }
            };
            let partner = (0..problem.terms.len())
                .filter(|&l| l != k)
                .max_by(|&a, &b| correlation(a).total_cmp(&correlation(b)));
            match partner {
                Some(l) if !open => format!(
                    "collinear with {} (correlation {:.2})",
                    problem.label(&problem.terms[l], names),
                    correlation(l)
                ),
                _ => "collinear with other constants".to_owned(),
            }
        });
        checks.push(ConstantCheck {
            label: constant.label(),
            joint: names[constant.joint].to_owned(),
            unit: constant.unit(),
            size,
            standard_error,
            verdict,
            reason,
        });
    }
    Ok((checks, solved.rank))
}
