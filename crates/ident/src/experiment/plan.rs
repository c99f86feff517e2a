//! Experiments for Algorithm 2: what is held where, what moves, what each step estimates.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use armident_dynamics::{RigidArm, inverse_dynamics};
use armident_kinematics::DrivingAxisChain;
use armident_numeric::{Mat, NumericError, PseudoInverse};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::equations::single_motion_row;
use super::step_motion::StepMotion;
use super::task::{Task, tasks};
use crate::minimal_set::MinimalSet;

/// Schema of `plan.json`.
pub const PLAN_SCHEMA: &str = "armident.plan/1";

/// Random configurations tried per step.
const CANDIDATES: usize = 240;
/// Samples of the motion at which a configuration is judged.
const JUDGED_SAMPLES: usize = 16;
/// Above this condition number of the unit columns further joints are moved (theory, step 2.1).
const CONDITION_LIMIT: f64 = 1e3;
/// Relative rank cut of unit columns.
const RANK_CUT: f64 = 1e-9;
/// Share of a limit that a motion may use.
const LIMIT_SHARE: f64 = 0.8;
/// Slowest motion accepted, as a share of the quickness that the speed limit allows: a pose in which
/// the arm can only creep is worth less than another pose.
const SLOWEST: f64 = 0.25;
/// Coulomb level assumed where none is given, as a share of the effort limit: harmonic-drive and
/// belt joints of industrial arms lie at 1-5 %.
const ASSUMED_COULOMB: f64 = 0.03;

/// What the user may choose about a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSettings {
    /// Samples per second of the trajectories.
    pub rate_hz: f64,
    /// `A` for rotational joints \[rad\].
    pub amplitude_rad: f64,
    /// `A` for translational joints \[m\].
    pub amplitude_m: f64,
    /// `σ` \[1/s\], lowered where limits ask for it.
    pub sigma_per_s: f64,
    /// Known Coulomb levels \[N m or N\] by joint.
    pub coulomb: BTreeMap<String, f64>,
    /// Small oscillation of the observed joint that breaks its stiction.
    pub dither: Option<Dither>,
    /// Seed of the configurations tried.
    pub seed: u64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self {
            rate_hz: 200.0,
            amplitude_rad: PI / 6.0,
            amplitude_m: 0.15,
            sigma_per_s: 10.0,
            coulomb: BTreeMap::new(),
            dither: None,
            seed: 1992,
        }
    }
}

/// `amplitude sin(2π frequency t)` on a held joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dither {
    /// Amplitude \[rad or m\].
    pub amplitude: f64,
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
}

/// A list of experiments and the steps that use them; the content of `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// [`PLAN_SCHEMA`].
    pub schema: String,
    /// Robot name.
    pub robot: String,
    /// Base link of the chain.
    pub base_link: String,
    /// Tip link of the chain.
    pub tip_link: String,
    /// Gravity in the base link \[m/s2\].
    pub gravity: [f64; 3],
    /// Joints frozen off the chain \[rad or m\].
    pub locked: BTreeMap<String, f64>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Seed of the configurations.
    pub seed: u64,
    /// How joints are to be held on a real arm, and what stiction does.
    pub holding: String,
    /// Motions to record.
    pub experiments: Vec<Experiment>,
    /// What is estimated from them, in order.
    pub steps: Vec<Step>,
    /// What could not be planned.
    pub notes: Vec<String>,
}

/// One motion to record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Short name; the trajectory and the recording are `<id>.csv`.
    pub id: String,
    /// The moving joint.
    pub moving: String,
    /// Positions of the held joints \[rad or m\].
    pub held: BTreeMap<String, f64>,
    /// Motion of the moving joint.
    pub motion: StepMotion,
    /// Oscillation of held joints.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub dither: BTreeMap<String, Dither>,
}

