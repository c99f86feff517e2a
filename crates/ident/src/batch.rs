//! Weighted least squares of the minimal set and joint effects from ordinary motion.
//!
//! `τ_j = Σ Y_jk x_k + Σ φ_jl(motion) p_l + noise_j`: all columns and the effort pass through the same
//! zero-phase low-pass, nonlinear columns being formed before it. Each joint's rows are reduced to one
//! triangle, so that weighting by the joints' noise needs no second pass over the samples.
//!
//! Two beliefs stand beside the recordings, and vanish where the recordings say more
//! ([`BatchSettings`]): friction and rotor inertia have their sign, and the robot description is
//! right to its own size. On 25 fits of recorded motions of UR10, Panda, TX40 and two pendulums, judged
//! on motions that follow, they take the largest errors away: a fit of motions that leave constants
//! open extrapolates by what it is told of them.

use armident_dynamics::RigidArm;
use armident_effects::{
    Admissible, EVERYDAY, Effect, EffectOnJoint, JointMotion, Parameter, ReversalModel,
    SublinearViscousFriction, directions_with,
};
use armident_numeric::{
    AccumulatedQr, LeastSquares, Mat, NonNegative, NumericError, eliminate_in_order,
};

use crate::coupling::{Coupling, SHARED};
use crate::link_prior::LinkPrior;
use crate::minimal_set::{MinimalSet, random_states};
use crate::payload::KnownLoad;
use crate::quantiles::student_t_975;
use crate::rows::JointRows;

/// Relative rank cut of unit columns: only what is exactly undetermined is cut, what is badly
/// determined shows in its standard error.
pub(crate) const RANK_CUT: f64 = 1e-9;
/// Cut of the structural elimination at random states.
const DEPENDENT: f64 = 1e-8;
/// Reweighting ends when no joint's noise level moves by more than this share.
const WEIGHT_TOLERANCE: f64 = 1e-6;
const MOST_REWEIGHTINGS: usize = 50;
/// Names of the ten parameters of a body.
const NUMBERS: [&str; 10] = ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// What is believed beside the recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchSettings {
    /// Parameters whose law admits no negative value are held at zero or above.
    pub admissible_signs: bool,
    /// Standard deviation of the mass of every link of the robot description and of its second moments,
    /// along every line, relative to their size; none: the description is not used. At 1 a link may as
    /// well not be there, or be twice what is said.
    pub link_prior: Option<f64>,
}

impl Default for BatchSettings {
    fn default() -> Self {
        Self { admissible_signs: true, link_prior: Some(1.0) }
    }
}

impl BatchSettings {
    /// The recordings alone: plain weighted least squares.
    pub const PLAIN: Self = Self { admissible_signs: false, link_prior: None };
}

/// Laws of one joint whose parameters may be unknowns: those that every joint has, then those that recordings may ask for
/// ([`BatchProblem::choose`]).
pub const LAWS: [&dyn Effect; 5] = {
    let [viscous, coulomb, offset, inertia] = EVERYDAY else { panic!("four everyday laws") };
    [*viscous, *coulomb, *offset, *inertia, &SublinearViscousFriction]
};

/// One unknown of the batch problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term {
    /// A constant of the minimal set, by index.
    Constant(usize),
    /// A parameter of an effect on a joint.
    Effect {
        /// Joint, from 0.
        joint: usize,
        /// Effect, index into [`LAWS`].
        effect: usize,
        /// Parameter, index into the law's list.
        parameter: usize,
    },
    /// A coefficient of the transmission that a joint shares with the next ([`Coupling`]).
    Shared {
        /// Which.
        coupling: Coupling,
        /// Coefficient, index into the law's columns.
        coefficient: usize,
    },
    /// What is not known of a load on the last link ([`KnownLoad`]).
    Load {
        /// Which, index into the loads with unknowns.
        load: usize,
        /// Number of the ten parameters of a body, 1 to 9.
        number: usize,
    },
}

impl Term {
    /// The parameter of the law; none where there is no law.
    pub fn parameter(&self) -> Option<&'static Parameter> {
        match *self {
            Self::Constant(_) | Self::Load { .. } => None,
            Self::Effect { effect, parameter, .. } => LAWS[effect].law().parameters.get(parameter),
            // the ratio comes first
            Self::Shared { coefficient, .. } => SHARED.law().parameters.get(1 + coefficient),
        }
    }
}

