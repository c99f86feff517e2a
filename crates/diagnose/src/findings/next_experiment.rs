//! The motion that separates findings from their alternatives best.
//!
//! T-optimal design (Atkinson & Fedorov 1975): among motions inside the limits, the one on which the
//! indistinguishable models differ most. Their parameters are those of the recordings; a refit of both to the new
//! motion would reduce the difference, which is not counted here.

use std::f64::consts::TAU;

use armident_kinematics::DrivingAxisChain;
use armident_recording::{JointChannels, Recording, RecordingError};

use armident_model::{ArmModel, PreparedRecording};

/// Length of a motion \[s\] and its rate \[Hz\].
const LENGTH_S: f64 = 20.0;
const RATE_HZ: f64 = 100.0;
/// Rest at both ends, and rise of the motion \[s\].
const REST_S: f64 = 0.3;
const RISE_S: f64 = 1.5;
/// Shares of the limits that are used.
const SHARE_OF_RANGE: f64 = 0.8;
const SHARE_OF_SPEED: f64 = 0.6;
const SHARE_OF_EFFORT: f64 = 0.9;
/// Range of a joint without limits, to either side \[rad or m\], and speed \[rad/s or m/s\].
const FREE_RANGE: f64 = 1.5;
const FREE_SPEED: f64 = 1.5;
/// Periods of the slowest and fastest swing \[s\].
const PERIODS_S: [f64; 4] = [10.0, 4.0, 1.8, 0.9];
/// Travels, as shares of the range.
const TRAVELS: [f64; 4] = [0.9, 0.4, 0.12, 0.03];
/// Phases of motions of all joints.
const PHASES: usize = 4;
/// Steps of the golden angle spread phases evenly, whatever their number.
const GOLDEN: f64 = 0.618_033_988_75;

/// A motion that separates findings from their alternatives.
#[derive(Debug, Clone)]
pub struct NextMotion {
    /// Positions, velocities and accelerations of all joints.
    pub motion: Recording,
    /// In words.
    pub description: String,
    /// Pairs of rivals whose efforts differ on it by more than the noise of one recorded sample (root mean
    /// square, on some joint).
    pub separated: usize,
    /// Pairs of rivals.
    pub pairs: usize,
    /// Median difference of a pair, in standard deviations of one recorded sample.
    pub separation: f64,
}

/// Largest useful difference, in standard deviations.
const PLENTY: f64 = 4.0;

/// Two models that the recordings do not distinguish.
pub(crate) struct Rivals<'a> {
    pub(crate) one: &'a ArmModel,
    pub(crate) other: &'a ArmModel,
    /// joints in question
    pub(crate) joints: Vec<usize>,
}

/// One swing of a joint.
#[derive(Clone, Copy)]
struct Swing {
    middle: f64,
    travel: f64,
    period_s: f64,
    phase: f64,
}

struct Candidate {
    swings: Vec<Option<Swing>>,
    description: String,
}

