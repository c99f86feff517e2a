//! From recordings and the given arm to the linear problem, about an operating point.

use crate::design::observations::{JointColumns, Observations, Weights};
use std::collections::BTreeMap;
use std::sync::Arc;

use armident_dynamics::{ParameterColumns, RigidArm, inertia_matrix};
use armident_effects::{BASELINE, Effect, EffectOnJoint, LawRole, Library, MotionScale, Scope};
use armident_kinematics::DrivingAxisChain;
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind, Location};
use crate::design::compliant_link::{CompliantLink, Posed};
use crate::design::linear_problem::LinearProblem;
use crate::design::link_error_prior::{as_large_as, inertial_error_directions};
use crate::design::placeholder::sizes_of_links;
use armident_model::OperatingPoint;
use armident_motion::BandMotion;

/// Share of the time of the reference in which a joint is no faster than its usual speed,
const USUAL: f64 = 0.99;
/// and how many times that it may be for its friction to be known: laws are nonlinear over more than a fifth.
const FASTER: f64 = 1.2;

/// Training recordings and the arm they are compared with.
pub(crate) struct Design<'a> {
    pub(crate) chain: &'a DrivingAxisChain,
    pub(crate) names: Vec<String>,
    pub(crate) signals: Arc<[BandMotion]>,
    pub(crate) observations: Observations,
    /// size of each joint's motion
    pub(crate) scale: Vec<MotionScale>,
    /// effects that were taken out of the recordings
    pub(crate) known: &'a [EffectOnJoint],
    /// laws that are looked for
    pub(crate) library: &'a Library,
}

impl<'a> Design<'a> {
    pub(crate) fn new(chain: &'a DrivingAxisChain, signals: Vec<BandMotion>) -> Self {
        let arm = RigidArm::from_chain(chain);
        let n = arm.dof();
        let inertia: Vec<Vec<Vec<f64>>> =
            signals.iter().map(|s| inertia_root_mean_square(&arm, s)).collect();
        let observations = Observations::new(&signals, &inertia);
        let longest = signals.iter().map(|s| s.time_s[s.len() - 1]).fold(0.0, f64::max);
        let scale = (0..n)
            .map(|j| {
                let pooled = |of: &dyn Fn(&BandMotion) -> &Vec<f64>, about: f64| {
                    let all = signals.iter().flat_map(|s| of(s).iter());
                    let count = signals.iter().map(BandMotion::len).sum::<usize>() as f64;
                    (all.map(|x| (x - about).powi(2)).sum::<f64>() / count).sqrt()
                };
                let mean = signals.iter().flat_map(|s| s.position[j].iter()).sum::<f64>()
                    / signals.iter().map(BandMotion::len).sum::<usize>() as f64;
                MotionScale {
                    kind: arm.joints[j].kind,
                    speed_rms: pooled(&|s| &s.velocity[j], 0.0).max(f64::MIN_POSITIVE),
                    position_deviation: pooled(&|s| &s.position[j], mean).max(f64::MIN_POSITIVE),
                    duration_s: longest,
                    temperature_c: temperatures_of(&signals, j),
                }
            })
            .collect();
        let names = chain.joints.iter().map(|j| j.name.clone()).collect();
        let (signals, library) = (signals.into(), Library::standard());
        Self { chain, names, signals, observations, scale, known: &[], library }
    }

    /// The same with the laws of another library.
    pub(crate) fn with_library(self, library: &'a Library) -> Self {
        Self { library, ..self }
    }

    /// The same of recordings from which these effects were taken.
    pub(crate) fn beside(self, known: &'a [EffectOnJoint]) -> Self {
        Self { known, ..self }
    }