/// One estimation step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Number in the paper.
    pub step: String,
    /// Equation of the paper.
    pub equation: String,
    /// Joint whose effort is used.
    pub observed: String,
    /// Labels of the constants sought.
    pub unknowns: Vec<String>,
    /// Ids of the experiments used.
    pub experiments: Vec<String>,
    /// Condition number of the unit columns, the motion being as planned.
    pub condition: f64,
    /// Whether all unknowns can be determined.
    pub full_rank: bool,
    /// RMS effort the unknowns cause at the observed joint, by the URDF's values \[N m or N\].
    pub signal_rms: f64,
    /// Coulomb level of the observed joint \[N m or N\], given or assumed; absent without effort limit.
    pub coulomb: Option<f64>,
    /// Whether `coulomb` is an assumption (3 % of the effort limit).
    pub coulomb_assumed: bool,
}

impl Step {
    /// Signal over Coulomb level.
    pub fn signal_to_stiction(&self) -> Option<f64> {
        self.coulomb.filter(|&c| c > 0.0).map(|c| self.signal_rms / c)
    }
}

const HOLDING: &str = "Hold joints with the position servo, brakes released and integral action on: \
    a braked joint shows no effort. The effort of a held joint is known only to its stiction: where \
    signal/stiction is below 5, approach the held position from both sides and average, or plan with \
    --dither AMPLITUDE,HZ, which keeps the held joint moving a little so that friction averages out.";

/// One candidate: where everything stands and how the mover moves.
#[derive(Debug, Clone)]
struct Candidate {
    moving: usize,
    q: Vec<f64>,
    motion: StepMotion,
    /// rows of the unknowns' columns (and the mover's friction when it is observed itself)
    rows: Vec<Vec<f64>>,
}

/// Plans the experiments of Algorithm 2 inside the joints' limits.
///
/// For every step random configurations inside the limits are tried and those kept that determine
/// the unknowns best together: greedy choice by the determinant of the information matrix in the
/// columns of the paper's equations (55)-(61).
///
/// # Errors
/// [`NumericError`] when the arm holds numbers that are not finite.
pub fn plan(
    chain: &DrivingAxisChain,
    set: &MinimalSet,
    settings: &PlanSettings,
) -> Result<Plan, NumericError> {
    Planner {
        chain,
        arm: RigidArm::from_chain(chain),
        set,
        settings,
        random: Pcg64::seed_from_u64(settings.seed),
        experiments: Vec::new(),
        notes: Vec::new(),
    }
    .run()
}

struct Planner<'a> {
    chain: &'a DrivingAxisChain,
    arm: RigidArm,
    set: &'a MinimalSet,
    settings: &'a PlanSettings,
    random: Pcg64,
    experiments: Vec<Experiment>,
    notes: Vec<String>,
}

