//! A UR5 of which everything is known, and its motion.

use std::f64::consts::TAU;
use std::path::PathBuf;

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};

pub(crate) struct Bench {
    pub(crate) model: ArmModel,
    pub(crate) arm: RigidArm,
    pub(crate) set: MinimalSet,
}

/// Position, velocity and acceleration, joint-major.
pub(crate) struct Sines {
    pub(crate) time_s: Vec<f64>,
    pub(crate) q: Vec<Vec<f64>>,
    pub(crate) dq: Vec<Vec<f64>>,
    pub(crate) ddq: Vec<Vec<f64>>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../urdf/ur5.urdf");
        let robot = load_urdf(&file).unwrap();
        let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
        let arm = model.rigid_arm();
        let set = MinimalSet::of(&arm).unwrap();
        Self { model, arm, set }
    }

    /// A motion with the efforts it was driven by, as a recording at 100 Hz gives it.
    pub(crate) fn recorded(&self, name: &str, sines: &Sines, effort: &[Vec<f64>]) -> Motion {
        let names = self.model.chain.joint_names();
        let channels = (0..6)
            .map(|j| JointChannels {
                position: Some(sines.q[j].clone()),
                velocity: Some(sines.dq[j].clone()),
                acceleration: Some(sines.ddq[j].clone()),
                effort: Some(effort[j].clone()),
                ..JointChannels::new(names[j])
            })
            .collect();
        let recording = Recording::new(name, sines.time_s.clone(), channels).unwrap();
        Motion::from_recording(&recording, &names, &MotionSettings::default()).unwrap()
    }
}

impl Sines {
    /// Sums of three sines a joint with exact derivatives at 100 Hz; `shift` makes another motion.
    pub(crate) fn new(samples: u32, shift: f64) -> Self {
        let time_s: Vec<f64> = (0..samples).map(|k| 0.01 * f64::from(k)).collect();
        let columns = |derivative: i32| -> Vec<Vec<f64>> {
            let joint = |j: usize| -> Vec<f64> {
                let at = |t: &f64| -> f64 {
                    (1..4)
                        .map(|k| {
                            let w = TAU * (0.11 * f64::from(k) + 0.017 * j as f64);
                            let turn = 0.25 * TAU * f64::from(derivative);
                            let phase = w * t + (1.3 + shift) * j as f64 + f64::from(k * k) + turn;
                            0.9 / f64::from(k) * w.powi(derivative) * phase.sin()
                        })
                        .sum()
                };
                time_s.iter().map(at).collect()
            };
            (0..6).map(joint).collect()
        };
        let (q, dq, ddq) = (columns(0), columns(1), columns(2));
        Self { time_s, q, dq, ddq }
    }
}