    /// The same with laws that act in all recordings, also in those before a change.
    pub(crate) fn acting_throughout(&self) -> Design<'_> {
        Design {
            chain: self.chain,
            names: self.names.clone(),
            signals: Arc::clone(&self.signals),
            observations: self.observations.with_laws_throughout(),
            scale: self.scale.clone(),
            known: self.known,
            library: self.library,
        }
    }

    pub(crate) fn joints(&self) -> usize {
        self.names.len()
    }

    /// Recordings at an operating point with other links.
    pub(crate) fn at(&self, point: &OperatingPoint) -> Vec<Posed<'_>> {
        let arm = RigidArm::from_chain(self.chain);
        let none = OperatingPoint::of(self.joints());
        let point_of =
            |r: usize| if r < self.observations.comparison.first_judged() { &none } else { point };
        let signals = self.signals.par_iter().enumerate();
        signals.map(|(r, s)| Posed::new(self.chain, &arm, s, point_of(r))).collect()
    }

    /// The same with other weights.
    pub(crate) fn weighted(&self, weights: Weights) -> Self {
        Self {
            names: self.names.clone(),
            signals: Arc::clone(&self.signals),
            observations: self.observations.weighted(weights),
            scale: self.scale.clone(),
            ..*self
        }
    }

    /// The same compared with those of its recordings before `from`, which show the arm as it was, and hold its links
    /// and baseline friction.
    ///
    /// Gives back as well, for each joint that moves faster now than then, how fast it was before: the reference
    /// does not determine its friction beyond that, so that these rows are excluded.
    pub(crate) fn against_reference(self, from: usize) -> (Self, BTreeMap<String, f64>) {
        let mut design = Self { observations: self.observations.against_reference(from), ..self };
        let mut exceeded = BTreeMap::new();
        for joint in 0..design.joints() {
            let Some(fastest) = design.usual_speed(joint, from) else { continue };
            let faster = |v: &f64| v.abs() > FASTER * fastest;
            let (weights, excluded) = design.observations.excluding(&design.signals, joint, |s| {
                s.velocity[joint].iter().map(faster).collect()
            });
            design.observations.weights = weights;
            if excluded > 0 {
                exceeded.insert(design.names[joint].clone(), fastest);
            }
        }
        (design, exceeded)
    }

    /// Of every row, whether a joint moves faster there than in the reference.
    pub(crate) fn rows_beyond_reference(&self) -> Vec<bool> {
        let from = self.observations.comparison.first_judged();
        let limits: Vec<Option<f64>> =
            (0..self.joints()).map(|joint| self.usual_speed(joint, from)).collect();
        let is_faster = |s: &BandMotion, t: usize| {
            let mut speeds = limits.iter().zip(&s.velocity);
            speeds.any(|(limit, v)| limit.is_some_and(|fastest| v[t].abs() > FASTER * fastest))
        };
        let samples = |s: &BandMotion| (0..s.len()).map(|t| is_faster(s, t)).collect();
        Observations::rows_of(&self.signals, samples)
    }

    /// Speed that a joint hardly exceeds in the first recordings; none where it has no effort in them.
    fn usual_speed(&self, joint: usize, first: usize) -> Option<f64> {
        let recorded = self.signals[..first].iter().filter(|s| !s.effort[joint].is_empty());
        let mut speeds: Vec<f64> =
            recorded.flat_map(|s| s.velocity[joint].iter().map(|v| v.abs())).collect();
        speeds.sort_unstable_by(f64::total_cmp);
        speeds.get((USUAL * speeds.len() as f64) as usize).copied()
    }

    /// JointColumns of an arm column given for each recording as `[joint][sample]`.
    pub(crate) fn arm_blocks(&self, by_recording: &[Vec<Vec<f64>>]) -> JointColumns {
        (0..self.joints())
            .map(|j| {
                if by_recording.iter().all(|c| c[j].iter().all(|x| *x == 0.0)) {
                    return Vec::new();
                }
                self.observations.form_law(
                    &self.signals,
                    j,
                    by_recording.iter().map(|c| c[j].as_slice()),
                )
            })
            .collect()
    }

    /// JointColumns of a column on one joint.
    pub(crate) fn joint_blocks(&self, joint: usize, by_recording: &[Vec<f64>]) -> JointColumns {
        let mut blocks = vec![Vec::new(); self.joints()];
        blocks[joint] = self.observations.form_law(
            &self.signals,
            joint,
            by_recording.iter().map(Vec::as_slice),
        );
        blocks
    }

    /// The problem with all candidates that need no search of their own.
    pub(crate) fn problem(&self, point: &OperatingPoint) -> LinearProblem {
        self.problem_at(&self.at(point))
    }

    /// The same of recordings at an operating point.
    pub(crate) fn problem_at(&self, at: &[Posed<'_>]) -> LinearProblem {
        self.problem_with(at, |_| true)
    }

    /// The same without the laws of joints whose constants are tried: most columns are theirs.
    pub(crate) fn problem_without_trials(&self, point: &OperatingPoint) -> LinearProblem {
        self.problem_with(&self.at(point), <[f64]>::is_empty)
    }

    /// The same with the laws of the whole arm and of links alone, of recordings at an operating point.
    pub(crate) fn problem_of_arm(&self, at: &[Posed<'_>]) -> LinearProblem {
        self.problem_with(at, |_| false)
    }

    fn problem_with(&self, at: &[Posed<'_>], shapes: impl Fn(&[f64]) -> bool) -> LinearProblem {
        let n = self.joints();
        let efforts: Vec<Vec<Vec<f64>>> = at.iter().map(|at| at.effort_or_rigid()).collect();
        let effort: JointColumns = (0..n)
            .map(|j| {
                let difference = at.iter().zip(&efforts).map(|(at, effort)| {
                    at.answered(j).iter().zip(&effort[j]).map(|(r, e)| e - r).collect()
                });
                let difference: Vec<Vec<f64>> = difference.collect();
                self.observations.form(&self.signals, j, difference.iter().map(Vec::as_slice))
            })
            .collect();
        let mut rigid = self.rigid_columns(at);
        let mut link_error_prior = inertial_error_directions(&sizes_of_links(self.chain));
        if self.observations.comparison.seeks_change() {
            let (columns, deviations) = self.baseline_columns(at, &effort);
            rigid.extend(columns);
            link_error_prior.extend(&deviations);
        }
        let mut problem =
            LinearProblem::new(self.observations.clone(), effort, rigid, link_error_prior);
        problem.library.clone_from(self.library);
        for (known, name) in problem.known.iter_mut().zip(&self.names) {
            known.extend(self.known.iter().filter(|effect| effect.joint == *name).cloned());
        }
        let of_scope =
            |scope: Scope, sites: usize| -> Vec<(&'static dyn Effect, usize, Vec<f64>)> {
                let named = || self.library.named();
                let laws = move || named().filter(move |law| law.law().scope == scope);
                let at_location = |j: usize| {
                    laws().flat_map(move |law| {
                        law.shapes(&self.scale[j]).into_iter().map(move |shape| (law, j, shape))
                    })
                };
                (0..sites).flat_map(at_location).filter(|(_, _, shape)| shapes(shape)).collect()
            };
        // columns are expensive to form and independent; candidates are numbered in order
        let of_joints = of_scope(Scope::Joint, n);
        let columns: Vec<Vec<JointColumns>> = of_joints
            .par_iter()
            .map(|(law, j, shape)| self.joint_law_columns(at, *law, *j, shape))
            .collect();
        for ((law, j, shape), columns) in of_joints.iter().zip(columns) {
            self.push_joint_columns(&mut problem, *law, *j, shape, columns);
        }
        for (law, j, shape) in of_scope(Scope::Neighbours, n - 1) {
            self.push_pair_law(&mut problem, at, law, j, &shape);
        }
        self.push_arm_laws(&mut problem, at, &efforts);
        self.push_links(&mut problem);
        problem
    }

    /// The terms of a plain identification on every joint, the same before and after a change, and a
    /// deviation of their coefficients that leaves them free: such that a column is as large as the
    /// effort to be explained on its joint.
    fn baseline_columns(
        &self,
        at: &[Posed<'_>],
        effort: &JointColumns,
    ) -> (Vec<JointColumns>, Vec<f64>) {
        let (mut columns, mut deviations) = (Vec::new(), Vec::new());
        for j in 0..self.joints() {
            for law in BASELINE {
                let pieces: Vec<Vec<f64>> = at
                    .iter()
                    .filter_map(|at| {
                        Some(at.recorded(j, law.columns(&[], &at.joint(j)).into_iter().next()?))
                    })
                    .collect();
                let mut blocks = vec![Vec::new(); self.joints()];
                blocks[j] =
                    self.observations.form(&self.signals, j, pieces.iter().map(Vec::as_slice));
                deviations.push(as_large_as(effort, &blocks));
                columns.push(blocks);
            }
        }
        (columns, deviations)
    }

    /// The `10 n` columns of the standard parameters.
    fn rigid_columns(&self, at: &[Posed<'_>]) -> Vec<JointColumns> {
        let n = self.joints();
        let standard = ParameterColumns::standard(n);
        let yielding: Vec<Vec<(&CompliantLink, _)>> = at
            .par_iter()
            .map(|at| at.compliant_links().map(|s| (s, s.yields_to_parameters(at))).collect())
            .collect();
        let sprung = yielding.iter().flatten().map(|(sprung, _)| sprung.joint()).min();
        let of_row = |row: usize| -> Vec<(usize, Vec<f64>)> {
            // a link loads the joints before it, and moves all that it hangs with where one of these is sprung
            let wanted = 10 * sprung.map_or(row, |first| first.min(row))..10 * n;
            let parameters: Vec<usize> = wanted.clone().collect();
            let by_recording: Vec<Vec<Vec<f64>>> = at
                .iter()
                .zip(&yielding)
                .map(|(at, yielding)| {
                    let motion = at.motion();
                    let accelerations = at.signals.accelerations_on(row, true);
                    let answered = motion.with_accelerations(&accelerations);
                    let mut columns = standard.of_arm_motion(&at.arm, row, &answered, &parameters);
                    for (sprung, yielding) in yielding {
                        let more = sprung.columns_on(at, row, wanted.clone(), yielding);
                        for (column, more) in columns.iter_mut().zip(more) {
                            column.iter_mut().zip(more).for_each(|(c, m)| *c += m);
                        }
                    }
                    columns.into_iter().map(|column| at.recorded(row, column)).collect()
                })
                .collect();
            let formed = parameters.iter().enumerate().filter_map(|(k, &parameter)| {
                let pieces = by_recording.iter().map(|c| c[k].as_slice());
                let any = pieces.clone().flatten().any(|x| *x != 0.0);
                any.then(|| (parameter, self.observations.form(&self.signals, row, pieces)))
            });
            formed.collect()
        };
        let by_row: Vec<Vec<(usize, Vec<f64>)>> = (0..n).into_par_iter().map(of_row).collect();
        let mut columns: Vec<JointColumns> = vec![vec![Vec::new(); n]; 10 * n];
        for (row, formed) in by_row.into_iter().enumerate() {
            for (parameter, block) in formed {
                columns[parameter][row] = block;
            }
        }
        columns
    }

    /// Adds a law on one joint; columns that are there already are shared. Gives the candidate's id.
    pub(crate) fn push_joint_law(
        &self,
        problem: &mut LinearProblem,
        at: &[Posed<'_>],
        law: &'static dyn Effect,
        joint: usize,
        shape: &[f64],
    ) -> Option<usize> {
        let columns = self.joint_law_columns(at, law, joint, shape);
        self.push_joint_columns(problem, law, joint, shape, columns)
    }

    fn joint_law_columns(
        &self,
        at: &[Posed<'_>],
        law: &'static dyn Effect,
        joint: usize,
        shape: &[f64],
    ) -> Vec<JointColumns> {
        let by_recording: Vec<Vec<Vec<f64>>> =
            at.iter().map(|at| law.columns(shape, &at.joint_seen_by(law, joint))).collect();
        let count = by_recording.first().map_or(0, Vec::len);
        (0..count)
            .map(|k| {
                let pieces: Vec<Vec<f64>> = by_recording.iter().map(|c| c[k].clone()).collect();
                self.joint_blocks(joint, &pieces)
            })
            .collect()
    }

    fn push_joint_columns(
        &self,
        problem: &mut LinearProblem,
        law: &'static dyn Effect,
        joint: usize,
        shape: &[f64],
        columns: Vec<JointColumns>,
    ) -> Option<usize> {
        if columns.is_empty() {
            return None;
        }
        let ids = columns.into_iter().map(|blocks| self.share_or_push(problem, blocks)).collect();
        let location = Location { joints: vec![joint], window: None };
        Some(push_law(problem, law, location, shape, ids, shape.len()))
    }

    pub(crate) fn push_pair_law(
        &self,
        problem: &mut LinearProblem,
        at: &[Posed<'_>],
        law: &'static dyn Effect,
        first: usize,
        shape: &[f64],
    ) -> usize {
        let by_recording: Vec<Vec<[Vec<f64>; 2]>> = at
            .iter()
            .map(|at| {
                let columns = law.pair_columns(shape, &at.joint(first), &at.joint(first + 1));
                let recorded =
                    |[a, b]: [Vec<f64>; 2]| [at.recorded(first, a), at.recorded(first + 1, b)];
                columns.into_iter().map(recorded).collect()
            })
            .collect();
        let count = by_recording.first().map_or(0, Vec::len);
        let mut ids = Vec::new();
        for k in 0..count {
            let mut blocks = vec![Vec::new(); self.joints()];
            for side in 0..2 {
                let pieces = by_recording.iter().map(|c| c[k][side].as_slice());
                blocks[first + side] =
                    self.observations.form_law(&self.signals, first + side, pieces);
            }
            ids.push(self.share_or_push(problem, blocks));
        }
        let location = Location { joints: vec![first, first + 1], window: None };
        push_law(problem, law, location, shape, ids, shape.len())
    }

    fn share_or_push(&self, problem: &mut LinearProblem, blocks: JointColumns) -> usize {
        match problem.find_column(&blocks, problem.rigid) {
            Some(known) => known,
            None => problem.push_columns(vec![blocks]),
        }
    }

    /// Encoders, transmissions to first order, gravity and the clock.
    fn push_arm_laws(
        &self,
        problem: &mut LinearProblem,
        at: &[Posed<'_>],
        efforts: &[Vec<Vec<f64>>],
    ) {
        for law in self.library.named() {
            let joints = match law.law().scope {
                Scope::ThroughJoint => self.joints(),
                Scope::Arm if law.law().roles != [LawRole::Contact] => 1,
                _ => continue,
            };
            for j in 0..joints {
                let by_recording: Vec<Vec<Vec<Vec<f64>>>> = at
                    .iter()
                    .zip(efforts)
                    .map(|(at, effort)| {
                        if law.law().roles != [LawRole::Time] {
                            return at.recorded_arm_columns(law, j, self.chain);
                        }
                        // the clock shifts all that is recorded, not the rigid body alone
                        let all = at.signals.with_known_effort(effort.clone());
                        law.arm_columns(j, &at.arm_motion(self.chain, &all))
                    })
                    .collect();
                let count = by_recording[0].len();
                if count == 0 {
                    continue;
                }
                let mut ids = Vec::new();
                for k in 0..count {
                    let pieces: Vec<Vec<Vec<f64>>> =
                        by_recording.iter().map(|c| c[k].clone()).collect();
                    ids.push(problem.push_columns(vec![self.arm_blocks(&pieces)]));
                }
                let mut location = Location::default();
                if law.law().scope == Scope::ThroughJoint {
                    location.joints = vec![j];
                }
                // a transmission brings the inertia of its motor with it
                let relative = law.law().contains.first().and_then(|slug| self.library.get(slug));
                let searched = usize::from(relative.is_some());
                if let Some(relative) = relative {
                    let columns: Vec<Vec<f64>> = at
                        .iter()
                        .filter_map(|at| relative.columns(&[], &at.joint(j)).into_iter().next())
                        .collect();
                    ids.push(self.share_or_push(problem, self.joint_blocks(j, &columns)));
                }
                push_law(problem, law, location, &[], ids, searched);
            }
        }
    }
}

/// Adds a law's candidate, and gives its id.
pub(crate) fn push_law(
    problem: &mut LinearProblem,
    law: &'static dyn Effect,
    location: Location,
    shape: &[f64],
    columns: Vec<usize>,
    searched: usize,
) -> usize {
    problem.candidates.push(Candidate {
        kind: CandidateKind::Law(law),
        location,
        shape: shape.to_vec(),
        columns,
        searched,
        places: law.law().roles.to_vec(),
        transform: None,
        hidden: Vec::new(),
        above_band: 1.0,
        is_of_size_one: false,
    });
    problem.candidates.len() - 1
}

/// Lowest and highest temperature of the drive of a joint; none where some recording lacks it.
fn temperatures_of(signals: &[BandMotion], joint: usize) -> Option<[f64; 2]> {
    let range = |s: &BandMotion| {
        let least = s.temperature_c[joint].iter().copied().reduce(f64::min)?;
        let most = s.temperature_c[joint].iter().copied().reduce(f64::max)?;
        Some([least, most])
    };
    let ranges: Option<Vec<[f64; 2]>> = signals.iter().map(range).collect();
    ranges?.into_iter().reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// Root mean square of every entry of the inertia matrix over some instants of a recording.
fn inertia_root_mean_square(arm: &RigidArm, signals: &BandMotion) -> Vec<Vec<f64>> {
    const INSTANTS: usize = 20;
    let n = arm.dof();
    let mut squares = vec![vec![0.0; n]; n];
    for k in 0..INSTANTS {
        let t = k * (signals.len() - 1) / (INSTANTS - 1);
        let q: Vec<f64> = signals.position.iter().map(|q| q[t]).collect();
        let inertia = inertia_matrix(arm, &q);
        for i in 0..n {
            for j in 0..n {
                squares[i][j] += inertia[(i, j)].powi(2) / INSTANTS as f64;
            }
        }
    }
    squares.iter().map(|row| row.iter().map(|x| x.sqrt()).collect()).collect()
}
