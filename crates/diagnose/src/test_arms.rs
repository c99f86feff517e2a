//! A UR5 that swings, for tests.

use armident_dynamics::RigidArm;
use armident_effects::effect;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_recording::{JointChannels, Recording};

use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use armident_model::{OperatingPoint, PosedRecording};
use armident_motion::{BAND_HZ, BandMotion};

pub(crate) fn ur5() -> DrivingAxisChain {
    let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf").unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

/// What a believed arm has to say of another one that swings: its rigid efforts, noise, and what is added on each joint
/// as a function of its velocity.
pub(crate) fn design<'a>(
    believed: &'a DrivingAxisChain,
    other: &DrivingAxisChain,
    added: impl Fn(usize, f64) -> f64,
) -> Design<'a> {
    Design::new(believed, vec![swung(other, 0.1, |j, v| added(j, v[j]))])
}

/// An arm that swings for 30 s at 200 Hz: its rigid efforts, noise of so much \[N m\] from end to end, and what is added
/// on each joint as a function of all velocities.
pub(crate) fn swung(
    arm: &DrivingAxisChain,
    noise_nm: f64,
    added: impl Fn(usize, &[f64]) -> f64,
) -> BandMotion {
    swung_for(6000, arm, noise_nm, added)
}

/// The same for so many samples.
pub(crate) fn swung_for(
    samples: u32,
    arm: &DrivingAxisChain,
    noise_nm: f64,
    added: impl Fn(usize, &[f64]) -> f64,
) -> BandMotion {
    let names: Vec<String> = arm.joints.iter().map(|j| j.name.clone()).collect();
    let time: Vec<f64> = (0..samples).map(|k| f64::from(k) / 200.0).collect();
    let recording = |efforts: Option<&Vec<Vec<f64>>>| {
        let joints = names.iter().enumerate().map(|(j, name)| {
            let swing = |t: &f64| 0.6 * ((1.0 + 0.4 * j as f64) * t).sin() - 0.2 * j as f64;
            JointChannels {
                position: Some(time.iter().map(swing).collect()),
                effort: efforts.map(|efforts| efforts[j].clone()),
                ..JointChannels::new(name)
            }
        });
        Recording::new("made", time.clone(), joints.collect()).unwrap()
    };
    let moved = BandMotion::below(&recording(None), &names, BAND_HZ).unwrap();
    let point = OperatingPoint::of(names.len());
    let mut efforts = PosedRecording::new(arm, &RigidArm::from_chain(arm), &moved, &point).rigid;
    for t in 0..time.len() {
        let velocity: Vec<f64> = moved.velocity.iter().map(|v| v[t]).collect();
        for (j, effort) in efforts.iter_mut().enumerate() {
            let noise = ((t * 7919 + j * 104_729) % 1009) as f64 / 1009.0 - 0.5;
            effort[t] += noise_nm * noise + added(j, &velocity);
        }
    }
    BandMotion::below(&recording(Some(&efforts)), &names, BAND_HZ).unwrap()
}

/// Joint of [`rubbing`] with friction.
pub(crate) const RUBBING_JOINT: usize = 1;
/// Static and sliding level \[N m\] and speed \[rad/s\].
pub(crate) const STRIBECK: [f64; 3] = [9.0, 4.0, 0.15];

/// An arm with Stribeck friction on a joint, beside viscous friction \[N m s/rad\].
pub(crate) fn rubbing(chain: &DrivingAxisChain, viscous: f64) -> Design<'_> {
    let [highest, sliding, speed] = STRIBECK;
    design(chain, chain, |j, v| match j {
        RUBBING_JOINT => {
            let more = (highest - sliding) * (-(v / speed).powi(2)).exp();
            v.signum() * (sliding + more) + viscous * v
        }
        _ => 0.0,
    })
}

/// Stribeck friction on that joint, falling at this speed \[rad/s\].
pub(crate) fn stribeck(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    speed: f64,
) -> usize {
    let law = effect("stribeck_friction").unwrap();
    design.push_joint_law(problem, at, law, RUBBING_JOINT, &[speed]).unwrap()
}
