//! Weighted least squares of the minimal set and joint effects from ordinary motion.
//!
//! `τ_j = Σ Y_jk x_k + Σ φ_jl(motion) p_l + noise_j`: all columns and the effort pass through the same
//! zero-phase low-pass, nonlinear columns being formed before it. Each joint's rows are reduced to one
//! triangle, so that weighting by the joints' noise needs no second pass over the samples.

use armident_dynamics::RigidArm;
use armident_effects::{Effect, EffectOnJoint, JointMotion, LIBRARY};
use armident_numeric::{AccumulatedQr, Mat, NumericError, eliminate_in_order};
use armident_recording::Motion;

use crate::minimal_set::{MinimalSet, random_states};
use crate::quantiles::student_t_975;

/// Relative rank cut of unit columns: only what is exactly undetermined is cut, what is badly
/// determined shows in its standard error.
const RANK_CUT: f64 = 1e-9;
/// Cut of the structural elimination at random states.
const DEPENDENT: f64 = 1e-8;
/// Periods of the cut-off frequency left out at both ends of a recording, of the fit and of its
/// errors alike: the filter does not know what came before, so accelerations are wrong there.
const EDGE_PERIODS: f64 = 1.0;
/// Speed resolution as a share of the RMS speed: below it the sign of the velocity is not trusted.
const SPEED_RESOLUTION: f64 = 0.01;
/// Reweighting ends when no joint's noise level moves by more than this share.
const WEIGHT_TOLERANCE: f64 = 1e-6;
const MOST_REWEIGHTINGS: usize = 50;

/// One unknown of the batch problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term {
    /// A constant of the minimal set, by index.
    Constant(usize),
    /// A parameter of an effect on a joint.
    Effect {
        /// Joint, from 0.
        joint: usize,
        /// Effect, index into [`LIBRARY`].
        effect: usize,
        /// Parameter, index into the law's list.
        parameter: usize,
    },
}

/// An unknown that is the same as a combination of others on every motion of this arm.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedTerm {
    /// The unknown that is not estimated on its own.
    pub term: Term,
    /// What it adds to: (index into [`BatchProblem::terms`], coefficient).
    pub into: Vec<(usize, f64)>,
}

/// Rows of a set of recordings, one triangle per joint.
#[derive(Debug, Clone)]
pub struct JointRows {
    /// per joint, over the terms of [`BatchProblem::terms_of_joint`]
    triangles: Vec<AccumulatedQr>,
    /// per joint: number, sum and sum of squares of the filtered effort
    effort: Vec<(usize, f64, f64)>,
    /// independent samples over samples, weighted by samples
    share: f64,
}

/// The unknowns of an arm and where they appear.
#[derive(Debug, Clone)]
pub struct BatchProblem<'a> {
    arm: &'a RigidArm,
    set: &'a MinimalSet,
    /// Unknowns estimated.
    pub terms: Vec<Term>,
    /// Unknowns merged into others by the arm's structure (rotor inertia of joint 1 and `U1_33`).
    pub merged: Vec<MergedTerm>,
    by_joint: Vec<Vec<usize>>,
}

/// Effort error of one joint on a set of recordings, on the filtered effort.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFit {
    /// Root mean square of the residual \[N m or N\].
    pub rmse: f64,
    /// `norm(residual) / norm(effort - mean)`.
    pub relative: f64,
}

/// Estimates with their trust.
#[derive(Debug, Clone)]
pub struct BatchEstimate {
    /// One value per term of the problem.
    pub values: Vec<f64>,
    /// Covariance of the values, counting only independent samples.
    pub covariance: Mat<f64>,
    /// Half-width factor of 95 % intervals.
    pub quantile_95: f64,
    /// Noise level of each joint's filtered effort \[N m or N\].
    pub effort_noise: Vec<f64>,
    /// Numerical rank.
    pub rank: usize,
    /// Condition number of the weighted unit columns.
    pub condition: f64,
    /// Per term: share of its direction that the recordings do not determine, 0 to 1.
    pub undetermined: Vec<f64>,
    /// Rows used, all joints.
    pub rows: usize,
    /// Independent samples over samples.
    pub independent_share: f64,
    /// Fit on the training recordings.
    pub train: Vec<JointFit>,
}

