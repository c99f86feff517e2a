//! What would explain all columns together, before any of them is accused: gravity that points another way, joints that are
//! exchanged, or that count the other way, with position and effort.
//!
//! Method: the likelihood of the whole arm ([`arm_likelihood`](super::arm_likelihood)) of each explanation times its prior
//! probability. From what the headers state, the best single change is taken while it multiplies the posterior by a
//! thousand; then changes that others have made needless are taken back.
//!
//! References: own.

use armident_dynamics::RigidArm;
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_numeric::NumericError;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::arm_columns::{ArmColumns, JointMap, JointProducts};
use super::arm_likelihood::{
    ArmFit, ArmSystem, ConstantPrior, JointFacts, Meaning, mean_likelihood,
};
use super::gravity::{Direction, GravityDirectionFound, refine};
use super::link_errors::{LinkErrors, USUAL_LOG_GAIN};
use super::verdict::SURE;
use crate::minimal_set::MinimalSet;
use crate::regression::BatchProblem;

/// Errors of the links, and loads in mean links, that are equally likely: of a good CAD model, of a usual one, and links that
/// may be anything, each without a load and with one of a mean link.
const PRIORS: [(f64, f64); 4] = [(0.1, 0.0), (0.3, 1.0), (1.0, 0.0), (1.0, 1.0)];
/// Prior probabilities of gravity: along another axis of the base, taken off, along any direction; ...
const OTHER_AXIS: f64 = 0.01;
const TAKEN_OFF: f64 = 0.01;
const FREE: f64 = 0.01;
/// ... of a joint that counts the other way, or of two that are exchanged; and of joints in the order of their names.
const OTHER_WAY: f64 = 0.01;
const EXCHANGED: f64 = 0.01;
const BY_NAME: f64 = 0.01;
/// Standard gravity \[m/s²\], where the given one is none.
const STANDARD_GRAVITY: f64 = 9.806_65;
/// Part of the sphere that a direction known to a tenth of a degree is: the price of a free direction.
const SHARE_OF_SPHERE: f64 = 1e-6;
/// Changes that are judged with all priors: the best of those that one prior ranks.
const JUDGED_FULLY: usize = 3;
/// Changes of what the headers state, at most.
const MOST_CHANGES: usize = 6;
/// What an explanation must leave of some joint's error: half, or it explains less than is left.
pub(super) const MUST_LEAVE: f64 = 0.5;
/// Widest 95 % region of a direction that is one \[degrees\].
const WIDEST_DEG: f64 = 10.0;
/// Growth of any joint's error by an explanation that is none.
const MUST_NOT_GROW: f64 = 1.5;

/// How gravity stands in an explanation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Gravity {
    AsGiven,
    Axis(Vector3<f64>),
    TakenOff,
    Free(Vector3<f64>),
}

/// One explanation of all columns.
#[derive(Debug, Clone, PartialEq)]
struct State {
    gravity: Gravity,
    map: JointMap,
    /// logarithm of the prior probability of the map
    map_prior: f64,
}

impl State {
    fn as_labelled(map: JointMap) -> Self {
        Self { gravity: Gravity::AsGiven, map, map_prior: 0.0 }
    }
}

/// What explains all columns best.
pub(super) struct Explained {
    /// Gravity in `E_0` \[m/s²\].
    pub(super) gravity_e0: Vector3<f64>,
    /// Where it points; none where it is as given.
    pub(super) direction: Option<GravityDirectionFound>,
    pub(super) gravity_is_taken_off: bool,
    pub(super) map: JointMap,
    /// Posterior probability of what the headers state, against this.
    pub(super) as_labelled: f64,
    /// What each effort column is for the arm as a whole, by joints of the recordings.
    pub(super) meaning: Vec<Meaning>,
}

