//! One recording at an operating point: what moves there, which efforts that takes, what each joint carries.

use std::sync::OnceLock;

use armident_dynamics::RigidArm;
use armident_effects::{Effect, JointMotion, LawRole, ReversalModel, WholeArmMotion, tilted};
use armident_kinematics::{DrivingAxisChain, InertialParameters};
use nalgebra::Vector3;

use crate::link_load::Load;
use crate::operating_point::OperatingPoint;
use crate::reversal::{SHARP, regularised_sign};
use armident_motion::{BandMotion, Standstill};

/// One recording at an operating point.
pub struct PosedRecording<'a> {
    /// The recording on its grid.
    pub signals: &'a BandMotion,
    /// The given arm at the tilt of the operating point.
    pub arm: RigidArm,
    /// True positions: low-passed, less the encoder offsets \[rad or m\].
    pub position: Vec<Vec<f64>>,
    /// Efforts of the given rigid body \[N m or N\].
    pub rigid: Vec<Vec<f64>>,
    /// of joints that rest somewhere: with their held acceleration
    answered: Vec<Option<Vec<f64>>>,
    /// rigid effort and what is known of the rest, where there is some
    with_known: Vec<Option<Vec<f64>>>,
    /// directions of joints whose friction does not follow the sign of the velocity
    turned: Vec<Option<Vec<f64>>>,
    /// lag of the efforts \[s\]
    pub delay_s: f64,
    /// of the effort channels
    gain: Vec<f64>,
    /// the arm with other links, where a hidden one is simulated or friction follows the load, and its efforts: formed
    /// when first asked for
    others: Option<(RigidArm, OnceLock<Vec<Vec<f64>>>)>,
    /// of each joint, formed when first asked for
    loads: Vec<OnceLock<Load>>,
    /// of joints that rest somewhere: with their held acceleration and the other links
    carried: Vec<OnceLock<Option<Vec<f64>>>>,
}

impl<'a> PosedRecording<'a> {
    /// The recording of an arm at an operating point.
    pub fn new(
        chain: &DrivingAxisChain,
        arm: &RigidArm,
        signals: &'a BandMotion,
        point: &OperatingPoint,
    ) -> Self {
        let mut arm = arm.clone();
        let tilt = Vector3::new(point.tilt[0], point.tilt[1], 0.0);
        arm.gravity_e0 = tilted(&chain.base_from_e0, &arm.gravity_e0, &tilt);
        let moved = |(q, offset): (&Vec<f64>, &f64)| q.iter().map(|q| q - offset).collect();
        let position: Vec<Vec<f64>> =
            signals.position.iter().zip(&point.offset).map(moved).collect();
        let loads = (0..arm.dof()).map(|_| OnceLock::new()).collect();
        let carried = (0..arm.dof()).map(|_| OnceLock::new()).collect();
        let others = point.links.as_ref().map(|changes| {
            let mut others = arm.clone();
            for (link, change) in others.links.iter_mut().zip(changes.chunks(10)) {
                *link = changed(link, change);
            }
            (others, OnceLock::new())
        });
        let delay_s = point.delay_s;
        let (answered, with_known) = (Vec::new(), Vec::new());
        let turned = |(j, reversal): (usize, &ReversalModel)| {
            (*reversal != SHARP).then(|| {
                let (sharp, velocity) = (&signals.direction[j], &signals.velocity[j]);
                let ReversalModel::RegularisedSign { below } = reversal else {
                    return reversal.directions(&position[j], velocity);
                };
                let mut direction = regularised_sign(sharp, velocity, *below);
                // where a joint rests, its friction is what holds it: no function of a speed
                for rest in signals.dwells_of(j) {
                    direction[rest.clone()].copy_from_slice(&sharp[rest]);
                }
                direction
            })
        };
        let turned = point.reversals.iter().enumerate().map(turned).collect();
        let mut at = Self {
            signals,
            arm,
            position,
            rigid: Vec::new(),
            answered,
            with_known,
            turned,
            delay_s,
            gain: point.gain.clone(),
            others,
            loads,
            carried,
        };
        at.rigid = at.motion().efforts(&at.arm);
        at.answered = (0..signals.standstills.len()).map(|j| at.of_own(j, true)).collect();
        let with_known = |(j, known_effort): (usize, &Vec<f64>)| {
            let any = known_effort.iter().any(|x| *x != 0.0);
            any.then(|| at.answered(j).iter().zip(known_effort).map(|(e, x)| e + x).collect())
        };
        at.with_known = signals.known_effort.iter().enumerate().map(with_known).collect();
        at
    }

