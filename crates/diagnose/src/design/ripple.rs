//! Orders of ripple in the residual.

use armident_effects::{Effect, JointMotion, TorqueRipple};
use armident_kinematics::JointKind;
use armident_numeric::{dot, extremes};

use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;

/// Orders tried on a rotational joint: whole numbers of cycles a turn.
const HIGHEST_ORDER: usize = 130;
/// Orders tried on a translational joint \[cycles per metre\].
const TRANSLATIONAL: (f64, f64, f64) = (4.0, 60.0, 0.25);
/// Fewest waves of a ripple over the travel of its joint: what is no full wave is a curve over the position, whose period,
/// amplitude and offset are not determined together.
const FEWEST_WAVES: f64 = 1.0;
/// Least share of a joint's leftover that a peak must explain.
const LEAST_SHARE: f64 = 0.06;
/// Peaks offered a joint, and their least distance in orders.
const PEAKS: usize = 2;
const APART: f64 = 2.0;

/// Order, sine rows, cosine rows.
type Wave = (f64, Vec<f64>, Vec<f64>);

/// Least order of a ripple on a joint: one wave over the range that the judged recordings travel \[cycles per turn or metre\].
pub(crate) fn least_order(design: &Design<'_>, joint: usize) -> f64 {
    let judged = design.signals.iter().skip(design.observations.comparison.first_judged());
    let [least, most] = extremes(judged.flat_map(|s| s.position[joint].iter().copied()));
    let travel = most - least;
    let turn = match design.chain.joints[joint].kind {
        JointKind::Rotational => std::f64::consts::TAU,
        JointKind::Translational => 1.0,
    };
    FEWEST_WAVES * turn / travel.max(f64::MIN_POSITIVE)
}

/// Sine and cosine rows of every order, for every joint: formed once for a set of recordings.
pub(crate) struct RippleColumns {
    /// `[joint][order]`
    joints: Vec<Vec<Wave>>,
}

impl RippleColumns {
    pub(crate) fn new(design: &Design<'_>, at: &[Posed<'_>]) -> Self {
        let joints = (0..design.joints())
            .map(|j| {
                let orders: Vec<f64> = match at[0].arm.joints[j].kind {
                    JointKind::Rotational => (2..=HIGHEST_ORDER).map(|n| n as f64).collect(),
                    JointKind::Translational => {
                        let (low, high, step) = TRANSLATIONAL;
                        let count = ((high - low) / step) as usize;
                        (0..=count).map(|k| low + step * k as f64).collect()
                    }
                };
                let wave = |order: f64| {
                    let pieces: Vec<Vec<Vec<f64>>> = at
                        .iter()
                        .map(|at| {
                            let motion: JointMotion<'_> = at.joint(j);
                            TorqueRipple.columns(&[order, 1.0], &motion)
                        })
                        .collect();
                    let rows = |k: usize| {
                        let columns = pieces.iter().map(|p| p[k].as_slice());
                        design.observations.form_law(&design.signals, j, columns)
                    };
                    (order, rows(0), rows(1))
                };
                let least = least_order(design, j);
                orders.into_iter().filter(|order| *order >= least).map(wave).collect()
            })
            .collect();
        Self { joints }
    }

    /// The orders that explain most of the residual of a joint.
    fn peaks(&self, joint: usize, residual: &[f64]) -> Vec<f64> {
        let total = dot(residual, residual);
        let mut gains: Vec<(f64, f64)> = self.joints[joint]
            .iter()
            .map(|(order, sine, cosine)| (wave_gain(sine, cosine, residual), *order))
            .collect();
        gains.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<f64> = Vec::new();
        for (gain, order) in gains {
            if gain < LEAST_SHARE * total || kept.len() == PEAKS {
                break;
            }
            if kept.iter().all(|k| (k - order).abs() > APART) {
                kept.push(order);
            }
        }
        kept
    }

    /// Adds candidates for the peaks of a residual, with and without a second harmonic; gives their ids.
    pub(crate) fn offer(
        &self,
        design: &Design<'_>,
        at: &[Posed<'_>],
        problem: &mut LinearProblem,
        residual: &[Vec<f64>],
    ) -> Vec<usize> {
        let mut offered = Vec::new();
        for j in 0..design.joints() {
            for order in self.peaks(j, &residual[j]) {
                for harmonics in [1.0, 2.0] {
                    let shape = [order, harmonics];
                    let known = problem.candidates.iter().any(|g| {
                        g.is(&TorqueRipple) && g.location.joints == [j] && g.shape == shape
                    });
                    if known {
                        continue;
                    }
                    let id = design.push_joint_law(problem, at, &TorqueRipple, j, &shape);
                    if let Some(id) = id {
                        problem.candidates[id].searched = 1;
                        offered.push(id);
                    }
                }
            }
        }
        offered
    }
}

/// Reduction of the sum of squares of a residual by a sine and a cosine. Both at once: over a short travel
/// they are far from orthogonal.
pub(crate) fn wave_gain(sine: &[f64], cosine: &[f64], residual: &[f64]) -> f64 {
    let (ss, sc, cc) = (dot(sine, sine), dot(sine, cosine), dot(cosine, cosine));
    let (sr, cr) = (dot(sine, residual), dot(cosine, residual));
    let determinant = ss * cc - sc * sc;
    if determinant > 1e-6 * ss * cc {
        (cc * sr * sr - 2.0 * sc * sr * cr + ss * cr * cr) / determinant
    } else {
        0.0
    }
}
