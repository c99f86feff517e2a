//! Links behind a spring: their load on the joints, and the motion of the one behind the spring.
//!
//! ```text
//! τ = Y(q, q̇, q̈) π,   q the motion of the link;   dτ/dπ = Y + ∂τ/∂(q, q̇, q̈) d(q, q̇, q̈)/dπ
//! m δq̈ + (D + drag) δq̇ + (K + slope) δq = -Y_joint
//! ```
//!
//! The oscillation of a spring determines the inertia of its link better than the efforts do, and a wrong inertia leads to
//! another spring: both are found only where columns include the change of one with the other.

use armident_kinematics::{DrivingAxisChain, InertialParameters};
use armident_model::{Load, OperatingPoint, PosedRecording, Spring};
use armident_motion::BandMotion;
use std::ops::{Deref, Range};
use std::sync::OnceLock;

use armident_dynamics::{ArmMotion, ParameterColumns, RigidArm};
use armident_recording::RecordingError;

const TEN: usize = InertialParameters::COUNT;

/// The motion of the link behind a spring in one recording, and the efforts of small changes of it.
pub(crate) struct CompliantLink {
    spring: Spring,
    /// position, velocity, acceleration
    link: [Vec<f64>; 3],
    /// about this motion
    load: Load,
    /// `[position, velocity, acceleration][joint][sample]`: change of the efforts with them
    by_motion: [Vec<Vec<f64>>; 3],
    /// `[joint][sample]`: part of the difference to a rigid transmission that the columns of the links include
    counted: Vec<Vec<f64>>,
}

/// A posed recording with the compliant links of its operating point.
pub(crate) struct Posed<'a> {
    recording: PosedRecording<'a>,
    /// formed when first asked for
    compliant: Vec<(Spring, OnceLock<Option<CompliantLink>>)>,
}

impl<'a> Deref for Posed<'a> {
    type Target = PosedRecording<'a>;

    fn deref(&self) -> &Self::Target {
        &self.recording
    }
}

impl<'a> Posed<'a> {
    pub(crate) fn new(
        chain: &DrivingAxisChain,
        arm: &RigidArm,
        signals: &'a BandMotion,
        point: &OperatingPoint,
    ) -> Self {
        let compliant = point.springs.iter().map(|s| (s.clone(), OnceLock::new())).collect();
        Self { recording: PosedRecording::new(chain, arm, signals, point), compliant }
    }

    /// The links behind springs of the operating point.
    pub(crate) fn compliant_links(&self) -> impl Iterator<Item = &CompliantLink> {
        self.compliant.iter().filter_map(|(spring, made)| {
            made.get_or_init(|| CompliantLink::of(self, spring).ok()).as_ref()
        })
    }

    /// Whether the operating point has a spring on a joint that is about right.
    pub(crate) fn has_right_spring(&self, joint: usize) -> bool {
        self.compliant_links().any(|link| link.joint() == joint && link.is_about_right())
    }
}

impl CompliantLink {
    pub(crate) fn of(at: &Posed<'_>, spring: &Spring) -> Result<Self, RecordingError> {
        /// Steps of the differences \[rad or m, with seconds\].
        const STEPS: [f64; 3] = [1e-4, 1e-4, 1e-2];
        let joint = spring.joint;
        let link = spring.transmission.link_side_motion(at, joint)?;
        let arm = at.of_other_links().0;
        let motion = at.motion();
        let load = at.load(joint).moved(&motion, arm, joint, &link[0], &link[1]);
        let efforts = |link: &[Vec<f64>; 3]| {
            motion.with_joint(joint, link.each_ref().map(Vec::as_slice)).efforts(arm)
        };
        let here = efforts(&link);
        let by_motion = std::array::from_fn(|part| {
            let mut moved = link.clone();
            moved[part].iter_mut().for_each(|x| *x += STEPS[part]);
            let mut change = efforts(&moved);
            for (change, here) in change.iter_mut().zip(&here) {
                change.iter_mut().zip(here).for_each(|(c, h)| *c = (*c - h) / STEPS[part]);
            }
            change
        });
        let mut sprung =
            Self { spring: spring.clone(), link, load, by_motion, counted: Vec::new() };
        sprung.counted = of_other_links(&sprung, at);
        Ok(sprung)
    }

    /// Part of the difference to a rigid transmission that the columns of the links include, `[joint][sample]`.
    pub(crate) fn counted(&self) -> &[Vec<f64>] {
        &self.counted
    }