impl Planner<'_> {
    fn run(mut self) -> Result<Plan, NumericError> {
        let mut steps = Vec::new();
        for task in tasks(&self.arm, self.set) {
            steps.push(self.step(&task)?);
        }
        let gravity = self.chain.gravity_base;
        Ok(Plan {
            schema: PLAN_SCHEMA.to_owned(),
            robot: self.chain.robot.clone(),
            base_link: self.chain.base_link.clone(),
            tip_link: self.chain.tip_link.clone(),
            gravity: [gravity.x, gravity.y, gravity.z],
            locked: self.chain.locked.clone(),
            joints: self.chain.joints.iter().map(|j| j.name.clone()).collect(),
            rate_hz: self.settings.rate_hz,
            seed: self.settings.seed,
            holding: HOLDING.to_owned(),
            experiments: self.experiments,
            steps,
            notes: self.notes,
        })
    }

    fn step(&mut self, task: &Task) -> Result<Step, NumericError> {
        let mut best: Option<(Vec<Candidate>, f64, bool)> = None;
        for &mover in &task.movers {
            let pool = self.candidates(task, &[mover]);
            let chosen = choose(&pool, task.configurations);
            let (condition, full) = judge(&chosen)?;
            if best.as_ref().is_none_or(|(_, c, f)| (full, -condition) > (*f, -c)) {
                best = Some((chosen, condition, full));
            }
        }
        let (mut chosen, mut condition, mut full) =
            best.unwrap_or((Vec::new(), f64::INFINITY, false));
        // needed at zero gravity only: one joint at a time until the rank is full
        for &further in &task.further_movers {
            if full && condition <= CONDITION_LIMIT {
                break;
            }
            let mut pool = chosen.clone();
            pool.extend(self.candidates(task, &[further]));
            let more = choose_beside(&pool, chosen.len(), task.configurations);
            let (c, f) = judge(&more)?;
            if (f, -c) > (full, -condition) {
                (chosen, condition, full) = (more, c, f);
            }
        }
        let observed = &self.chain.joints[task.observed];
        let labels: Vec<String> =
            task.unknowns.iter().map(|&k| self.set.constants[k].label()).collect();
        if !full {
            self.notes.push(format!(
                "step {} cannot separate {} at joint `{}` inside the joint limits",
                task.step,
                labels.join(", "),
                observed.name
            ));
        }
        let given = self.settings.coulomb.get(&observed.name).copied();
        let assumed = observed.limits.effort.map(|e| ASSUMED_COULOMB * e);
        let signal_rms = self.signal(task, &chosen);
        let experiments = chosen.iter().map(|c| self.add_experiment(c, task.observed)).collect();
        Ok(Step {
            step: task.step.to_owned(),
            equation: task.equation.number().to_owned(),
            observed: observed.name.clone(),
            unknowns: labels,
            experiments,
            condition,
            full_rank: full,
            signal_rms,
            coulomb: given.or(assumed),
            coulomb_assumed: given.is_none(),
        })
    }

    /// RMS effort of the unknowns by the URDF's values.
    fn signal(&self, task: &Task, chosen: &[Candidate]) -> f64 {
        let values = self.set.values(&self.arm.constants());
        let squares: Vec<f64> = chosen
            .iter()
            .flat_map(|c| &c.rows)
            .map(|row| {
                task.unknowns.iter().zip(row).map(|(&k, x)| values[k] * x).sum::<f64>().powi(2)
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }

    fn add_experiment(&mut self, candidate: &Candidate, observed: usize) -> String {
        let id = format!("e{:03}", self.experiments.len() + 1);
        let name = |j: usize| self.chain.joints[j].name.clone();
        let held = (0..self.arm.dof())
            .filter(|&j| j != candidate.moving)
            .map(|j| (name(j), candidate.q[j]))
            .collect();
        let mut dither = BTreeMap::new();
        if let (Some(d), true) = (self.settings.dither, observed != candidate.moving) {
            dither.insert(name(observed), d);
        }
        self.experiments.push(Experiment {
            id: id.clone(),
            moving: name(candidate.moving),
            held,
            motion: candidate.motion,
            dither,
        });
        id
    }

    fn candidates(&mut self, task: &Task, movers: &[usize]) -> Vec<Candidate> {
        let mut all = Vec::new();
        for _ in 0..CANDIDATES {
            for &moving in movers {
                if let Some(candidate) = self.candidate(task, moving) {
                    all.push(candidate);
                }
            }
        }
        all
    }

    fn candidate(&mut self, task: &Task, moving: usize) -> Option<Candidate> {
        let n = self.arm.dof();
        let mut q: Vec<f64> = (0..n)
            .map(|j| {
                let (low, high) = self.range(j);
                let draw: f64 = self.random.random_range(0.0..1.0);
                // joints beyond the observed one only add known effort: keep them in the middle
                if j > task.observed { 0.5 * (low + high) } else { low + (high - low) * draw }
            })
            .collect();
        let motion = self.motion(moving, &mut q)?;
        let constants: Vec<_> = task.unknowns.iter().map(|&k| self.set.constants[k]).collect();
        let own_friction = moving == task.observed;
        let rows = (0..JUDGED_SAMPLES)
            .map(|k| {
                let phase = (k as f64 + 0.5) / JUDGED_SAMPLES as f64;
                // the lively part: the first third of the way there and of the way back
                let half = motion.half_s();
                let time = StepMotion::REST_S
                    + if phase < 0.5 {
                        phase * 2.0 * half / 3.0
                    } else {
                        half + (phase - 0.5) * 2.0 * half / 3.0
                    };
                let (position, dq, ddq) = motion.at(time);
                let mut at = q.clone();
                at[moving] = position;
                let mut row =
                    single_motion_row(&self.arm, moving, task.observed, &at, dq, ddq, &constants);
                if own_friction {
                    row.extend([dq, if dq == 0.0 { 0.0 } else { dq.signum() }]);
                }
                row
            })
            .collect();
        Some(Candidate { moving, q, motion, rows })
    }

    /// Range of positions used for a joint \[rad or m\].
    fn range(&self, j: usize) -> (f64, f64) {
        let joint = &self.chain.joints[j];
        let reach = if joint.kind.is_rotational() { PI } else { 0.5 };
        let (low, high) = match (joint.limits.lower, joint.limits.upper) {
            (Some(low), Some(high)) => (low, high),
            (Some(low), None) => (low, low + 2.0 * reach),
            (None, Some(high)) => (high - 2.0 * reach, high),
            (None, None) => (-reach, reach),
        };
        let margin = 0.5 * (1.0 - LIMIT_SHARE) * (high - low) * 0.5;
        let (low, high) = (low + margin, high - margin);
        if joint.kind.is_rotational() && high - low > 2.0 * PI {
            let middle = (0.5 * (low + high)).clamp(low + PI, high - PI);
            (middle - PI, middle + PI)
        } else {
            (low, high)
        }
    }

    /// Motion of the mover inside its position, speed and effort limits; moves `q` of the mover to
    /// its start. `None` when holding the arm there already needs too much effort.
    fn motion(&self, moving: usize, q: &mut [f64]) -> Option<StepMotion> {
        let joint = &self.chain.joints[moving];
        let (low, high) = self.range(moving);
        let wanted = if joint.kind.is_rotational() {
            self.settings.amplitude_rad
        } else {
            self.settings.amplitude_m
        };
        let amplitude = wanted.min(0.5 * (high - low));
        q[moving] = q[moving].min(high - amplitude).max(low);
        let mut sigma = self.settings.sigma_per_s;
        if let Some(speed) = joint.limits.velocity {
            sigma = sigma.min(LIMIT_SHARE * speed * std::f64::consts::E / amplitude);
        }
        let slowest = SLOWEST * sigma;
        while sigma >= slowest {
            let motion = StepMotion { start: q[moving], amplitude, sigma_per_s: sigma };
            if self.within_effort(moving, q, &motion) {
                return Some(motion);
            }
            sigma *= 0.8;
        }
        None
    }

    fn within_effort(&self, moving: usize, q: &[f64], motion: &StepMotion) -> bool {
        let n = self.arm.dof();
        let (mut at, mut v, mut a) = (q.to_vec(), vec![0.0; n], vec![0.0; n]);
        // largest accelerations at the start and at 2/σ, largest speed at 1/σ, both ways
        let starts = [0.0, motion.half_s()];
        let instants = [1e-9, 1.0, 2.0].map(|x| x / motion.sigma_per_s);
        starts.iter().flat_map(|s| instants.map(|t| StepMotion::REST_S + s + t)).all(|time| {
            (at[moving], v[moving], a[moving]) = motion.at(time);
            let effort = inverse_dynamics(&self.arm, &at, &v, &a);
            effort.iter().zip(&self.chain.joints).all(|(e, joint)| {
                joint.limits.effort.is_none_or(|limit| e.abs() <= LIMIT_SHARE * limit)
            })
        })
    }
}

/// Greedy choice of `count` candidates with the largest information determinant.
fn choose(pool: &[Candidate], count: usize) -> Vec<Candidate> {
    choose_beside(pool, 0, count)
}

/// The same, the first `fixed` candidates being chosen already.
fn choose_beside(pool: &[Candidate], fixed: usize, count: usize) -> Vec<Candidate> {
    let Some(first) = pool.first() else { return Vec::new() };
    let p = first.rows[0].len().max(pool.iter().map(|c| c.rows[0].len()).max().unwrap_or(0));
    // unit columns over the whole pool make the ridge below comparable for all unknowns
    let mut scale = vec![0.0_f64; p];
    for row in pool.iter().flat_map(|c| &c.rows) {
        for (s, x) in scale.iter_mut().zip(row) {
            *s += x * x;
        }
    }
    let scale: Vec<f64> =
        scale.iter().map(|s| if *s > 0.0 { 1.0 / s.sqrt() } else { 0.0 }).collect();
    let information: Vec<nalgebra::DMatrix<f64>> = pool
        .iter()
        .map(|candidate| {
            let mut m = nalgebra::DMatrix::zeros(p, p);
            for row in &candidate.rows {
                for i in 0..row.len() {
                    for j in 0..row.len() {
                        m[(i, j)] += row[i] * scale[i] * row[j] * scale[j];
                    }
                }
            }
            m
        })
        .collect();
    // a ridge far below one configuration's information, so that the first choices compare
    let ridge = 1e-6 / pool.len() as f64;
    let mut total = nalgebra::DMatrix::identity(p, p) * ridge;
    let mut chosen: Vec<usize> = (0..fixed).collect();
    for &k in &chosen {
        total += &information[k];
    }
    while chosen.len() < fixed + count && chosen.len() < pool.len() {
        let worth = |k: usize| {
            (&total + &information[k]).cholesky().map_or(f64::NEG_INFINITY, |c| {
                c.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
            })
        };
        let best = (fixed..pool.len())
            .filter(|k| !chosen.contains(k))
            .map(|k| (k, worth(k)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((best, _)) = best else { break };
        total += &information[best];
        chosen.push(best);
    }
    chosen.into_iter().map(|k| pool[k].clone()).collect()
}

/// Condition number of the stacked unit columns, and whether their rank is full.
fn judge(chosen: &[Candidate]) -> Result<(f64, bool), NumericError> {
    let rows: Vec<&Vec<f64>> = chosen.iter().flat_map(|c| &c.rows).collect();
    let p = rows.iter().map(|r| r.len()).max().unwrap_or(0);
    if p == 0 {
        return Ok((f64::INFINITY, false));
    }
    let stacked = Mat::from_fn(rows.len(), p, |i, j| rows[i].get(j).copied().unwrap_or(0.0));
    let inverse = PseudoInverse::of(&stacked, RANK_CUT)?;
    Ok((inverse.condition, inverse.rank == p))
}

impl Plan {
    /// Samples of an experiment's trajectory: time, and per chain joint position, velocity and
    /// acceleration columns.
    pub fn trajectory(&self, experiment: &Experiment) -> PlannedTrajectory {
        let samples = (experiment.motion.duration_s() * self.rate_hz).ceil() as usize + 1;
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / self.rate_hz).collect();
        let joints = self
            .joints
            .iter()
            .map(|name| {
                time_s
                    .iter()
                    .map(|&t| {
                        if *name == experiment.moving {
                            return experiment.motion.at(t);
                        }
                        let at = experiment.held.get(name).copied().unwrap_or(0.0);
                        match experiment.dither.get(name) {
                            None => (at, 0.0, 0.0),
                            Some(dither) => {
                                let w = 2.0 * PI * dither.frequency_hz;
                                let (sin, cos) = (w * t).sin_cos();
                                let a = dither.amplitude;
                                (at + a * sin, a * w * cos, -a * w * w * sin)
                            }
                        }
                    })
                    .collect()
            })
            .collect();
        PlannedTrajectory { time_s, joints }
    }

    /// Which joints move in an experiment, in chain order.
    pub fn moving_joints(&self, experiment: &Experiment) -> Vec<bool> {
        let moves =
            |name: &String| *name == experiment.moving || experiment.dither.contains_key(name);
        self.joints.iter().map(moves).collect()
    }
}

/// The samples of one planned experiment.
#[derive(Debug, Clone)]
pub struct PlannedTrajectory {
    /// Time \[s\].
    pub time_s: Vec<f64>,
    /// `[joint][sample]`: position, velocity, acceleration.
    pub joints: Vec<Vec<(f64, f64, f64)>>,
}
