//! Algorithm 2 on recordings: one joint at a time, later joints first, with the covariance of what
//! is already known carried along.

use armident_dynamics::RigidArm;
use armident_effects::{CoulombFriction, Effect, JointMotion, ViscousFriction, directions_with};
use armident_motion::Motion;
use armident_numeric::{Mat, NumericError, PseudoInverse};

use super::plan::{Plan, Step};
use crate::minimal_set::MinimalSet;
use crate::used_samples::EDGE_PERIODS;
use armident_inference::student_t_975;

/// Relative rank cut of unit columns.
const RANK_CUT: f64 = 1e-9;
/// Speed below which the direction of a filtered motion is not trusted, as a share of the largest.
const SPEED_RESOLUTION: f64 = 1e-3;

/// Why recordings cannot be used with a plan.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Algorithm2Error {
    /// The plan was made for another arm.
    #[error("the plan is for joints {planned:?}, the arm has {found:?}")]
    OtherArm {
        /// Joints of the plan.
        planned: Vec<String>,
        /// Joints of the arm.
        found: Vec<String>,
    },
    /// A plan names a constant the arm does not have.
    #[error("step {step} of the plan seeks `{label}`, which is not in the arm's minimal set")]
    UnknownConstant {
        /// Step of the plan.
        step: String,
        /// The label.
        label: String,
    },
    /// A step names an experiment that the plan does not list.
    #[error("step {step} of the plan uses experiment `{id}`, which the plan does not list")]
    UnknownExperiment {
        /// Step of the plan.
        step: String,
        /// The experiment.
        id: String,
    },
    /// A recording has no effort.
    #[error("experiment `{id}` has no effort column for joint `{joint}`")]
    NoEffort {
        /// The experiment.
        id: String,
        /// The joint.
        joint: String,
    },
    /// The least squares failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// What one step found.
#[derive(Debug, Clone)]
pub struct StepResult {
    /// Number of the step in the paper.
    pub step: String,
    /// Equation used.
    pub equation: String,
    /// Observed joint.
    pub observed: String,
    /// Labels of the constants found.
    pub unknowns: Vec<String>,
    /// Rows of the least-squares problem.
    pub rows: usize,
    /// Numerical rank, friction columns included.
    pub rank: usize,
    /// Columns, friction included.
    pub columns: usize,
    /// Condition number of the unit columns.
    pub condition: f64,
    /// Residual RMS \[N m or N\].
    pub rmse: f64,
    /// Viscous coefficient and Coulomb level of the moving joint with standard errors, where the
    /// moving joint is the observed one and the recording determines them.
    pub friction: Option<[(f64, f64); 2]>,
}

/// Constants found by Algorithm 2.
#[derive(Debug, Clone)]
pub struct Algorithm2Estimate {
    /// Value of each constant of the minimal set; NaN where no step determined it.
    pub values: Vec<f64>,
    /// Covariance of the values.
    pub covariance: Mat<f64>,
    /// Half-width factor of 95 % intervals, per constant (Student t of the step's joint).
    pub quantile_95: Vec<f64>,
    /// Noise level of each joint's effort \[N m or N\], from the residuals; NaN for joints not used.
    pub effort_noise: Vec<f64>,
    /// The steps.
    pub steps: Vec<StepResult>,
}

impl Algorithm2Estimate {
    /// Standard error of constant `k`.
    pub fn standard_error(&self, k: usize) -> f64 {
        self.covariance[(k, k)].sqrt()
    }
}