/// The motion with the largest differences over all rivals, each counted up to the largest useful one; none where no motion
/// inside the limits separates a pair.
///
/// # Errors
/// None that planned recordings could cause.
pub(crate) fn next_motion(
    chain: &DrivingAxisChain,
    noise: &[f64],
    rivals: &[Rivals<'_>],
) -> Result<Option<NextMotion>, RecordingError> {
    let mut best: Option<(f64, NextMotion)> = None;
    let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
    for candidate in candidates(chain, rivals) {
        let motion = candidate.motion(chain)?;
        let mut differences = Vec::new();
        for pair in rivals {
            let motion = PreparedRecording::of(&motion, &names)?;
            let (one, other) =
                (pair.one.predict_prepared(&motion)?, pair.other.predict_prepared(&motion)?);
            let within = one.iter().zip(&chain.joints).all(|(effort, joint)| {
                let most = joint.limits.effort.filter(|e| *e > 0.0).map(|e| SHARE_OF_EFFORT * e);
                effort.iter().all(|e| most.is_none_or(|most| e.abs() <= most))
            });
            if !within {
                break;
            }
            let of_joint = |j: usize| {
                let squares: f64 = one[j].iter().zip(&other[j]).map(|(a, b)| (a - b).powi(2)).sum();
                (squares / one[j].len() as f64).sqrt() / noise[j].max(f64::MIN_POSITIVE)
            };
            differences.push((0..one.len()).map(of_joint).fold(0.0, f64::max));
        }
        if differences.len() < rivals.len() {
            continue;
        }
        let worth: f64 = differences.iter().map(|d| d.min(PLENTY)).sum();
        let separated = differences.iter().filter(|d| **d > 1.0).count();
        if separated > 0 && best.as_ref().is_none_or(|(most, _)| worth > *most) {
            differences.sort_by(f64::total_cmp);
            let separation = differences[differences.len() / 2];
            let description = candidate.description;
            let pairs = rivals.len();
            best = Some((worth, NextMotion { motion, description, separated, pairs, separation }));
        }
    }
    Ok(best.map(|(_, next)| next))
}

fn candidates(chain: &DrivingAxisChain, rivals: &[Rivals<'_>]) -> Vec<Candidate> {
    let n = chain.dof();
    let mut all = Vec::new();
    let mut blamed: Vec<usize> = rivals.iter().flat_map(|r| r.joints.clone()).collect();
    blamed.sort_unstable();
    blamed.dedup();
    for &j in &blamed {
        let name = &chain.joints[j].name;
        for period_s in PERIODS_S {
            for share in TRAVELS {
                let (middle, half) = range(chain, j);
                let mut swings = vec![None; n];
                swings[j] = Some(limited(chain, j, middle, share * half, period_s, 0.0));
                all.push(Candidate {
                    swings: swings.clone(),
                    description: format!(
                        "{name} swings over {:.2} to either side in {period_s} s, the others rest",
                        swings[j].map_or(0.0, |s| s.travel),
                    ),
                });
                // the same while the joints before and after it change the load slowly
                for (other, swing) in swings.iter_mut().enumerate().filter(|(o, _)| *o != j) {
                    let (middle, half) = range(chain, other);
                    let phase = GOLDEN * other as f64;
                    *swing = Some(limited(chain, other, middle, 0.6 * half, 13.0, phase));
                }
                all.push(Candidate {
                    swings: swings.clone(),
                    description: format!(
                        "{name} swings over {:.2} to either side in {period_s} s while the others change \
                         the pose slowly",
                        swings[j].map_or(0.0, |s| s.travel),
                    ),
                });
            }
        }
    }
    for k in 0..PHASES {
        for base_s in [3.0, 8.0] {
            let swings = (0..n)
                .map(|j| {
                    let (middle, half) = range(chain, j);
                    let phase = GOLDEN * (k * n + j) as f64;
                    // periods without a common multiple
                    let period_s = base_s * (1.0 + 0.37 * ((GOLDEN * (j + k) as f64) % 1.0));
                    Some(limited(chain, j, middle, 0.9 * half, period_s, phase))
                })
                .collect();
            all.push(Candidate {
                swings,
                description: format!("all joints swing at once, in about {base_s} s"),
            });
        }
    }
    all
}

/// Middle of a joint's range and half of the used part.
fn range(chain: &DrivingAxisChain, joint: usize) -> (f64, f64) {
    let limits = &chain.joints[joint].limits;
    match (limits.lower, limits.upper) {
        (Some(low), Some(high)) if high > low => {
            let half = (0.5 * SHARE_OF_RANGE * (high - low)).min(FREE_RANGE);
            // arms whose limits are whole turns stay near their zero
            let middle = (0.5 * (low + high)).clamp(-TAU, TAU);
            (middle, half)
        }
        _ => (0.0, FREE_RANGE),
    }
}

/// A swing whose speed stays inside the limit: of a travel too far for its period, the travel gives way.
fn limited(
    chain: &DrivingAxisChain,
    joint: usize,
    middle: f64,
    travel: f64,
    period_s: f64,
    phase: f64,
) -> Swing {
    let speed = chain.joints[joint].limits.velocity.filter(|v| *v > 0.0).unwrap_or(FREE_SPEED);
    let most = SHARE_OF_SPEED * speed.min(2.0 * FREE_SPEED) * period_s / TAU;
    Swing { middle, travel: travel.min(most), period_s, phase }
}

/// Rises from 0 to 1 between two times with two smooth derivatives; value and derivatives.
fn rise(t: f64, from: f64, length: f64) -> [f64; 3] {
    let x = ((t - from) / length).clamp(0.0, 1.0);
    let value = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    let slope = 30.0 * x * x * (1.0 - x) * (1.0 - x) / length;
    let curvature = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (length * length);
    [value, slope, curvature]
}

impl Candidate {
    fn motion(&self, chain: &DrivingAxisChain) -> Result<Recording, RecordingError> {
        let count = (LENGTH_S * RATE_HZ) as usize + 1;
        let time_s: Vec<f64> = (0..count).map(|k| k as f64 / RATE_HZ).collect();
        let joints =
            chain.joints.iter().zip(&self.swings).enumerate().map(|(j, (joint, swing))| {
                let at = |t: f64| -> [f64; 3] {
                    let Some(swing) = swing else { return [range(chain, j).0, 0.0, 0.0] };
                    let up = rise(t, REST_S, RISE_S);
                    let down = rise(t, LENGTH_S - REST_S - RISE_S, RISE_S);
                    let w = [up[0] * (1.0 - down[0]), up[1] - down[1], up[2] - down[2]];
                    let omega = TAU / swing.period_s;
                    let (sin, cos) = (omega * t + TAU * swing.phase).sin_cos();
                    let s = [sin, omega * cos, -omega * omega * sin];
                    [
                        swing.middle + swing.travel * w[0] * s[0],
                        swing.travel * (w[1] * s[0] + w[0] * s[1]),
                        swing.travel * (w[2] * s[0] + 2.0 * w[1] * s[1] + w[0] * s[2]),
                    ]
                };
                let columns: Vec<[f64; 3]> = time_s.iter().map(|t| at(*t)).collect();
                let column = |k: usize| Some(columns.iter().map(|c| c[k]).collect());
                JointChannels {
                    position: column(0),
                    velocity: column(1),
                    acceleration: column(2),
                    ..JointChannels::new(&joint.name)
                }
            });
        Recording::new("next_motion", time_s.clone(), joints.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rise_is_smooth() {
        for t in [0.1, 0.7, 1.3] {
            let h = 1e-5;
            let [before, now, after] = [t - h, t, t + h].map(|t| rise(t, 0.0, 1.5));
            assert!(((after[0] - before[0]) / (2.0 * h) - now[1]).abs() < 1e-6);
            assert!(((after[1] - before[1]) / (2.0 * h) - now[2]).abs() < 1e-5);
        }
        assert_eq!(rise(-1.0, 0.0, 1.5), [0.0; 3]);
        assert_eq!(rise(9.0, 0.0, 1.5)[0], 1.0);
    }
}