/// The best explanation of recordings of an arm; `reversed` is the problem with the friction of its joints.
pub(super) fn explain(
    model: &ArmModel,
    motions: &[Motion],
    reversed: &BatchProblem,
    facts: &JointFacts,
) -> Result<Explained, NumericError> {
    let arm = reversed.arm();
    let problem = generic_problem(reversed)?;
    let priors = priors_of(&problem);
    let as_labelled = JointMap::as_labelled(arm.dof());
    let nothing = |meaning: Vec<Meaning>| Explained {
        gravity_e0: arm.gravity_e0,
        direction: None,
        gravity_is_taken_off: false,
        map: JointMap::as_labelled(arm.dof()),
        as_labelled: 1.0,
        meaning,
    };
    if priors.len() < PRIORS.len() {
        return Ok(nothing(vec![Meaning::Effort; arm.dof()]));
    }
    let columns = ArmColumns::of(&problem, motions);
    let search = Search { model, columns, priors, facts, given: arm.gravity_e0 };
    let start = State::as_labelled(as_labelled);
    let labelled = search.judged(&start);
    // the residual of every joint is noise: nothing explains half of it
    if !search.leaves_more_than_noise(&labelled) {
        // links without gravity fit such efforts too: only their likelihood decides
        let off = search.judged(&State { gravity: Gravity::TakenOff, ..start });
        let gravity_is_taken_off = off.score > labelled.score - SURE.ln();
        let meaning = if gravity_is_taken_off { off.meaning() } else { labelled.meaning() };
        return Ok(Explained { gravity_is_taken_off, ..nothing(meaning) });
    }
    let mut best = labelled.clone();
    for _ in 0..MOST_CHANGES {
        let Some(better) = search.better(&best) else { break };
        best = better;
    }
    if best.state == labelled.state {
        return Ok(nothing(labelled.meaning()));
    }
    let odds = (labelled.score - best.score).exp();
    let probability = odds / (1.0 + odds);
    if probability > SURE
        || !search.explains(&labelled, &best)
        || !search.holds_in_each_recording(&labelled, &best)
    {
        return Ok(nothing(labelled.meaning()));
    }
    let (gravity_e0, direction) = search.direction(&best);
    if direction.as_ref().is_some_and(|found| found.radius_95_deg > WIDEST_DEG) {
        return Ok(nothing(labelled.meaning()));
    }
    let gravity_is_taken_off = best.state.gravity == Gravity::TakenOff;
    let meaning = best.meaning();
    let (map, as_labelled) = (best.state.map, probability);
    Ok(Explained { gravity_e0, direction, gravity_is_taken_off, map, as_labelled, meaning })
}

/// Whether another order of the effort columns, which each joint's own evidence indicates, leaves half of the error of every
/// column that it moves, and of none much more: with few independent samples the likelihood of the arm alone does not decide.
pub(super) fn order_explains(
    model: &ArmModel,
    motions: &[Motion],
    reversed: &BatchProblem,
    facts: &JointFacts,
    order: &[usize],
) -> Result<bool, NumericError> {
    let problem = generic_problem(reversed)?;
    let priors = priors_of(&problem);
    if priors.is_empty() {
        return Ok(false);
    }
    let columns = ArmColumns::of(&problem, motions);
    let given = reversed.arm().gravity_e0;
    let search = Search { model, columns, priors, facts, given };
    let as_labelled = JointMap::as_labelled(order.len());
    let reordered = JointMap { effort: order.to_vec(), ..as_labelled.clone() };
    let labelled = search.judged(&State::as_labelled(as_labelled));
    let judged = search.judged(&State::as_labelled(reordered));
    let ratios = search.ratios(&labelled, &judged);
    let moved = order.iter().enumerate().filter(|(j, k)| j != *k).map(|(_, k)| *k);
    let all_better = moved.into_iter().all(|k| ratios[k] <= MUST_LEAVE);
    Ok(all_better && search.explains(&labelled, &judged))
}

/// The problem of an arm with gravity along no special direction.
fn generic_problem(reversed: &BatchProblem) -> Result<BatchProblem, NumericError> {
    let generic = generic_arm(reversed.arm());
    let set = MinimalSet::of(&generic)?;
    let mut problem = BatchProblem::new(&generic, &set);
    problem.reversals.clone_from(&reversed.reversals);
    Ok(problem)
}

fn priors_of(problem: &BatchProblem) -> Vec<ConstantPrior> {
    let prior = |&(error, load): &(f64, f64)| {
        let of = LinkErrors::of(problem, error, load);
        ConstantPrior::of(of.mean, &of.spread)
    };
    PRIORS.iter().filter_map(prior).collect()
}

/// The arm with gravity along no special direction.
fn generic_arm(arm: &RigidArm) -> RigidArm {
    let mut generic = arm.clone();
    generic.gravity_e0 = STANDARD_GRAVITY * Vector3::new(0.48, 0.6, -0.64);
    generic
}

#[derive(Clone)]
struct Judged {
    state: State,
    score: f64,
    fits: Vec<ArmFit>,
}