    /// Whether the difference to a rigid transmission is about as large as simulated: from then on it is exactly that, for
    /// its size and the stiffness nearly say the same.
    pub(crate) fn is_about_right(&self) -> bool {
        const NEAR: f64 = 0.2;
        (self.spring.share - 1.0).abs() < NEAR
    }

    pub(crate) fn joint(&self) -> usize {
        self.spring.joint
    }

    fn motion<'b>(&'b self, motion: &'b ArmMotion<'b>) -> ArmMotion<'b> {
        motion.with_joint(self.joint(), self.link.each_ref().map(Vec::as_slice))
    }

    /// How the link moves under an effort on it beside those that it has, the spring twisted so far at first.
    fn yields_to(&self, effort: Vec<f64>, twist: f64, rate_hz: f64) -> [Vec<f64>; 3] {
        self.spring.transmission.yields_to(&self.load, effort, twist, rate_hz)
    }

    /// How far some efforts on the joint twist the spring at the first sample, given for a motion of one sample: as the
    /// twist there is found.
    fn twists(&self, at: &Posed<'_>, efforts: impl Fn(&ArmMotion<'_>) -> Vec<f64>) -> Vec<f64> {
        const STEP: f64 = 1e-4;
        let (signals, joint) = (at.signals, self.joint());
        let stiffness = self.spring.transmission.stiffness;
        let first = |of: &[Vec<f64>]| -> Vec<Vec<f64>> { of.iter().map(|x| vec![x[0]]).collect() };
        let mut position = first(&at.position);
        if signals.starts_at_rest {
            let still = vec![vec![0.0]; position.len()];
            position[joint][0] = self.link[0][0];
            let there = efforts(&ArmMotion::new(&position, &still, &still));
            let resists = stiffness + self.load.slope_at_start();
            return there.into_iter().map(|effort| effort / resists).collect();
        }
        let twist = position[joint][0] - self.link[0][0];
        let (velocity, acceleration) = (first(&signals.velocity), first(&signals.acceleration));
        let mut at_position = |moved: f64| {
            position[joint][0] += moved;
            efforts(&ArmMotion::new(&position, &velocity, &acceleration))
        };
        let (here, moved) = (at_position(0.0), at_position(STEP));
        let resists = stiffness + at.load(joint).slope_at_start();
        let borne =
            here.iter().zip(&moved).map(|(here, moved)| here - (moved - here) / STEP * twist);
        borne.map(|effort| effort / resists).collect()
    }

    /// Change of the effort on a joint with such a motion.
    fn felt_on(&self, joint: usize, moved: &[Vec<f64>; 3]) -> Vec<f64> {
        let mut felt = vec![0.0; moved[0].len()];
        for (moved, by) in moved.iter().zip(&self.by_motion) {
            for ((f, x), by) in felt.iter_mut().zip(moved).zip(&by[joint]) {
                *f += x * by;
            }
        }
        felt
    }

    /// How the link yields to each standard parameter from those of its own link on: `[parameter]`.
    pub(crate) fn yields_to_parameters(&self, at: &Posed<'_>) -> Vec<[Vec<f64>; 3]> {
        let dof = at.arm.dof();
        let wanted: Vec<usize> = (TEN * self.joint()..TEN * dof).collect();
        let (motion, standard) = (at.motion(), ParameterColumns::standard(dof));
        let own = self.motion(&motion);
        let columns = standard.of_arm_motion(&at.arm, self.joint(), &own, &wanted);
        let twists = self.twists(at, |first| {
            let columns = standard.of_arm_motion(&at.arm, self.joint(), first, &wanted);
            columns.iter().map(|column| column[0]).collect()
        });
        let each = columns.into_iter().zip(twists);
        each.map(|(column, twist)| self.yields_to(column, twist, at.signals.rate_hz)).collect()
    }

    /// Columns of some standard parameters on a joint beyond those with a rigid transmission. `yielding`: of
    /// [`Self::yields_to_parameters`].
    pub(crate) fn columns_on(
        &self,
        at: &Posed<'_>,
        joint: usize,
        wanted: Range<usize>,
        yielding: &[[Vec<f64>; 3]],
    ) -> Vec<Vec<f64>> {
        let standard = ParameterColumns::standard(at.arm.dof());
        let wanted: Vec<usize> = wanted.collect();
        let motion = at.motion();
        let sprung = standard.of_arm_motion(&at.arm, joint, &self.motion(&motion), &wanted);
        let rigid = standard.of_arm_motion(&at.arm, joint, &motion, &wanted);
        let first = TEN * self.joint();
        let columns = wanted.iter().zip(sprung.iter().zip(&rigid));
        columns
            .map(|(&parameter, (sprung, rigid))| {
                let mut more: Vec<f64> = sprung.iter().zip(rigid).map(|(s, r)| s - r).collect();
                if let Some(moved) = parameter.checked_sub(first).map(|k| &yielding[k]) {
                    let felt = self.felt_on(joint, moved);
                    more.iter_mut().zip(felt).for_each(|(m, f)| *m += f);
                }
                more.iter_mut().for_each(|m| *m *= self.spring.share);
                more
            })
            .collect()
    }
}