    /// The motion of the arm as recorded.
    pub fn motion(&self) -> armident_dynamics::ArmMotion<'_> {
        let (v, a) = (&self.signals.velocity, &self.signals.acceleration);
        armident_dynamics::ArmMotion::new(&self.position, v, a)
    }

    /// The efforts as they were, without their lag; of a joint without a record, whose rows weigh nothing, those
    /// of the rigid arm.
    pub fn effort_or_rigid(&self) -> Vec<Vec<f64>> {
        let recorded = self.signals.effort_before(self.delay_s).into_iter().zip(&self.rigid);
        recorded.map(|(e, rigid)| if e.is_empty() { rigid.clone() } else { e }).collect()
    }

    /// Efforts on a joint as its channel records them.
    pub fn recorded(&self, j: usize, mut efforts: Vec<f64>) -> Vec<f64> {
        if self.gain[j] != 1.0 {
            efforts.iter_mut().for_each(|x| *x *= self.gain[j]);
        }
        efforts
    }

    /// The same of all joints.
    pub fn all_recorded(&self, efforts: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        efforts.into_iter().enumerate().map(|(j, e)| self.recorded(j, e)).collect()
    }

    /// Rigid effort on a joint that stops somewhere, with accelerations that jump there or are [held](BandMotion::accelerations_on);
    /// none on others.
    pub fn of_own(&self, j: usize, held: bool) -> Option<Vec<f64>> {
        self.of_own_on(&self.arm, j, held)
    }

    /// The same of an arm with other links.
    fn of_own_on(&self, arm: &RigidArm, j: usize, held: bool) -> Option<Vec<f64>> {
        let stops = self.signals.standstills[j].iter().any(Standstill::stops);
        let own = || {
            let accelerations = self.signals.accelerations_on(j, held);
            self.motion().with_accelerations(&accelerations).effort_on(arm, j)
        };
        stops.then(own)
    }

    /// The rigid effort that the drive of a joint answers.
    pub fn answered(&self, j: usize) -> &[f64] {
        self.answered[j].as_ref().unwrap_or(&self.rigid[j])
    }

    /// The arm that the answer makes of it where that matters for more than its own efforts, and these.
    pub fn of_other_links(&self) -> (&RigidArm, &[Vec<f64>]) {
        match &self.others {
            Some((arm, efforts)) => (arm, efforts.get_or_init(|| self.motion().efforts(arm))),
            None => (&self.arm, &self.rigid),
        }
    }

    /// What a joint has to move.
    pub fn load(&self, j: usize) -> &Load {
        self.loads[j].get_or_init(|| {
            let (position, velocity) = (&self.position[j], &self.signals.velocity[j]);
            Load::of(&self.motion(), self.of_other_links().0, j, position, velocity)
        })
    }

    /// The motion of a joint as laws take it.
    pub fn joint(&self, j: usize) -> JointMotion<'_> {
        JointMotion {
            kind: self.arm.joints[j].kind,
            time_s: &self.signals.time_s,
            position: &self.position[j],
            velocity: &self.signals.velocity[j],
            acceleration: &self.signals.actuator_acceleration[j],
            direction: self.turned[j].as_ref().unwrap_or(&self.signals.direction[j]),
            rigid_effort: self.answered(j),
            temperature_c: &self.signals.temperature_c[j],
        }
    }

    /// What a law sees of a joint: a gain of the channel sees all that is known of its effort, others the load of the
    /// rigid body with the links that the answer gives it.
    pub fn joint_seen_by(&self, law: &dyn Effect, j: usize) -> JointMotion<'_> {
        let seen = match law.law().roles.contains(&LawRole::Gain) {
            true => self.with_known[j].as_deref(),
            false => self.carried(j),
        };
        match seen {
            Some(rigid_effort) => JointMotion { rigid_effort, ..self.joint(j) },
            None => self.joint(j),
        }
    }

    /// The rigid effort that the drive of a joint answers with other links, where there are some.
    fn carried(&self, j: usize) -> Option<&[f64]> {
        self.others.as_ref()?;
        let (arm, efforts) = self.of_other_links();
        let own = self.carried[j].get_or_init(|| self.of_own_on(arm, j, true));
        Some(own.as_ref().unwrap_or(&efforts[j]))
    }

    /// The motion of the arm as laws of the whole arm take it.
    pub fn arm_motion<'b>(
        &'b self,
        chain: &DrivingAxisChain,
        effort: &'b [Vec<f64>],
    ) -> WholeArmMotion<'b> {
        WholeArmMotion {
            arm: &self.arm,
            base_from_e0: chain.base_from_e0,
            tip_in_last_m: chain.tip_in_e.translation.vector,
            rate_hz: self.signals.rate_hz,
            position: &self.position,
            velocity: &self.signals.velocity,
            acceleration: &self.signals.acceleration,
            rigid_effort: effort,
        }
    }

    /// Columns of a law on the whole arm as the channels record them: `[column][joint][sample]`.
    pub fn recorded_arm_columns(
        &self,
        law: &dyn Effect,
        j: usize,
        chain: &DrivingAxisChain,
    ) -> Vec<Vec<Vec<f64>>> {
        let mut columns = law.arm_columns(j, &self.arm_motion(chain, &self.rigid));
        clear_rounding(&mut columns);
        columns.into_iter().map(|column| self.all_recorded(column)).collect()
    }
}

/// Makes nothing of columns that are nothing but rounding beside the largest: what pushes a planar arm out of its plane.
fn clear_rounding(columns: &mut [Vec<Vec<f64>>]) {
    const ROUNDING: f64 = 1e-9;
    let most =
        |column: &Vec<Vec<f64>>| column.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let largest = columns.iter().map(most).fold(0.0, f64::max);
    for column in columns.iter_mut().filter(|column| most(column) < ROUNDING * largest) {
        column.iter_mut().for_each(|efforts| efforts.fill(0.0));
    }
}

/// Standard parameters of a link changed by `10` numbers.
pub fn changed(link: &InertialParameters, change: &[f64]) -> InertialParameters {
    let mut numbers = link.to_array();
    for (x, d) in numbers.iter_mut().zip(change) {
        *x += d;
    }
    InertialParameters::from_array(&numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What loads no joint of a planar arm but by rounding is none of its columns; small ones stay.
    #[test]
    fn columns_of_rounding_are_nothing() {
        let mut columns =
            vec![vec![vec![2e-17, 0.0]; 2], vec![vec![1e-6, 0.0]; 2], vec![vec![3.0, 1.0]; 2]];
        let others = columns[1..].to_vec();
        clear_rounding(&mut columns);
        assert!(columns[0].iter().flatten().all(|x| *x == 0.0));
        assert_eq!(columns[1..], others);
        let mut nothing = vec![vec![vec![0.0; 2]; 2]];
        clear_rounding(&mut nothing);
        assert_eq!(nothing, [vec![vec![0.0; 2]; 2]]);
    }
}