impl BatchEstimate {
    /// Standard error of term `k`.
    pub fn standard_error(&self, k: usize) -> f64 {
        self.covariance[(k, k)].sqrt()
    }
}

impl<'a> BatchProblem<'a> {
    /// The minimal set and every linear effect of the library on every joint, less what the arm's
    /// structure merges (decided at random states: rotor inertia of the first joint is its `U_33`).
    pub fn new(arm: &'a RigidArm, set: &'a MinimalSet) -> Self {
        let n = arm.dof();
        let mut all: Vec<Term> = (0..set.len()).map(Term::Constant).collect();
        for joint in 0..n {
            for (effect, law) in LIBRARY.iter().enumerate() {
                for parameter in 0..law.law().parameters.len() {
                    all.push(Term::Effect { joint, effect, parameter });
                }
            }
        }
        // effect by effect, so that what is merged away is an effect and not a rigid constant, and
        // rotor inertia (last in the library) before friction
        let states = random_states(arm, 12 * n + 30);
        let columns_of = |joint: usize, pick: usize| -> Vec<f64> {
            states.iter().map(|s| [&s.0, &s.1, &s.2][pick][joint]).collect()
        };
        let mut matrix = Mat::<f64>::zeros(states.len() * n, all.len());
        for (row, (q, dq, ddq)) in states.iter().enumerate() {
            let rigid = set.columns().regressor(arm, q, dq, ddq);
            for joint in 0..n {
                for k in 0..set.len() {
                    matrix[(row * n + joint, k)] = rigid[joint * set.len() + k];
                }
            }
        }
        for joint in 0..n {
            let [q, dq, ddq] = [0, 1, 2].map(|pick| columns_of(joint, pick));
            let time: Vec<f64> = (0..states.len()).map(|t| t as f64).collect();
            let motion = JointMotion {
                time_s: &time,
                position: &q,
                velocity: &dq,
                acceleration: &ddq,
                speed_resolution: 1e-6,
            };
            for (effect, law) in LIBRARY.iter().enumerate() {
                for (parameter, column) in law.columns(&motion).iter().enumerate() {
                    let term = Term::Effect { joint, effect, parameter };
                    let Some(k) = all.iter().position(|t| *t == term) else { continue };
                    for (row, value) in column.iter().enumerate() {
                        matrix[(row * n + joint, k)] = *value;
                    }
                }
            }
        }
        let order: Vec<usize> = (0..all.len()).collect();
        let elimination = eliminate_in_order(&matrix, &order, DEPENDENT);
        let mut kept = elimination.kept.clone();
        kept.sort_unstable();
        let place = |k: usize| kept.iter().position(|&x| x == k).unwrap_or(usize::MAX);
        let merged = elimination
            .dropped
            .iter()
            .map(|d| MergedTerm {
                term: all[d.column],
                into: d.combination.iter().map(|&(k, x)| (place(k), x)).collect(),
            })
            .collect();
        let terms: Vec<Term> = kept.iter().map(|&k| all[k]).collect();
        let by_joint = (0..n)
            .map(|joint| {
                (0..terms.len())
                    .filter(|&k| match terms[k] {
                        Term::Constant(c) => set.constants[c].joint >= joint,
                        Term::Effect { joint: on, .. } => on == joint,
                    })
                    .collect()
            })
            .collect();
        Self { arm, set, terms, merged, by_joint }
    }

    /// Terms that appear in the effort of a joint.
    pub fn terms_of_joint(&self, joint: usize) -> &[usize] {
        &self.by_joint[joint]
    }

    /// Label of a term: the constant's, or `effect.parameter(joint)`.
    pub fn label(&self, term: &Term, joint_names: &[&str]) -> String {
        match *term {
            Term::Constant(k) => self.set.constants[k].label(),
            Term::Effect { joint, effect, parameter } => {
                let law = LIBRARY[effect].law();
                if law.parameters.len() == 1 {
                    format!("{}({})", law.slug, joint_names[joint])
                } else {
                    format!(
                        "{}.{}({})",
                        law.slug, law.parameters[parameter].name, joint_names[joint]
                    )
                }
            }
        }
    }

