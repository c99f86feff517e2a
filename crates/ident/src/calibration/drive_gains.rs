//! Gains of drives whose current is recorded and whose torque constant is not known.
//!
//! ```text
//! current_j = (Y_j x + load_j) / K_j + φ_j p_j + noise_j
//! ```
//!
//! with the load of known mass that some recordings have. Joints share the constants `x`, so the ratios of
//! the gains `K_j` follow from any motion; their size only from a known load, or from a joint whose effort
//! is known in N m.
//!
//! Method: Gauss-Newton on the triangles of the rows, started from the gains that the equation times `K_j` gives, which is
//! linear but has noise in its regressors. Standard errors by the block jackknife.
//!
//! References: M. Gautier, S. Briot, Global identification of joint drive gains and dynamic parameters of
//! robots, ASME J. Dyn. Sys. Meas. Control 136 (2014).

use armident_model::DriveGainsKnown;
use armident_motion::Motion;
use armident_numeric::{AccumulatedQr, NumericError};

use crate::regression::{BatchProblem, JointRows, KnownLoad, RANK_CUT, Term};
use armident_inference::student_t_975;
use armident_inference::{FEWEST_BLOCKS, leave_one_out, standard_error};

const MOST_STEPS: usize = 30;
/// Steps are done when no gain moves by more of itself.
const CONVERGED: f64 = 1e-9;
/// Rounds of weights and solutions.
const WEIGHT_ROUNDS: usize = 3;

/// Least relative error of a gain that recordings determine: without any, no row depends on it.
const HELD: f64 = 1e-9;

/// A gain whose 95 % interval has a larger ratio of its ends is not identifiable.
const NOT_DETERMINED: f64 = 10.0;

/// The gain of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveGain {
    /// Effort over current \[N m/A or N/A\].
    pub value: f64,
    /// Its standard error; none from too short recordings, and of a gain that is 1 by definition.
    pub standard_error: Option<f64>,
    /// 95 % interval.
    pub interval_95: Option<[f64; 2]>,
}

impl DriveGain {
    /// Whether the recordings determine it: a 95 % interval of less than a factor of ten. Also where
    /// they are too short for an error.
    pub fn is_determined(&self) -> bool {
        self.standard_error.is_none()
            || self.interval_95.is_some_and(|[a, b]| (b / a).ln().abs() < NOT_DETERMINED.ln())
    }
}

/// Gains of all drives.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveGains {
    /// Per joint; none where the effort is recorded.
    pub joints: Vec<Option<DriveGain>>,
    /// Whether something fixes their size. If not, gains are relative to one of them.
    pub absolute: bool,
    /// Where only ratios are known: the factor that makes the constants found those of the robot
    /// description, as well as one number can.
    pub scale_of_description: f64,
    /// Covariance of the logarithms of the gains, `[joint][joint]`, 0 where the effort is recorded; none where the recordings
    /// are too short for one.
    pub log_covariance: Option<Vec<Vec<f64>>>,
}

impl DriveGains {
    /// Weighted mean of the gains and its standard error, relative: how much larger than recorded the efforts of all joints
    /// are. None where no gain has an interval.
    pub fn common(&self) -> Option<(f64, f64)> {
        let covariance = self.log_covariance.as_ref().filter(|_| self.absolute)?;
        let known: Vec<(usize, f64)> = (self.joints.iter().enumerate())
            .filter_map(|(joint, gain)| {
                gain.filter(|g| g.interval_95.is_some()).map(|g| (joint, g))
            })
            .filter(|(_, gain)| gain.value > 0.0)
            .map(|(joint, gain)| (joint, gain.value.ln()))
            .collect();
        let weights: Vec<f64> =
            known.iter().map(|(joint, _)| 1.0 / covariance[*joint][*joint]).collect();
        let all: f64 = weights.iter().sum();
        let mean = known.iter().zip(&weights).map(|((_, gain), w)| w / all * gain).sum::<f64>();
        let variance: f64 = (known.iter().zip(&weights))
            .flat_map(|(a, wa)| known.iter().zip(&weights).map(move |(b, wb)| (a.0, wa, b.0, wb)))
            .map(|(a, wa, b, wb)| wa / all * (wb / all) * covariance[a][b])
            .sum();
        (all.is_finite() && variance > 0.0).then(|| (mean.exp(), variance.sqrt()))
    }