/// Runs the steps of a plan on its recordings.
///
/// `recordings[e]` belongs to `plan.experiments[e]` and has the plan's joints in chain order.
/// Constants found by earlier steps are estimates, not known numbers: with the step's solution
/// `x = A⁺(y - B z)` and the covariance `P` of the earlier `z`,
///
/// ```text
/// cov(x)    = σ² A⁺A⁺ᵀ + (A⁺B) P (A⁺B)ᵀ
/// cov(x, z) = -(A⁺B) P
/// ```
///
/// σ² is pooled over the steps that observe the same joint. Every step has recordings of its own, so
/// its noise is independent of that of earlier steps.
///
/// # Errors
/// [`Algorithm2Error`] when plan, arm and recordings do not fit one another.
pub fn algorithm2(
    arm: &RigidArm,
    set: &MinimalSet,
    plan: &Plan,
    recordings: &[Motion],
) -> Result<Algorithm2Estimate, Algorithm2Error> {
    let labels = set.labels();
    let mut values = vec![f64::NAN; set.len()];
    let mut solved = Vec::new();
    for step in &plan.steps {
        let unknowns: Vec<usize> = step
            .unknowns
            .iter()
            .map(|label| {
                labels.iter().position(|l| l == label).ok_or_else(|| {
                    Algorithm2Error::UnknownConstant {
                        step: step.step.clone(),
                        label: label.clone(),
                    }
                })
            })
            .collect::<Result<_, _>>()?;
        let observed = joint_index(plan, &step.observed)?;
        let known: Vec<usize> = (0..set.len())
            .filter(|&k| values[k].is_finite() && set.constants[k].joint >= observed)
            .filter(|k| !unknowns.contains(k))
            .collect();
        // own constants left for a later step (U_33 of an axis perpendicular to that of joint r) show
        // themselves here only if the observed joint is dithered
        let dithered = plan
            .experiments
            .iter()
            .any(|e| step.experiments.contains(&e.id) && e.dither.contains_key(&step.observed));
        let later: Vec<usize> = (0..set.len())
            .filter(|&k| dithered && set.constants[k].joint == observed)
            .filter(|k| !unknowns.contains(k) && !known.contains(k))
            .collect();
        let rows =
            rows_of_step(arm, set, plan, recordings, step, observed, &unknowns, &known, &later)?;
        let one = solve_step(&rows, &known, &values)?;
        for (&k, &x) in unknowns.iter().zip(&one.solution) {
            values[k] = x;
        }
        solved.push((observed, unknowns, known, one));
    }
    Ok(with_covariance(arm.dof(), set.len(), plan, values, &solved))
}

/// Columns of one step over all its samples.
struct StepRows {
    unknown: Vec<Vec<f64>>,
    friction: Vec<Vec<f64>>,
    /// constants of the observed joint that a later step determines
    later: Vec<Vec<f64>>,
    known: Vec<Vec<f64>>,
    effort: Vec<f64>,
    /// samples counted as independent, over samples
    share: f64,
}

struct SolvedStep {
    /// unknowns, then friction, then constants of a later step
    solution: Vec<f64>,
    unit_covariance: Mat<f64>,
    /// `A⁺B`, rows as `solution`, columns as the known constants
    carried: Vec<Vec<f64>>,
    residual_sum_of_squares: f64,
    rows: usize,
    rank: usize,
    condition: f64,
    share: f64,
    has_friction: bool,
}

fn joint_index(plan: &Plan, name: &str) -> Result<usize, Algorithm2Error> {
    plan.joints.iter().position(|j| j == name).ok_or_else(|| Algorithm2Error::OtherArm {
        planned: vec![name.to_owned()],
        found: plan.joints.clone(),
    })
}

