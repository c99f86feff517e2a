//! Which effects of the library a suite would show, before the arm has moved.
//!
//! Of each law at each joint, the standard error of its size with all that is fitted anyway beside it ([`crate::imitation`]):
//! columns that the fit imitates are left out, the others give the smallest size that is four standard errors.
//!
//! References: own.

use armident_effects::{ArmColumns, Draw, DrawContext, Effect, JointSize, LocationKind, Parameter};
use armident_kinematics::DrivingAxisChain;
use armident_numeric::Mat;
use serde::Serialize;

use crate::imitation::Fitted;
use crate::information::Parameters;
use crate::law_columns::{PlacedLaw, PlannedMotion, deviation, mean, places, root_mean_square};

/// Standard errors of the smallest size that is visible: with some hundred effects at a place each, less than one is beyond
/// it where there is none (two-sided normal probability 6e-5).
pub const STANDARD_ERRORS: f64 = 4.0;
/// Share of a column's square that must be left by all that is fitted: less is rounding and the filters of an estimator.
const LEAST_SHARE: f64 = 1e-6;
/// Dry friction of a joint whose URDF gives none, over its root mean square effort; viscous friction is as large at the root
/// mean square speed.
const FRICTION_SHARE: f64 = 0.1;
/// Size of an effect whose draws have no largest one, over the smallest that is drawn.
const OVER_SMALLEST: f64 = 10.0;
/// Step of the slope of a parameter in a coefficient.
const STEP: f64 = 1e-6;

/// Whether some motions would show an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sight {
    /// The largest size of simulated cases is at least four standard errors.
    Visible,
    /// Even the largest size of simulated cases is less than four standard errors.
    TooSmall,
    /// Link constants, friction and offset that are fitted anyway imitate it.
    Imitated,
}

/// How well an effect shows on the motions of a suite.
#[derive(Debug, Clone, Serialize)]
pub struct Visibility {
    /// Slug of the law.
    pub effect: String,
    /// Its joint; the first of two neighbours; none for the whole arm.
    pub joint: Option<String>,
    /// The second of two neighbours.
    pub other_joint: Option<String>,
    /// The parameter that is its size.
    pub parameter: String,
    /// Unit of the size.
    pub unit: String,
    /// Smallest size that the training motion shows: four standard errors; none where it is imitated, or without that motion.
    pub least_from_train: Option<f64>,
    /// Smallest size that all motions of the fit show.
    pub least_from_suite: Option<f64>,
    /// Largest size that a simulated case of the challenge hides.
    pub largest: f64,
    /// Verdict for the training motion.
    pub train: Option<Sight>,
    /// Verdict for all motions of the fit.
    pub suite: Sight,
}

/// A draw without chance: the middle of every interval, on one joint.
struct Middle(usize);

impl Draw for Middle {
    fn uniform(&mut self) -> f64 {
        0.5
    }

    fn normal(&mut self) -> f64 {
        1.0
    }

    fn index(&mut self, count: usize) -> usize {
        self.0.min(count.saturating_sub(1))
    }
}

/// What an effect is judged on: its shape and the size that a case would hide at most.
struct Typical {
    shape: Vec<f64>,
    coefficients: Vec<f64>,
}

fn typical(law: &dyn Effect, joint: usize, context: &DrawContext<'_>) -> Option<Typical> {
    let drawn = law.draw(&mut Middle(joint), context)?;
    let size = Some(drawn.most).filter(|most| most.is_finite());
    let parameters = drawn.parameters(size.unwrap_or(OVER_SMALLEST * drawn.start));
    let (shape, coefficients) = law.shape_and_coefficients(&parameters);
    Some(Typical { shape, coefficients })
}