    /// What a model keeps: none where only ratios are known.
    pub fn known(&self, joints: &[&str]) -> Option<DriveGainsKnown> {
        let covariance = self.log_covariance.as_ref().filter(|_| self.absolute)?;
        let drives: Vec<(usize, f64)> = (self.joints.iter().enumerate())
            .filter_map(|(joint, gain)| Some((joint, gain.as_ref()?.value)))
            .collect();
        let row =
            |joint: usize| drives.iter().map(|(other, _)| covariance[joint][*other]).collect();
        Some(DriveGainsKnown {
            joints: drives.iter().map(|(joint, _)| joints[*joint].to_owned()).collect(),
            gain: drives.iter().map(|(_, gain)| *gain).collect(),
            log_covariance: drives.iter().map(|(joint, _)| row(*joint)).collect(),
        })
    }

    /// The gains that a model knows, of joints whose currents are recorded; none where it does not know all of them.
    pub(crate) fn of_model(
        known: &DriveGainsKnown,
        joints: &[&str],
        is_current: &[bool],
    ) -> Option<Self> {
        let place = |joint: &str| known.joints.iter().position(|name| name == joint);
        let gain = |joint: &str| {
            let (value, error) = known.of(joint)?;
            let standard_error = Some(value.abs() * error);
            Some(DriveGain { value, standard_error, interval_95: known.interval_95(joint) })
        };
        let of_joint = |(joint, is_current): (&&str, &bool)| match is_current {
            true => gain(joint).map(Some),
            false => Some(None),
        };
        let gains = joints.iter().zip(is_current).map(of_joint).collect::<Option<_>>()?;
        let covariance = |a: &&str, b: &&str| match (place(a), place(b)) {
            (Some(a), Some(b)) => known.log_covariance[a][b],
            _ => 0.0,
        };
        let row = |a: &&str| joints.iter().map(|b| covariance(a, b)).collect();
        Some(Self {
            joints: gains,
            absolute: true,
            scale_of_description: 1.0,
            log_covariance: Some(joints.iter().map(row).collect()),
        })
    }
}

struct Solved {
    /// currents over efforts
    inverse: Vec<f64>,
    values: Vec<f64>,
}