fn rows_of_step(
    arm: &RigidArm,
    set: &MinimalSet,
    plan: &Plan,
    recordings: &[Motion],
    step: &Step,
    observed: usize,
    unknowns: &[usize],
    known: &[usize],
    later: &[usize],
) -> Result<StepRows, Algorithm2Error> {
    let mut all = StepRows {
        unknown: vec![Vec::new(); unknowns.len()],
        friction: Vec::new(),
        later: vec![Vec::new(); later.len()],
        known: vec![Vec::new(); known.len()],
        effort: Vec::new(),
        share: 1.0,
    };
    for id in &step.experiments {
        let index = plan.experiments.iter().position(|e| &e.id == id).ok_or_else(|| {
            Algorithm2Error::UnknownExperiment { step: step.step.clone(), id: id.clone() }
        })?;
        let (experiment, motion) = (&plan.experiments[index], &recordings[index]);
        let effort = motion.effort_filtered.as_ref().ok_or_else(|| Algorithm2Error::NoEffort {
            id: id.clone(),
            joint: step.observed.clone(),
        })?;
        let moves = plan.moving_joints(experiment);
        // what is held stands where it stood on average: its encoder shows only noise
        let still = |columns: &[Vec<f64>], keep_mean: bool| -> Vec<Vec<f64>> {
            columns
                .iter()
                .zip(&moves)
                .map(|(column, &moves)| {
                    if moves {
                        return column.clone();
                    }
                    let mean = column.iter().sum::<f64>() / column.len() as f64;
                    vec![if keep_mean { mean } else { 0.0 }; column.len()]
                })
                .collect()
        };
        let q = still(&motion.position, true);
        let dq = still(&motion.velocity, false);
        let ddq = still(&motion.acceleration, false);
        let wanted: Vec<usize> = unknowns.iter().chain(known).chain(later).copied().collect();
        let mut columns = set.columns().of_motion(arm, observed, &q, &dq, &ddq, &wanted);
        let own_motion = experiment.moving == step.observed || moves[observed];
        let mut friction = Vec::new();
        if own_motion {
            // exact velocities have exact signs; filtered ones fade through zero
            let speed_resolution = if motion.filter.is_some() {
                SPEED_RESOLUTION * dq[observed].iter().fold(0.0_f64, |a, v| a.max(v.abs()))
            } else {
                0.0
            };
            let joint_motion = JointMotion {
                kind: arm.joints[observed].kind,
                time_s: &motion.time_s,
                position: &q[observed],
                velocity: &dq[observed],
                acceleration: &ddq[observed],
                direction: &directions_with(&dq[observed], speed_resolution),
                rigid_effort: &[],
                temperature_c: &[],
            };
            friction.extend(ViscousFriction.columns(&[], &joint_motion));
            friction.extend(CoulombFriction.columns(&[], &joint_motion));
        }
        motion.filter_columns(&mut columns);
        motion.filter_columns(&mut friction);
        let edge = motion
            .filter
            .as_ref()
            .map_or(0, |f| (EDGE_PERIODS * motion.rate_hz / f.cutoff_hz()).ceil() as usize);
        let kept = edge.min(motion.len() / 4)..motion.len() - edge.min(motion.len() / 4);
        let (unknown, rest) = columns.split_at(unknowns.len());
        let (known_columns, later_columns) = rest.split_at(known.len());
        for (all, column) in all.unknown.iter_mut().zip(unknown) {
            all.extend_from_slice(&column[kept.clone()]);
        }
        for (all, column) in all.known.iter_mut().zip(known_columns) {
            all.extend_from_slice(&column[kept.clone()]);
        }
        for (all, column) in all.later.iter_mut().zip(later_columns) {
            all.extend_from_slice(&column[kept.clone()]);
        }
        let before = all.effort.len();
        if !friction.is_empty() && all.friction.is_empty() {
            all.friction = vec![vec![0.0; before]; friction.len()];
        }
        for (k, column) in all.friction.iter_mut().enumerate() {
            match friction.get(k) {
                Some(f) => column.extend_from_slice(&f[kept.clone()]),
                None => column.extend(std::iter::repeat_n(0.0, kept.len())),
            }
        }
        all.effort.extend_from_slice(&effort[observed][kept]);
        all.share = all.share.min(motion.independent_share());
    }
    Ok(all)
}

fn solve_step(
    rows: &StepRows,
    known: &[usize],
    values: &[f64],
) -> Result<SolvedStep, Algorithm2Error> {
    let columns: Vec<&Vec<f64>> =
        rows.unknown.iter().chain(&rows.friction).chain(&rows.later).collect();
    let count = rows.effort.len();
    let a = Mat::from_fn(count, columns.len(), |i, j| columns[j][i]);
    let mut rest = rows.effort.clone();
    for (column, &k) in rows.known.iter().zip(known) {
        for (y, x) in rest.iter_mut().zip(column) {
            *y -= x * values[k];
        }
    }
    let inverse = PseudoInverse::of(&a, RANK_CUT)?;
    let solution = inverse.apply(&rest);
    let per_known: Vec<Vec<f64>> = rows.known.iter().map(|column| inverse.apply(column)).collect();
    let carried = (0..columns.len())
        .map(|row| per_known.iter().map(|column| column[row]).collect())
        .collect();
    let residual_sum_of_squares = (0..count)
        .map(|i| {
            let fitted: f64 = columns.iter().zip(&solution).map(|(c, x)| c[i] * x).sum();
            (rest[i] - fitted).powi(2)
        })
        .sum();
    Ok(SolvedStep {
        solution,
        unit_covariance: inverse.unit_covariance(),
        carried,
        residual_sum_of_squares,
        rows: count,
        rank: inverse.rank,
        condition: inverse.condition,
        share: rows.share,
        has_friction: !rows.friction.is_empty(),
    })
}