/// Sizes of the joints on a motion, from which effects are drawn.
fn context<'a>(
    chain: &DrivingAxisChain,
    parameters: &Parameters<'a>,
    motion: &PlannedMotion<'_>,
) -> DrawContext<'a> {
    let [position, velocity, acceleration] = motion.columns;
    let joints = chain.joints.iter().enumerate().map(|(j, joint)| {
        let speed = root_mean_square(&velocity[j], 0.0).max(f64::MIN_POSITIVE);
        let effort = root_mean_square(&motion.rigid_effort[j], 0.0);
        let [low, high] = armident_numeric::extremes(motion.rigid_effort[j].iter().copied());
        let given = joint
            .dynamics
            .unwrap_or(armident_kinematics::JointDynamics { damping: 0.0, friction: 0.0 });
        let or_share = |value: f64, share: f64| if value > 0.0 { value } else { share };
        JointSize {
            kind: joint.kind,
            position_mean: mean(&position[j]),
            position_deviation: deviation(&position[j]),
            speed,
            acceleration: root_mean_square(&acceleration[j], 0.0),
            noise: parameters.noise[j],
            effort_range: high - low,
            dry_level: or_share(given.friction, FRICTION_SHARE * effort),
            viscous: or_share(given.damping, FRICTION_SHARE * effort / speed),
        }
    });
    DrawContext {
        arm: parameters.arm,
        link_in_e: chain.joints.iter().map(|joint| joint.child_link_in_e).collect(),
        joints: joints.collect(),
        duration_s: motion.duration_s(),
        recordings: 1,
    }
}

/// The parameter that is the size of a law, its slope in each coefficient: the first main one that has a slope, else the
/// first.
fn size_parameter(
    law: &dyn Effect,
    shape: &[f64],
    count: usize,
) -> Option<(&'static Parameter, Vec<f64>)> {
    let at = |coefficients: &[f64]| law.parameters(shape, coefficients);
    let zero = at(&vec![0.0; count]);
    let slopes: Vec<Vec<f64>> = (0..count)
        .map(|c| {
            let mut moved = vec![0.0; count];
            moved[c] = STEP;
            at(&moved).iter().zip(&zero).map(|(a, b)| (a - b) / STEP).collect()
        })
        .collect();
    let parameters = law.law().parameters.iter().enumerate();
    let slope_of = |k: usize| -> Vec<f64> {
        slopes.iter().map(|s| s.get(k).copied().unwrap_or(0.0)).collect()
    };
    let has_slope = |k: usize| {
        slope_of(k).iter().all(|s| s.is_finite()) && slope_of(k).iter().any(|s| *s != 0.0)
    };
    let of = |main: bool| parameters.clone().find(|(k, p)| (p.is_main || !main) && has_slope(*k));
    let (k, parameter) = of(true).or_else(|| of(false))?;
    Some((parameter, slope_of(k)))
}

/// Smallest visible size from the information on the coefficients; none where all that matter are imitated.
fn least_visible([left, own]: &[Mat<f64>; 2], slopes: &[f64]) -> Option<f64> {
    let kept: Vec<usize> = (0..slopes.len())
        .filter(|&c| own[(c, c)] > 0.0 && left[(c, c)] > LEAST_SHARE * own[(c, c)])
        .collect();
    let size = |c: usize| left[(c, c)].sqrt();
    let factor = armident_numeric::Cholesky::of(kept.len(), |a, b| {
        let (i, j) = (kept[a], kept[b]);
        left[(i, j)] / (size(i) * size(j)) + if a == b { LEAST_SHARE } else { 0.0 }
    })?;
    let diagonal = factor.inverse_diagonal();
    let error = kept
        .iter()
        .zip(&diagonal)
        .map(|(&c, d)| slopes[c].abs() * d.sqrt() / size(c))
        .fold(0.0, f64::max);
    (error > 0.0).then_some(STANDARD_ERRORS * error)
}