impl BatchProblem {
    /// Gains of the joints whose "effort" in these motions is a current. The loads must not have been
    /// taken off the motions.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn drive_gains(
        &self,
        motions: &[&Motion],
        is_current: &[bool],
        loads: &[KnownLoad],
    ) -> Result<DriveGains, NumericError> {
        let efforts: Vec<Option<Vec<Vec<f64>>>> = motions
            .iter()
            .map(|motion| {
                let mut sum: Option<Vec<Vec<f64>>> = None;
                for load in loads.iter().filter(|load| load.is_on(&motion.source)) {
                    let mut own = load.effort(self.arm(), motion);
                    motion.filter_columns(&mut own);
                    match &mut sum {
                        None => sum = Some(own),
                        Some(sum) => {
                            for (sum, own) in sum.iter_mut().zip(&own) {
                                sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
                            }
                        }
                    }
                }
                sum
            })
            .collect();
        // the load's effort behind the columns of each joint
        let rows = self.accumulate_with(
            motions,
            |index, joint, current| {
                let mut columns = self.columns(joint, motions[index]);
                columns.push(match &efforts[index] {
                    Some(effort) => effort[joint].clone(),
                    None => vec![0.0; motions[index].len()],
                });
                (columns, current.to_vec())
            },
            |joint| self.by_joint[joint].len() + 1,
        );
        let loaded =
            loads.iter().any(|l| l.mass_kg > 0.0 && motions.iter().any(|m| l.is_on(&m.source)));
        let absolute = loaded || is_current.iter().any(|current| !current);
        // gains are relative to that of the joint whose links take most effort, as they are described
        let described = self.described_effort(&rows.triangles);
        let strongest = (0..is_current.len())
            .filter(|&joint| is_current[joint])
            .max_by(|&a, &b| described[a].total_cmp(&described[b]));
        let reference = if absolute { None } else { strongest };
        let known: Vec<bool> = (is_current.iter().enumerate())
            .map(|(joint, current)| !current || reference == Some(joint))
            .collect();

        let triangles = &rows.triangles;
        let mut noise = self.noise_of_currents(&rows)?;
        let mut solved = self.first_gains(triangles, &known, &noise, !loaded)?;
        for _ in 0..WEIGHT_ROUNDS {
            self.settle(triangles, &known, &noise, &mut solved)?;
            for (joint, noise) in noise.iter_mut().enumerate() {
                let left =
                    triangles[joint].residual_sum_of_squares(&self.in_currents(joint, &solved));
                let floor = f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE;
                *noise = (left / rows.effort[joint].0 as f64).sqrt().max(floor);
            }
        }
        self.settle(triangles, &known, &noise, &mut solved)?;

        let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
        let mut without: Vec<Vec<f64>> = Vec::new();
        if blocks >= FEWEST_BLOCKS {
            let left: Vec<Vec<AccumulatedQr>> =
                rows.blocks.iter().map(|b| leave_one_out(b)).collect();
            for b in 0..blocks {
                let triangles: Vec<AccumulatedQr> = left.iter().map(|l| l[b].clone()).collect();
                let mut again =
                    Solved { inverse: solved.inverse.clone(), values: solved.values.clone() };
                self.settle(&triangles, &known, &noise, &mut again)?;
                without.push(again.inverse);
            }
        }
        let quantile = student_t_975(blocks.saturating_sub(1).max(1) as f64);
        let joints = (0..is_current.len())
            .map(|joint| {
                if !is_current[joint] {
                    return None;
                }
                let inverse = solved.inverse[joint];
                let value = inverse.recip();
                if known[joint] || without.is_empty() {
                    return Some(DriveGain { value, standard_error: None, interval_95: None });
                }
                let mean = without.iter().map(|g| g[joint]).sum::<f64>() / blocks as f64;
                let squares: f64 = without.iter().map(|g| (g[joint] - mean).powi(2)).sum();
                let error = standard_error(squares, blocks);
                // currents over efforts are what is linear; a gain of either sign beyond every bound is
                // none
                let ends = [inverse - quantile * error, inverse + quantile * error];
                // and no spread at all is that of a gain which the rows do not hold
                let held = error > HELD * inverse.abs();
                let bounded = held && ends[0] * ends[1] > 0.0;
                let interval = bounded.then(|| {
                    let [a, b] = ends.map(f64::recip);
                    [a.min(b), a.max(b)]
                });
                Some(DriveGain {
                    value,
                    standard_error: Some(error * value * value),
                    interval_95: interval,
                })
            })
            .collect();
        let scale_of_description =
            if absolute { 1.0 } else { self.scale(triangles, &noise, &solved) };
        let log_covariance = (!without.is_empty()).then(|| {
            let mean = |joint: usize| without.iter().map(|g| g[joint]).sum::<f64>() / blocks as f64;
            let covariance = |a: usize, b: usize| {
                let off = |g: &Vec<f64>, joint: usize| g[joint] / mean(joint) - 1.0;
                let products = without.iter().map(|g| off(g, a) * off(g, b)).sum::<f64>();
                if is_current[a] && is_current[b] {
                    products * (blocks as f64 - 1.0) / blocks as f64
                } else {
                    0.0
                }
            };
            let joints = 0..is_current.len();
            joints.clone().map(|a| joints.clone().map(|b| covariance(a, b)).collect()).collect()
        });
        Ok(DriveGains { joints, absolute, scale_of_description, log_covariance })
    }

    /// Sum of squares of the effort that the links take as they are described, per joint.
    fn described_effort(&self, triangles: &[AccumulatedQr]) -> Vec<f64> {
        let described = self.set().values(&self.arm().constants());
        (triangles.iter().zip(&self.by_joint))
            .map(|(triangle, terms)| {
                let order: Vec<usize> = (0..=terms.len() + 1).collect();
                let r = triangle.reordered(&order);
                let row = |i: usize| -> f64 {
                    let of_term = |(at, &k): (usize, &usize)| match self.terms[k] {
                        Term::Constant(c) => r[(i, at)] * described[c],
                        _ => 0.0,
                    };
                    terms.iter().enumerate().map(of_term).sum()
                };
                (0..order.len()).map(|i| row(i).powi(2)).sum()
            })
            .collect()
    }

    /// Whether an unknown is in N m or N and not in currents: it belongs to all joints.
    fn is_common(&self, k: usize) -> bool {
        matches!(self.terms[k], Term::Constant(_) | Term::Load { .. })
    }

    /// Values of the columns of a joint's triangle, load last, that give its current.
    fn in_currents(&self, joint: usize, solved: &Solved) -> Vec<f64> {
        let inverse = solved.inverse[joint];
        let of_term = |&k: &usize| {
            if self.is_common(k) { inverse * solved.values[k] } else { solved.values[k] }
        };
        self.by_joint[joint].iter().map(of_term).chain([inverse]).collect()
    }

    /// What each joint alone leaves of its current.
    fn noise_of_currents(&self, rows: &JointRows) -> Result<Vec<f64>, NumericError> {
        (rows.triangles.iter().zip(&rows.effort))
            .map(|(triangle, &(count, _, squares))| {
                let left = triangle.solve(RANK_CUT)?.residual_sum_of_squares;
                let floor = f64::EPSILON * squares.sqrt() + f64::MIN_POSITIVE;
                Ok((left / count as f64).sqrt().max(floor))
            })
            .collect()
    }

    /// Gains from `Y_j x + φ_j (K_j p_j) - K_j current_j = -load_j`, linear in everything.
    fn first_gains(
        &self,
        triangles: &[AccumulatedQr],
        known: &[bool],
        noise: &[f64],
        no_load: bool,
    ) -> Result<Solved, NumericError> {
        let (p, n) = (self.terms.len(), triangles.len());
        let mut all = AccumulatedQr::new(p + n);
        for (joint, triangle) in triangles.iter().enumerate() {
            let terms = &self.by_joint[joint];
            let (load, current) = (terms.len(), terms.len() + 1);
            let order: Vec<usize> = (0..=current).collect();
            let r = triangle.reordered(&order);
            let rows: Vec<Vec<f64>> = (0..=current)
                .map(|i| {
                    let mut row = vec![0.0; p + n + 1];
                    for (at, &k) in terms.iter().enumerate() {
                        row[k] = r[(i, at)] / noise[joint];
                    }
                    let own = r[(i, current)] / noise[joint];
                    row[p + n] = -r[(i, load)] / noise[joint];
                    if known[joint] {
                        row[p + n] += own;
                    } else {
                        row[p + joint] = -own;
                    }
                    row
                })
                .collect();
            all.push_rows(&rows);
        }
        debug_assert!(!no_load || known.iter().any(|k| *k));
        let found = all.solve(RANK_CUT)?.solution;
        let inverse: Vec<f64> = (0..n)
            .map(|joint| {
                let gain = if known[joint] { 1.0 } else { found[p + joint] };
                if gain == 0.0 { 1.0 } else { gain.recip() }
            })
            .collect();
        let mut values = found[..p].to_vec();
        for (k, value) in values.iter_mut().enumerate() {
            if !self.is_common(k)
                && let Some(joint) = self.by_joint.iter().position(|terms| terms.contains(&k))
            {
                *value *= inverse[joint];
            }
        }
        Ok(Solved { inverse, values })
    }

    /// Gauss and Newton to the end.
    fn settle(
        &self,
        triangles: &[AccumulatedQr],
        known: &[bool],
        noise: &[f64],
        solved: &mut Solved,
    ) -> Result<(), NumericError> {
        let (p, n) = (self.terms.len(), triangles.len());
        let of_loads: Vec<Vec<f64>> = self.load_prior();
        for _ in 0..MOST_STEPS {
            let mut all = AccumulatedQr::new(p + n);
            for (joint, triangle) in triangles.iter().enumerate() {
                let terms = &self.by_joint[joint];
                let (load, current) = (terms.len(), terms.len() + 1);
                let order: Vec<usize> = (0..=current).collect();
                let r = triangle.reordered(&order);
                let inverse = solved.inverse[joint];
                let rows: Vec<Vec<f64>> = (0..=current)
                    .map(|i| {
                        let mut row = vec![0.0; p + n + 1];
                        let mut effort = r[(i, load)];
                        for (at, &k) in terms.iter().enumerate() {
                            let x = r[(i, at)];
                            if self.is_common(k) {
                                effort += x * solved.values[k];
                                row[k] = inverse * x / noise[joint];
                            } else {
                                row[k] = x / noise[joint];
                            }
                        }
                        if !known[joint] {
                            row[p + joint] = effort / noise[joint];
                        }
                        // what is common is sought as a change, what is the joint's own as it is
                        row[p + n] = (r[(i, current)] - inverse * effort) / noise[joint];
                        row
                    })
                    .collect();
                all.push_rows(&rows);
            }
            let prior: Vec<Vec<f64>> = of_loads
                .iter()
                .map(|row| {
                    let known: f64 = row.iter().zip(&solved.values).map(|(a, b)| a * b).sum();
                    let zeros = vec![0.0; n];
                    [&row[..], &zeros, &[-known]].concat()
                })
                .collect();
            all.push_rows(&prior);
            let step = all.solve(RANK_CUT)?.solution;
            for (k, value) in solved.values.iter_mut().enumerate() {
                *value = if self.is_common(k) { *value + step[k] } else { step[k] };
            }
            let mut moved = 0.0_f64;
            for (joint, inverse) in solved.inverse.iter_mut().enumerate() {
                moved = moved.max((step[p + joint] / *inverse).abs());
                *inverse += step[p + joint];
            }
            if moved < CONVERGED {
                break;
            }
        }
        Ok(())
    }

    /// Factor by which the rigid effort found becomes that of the description, over all rows.
    fn scale(&self, triangles: &[AccumulatedQr], noise: &[f64], solved: &Solved) -> f64 {
        let described = self.set().values(&self.arm().constants());
        let (mut both, mut own) = (0.0, 0.0);
        for (joint, triangle) in triangles.iter().enumerate() {
            let terms = &self.by_joint[joint];
            let order: Vec<usize> = (0..=terms.len() + 1).collect();
            let r = triangle.reordered(&order);
            let weight = (solved.inverse[joint] / noise[joint]).powi(2);
            for i in 0..order.len() {
                let (mut of_description, mut found) = (0.0, 0.0);
                for (at, &k) in terms.iter().enumerate() {
                    if let Term::Constant(c) = self.terms[k] {
                        of_description += r[(i, at)] * described[c];
                        found += r[(i, at)] * solved.values[k];
                    }
                }
                both += weight * of_description * found;
                own += weight * found * found;
            }
        }
        if own > 0.0 && both != 0.0 { both / own } else { 1.0 }
    }
}