fn with_covariance(
    dof: usize,
    count: usize,
    plan: &Plan,
    values: Vec<f64>,
    solved: &[(usize, Vec<usize>, Vec<usize>, SolvedStep)],
) -> Algorithm2Estimate {
    // noise pooled over the steps that observe one joint; independent samples counted
    let (mut squares, mut freedom) = (vec![0.0; dof], vec![0.0; dof]);
    for (observed, _, _, step) in solved {
        squares[*observed] += step.residual_sum_of_squares * step.share;
        freedom[*observed] += step.rows as f64 * step.share - step.rank as f64;
    }
    let variance: Vec<f64> = (0..dof)
        .map(|j| squares[j] / if freedom[j] > 0.0 { freedom[j] } else { f64::NAN })
        .collect();

    let mut covariance = Mat::<f64>::zeros(count, count);
    let mut quantile_95 = vec![f64::NAN; count];
    let mut steps = Vec::new();
    for ((observed, unknowns, known, step), planned) in solved.iter().zip(&plan.steps) {
        // samples that are not independent inform as much as their independent share
        let noise = variance[*observed] / step.share;
        let covariance_of = |row: usize, other: usize| {
            noise * step.unit_covariance[(row, other)]
                + known
                    .iter()
                    .enumerate()
                    .map(|(a, &ka)| {
                        known
                            .iter()
                            .enumerate()
                            .map(|(b, &kb)| {
                                step.carried[row][a] * covariance[(ka, kb)] * step.carried[other][b]
                            })
                            .sum::<f64>()
                    })
                    .sum::<f64>()
        };
        let own: Vec<Vec<f64>> = (0..step.solution.len())
            .map(|row| (0..step.solution.len()).map(|other| covariance_of(row, other)).collect())
            .collect();
        // correlation with everything found before, also what this step does not use itself
        let cross: Vec<Vec<f64>> = (0..unknowns.len())
            .map(|row| {
                (0..count)
                    .map(|other| {
                        -known
                            .iter()
                            .enumerate()
                            .map(|(a, &ka)| step.carried[row][a] * covariance[(ka, other)])
                            .sum::<f64>()
                    })
                    .collect()
            })
            .collect();
        for (row, &k) in unknowns.iter().enumerate() {
            for other in 0..count {
                covariance[(k, other)] = cross[row][other];
                covariance[(other, k)] = cross[row][other];
            }
        }
        for (row, &k) in unknowns.iter().enumerate() {
            quantile_95[k] = student_t_975(freedom[*observed]);
            for (other, &o) in unknowns.iter().enumerate() {
                covariance[(k, o)] = own[row][other];
            }
        }
        let first_friction = unknowns.len();
        let friction = step.has_friction.then(|| {
            [0, 1].map(|f| {
                let k = first_friction + f;
                (step.solution[k], own[k][k].sqrt())
            })
        });
        steps.push(StepResult {
            step: planned.step.clone(),
            equation: planned.equation.clone(),
            observed: planned.observed.clone(),
            unknowns: planned.unknowns.clone(),
            rows: step.rows,
            rank: step.rank,
            columns: step.solution.len(),
            condition: step.condition,
            rmse: (step.residual_sum_of_squares / step.rows.max(1) as f64).sqrt(),
            friction,
        });
    }
    Algorithm2Estimate {
        values,
        covariance,
        quantile_95,
        effort_noise: variance.iter().map(|v| v.sqrt()).collect(),
        steps,
    }
}