    /// Columns of one joint over a motion, through its filter, in the order of
    /// [`Self::terms_of_joint`].
    fn columns(&self, joint: usize, motion: &Motion) -> Vec<Vec<f64>> {
        let wanted: Vec<usize> = self.by_joint[joint]
            .iter()
            .filter_map(|&k| match self.terms[k] {
                Term::Constant(c) => Some(c),
                Term::Effect { .. } => None,
            })
            .collect();
        let mut columns = self.set.columns().of_motion(
            self.arm,
            joint,
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
            &wanted,
        );
        let effects: Vec<(usize, Vec<Vec<f64>>)> = LIBRARY
            .iter()
            .enumerate()
            .map(|(e, law)| (e, effect_columns(*law, joint, motion)))
            .collect();
        for &k in &self.by_joint[joint] {
            if let Term::Effect { effect, parameter, .. } = self.terms[k] {
                columns.push(effects[effect].1[parameter].clone());
            }
        }
        motion.filter_columns(&mut columns);
        columns
    }

    /// Reduces recordings to one triangle per joint. Memory: the columns of one joint of one
    /// recording at a time.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn accumulate(&self, motions: &[&Motion]) -> JointRows {
        let n = self.arm.dof();
        let mut rows = JointRows {
            triangles: self.by_joint.iter().map(|t| AccumulatedQr::new(t.len())).collect(),
            effort: vec![(0, 0.0, 0.0); n],
            share: 1.0,
        };
        let (mut independent, mut samples) = (0.0, 0.0);
        for motion in motions {
            #[expect(clippy::expect_used, reason = "documented panic: checked by the callers")]
            let effort = motion.effort_filtered.as_ref().expect("a motion with efforts");
            let edge = match &motion.filter {
                Some(filter) => {
                    let edge = (EDGE_PERIODS * motion.rate_hz / filter.cutoff_hz()).ceil() as usize;
                    edge.min(motion.len() / 4)
                }
                None => 0,
            };
            let kept = edge..motion.len() - edge;
            independent += motion.independent_share() * kept.len() as f64;
            samples += kept.len() as f64;
            for joint in 0..n {
                let mut columns = self.columns(joint, motion);
                for column in &mut columns {
                    column.truncate(kept.end);
                    column.drain(..kept.start);
                }
                let y = &effort[joint][kept.clone()];
                rows.triangles[joint].push_columns(&columns, y);
                let total = &mut rows.effort[joint];
                total.0 += y.len();
                total.1 += y.iter().sum::<f64>();
                total.2 += y.iter().map(|e| e * e).sum::<f64>();
            }
        }
        rows.share = if samples > 0.0 { independent / samples } else { 1.0 };
        rows
    }

    /// Solves for all terms, each joint weighted by its own noise.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate(&self, rows: &JointRows) -> Result<BatchEstimate, NumericError> {
        let n = self.arm.dof();
        let count = |joint: usize| rows.effort[joint].0 as f64;
        // first weights: what each joint alone cannot fit
        let mut noise: Vec<f64> = (0..n)
            .map(|joint| {
                let alone = rows.triangles[joint].solve(RANK_CUT)?;
                let floor = f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE;
                Ok((alone.residual_sum_of_squares / count(joint)).sqrt().max(floor))
            })
            .collect::<Result<_, NumericError>>()?;
        let mut solved = self.weighted(rows, &noise)?;
        let mut freedom = 0.0;
        for _ in 0..MOST_REWEIGHTINGS {
            let mut moved = 0.0_f64;
            freedom = 0.0;
            for joint in 0..n {
                let terms = &self.by_joint[joint];
                let pick = |v: &[f64]| terms.iter().map(|&k| v[k]).collect::<Vec<_>>();
                let own = Mat::from_fn(terms.len(), terms.len(), |i, j| {
                    solved.unit_covariance[(terms[i], terms[j])]
                });
                let paid = rows.triangles[joint].trace_with(&own) / noise[joint].powi(2);
                let squares =
                    rows.triangles[joint].residual_sum_of_squares(&pick(&solved.solution));
                let independent = count(joint) * rows.share;
                let left = (independent - paid).max(1.0);
                freedom += left;
                let floor = f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE;
                let level = (squares * rows.share / left).sqrt().max(floor);
                moved = moved.max((level / noise[joint] - 1.0).abs());
                noise[joint] = level;
            }
            solved = self.weighted(rows, &noise)?;
            if moved < WEIGHT_TOLERANCE {
                break;
            }
        }
        let p = self.terms.len();
        let covariance = Mat::from_fn(p, p, |i, j| solved.unit_covariance[(i, j)] / rows.share);
        let train = self.fit(rows, &solved.solution);
        Ok(BatchEstimate {
            values: solved.solution,
            covariance,
            quantile_95: student_t_975(freedom),
            effort_noise: noise,
            rank: solved.rank,
            condition: solved.condition,
            undetermined: solved.undetermined,
            rows: rows.effort.iter().map(|e| e.0).sum(),
            independent_share: rows.share,
            train,
        })
    }

    fn weighted(
        &self,
        rows: &JointRows,
        noise: &[f64],
    ) -> Result<armident_numeric::LeastSquares, NumericError> {
        let mut all = AccumulatedQr::new(self.terms.len());
        for (joint, triangle) in rows.triangles.iter().enumerate() {
            all.merge_weighted(triangle, &self.by_joint[joint], 1.0 / noise[joint]);
        }
        all.solve(RANK_CUT)
    }

    /// Effort error of given values on accumulated recordings, per joint.
    pub fn fit(&self, rows: &JointRows, values: &[f64]) -> Vec<JointFit> {
        rows.triangles
            .iter()
            .zip(&self.by_joint)
            .zip(&rows.effort)
            .map(|((triangle, terms), &(count, sum, squares))| {
                let x: Vec<f64> = terms.iter().map(|&k| values[k]).collect();
                let residual = triangle.residual_sum_of_squares(&x);
                let varying = squares - sum * sum / count as f64;
                JointFit {
                    rmse: (residual / count as f64).sqrt(),
                    relative: (residual / varying).sqrt(),
                }
            })
            .collect()
    }

    /// Values of the minimal constants within a vector of all terms.
    pub fn constants(&self, values: &[f64]) -> Vec<f64> {
        let mut constants = vec![0.0; self.set.len()];
        for (term, &value) in self.terms.iter().zip(values) {
            if let Term::Constant(k) = *term {
                constants[k] = value;
            }
        }
        constants
    }

    /// The effects within a vector of all terms; merged parameters are zero.
    pub fn effects(&self, values: &[f64], joint_names: &[&str]) -> Vec<EffectOnJoint> {
        let mut list: Vec<EffectOnJoint> = Vec::new();
        for (term, &value) in self.terms.iter().zip(values) {
            let Term::Effect { joint, effect, parameter } = *term else { continue };
            let law = LIBRARY[effect].law();
            let name = joint_names[joint];
            let index = match list.iter().position(|e| e.effect == law.slug && e.joint == name) {
                Some(index) => index,
                None => {
                    list.push(EffectOnJoint {
                        effect: law.slug.to_owned(),
                        joint: name.to_owned(),
                        parameters: vec![0.0; law.parameters.len()],
                    });
                    list.len() - 1
                }
            };
            list[index].parameters[parameter] = value;
        }
        list
    }
}

/// Columns of an effect on one joint of a motion, not filtered.
pub(crate) fn effect_columns(effect: &dyn Effect, joint: usize, motion: &Motion) -> Vec<Vec<f64>> {
    let velocity = &motion.velocity[joint];
    let mean_square = velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len() as f64;
    effect.columns(&JointMotion {
        time_s: &motion.time_s,
        position: &motion.position[joint],
        velocity,
        acceleration: &motion.acceleration[joint],
        speed_resolution: (SPEED_RESOLUTION * mean_square.sqrt()).max(f64::MIN_POSITIVE),
    })
}
