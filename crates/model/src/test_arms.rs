//! A UR5 that swings, for tests.

use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_motion::{BAND_HZ, BandMotion};
use armident_recording::{JointChannels, Recording};

pub(crate) fn ur5() -> DrivingAxisChain {
    let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf").unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

/// The motion of an arm that swings for 30 s at 200 Hz, without efforts.
pub(crate) fn swinging(arm: &DrivingAxisChain) -> BandMotion {
    let names: Vec<String> = arm.joints.iter().map(|j| j.name.clone()).collect();
    let time: Vec<f64> = (0..6000).map(|k| f64::from(k) / 200.0).collect();
    let joints = names.iter().enumerate().map(|(j, name)| {
        let swing = |t: &f64| 0.6 * ((1.0 + 0.4 * j as f64) * t).sin() - 0.2 * j as f64;
        let position = Some(time.iter().map(swing).collect());
        JointChannels { position, ..JointChannels::new(name) }
    });
    let recording = Recording::new("made", time.clone(), joints.collect()).unwrap();
    BandMotion::below(&recording, &names, BAND_HZ).unwrap()
}