/// Columns of the links beyond those with a rigid transmission, times the difference of the operating point's links to the
/// given ones.
fn of_other_links(sprung: &CompliantLink, at: &Posed<'_>) -> Vec<Vec<f64>> {
    let others = at.of_other_links().0;
    let motion = at.motion();
    let difference = |motion: &ArmMotion<'_>| -> Vec<Vec<f64>> {
        let (a, b) = (motion.efforts(others), motion.efforts(&at.arm));
        a.iter().zip(&b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect()).collect()
    };
    let mut more = difference(&sprung.motion(&motion));
    let joint = sprung.joint();
    let twist = sprung.twists(at, |first| vec![difference(first)[joint][0]])[0];
    let moved = sprung.yields_to(more[joint].clone(), twist, at.signals.rate_hz);
    for (j, (more, rigid)) in more.iter_mut().zip(difference(&motion)).enumerate() {
        let felt = sprung.felt_on(j, &moved);
        for ((m, r), f) in more.iter_mut().zip(rigid).zip(felt) {
            *m += f - r;
        }
    }
    more
}

/// Mean over the recordings of the joint's own inertia.
pub(crate) fn mean_inertia(at: &[Posed<'_>], joint: usize) -> f64 {
    let loads = || at.iter().map(|at| &at.load(joint).inertia);
    loads().flatten().sum::<f64>() / loads().map(Vec::len).sum::<usize>() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::training::Design;
    use crate::regression::relinearise::Step;
    use crate::regression::relinearise::stride;
    use crate::selection::iterate::select;
    use crate::test_arms::{swung, swung_for, ur5};
    use armident_dynamics::RigidArm;
    use armident_model::FittedTransmission;
    use armident_model::changed;

    /// Where the fit follows its operating point by a share, two steps determine the fixed point; where by nearly all of it, the
    /// step is no longer than three.
    #[test]
    fn two_steps_determine_fixed_point_of_spring() {
        const SETTLED: f64 = 5.0;
        let at = |stiffness_ln: f64| {
            let transmission =
                FittedTransmission { gap: 0.0, stiffness: stiffness_ln.exp(), damping: 1.0 };
            vec![Spring { joint: 0, transmission, share: 1.0 }]
        };
        let point = |springs: Vec<Spring>| OperatingPoint { springs, ..OperatingPoint::of(1) };
        for share in [-1.5, -0.4, 0.13, 0.6, 0.95] {
            let fitted = |beside: f64| SETTLED + share * (beside - SETTLED);
            let (before, here) = (5.3, fitted(5.3));
            let last = Step { from: at(before), to: at(here) };
            let mut to = point(at(fitted(here)));
            stride(&mut to, &point(at(here)), Some(&last));
            let reached = to.springs[0].transmission.stiffness.ln();
            let longest = here + 3.0 * (fitted(here) - here);
            let expected = if share > 2.0 / 3.0 { longest } else { SETTLED };
            assert!((reached - expected).abs() < 1e-9, "{share}: {reached}");
        }
    }

    /// The columns of a link are derivatives of simulated efforts, on all joints and about links other than the given ones; and
    /// their part of the spring's difference is their sum for these.
    #[test]
    fn columns_behind_spring_are_derivatives_of_efforts() {
        const JOINT: usize = 1;
        let chain = ur5();
        let arm = RigidArm::from_chain(&chain);
        let signals = swung(&chain, 0.0, |_, _| 0.0);
        let dof = chain.joints.len();
        let transmission = FittedTransmission { gap: 0.0, stiffness: 900.0, damping: 2.0 };
        let spring = Spring { joint: JOINT, transmission, share: 1.0 };
        let mut links = vec![0.0; TEN * dof];
        links[TEN * 2..TEN * 2 + 4].copy_from_slice(&[0.4, 0.1, 0.02, -0.03]);
        let at_links = |links: &[f64]| {
            let (links, springs) = (Some(links.to_vec()), vec![spring.clone()]);
            let point = OperatingPoint { links, springs, ..OperatingPoint::of(dof) };
            Posed::new(&chain, &arm, &signals, &point)
        };
        let at = at_links(&links);
        let sprung = at.compliant_links().next().unwrap();
        let yielding = sprung.yields_to_parameters(&at);
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut counted = vec![vec![0.0; signals.len()]; dof];
        for parameter in 0..TEN * dof {
            const STEP: f64 = 1e-4;
            let [below, above] = [-STEP, STEP].map(|step| {
                let mut links = links.clone();
                links[parameter] += step;
                transmission.difference(&at_links(&links), JOINT).unwrap()
            });
            for j in 0..dof {
                let column = &sprung.columns_on(&at, j, parameter..parameter + 1, &yielding)[0];
                let expected: Vec<f64> =
                    above[j].iter().zip(&below[j]).map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
                let off: Vec<f64> = column.iter().zip(&expected).map(|(c, e)| c - e).collect();
                assert!(
                    size(&off) < 0.01 * size(&expected) + 1e-3,
                    "{parameter} on {j}: {} of {}",
                    size(&off),
                    size(&expected)
                );
                let sum = counted[j].iter_mut().zip(column);
                sum.for_each(|(sum, c)| *sum += links[parameter] * c);
            }
        }
        for (counted, expected) in counted.iter().zip(sprung.counted()) {
            let off: Vec<f64> = counted.iter().zip(expected).map(|(c, e)| c - e).collect();
            assert!(size(&off) < 1e-6 * size(expected) + 1e-9, "{}", size(&off));
        }
    }

    /// A spring and the inertia of its link, both different from the model, are found together.
    #[test]
    fn spring_is_found_together_with_its_link() {
        const JOINT: usize = 0;
        const MOTOR_INERTIA: f64 = 0.2;
        let given = ur5();
        let mut true_arm = given.clone();
        let mut change = [0.0; TEN];
        // 1.5 kg more, near the wrist
        change[..4].copy_from_slice(&[1.5, 0.6, 0.0, 0.1]);
        change[TEN - 3..].copy_from_slice(&[0.25, 0.0, 0.25]);
        true_arm.joints[2].link = changed(&true_arm.joints[2].link, &change);

        let mut recorded = swung_for(2000, &true_arm, 0.1, |_, _| 0.0);
        let point = OperatingPoint::of(true_arm.joints.len());
        let moved = recorded.clone();
        let at = Posed::new(&true_arm, &RigidArm::from_chain(&true_arm), &moved, &point);
        let inertia = mean_inertia(std::slice::from_ref(&at), JOINT);
        let rate = std::f64::consts::TAU * 2.3;
        let (stiffness, damping) = (inertia * rate * rate, 0.06 * inertia * rate);
        let spring = FittedTransmission { gap: 0.0, stiffness, damping };
        for (effort, more) in recorded.effort.iter_mut().zip(spring.difference(&at, JOINT).unwrap())
        {
            effort.iter_mut().zip(more).for_each(|(e, m)| *e += m);
        }
        let accelerated = recorded.effort[JOINT].iter_mut().zip(&moved.acceleration[JOINT]);
        accelerated.for_each(|(e, a)| *e += MOTOR_INERTIA * a);

        let design = Design::new(&given, vec![recorded]);
        let (_, found) = select(&design).unwrap();
        let candidates = || found.estimate.set.iter().map(|g| &found.problem.candidates[*g]);
        let elastic = candidates().find(|g| g.slug() == "joint_elasticity").unwrap();
        assert_eq!(elastic.location.joints, [JOINT]);
        let off = elastic.shape[0] / stiffness - 1.0;
        assert!(off.abs() < 0.01, "{off}");
        let [size, motor_inertia] = found.estimate.fit.of_candidate(elastic)[..] else { panic!() };
        assert!(size == 1.0, "{size}");
        // a stiffness with a relative error leaves that share of the inertia behind it to the motor
        let off_kg_m2 = motor_inertia - MOTOR_INERTIA;
        assert!(off_kg_m2.abs() < 0.01 * inertia, "{off_kg_m2} of {inertia}");
    }
}