/// An unknown that is the same as a combination of others on every motion of this arm.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedTerm {
    /// The unknown that is not estimated on its own.
    pub term: Term,
    /// What it adds to: (index into [`BatchProblem::terms`], coefficient).
    pub into: Vec<(usize, f64)>,
}

/// The unknowns of an arm and where they appear.
#[derive(Debug, Clone)]
pub struct BatchProblem<'a> {
    pub(crate) arm: &'a RigidArm,
    pub(crate) set: &'a MinimalSet,
    /// Unknowns estimated.
    pub terms: Vec<Term>,
    /// Unknowns merged into others by the arm's structure (rotor inertia of joint 1 and `U1_33`).
    pub merged: Vec<MergedTerm>,
    pub(crate) by_joint: Vec<Vec<usize>>,
    /// Loads with unknowns.
    pub(crate) loads: Vec<KnownLoad>,
    /// How each joint's dry friction turns; none: below a share of the RMS speed of the motion at hand.
    pub turns: Option<Vec<ReversalModel>>,
    /// Joints whose columns leave small efforts out ([`unreported`](crate::unreported)).
    pub(crate) unreported: Vec<bool>,
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
    /// Covariance of the values, counting only independent samples, the prior included; rows and
    /// columns of terms at their bound are zero.
    pub covariance: Mat<f64>,
    /// A root `R` of the information matrix `RᵀR`, which counts only independent samples, the prior
    /// included; without regard to bounds.
    pub information_root: Mat<f64>,
    /// Per term, whether its sign bound holds it at 0.
    pub at_bound: Vec<bool>,
    /// Per term, share of what is known of it that is the prior's and not the recordings', 0 to 1
    /// (one less the resolution of the recordings).
    pub from_prior: Vec<f64>,
    /// Half-width factor of 95 % intervals.
    pub quantile_95: f64,
    /// Noise level of each joint's filtered effort \[N m or N\].
    pub effort_noise: Vec<f64>,
    /// Numerical rank of the recordings alone.
    pub rank: usize,
    /// Condition number of the weighted unit columns, of the recordings alone.
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
    /// Whether the recordings need term `k`: its 95 % interval does not hold 0.
    pub fn is_essential(&self, k: usize) -> bool {
        self.standard_error(k).is_some_and(|error| self.values[k].abs() > self.quantile_95 * error)
    }

    /// Standard error of term `k`; none is claimed for a term at its bound.
    pub fn standard_error(&self, k: usize) -> Option<f64> {
        (!self.at_bound[k]).then(|| self.covariance[(k, k)].sqrt())
    }
}

