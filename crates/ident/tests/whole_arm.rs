//! Faults of the arm as a whole are found as such, and no column is accused.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use armident_dynamics::inverse_dynamics_of_motion;
use armident_ident::checks::{Check, RecordingCheck, Topic, Verdict, check};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings, common_cutoff_hz};
use armident_recording::{JointChannels, Recording};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

const RATE_HZ: f64 = 50.0;
/// Viscous, Coulomb, rotor inertia of each joint, and the noise of its effort.
const JOINTS: [[f64; 4]; 3] = [[4.0, 3.0, 0.4, 0.3], [6.0, 4.0, 0.5, 0.4], [2.0, 1.5, 0.2, 0.2]];

/// The first three joints of a Puma 560, whose links are a tenth heavier than in its URDF.
struct Puma {
    model: ArmModel,
}

impl Puma {
    fn new() -> Self {
        let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../urdf/puma560.urdf");
        let robot = load_urdf(&file).unwrap();
        let recorded = ["joint_1", "joint_2", "joint_3"].map(ToOwned::to_owned).to_vec();
        let selection =
            ChainSelection { recorded_joints: Some(recorded), ..ChainSelection::default() };
        let chain = SerialChain::from_description(&robot, &selection).unwrap();
        Self { model: ArmModel::from_chain(DrivingAxisChain::from_chain(&chain)) }
    }

    /// Positions and efforts of 40 s of sines under a gravity \[m/s²\], by joints.
    fn moved(&self, gravity_base: Vector3<f64>, measured: bool) -> [Vec<Vec<f64>>; 2] {
        let mut arm = self.model.rigid_arm();
        arm.gravity_e0 = self.model.chain.base_from_e0.rotation.inverse() * gravity_base;
        for link in &mut arm.links {
            link.mass_kg *= 1.1;
            link.first_moment_kgm *= 1.1;
            link.inertia_origin_kgm2 *= 1.1;
        }
        let columns = |derivative: i32| -> Vec<Vec<f64>> {
            let at = |j: usize, t: f64| -> f64 {
                (1..4)
                    .map(|k| {
                        let w = TAU * (0.09 * f64::from(k) + 0.023 * j as f64);
                        let turn = 0.25 * TAU * f64::from(derivative);
                        let phase = w * t + 1.3 * j as f64 + f64::from(k * k) + turn;
                        0.8 / f64::from(k) * w.powi(derivative) * phase.sin()
                    })
                    .sum()
            };
            (0..3).map(|j| (0..2000).map(|k| at(j, f64::from(k) / RATE_HZ)).collect()).collect()
        };
        let (q, dq, ddq) = (columns(0), columns(1), columns(2));
        let mut effort = inverse_dynamics_of_motion(&arm, &q, &dq, &ddq);
        let mut random = Pcg64::seed_from_u64(7);
        for (j, [viscous, coulomb, rotor, noise]) in JOINTS.iter().enumerate() {
            let normal = Normal::new(0.0, *noise).unwrap();
            for (t, e) in effort[j].iter_mut().enumerate() {
                *e += rotor * ddq[j][t];
                if measured {
                    *e += viscous * dq[j][t] + coulomb * dq[j][t].signum();
                    *e += normal.sample(&mut random);
                }
            }
        }
        [q, effort]
    }

    fn checked(&self, [position, effort]: [Vec<Vec<f64>>; 2]) -> RecordingCheck {
        let names = self.model.chain.joint_names();
        let channels = (position.into_iter().zip(effort).zip(&names))
            .map(|((position, effort), name)| JointChannels {
                position: Some(position),
                effort: Some(effort),
                ..JointChannels::new(*name)
            })
            .collect();
        let time_s = (0..2000).map(|k| f64::from(k) / RATE_HZ).collect();
        let recordings = [Recording::new("run", time_s, channels).unwrap()];
        let cutoff_hz = common_cutoff_hz(&recordings, &names, None).unwrap();
        let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
        let motion = Motion::from_recording(&recordings[0], &names, &settings).unwrap();
        check(&self.model, &recordings, &[motion], &BTreeMap::new()).unwrap()
    }
}

fn wrong(found: &RecordingCheck) -> Vec<&Check> {
    found.checks.iter().filter(|c| c.verdict == Verdict::Wrong).collect()
}

const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

#[test]
fn right_columns_are_not_accused() {
    let puma = Puma::new();
    let found = puma.checked(puma.moved(DOWN, true));
    assert_eq!(wrong(&found), Vec::<&Check>::new());
    assert_eq!((found.gravity, found.mirrored), (None, vec![false; 3]));
}

#[test]
fn gravity_is_found_at_any_angle() {
    let puma = Puma::new();
    let tilted = Vector3::new(9.81 * 0.3, -9.81 * 0.4, -9.81 * 0.75_f64.sqrt());
    for (gravity, option) in [(-DOWN, Some("0,0,9.81")), (tilted, None)] {
        let found = puma.checked(puma.moved(gravity, true));
        let reported = wrong(&found);
        assert!(
            reported.len() == 1 && reported[0].topic == Topic::Gravity,
            "{gravity}: {:?}",
            found.checks
        );
        let direction = found.gravity.clone().unwrap();
        let off = Vector3::from(direction.gravity_base).angle(&gravity).to_degrees();
        assert!(off < direction.radius_95_deg && off < 0.4, "{direction:?}");
        if let Some(option) = option {
            assert_eq!(direction.option(), option);
        }
    }
}

#[test]
fn mirrored_joint_is_named_alone() {
    let puma = Puma::new();
    let mut moved = puma.moved(DOWN, true);
    moved.iter_mut().for_each(|of| of[1].iter_mut().for_each(|x| *x = -*x));
    let found = puma.checked(moved);
    let reported = wrong(&found);
    assert!(reported.len() == 1 && reported[0].topic == Topic::JointSign, "{reported:?}");
    assert_eq!(found.mirrored, [false, true, false]);
}

#[test]
fn exchanged_joints_are_named_alone() {
    let puma = Puma::new();
    let mut moved = puma.moved(DOWN, true);
    moved.iter_mut().for_each(|of| of.swap(0, 2));
    let found = puma.checked(moved);
    let reported = wrong(&found);
    assert!(reported.len() == 1 && reported[0].topic == Topic::Order, "{reported:?}");
    assert_eq!(found.recorded_as, [2, 1, 0]);
}

#[test]
fn columns_without_content_are_named() {
    let puma = Puma::new();
    let verdict = |found: &RecordingCheck, text: &str| {
        let reported = found.checks.iter().find(|c| c.message.contains(text));
        reported.map(|c| (c.verdict, c.joint.clone()))
    };
    let mut constant = puma.moved(DOWN, true);
    constant[1][2].fill(0.0);
    let found = puma.checked(constant);
    let reported = verdict(&found, "exactly 0 throughout");
    assert_eq!(reported, Some((Verdict::Wrong, Some("joint_3".to_owned()))));
    let mut magnitudes = puma.moved(DOWN, true);
    magnitudes[1].iter_mut().flatten().for_each(|x| *x = x.abs());
    let found = puma.checked(magnitudes);
    assert!(verdict(&found, "magnitude without sign").is_some());
    assert!(verdict(&found, "different motions").is_none());
    let computed = puma.checked(puma.moved(DOWN, false));
    assert_eq!(verdict(&computed, "computed by a model"), Some((Verdict::Doubtful, None)));
}