/// Largest size of a typical effect beyond what is imitated.
fn largest_size(coefficients: &[f64], slopes: &[f64], [left, own]: &[Mat<f64>; 2]) -> f64 {
    (0..slopes.len().min(coefficients.len()))
        .filter(|&c| left[(c, c)] > LEAST_SHARE * own[(c, c)])
        .map(|c| (slopes[c] * coefficients[c]).abs())
        .fold(0.0, f64::max)
}

/// Motions whose recordings are fitted, one of them the training motion perhaps.
pub(crate) struct Seen<'a> {
    pub(crate) chain: &'a DrivingAxisChain,
    pub(crate) parameters: &'a Parameters<'a>,
    pub(crate) motions: &'a [PlannedMotion<'a>],
    /// which of them is the training motion
    pub(crate) train: Option<usize>,
}

impl Seen<'_> {
    fn fitted(&self, which: &[usize]) -> Fitted {
        let regressors =
            which.iter().map(|&m| self.parameters.regressors(self.motions[m].columns)).collect();
        Fitted::new(self.parameters.len(), regressors, &self.parameters.noise)
    }

    /// Visibility of all named laws whose effort is known from the motion alone, on every joint.
    pub(crate) fn effects(&self) -> Vec<Visibility> {
        let Some(reference) = self.motions.get(self.train.unwrap_or(0)) else { return Vec::new() };
        let (chain, arm) = (self.chain, self.parameters.arm);
        let everything: Vec<usize> = (0..self.motions.len()).collect();
        let all = self.fitted(&everything);
        let train = self.train.map(|m| self.fitted(&[m]));
        let context = context(chain, self.parameters, reference);
        let baseline: Vec<&str> =
            crate::information::JOINT_LAWS.iter().map(|law| law.slug()).collect();
        let mut found = Vec::new();
        for law in armident_effects::Library::standard().named() {
            if baseline.contains(&law.slug()) {
                continue;
            }
            for placed in places(law, arm.dof()) {
                let Some(of) = typical(law, placed.joint, &context) else { continue };
                let columns: Vec<ArmColumns> = self
                    .motions
                    .iter()
                    .map(|motion| motion.law(chain, arm, placed, &of.shape))
                    .collect();
                found.extend(self.visibility(placed, &of, &columns, &all, train.as_ref()));
            }
        }
        found
    }

    fn visibility(
        &self,
        placed: PlacedLaw,
        of: &Typical,
        columns: &[ArmColumns],
        all: &Fitted,
        train: Option<&Fitted>,
    ) -> Option<Visibility> {
        let count = columns.first().map_or(0, Vec::len);
        let (parameter, slopes) = size_parameter(placed.law, &of.shape, count)?;
        let suite = all.residual(columns)?;
        let largest = largest_size(&of.coefficients, &slopes, &suite);
        let least_from_suite = least_visible(&suite, &slopes);
        let only = self.train.zip(train).and_then(|(m, train)| train.residual(&columns[m..=m]));
        let least_from_train = only.as_ref().and_then(|only| least_visible(only, &slopes));
        let sight = |least: Option<f64>| match least {
            None => Sight::Imitated,
            Some(least) if least <= largest => Sight::Visible,
            Some(_) => Sight::TooSmall,
        };
        let law = placed.law.law();
        let name = |joint: usize| self.chain.joints.get(joint).map(|joint| joint.name.clone());
        let whole = matches!(law.location, LocationKind::AllJoints | LocationKind::Arm);
        let is_pair = law.scope == armident_effects::Scope::Neighbours;
        Some(Visibility {
            effect: law.slug.to_owned(),
            joint: name(placed.joint).filter(|_| !whole),
            other_joint: name(placed.joint + 1).filter(|_| is_pair),
            parameter: parameter.name.to_owned(),
            unit: parameter.unit(self.chain.joints[placed.joint].kind).to_owned(),
            least_from_train,
            least_from_suite,
            largest,
            train: only.map(|_| sight(least_from_train)),
            suite: sight(least_from_suite),
        })
    }
}