impl<'a> BatchProblem<'a> {
    /// The minimal set and every linear effect of the library on every joint, less what the arm's
    /// structure merges (decided at random states: rotor inertia of the first joint is its `U_33`).
    pub fn new(arm: &'a RigidArm, set: &'a MinimalSet) -> Self {
        let n = arm.dof();
        let mut all: Vec<Term> = (0..set.len()).map(Term::Constant).collect();
        for joint in 0..n {
            for (effect, law) in EVERYDAY.iter().enumerate() {
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
                kind: arm.joints[joint].kind,
                direction: &directions_with(&dq, 1e-6),
                rigid_effort: &[],
            };
            for (effect, law) in EVERYDAY.iter().enumerate() {
                for (parameter, column) in law.columns(&[], &motion).iter().enumerate() {
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
                        Term::Shared { coupling, .. } => coupling.joints().contains(&joint),
                        Term::Load { .. } => true,
                    })
                    .collect()
            })
            .collect();
        Self {
            arm,
            set,
            terms,
            merged,
            by_joint,
            loads: Vec::new(),
            turns: None,
            unreported: vec![false; n],
        }
    }

    /// The same with joints whose columns leave small efforts out. All rows of such a joint together weigh as one
    /// sample that is off by what the described body would need there, and it shares no transmission.
    #[must_use]
    pub fn with_unreported(mut self, unreported: Vec<bool>) -> Self {
        self.unreported = unreported;
        self
    }

    /// The arm whose efforts are explained.
    pub fn arm(&self) -> &'a RigidArm {
        self.arm
    }

    /// The constants among the unknowns.
    pub fn set(&self) -> &'a MinimalSet {
        self.set
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
                let law = LAWS[effect].law();
                if law.parameters.len() == 1 {
                    format!("{}({})", law.slug, joint_names[joint])
                } else {
                    format!(
                        "{}.{}({})",
                        law.slug, law.parameters[parameter].name, joint_names[joint]
                    )
                }
            }
            Term::Load { load, number } => {
                let source = self.loads[load].sources.join(", ");
                format!("load.{}({source})", NUMBERS[number])
            }
            Term::Shared { coupling, .. } => {
                let name = term.parameter().map_or("", |parameter| parameter.name);
                let [a, b] = coupling.joints().map(|joint| joint_names[joint]);
                format!("{}.{name}({a}, {b})", SHARED.law().slug)
            }
        }
    }

    /// Solves for all terms, each joint weighted by its own noise, with the default settings.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate(&self, rows: &JointRows) -> Result<BatchEstimate, NumericError> {
        self.estimate_with(rows, &BatchSettings::default())
    }

    /// Solves for all terms, each joint weighted by its own noise.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn estimate_with(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, NumericError> {
        let n = self.arm.dof();
        let count = |joint: usize| rows.effort[joint].0 as f64;
        let beliefs = self.beliefs(settings)?;
        let least = self.least_noise(rows)?;
        // first weights: what each joint alone cannot fit
        let mut noise = self.noise_alone(rows)?;
        let mut solved = self.weighted(rows, &noise, &beliefs)?;
        let mut freedom = 0.0;
        for _ in 0..MOST_REWEIGHTINGS {
            let mut moved = 0.0_f64;
            freedom = 0.0;
            for joint in 0..n {
                let terms = &self.by_joint[joint];
                let pick = |v: &[f64]| terms.iter().map(|&k| v[k]).collect::<Vec<_>>();
                let own = Mat::from_fn(terms.len(), terms.len(), |i, j| {
                    solved.answer.unit_covariance[(terms[i], terms[j])]
                });
                let paid = rows.triangles[joint].trace_with(&own) / noise[joint].powi(2);
                let squares =
                    rows.triangles[joint].residual_sum_of_squares(&pick(&solved.answer.solution));
                let independent = count(joint) * rows.share;
                let left = (independent - paid).max(1.0);
                freedom += left;
                let level = (squares * rows.share / left).sqrt().max(least[joint]);
                moved = moved.max((level / noise[joint] - 1.0).abs());
                noise[joint] = level;
            }
            solved = self.weighted(rows, &noise, &beliefs)?;
            if moved < WEIGHT_TOLERANCE {
                break;
            }
        }
        self.finished(rows, &beliefs, noise, freedom, solved)
    }

    /// Root mean square of what the columns of each joint alone leave of its effort, or the least noise.
    pub(crate) fn noise_alone(&self, rows: &JointRows) -> Result<Vec<f64>, NumericError> {
        let least = self.least_noise(rows)?;
        let joints = rows.triangles.iter().enumerate().zip(least);
        joints.map(|((j, triangle), least)| Ok(noise_of(triangle, rows, j)?.max(least))).collect()
    }

    /// What each joint's noise is at least: where small efforts are left out, what the described body leaves
    /// of the effort beside the joint's own terms; else what rounding leaves.
    fn least_noise(&self, rows: &JointRows) -> Result<Vec<f64>, NumericError> {
        let described = self.set.values(&self.arm.constants());
        let of_joint = |(joint, triangle): (usize, &AccumulatedQr)| {
            if !self.unreported[joint] {
                return Ok(rounding(rows, joint));
            }
            let terms = &self.by_joint[joint];
            let body = terms.iter().map(|&k| match self.terms[k] {
                Term::Constant(c) => described[c],
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
            });
            let beyond = triangle.beyond(&body.collect::<Vec<_>>());
            let own: Vec<usize> = (0..terms.len())
                .filter(|&place| !matches!(self.terms[terms[place]], Term::Constant(_)))
                .collect();
            noise_of(&beyond.with_unknowns(&own), rows, joint)
        };
        rows.triangles.iter().enumerate().map(of_joint).collect()
    }

    /// Settings in the form the solver takes.
    pub(crate) fn beliefs(&self, settings: &BatchSettings) -> Result<Beliefs, NumericError> {
        Ok(Beliefs {
            bound: settings.admissible_signs.then(|| self.bound()),
            prior: self.prior(settings)?,
        })
    }

    /// What is said of a solution, beside its values.
    pub(crate) fn finished(
        &self,
        rows: &JointRows,
        beliefs: &Beliefs,
        noise: Vec<f64>,
        freedom: f64,
        solved: NonNegative,
    ) -> Result<BatchEstimate, NumericError> {
        let NonNegative { answer, at_bound } = solved;
        let p = self.terms.len();
        let covariance = Mat::from_fn(p, p, |i, j| answer.unit_covariance[(i, j)] / rows.share);
        let information_root = self.information(rows, &noise, beliefs).0.root(rows.share.sqrt());
        let train = self.fit(rows, &answer.solution);
        // rank and the like are of the recordings, whatever is believed
        let (from_prior, recorded) = match &beliefs.prior {
            Some(prior) => {
                let recorded = self.recorded(rows, &noise).solve(RANK_CUT)?;
                (prior.share_of(&covariance), recorded)
            }
            None => (vec![0.0; p], answer.clone()),
        };
        let LeastSquares { rank, condition, undetermined, .. } = recorded;
        Ok(BatchEstimate {
            values: answer.solution,
            covariance,
            information_root,
            at_bound,
            from_prior,
            quantile_95: student_t_975(freedom),
            effort_noise: noise,
            rank,
            condition,
            undetermined,
            rows: rows.effort.iter().map(|e| e.0).sum(),
            independent_share: rows.share,
            train,
        })
    }

    /// Which terms may not be negative.
    pub(crate) fn bound(&self) -> Vec<bool> {
        let of_law = |term: &Term| match *term {
            Term::Constant(_) | Term::Load { .. } => false,
            Term::Effect { .. } | Term::Shared { .. } => term
                .parameter()
                .is_some_and(|parameter| parameter.admissible == Admissible::NonNegative),
        };
        self.terms.iter().map(of_law).collect()
    }

    /// The prior over all terms.
    pub(crate) fn prior(
        &self,
        settings: &BatchSettings,
    ) -> Result<Option<TermPrior>, NumericError> {
        let of_links = match settings.link_prior {
            Some(relative) => self.believed_links(relative)?,
            None => None,
        };
        let nothing = || TermPrior { mean: vec![0.0; self.terms.len()], rows: Vec::new() };
        let mut prior = of_links.unwrap_or_else(nothing);
        prior.rows.extend(self.load_prior());
        Ok((!prior.rows.is_empty()).then_some(prior))
    }

    /// What is believed of the links, over all terms; none where the description gives no link a mass.
    pub(crate) fn believed_links(&self, relative: f64) -> Result<Option<TermPrior>, NumericError> {
        let with_rotor: Vec<usize> = (self.merged.iter().flat_map(|m| &m.into))
            .filter_map(|&(k, _)| match self.terms[k] {
                Term::Constant(c) => Some(c),
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => None,
            })
            .collect();
        let Some(prior) = LinkPrior::of(self.arm, self.set, &with_rotor, relative)? else {
            return Ok(None);
        };
        let over_terms = |row: &[f64]| -> Vec<f64> {
            let of_term = |term: &Term| match *term {
                Term::Constant(c) => row[c],
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
            };
            self.terms.iter().map(of_term).collect()
        };
        Ok(Some(TermPrior {
            mean: over_terms(&prior.mean),
            rows: prior.rows.iter().map(|row| over_terms(row)).collect(),
        }))
    }

    /// All joints' rows, each over its noise. What a joint leaves out does not average out over its samples: they
    /// count as one.
    fn recorded(&self, rows: &JointRows, noise: &[f64]) -> AccumulatedQr {
        let mut all = AccumulatedQr::new(self.terms.len());
        for (joint, triangle) in rows.triangles.iter().enumerate() {
            let independent = (rows.share * rows.effort[joint].0 as f64).max(1.0);
            let alike = if self.unreported[joint] { independent.sqrt() } else { 1.0 };
            all.merge_weighted(triangle, &self.by_joint[joint], 1.0 / (alike * noise[joint]));
        }
        all
    }

    /// All joints' rows and the prior's. With a prior, unknowns are distances from its mean, which is
    /// given back: what neither sees stays where it is believed.
    pub(crate) fn information(
        &self,
        rows: &JointRows,
        noise: &[f64],
        beliefs: &Beliefs,
    ) -> (AccumulatedQr, Option<Vec<f64>>) {
        let mut all = self.recorded(rows, noise);
        let Some(TermPrior { mean, rows: prior_rows }) = &beliefs.prior else {
            return (all, None);
        };
        all = all.beyond(mean);
        let prior = triangle_of(prior_rows, self.terms.len());
        let terms: Vec<usize> = (0..self.terms.len()).collect();
        // rows of samples count for more than they know by the dependent ones among them
        all.merge_weighted(&prior, &terms, 1.0 / rows.share.sqrt());
        (all, Some(mean.clone()))
    }

    pub(crate) fn weighted(
        &self,
        rows: &JointRows,
        noise: &[f64],
        beliefs: &Beliefs,
    ) -> Result<NonNegative, NumericError> {
        let (all, _) = self.information(rows, noise, beliefs);
        let mut solved = match &beliefs.bound {
            // effects, the only terms with bounds, are at 0 in the prior
            Some(bound) => all.solve_non_negative(bound, RANK_CUT)?,
            None => NonNegative {
                answer: all.solve(RANK_CUT)?,
                at_bound: vec![false; self.terms.len()],
            },
        };
        if let Some(prior) = &beliefs.prior {
            for (x, mean) in solved.answer.solution.iter_mut().zip(&prior.mean) {
                *x += mean;
            }
        }
        Ok(solved)
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
            let law = LAWS[effect].law();
            let name = joint_names[joint];
            let index = match list.iter().position(|e| e.effect == law.slug && e.joint == name) {
                Some(index) => index,
                None => {
                    let zeros = vec![0.0; law.parameters.len()];
                    list.push(EffectOnJoint::new(law.slug, name, zeros));
                    list.len() - 1
                }
            };
            list[index].parameters[parameter] = value;
        }
        list.extend(self.couplings_of(values, joint_names));
        list
    }
}