impl Judged {
    /// The fit under the most likely prior.
    fn best(&self) -> Option<&ArmFit> {
        self.fits.iter().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
    }

    /// By joints of the recordings, what their effort columns are.
    fn meaning(&self) -> Vec<Meaning> {
        let mut meaning = vec![Meaning::Effort; self.state.map.effort.len()];
        if let Some(fit) = self.best() {
            self.state.map.effort.iter().zip(&fit.meaning).for_each(|(&e, m)| meaning[e] = *m);
        }
        meaning
    }
}

struct Search<'a> {
    model: &'a ArmModel,
    columns: ArmColumns<'a>,
    priors: Vec<ConstantPrior>,
    facts: &'a JointFacts,
    given: Vector3<f64>,
}

impl Search<'_> {
    fn size(&self) -> f64 {
        let given = self.given.norm();
        if given > 0.0 { given } else { STANDARD_GRAVITY }
    }

    fn gravity_of(&self, gravity: Gravity) -> Vector3<f64> {
        match gravity {
            Gravity::AsGiven => self.given,
            Gravity::TakenOff => Vector3::zeros(),
            Gravity::Axis(at) | Gravity::Free(at) => at,
        }
    }

    /// The fits to the blocks of time that are wanted, under all priors.
    fn fits(
        &self,
        products: &[JointProducts],
        gravity: &Vector3<f64>,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Vec<ArmFit> {
        let system = ArmSystem::of(&self.columns, products, self.facts, gravity, wanted);
        self.priors.iter().map(|prior| system.fit(prior)).collect()
    }

    /// The fit at one gravity under the widest prior, with which a search ranks.
    fn loose_fit(&self, products: &[JointProducts], gravity: &Vector3<f64>) -> ArmFit {
        ArmSystem::of(&self.columns, products, self.facts, gravity, &|_| true)
            .fit(&self.priors[self.priors.len() - 1])
    }

    /// The most likely direction near one, under that prior.
    fn refined(&self, products: &[JointProducts], near: &Vector3<f64>) -> Option<Direction> {
        let prior = &self.priors[self.priors.len() - 1];
        refine(&self.columns, products, prior, near, &|at| self.loose_fit(products, at))
    }

    fn judged_with(&self, state: &State, products: &[JointProducts]) -> Judged {
        let fits = self.fits(products, &self.gravity_of(state.gravity), &|_| true);
        let prior = state.map_prior
            + match state.gravity {
                Gravity::AsGiven => (1.0 - OTHER_AXIS - TAKEN_OFF - FREE).ln(),
                Gravity::Axis(_) => (OTHER_AXIS / 5.0).ln(),
                Gravity::TakenOff => TAKEN_OFF.ln(),
                Gravity::Free(_) => (FREE * SHARE_OF_SPHERE).ln(),
            };
        Judged { state: state.clone(), score: prior + mean_likelihood(&fits), fits }
    }

    fn judged(&self, state: &State) -> Judged {
        self.judged_with(state, &self.columns.products(&state.map))
    }

    /// The best single change, if it makes the explanation a thousand times as likely.
    fn better(&self, from: &Judged) -> Option<Judged> {
        let products = self.columns.products(&from.state.map);
        let mut tried: Vec<Judged> = self.gravities(from, &products);
        let mapped = |(map, prior): &(JointMap, f64)| State {
            map: map.clone(),
            map_prior: if map.is_as_labelled() { 0.0 } else { from.state.map_prior + prior },
            ..from.state.clone()
        };
        // all with the priors that a search needs, the best of them with all
        let gravity = self.gravity_of(from.state.gravity);
        let mut rough: Vec<(f64, State)> = self
            .maps(&from.state.map)
            .par_iter()
            .map(|change| {
                let state = mapped(change);
                let products = self.columns.products(&state.map);
                let fit = self.loose_fit(&products, &gravity);
                (state.map_prior + fit.log_likelihood, state)
            })
            .collect();
        let exchanged: Vec<(f64, State)> = self
            .effort_maps(&from.state.map)
            .par_iter()
            .map(|change| {
                let state = mapped(change);
                let efforts = state.map.effort.iter();
                let products: Vec<JointProducts> =
                    products.iter().zip(efforts).map(|(of, &k)| of.with_effort(k)).collect();
                let fit = self.loose_fit(&products, &gravity);
                (state.map_prior + fit.log_likelihood, state)
            })
            .collect();
        rough.extend(exchanged);
        rough.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = rough.iter().take(JUDGED_FULLY);
        tried.extend(best.map(|(_, state)| self.judged(state)));
        let best = tried.into_iter().max_by(|a, b| a.score.total_cmp(&b.score))?;
        (best.score > from.score - SURE.ln()).then_some(best)
    }

    /// Other directions of gravity: along the axes of the base, none, and any.
    fn gravities(&self, from: &Judged, products: &[JointProducts]) -> Vec<Judged> {
        let to_e0 = self.model.chain.base_from_e0.rotation.inverse();
        let is_given = |at: &Vector3<f64>| at.angle(&self.given) < 1e-6;
        let along = |axis: Vector3<f64>| to_e0 * axis * self.size();
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let axes: Vec<Vector3<f64>> = axes.iter().flat_map(|a| [along(*a), along(-*a)]).collect();
        let mut states: Vec<Gravity> =
            axes.iter().filter(|at| !is_given(at)).map(|at| Gravity::Axis(*at)).collect();
        states.push(Gravity::AsGiven);
        states.push(Gravity::TakenOff);
        states.retain(|gravity| *gravity != from.state.gravity);
        let mut judged: Vec<Judged> = states
            .par_iter()
            .map(|&gravity| self.judged_with(&State { gravity, ..from.state.clone() }, products))
            .collect();
        // any direction: from the best of a grid over the sphere
        let grid: Vec<Vector3<f64>> = (0..27)
            .map(|k| {
                Vector3::new(f64::from(k % 3 - 1), f64::from(k / 3 % 3 - 1), f64::from(k / 9 - 1))
            })
            .filter(|at| at.norm() > 0.0)
            .map(|at| at.normalize() * self.size())
            .collect();
        let start = grid
            .par_iter()
            .map(|at| (self.loose_fit(products, at).log_likelihood, *at))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, at)) = start
            && let Some(found) = self.refined(products, &at)
        {
            let gravity = Gravity::Free(found.gravity);
            judged.push(self.judged_with(&State { gravity, ..from.state.clone() }, products));
        }
        judged
    }

    /// Maps that differ by one change, each with the logarithm of its prior.
    fn maps(&self, from: &JointMap) -> Vec<(JointMap, f64)> {
        let n = self.columns.joints();
        let mut maps = Vec::new();
        for j in 0..n {
            let mut map = from.clone();
            map.sign[j] = -map.sign[j];
            maps.push((map, (OTHER_WAY / n as f64).ln()));
        }
        let pairs = (n * n.saturating_sub(1) / 2).max(1) as f64;
        for j in 0..n {
            for k in 0..j {
                let mut map = from.clone();
                map.source.swap(j, k);
                map.sign.swap(j, k);
                map.effort.swap(j, k);
                maps.push((map, (EXCHANGED / pairs).ln()));
            }
        }
        // joints written in the order of their names, read in that of the chain; and the other way round
        let names = self.model.chain.joint_names();
        let mut by_name: Vec<usize> = (0..n).collect();
        by_name.sort_by_key(|&j| names[j]);
        let mut back = vec![0; n];
        by_name.iter().enumerate().for_each(|(k, &j)| back[j] = k);
        for source in [by_name, back] {
            let moved = source.iter().enumerate().filter(|(j, s)| j != *s).count();
            if moved > 2 {
                let effort = source.clone();
                maps.push((JointMap { source, sign: vec![1.0; n], effort }, BY_NAME.ln()));
            }
        }
        maps
    }

    /// Maps with two effort columns exchanged.
    fn effort_maps(&self, from: &JointMap) -> Vec<(JointMap, f64)> {
        let n = self.columns.joints();
        let usable: Vec<usize> = (0..n).filter(|&j| !self.facts.is_mute[from.effort[j]]).collect();
        let pairs = (n * n.saturating_sub(1) / 2).max(1) as f64;
        let mut maps = Vec::new();
        for &j in &usable {
            for &k in usable.iter().filter(|&&k| k < j) {
                let mut map = from.clone();
                map.effort.swap(j, k);
                maps.push((map, (EXCHANGED / pairs).ln()));
            }
        }
        maps
    }

    /// Whether no recording alone shows the contrary of what all show together.
    fn holds_in_each_recording(&self, before: &Judged, after: &Judged) -> bool {
        let blocks = self.columns.blocks_by_recording();
        if blocks.len() < 2 {
            return true;
        }
        let products = [before, after].map(|of| self.columns.products(&of.state.map));
        let mut start = 0;
        blocks.iter().all(|&count| {
            let own = start..start + count;
            start += count;
            let [was, is] =
                [(before, &products[0]), (after, &products[1])].map(|(of, products)| {
                    let gravity = self.gravity_of(of.state.gravity);
                    mean_likelihood(&self.fits(products, &gravity, &|b| own.contains(&b)))
                });
            is > was + SURE.ln()
        })
    }

    /// Per recorded joint, what another explanation leaves of its error.
    fn ratios(&self, before: &Judged, after: &Judged) -> Vec<f64> {
        let n = self.columns.joints();
        let mut ratios = vec![1.0; n];
        if let (Some(from), Some(to)) = (before.best(), after.best()) {
            for j in 0..n {
                let column = after.state.map.effort[j];
                let was = before.state.map.effort.iter().position(|s| *s == column);
                let Some(was) = was else { continue };
                ratios[column] = (to.variance[j] / from.variance[was]).sqrt();
            }
        }
        ratios
    }

    /// Whether some joint has an error of which another explanation could leave half.
    fn leaves_more_than_noise(&self, judged: &Judged) -> bool {
        judged.best().is_none_or(|fit| {
            (0..self.columns.joints()).any(|s| {
                let usable = !self.facts.is_mute[s] && self.columns.moves[s];
                usable && fit.variance[s] * MUST_LEAVE.powi(2) > fit.least_variance[s]
            })
        })
    }

    /// Whether an explanation leaves half of some joint's error at most, and of none much more.
    fn explains(&self, before: &Judged, after: &Judged) -> bool {
        let usable = |s: &usize| !self.facts.is_mute[*s] && self.columns.moves[*s];
        let ratios = self.ratios(before, after);
        let of_usable: Vec<f64> = (0..ratios.len()).filter(usable).map(|s| ratios[s]).collect();
        let least = of_usable.iter().copied().fold(f64::INFINITY, f64::min);
        let most = of_usable.iter().copied().fold(0.0, f64::max);
        least <= MUST_LEAVE && most <= MUST_NOT_GROW && self.fits_most(after)
    }

    /// Whether the arm explains most of its moving joints: accelerations that are noise, or stamps that are late, are
    /// fitted by no arm, and the least bad one means nothing.
    fn fits_most(&self, judged: &Judged) -> bool {
        let Some(fit) = judged.best() else { return false };
        let effort = &judged.state.map.effort;
        let usable: Vec<usize> = (0..effort.len())
            .filter(|&j| !self.facts.is_mute[effort[j]] && self.columns.moves[effort[j]])
            .collect();
        let fitted = usable.iter().filter(|&&j| {
            let near_one =
                (fit.gain[j] - 1.0).abs() < 2.0 * USUAL_LOG_GAIN || self.facts.is_signal[effort[j]];
            near_one && fit.left[j] <= MUST_LEAVE.powi(2)
        });
        2 * fitted.count() >= usable.len()
    }

    /// Gravity of an explanation, and where it points if that is not where it was given.
    fn direction(&self, best: &Judged) -> (Vector3<f64>, Option<GravityDirectionFound>) {
        let at = self.gravity_of(best.state.gravity);
        if matches!(best.state.gravity, Gravity::AsGiven | Gravity::TakenOff) {
            return (self.given, None);
        }
        let products = self.columns.products(&best.state.map);
        let Some(found) = self.refined(&products, &at) else { return (at, None) };
        let found = self.in_base(&found);
        let to_e0 = self.model.chain.base_from_e0.rotation.inverse();
        (to_e0 * Vector3::from(found.rounded()), Some(found))
    }

    fn in_base(&self, found: &Direction) -> GravityDirectionFound {
        let rotation = self.model.chain.base_from_e0.rotation;
        let (angle, half) =
            if self.given.norm() > 0.0 { found.angle_to(&self.given) } else { (0.0, 0.0) };
        let degrees = |x: f64| x.to_degrees();
        GravityDirectionFound {
            gravity_base: (rotation * found.gravity).into(),
            angle_deg: degrees(angle),
            interval_95_deg: [degrees((angle - half).max(0.0)), degrees(angle + half).min(180.0)],
            radius_95_deg: degrees(found.radius_rad()),
        }
    }
}