/// Root mean square of what the columns of a joint leave of its effort.
pub(crate) fn noise_of(
    triangle: &AccumulatedQr,
    rows: &JointRows,
    joint: usize,
) -> Result<f64, NumericError> {
    let left = triangle.solve(RANK_CUT)?.residual_sum_of_squares;
    Ok((left / rows.effort[joint].0 as f64).sqrt().max(rounding(rows, joint)))
}

/// What rounding leaves of the effort of a joint.
fn rounding(rows: &JointRows, joint: usize) -> f64 {
    f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE
}

/// Rows of a prior about its mean.
pub(crate) fn triangle_of(rows: &[Vec<f64>], unknowns: usize) -> AccumulatedQr {
    let mut prior = AccumulatedQr::new(unknowns);
    prior.push_rows(&rows.iter().map(|r| [r, &[0.0][..]].concat()).collect::<Vec<_>>());
    prior
}

/// Settings in the form the solver takes.
pub(crate) struct Beliefs {
    pub(crate) bound: Option<Vec<bool>>,
    pub(crate) prior: Option<TermPrior>,
}

/// [`LinkPrior`] over all terms; it says nothing of effects.
#[derive(Debug, Clone)]
pub(crate) struct TermPrior {
    pub(crate) mean: Vec<f64>,
    pub(crate) rows: Vec<Vec<f64>>,
}

impl TermPrior {
    /// `C P C`: the part of the covariance `C` of an estimate that comes from the doubt of the prior.
    pub(crate) fn carried(&self, covariance: &Mat<f64>) -> Mat<f64> {
        let p = covariance.nrows();
        // rows of B C
        let carried: Vec<Vec<f64>> = self
            .rows
            .iter()
            .map(|row| {
                (0..p).map(|j| (0..p).map(|k| row[k] * covariance[(k, j)]).sum::<f64>()).collect()
            })
            .collect();
        Mat::from_fn(p, p, |i, j| carried.iter().map(|row| row[i] * row[j]).sum())
    }

    /// Diagonal of `C P`, with `C` the covariance and `P` the information of the prior.
    pub(crate) fn share_of(&self, covariance: &Mat<f64>) -> Vec<f64> {
        let p = covariance.nrows();
        let mut share = vec![0.0; p];
        for row in &self.rows {
            for (k, share) in share.iter_mut().enumerate() {
                if row[k] != 0.0 {
                    *share += row[k] * (0..p).map(|j| covariance[(k, j)] * row[j]).sum::<f64>();
                }
            }
        }
        share.iter().map(|s| s.clamp(0.0, 1.0)).collect()
    }
}
