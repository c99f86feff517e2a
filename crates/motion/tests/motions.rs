//! Motions made from recordings of known motions.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::f64::consts::PI;

use armident_motion::{DerivativeSource, Motion, MotionSettings};
use armident_recording::{JointChannels, Recording, RecordingError};

/// Position, velocity and acceleration of a motion of three sines up to 2.1 Hz.
fn exact(t: f64) -> [f64; 3] {
    [(0.9, 0.31, 0.2), (0.3, 1.1, 1.3), (0.08, 2.1, 2.2)].into_iter().fold(
        [0.2, 0.0, 0.0],
        |[x, v, a], (amplitude, frequency_hz, phase)| {
            let omega = 2.0 * PI * frequency_hz;
            let angle = omega * t + phase;
            [
                x + amplitude * angle.sin(),
                v + amplitude * omega * angle.cos(),
                a - amplitude * omega * omega * angle.sin(),
            ]
        },
    )
}

/// Uniform in -1..1, the same on every run.
fn random(k: usize) -> f64 {
    let x = (k as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

fn column(time_s: &[f64], derivative: usize) -> Vec<f64> {
    time_s.iter().map(|t| exact(*t)[derivative]).collect()
}

fn even(n: usize, rate_hz: f64) -> Vec<f64> {
    (0..n).map(|k| k as f64 / rate_hz).collect()
}

/// 250 Hz, 12 s, stamps jittered by a tenth of the step and rounded to 1e-5 s, bursts lost,
/// position in steps of 1e-5 rad.
fn field_recording() -> Recording {
    let lost = |k: usize| [200, 500, 501, 900].contains(&k) || (1300..1305).contains(&k);
    let stamps: Vec<f64> = (0..3000)
        .filter(|k| !lost(*k))
        .map(|k| ((k as f64 + 0.1 * 1.7 * random(k)) * 0.004 * 1e5).round() * 1e-5)
        .collect();
    let position = column(&stamps, 0).iter().map(|x| (x * 1e5).round() * 1e-5).collect();
    let effort = column(&stamps, 2).iter().map(|a| 2.0 * a).collect();
    let joint = JointChannels {
        position: Some(position),
        effort: Some(effort),
        ..JointChannels::new("elbow")
    };
    Recording::new("field.csv", stamps, vec![joint]).unwrap()
}

/// RMS difference over RMS, half a second left out at both ends.
fn relative_error(motion: &Motion, values: &[f64], derivative: usize) -> f64 {
    let margin = (0.5 * motion.rate_hz) as usize;
    let inner = margin..motion.len() - margin;
    let exact = column(&motion.time_s, derivative);
    let difference: f64 = inner.clone().map(|k| (values[k] - exact[k]).powi(2)).sum();
    let size: f64 = inner.map(|k| exact[k].powi(2)).sum();
    (difference / size).sqrt()
}

fn of(recording: &Recording, settings: &MotionSettings) -> Motion {
    Motion::from_recording(recording, &recording.joint_names(), settings).unwrap()
}

fn cutoff(cutoff_hz: f64) -> MotionSettings {
    MotionSettings { cutoff_hz: Some(cutoff_hz), ..MotionSettings::default() }
}

#[test]
fn derivatives_of_a_clean_motion() {
    let stamps = even(2000, 200.0);
    let joint = JointChannels { position: Some(column(&stamps, 0)), ..JointChannels::new("elbow") };
    let recording = Recording::new("clean.csv", stamps, vec![joint]).unwrap();
    let motion = of(&recording, &cutoff(20.0));
    for (values, derivative, tolerance) in
        [(&motion.position, 0, 1e-8), (&motion.velocity, 1, 1e-6), (&motion.acceleration, 2, 5e-6)]
    {
        let error = relative_error(&motion, &values[0], derivative);
        println!("derivative {derivative}: relative error {error:.1e}");
        assert!(error < tolerance, "derivative {derivative}: {error:e}");
    }
}

#[test]
fn a_jittered_and_lossy_recording_gives_its_smooth_motion() {
    let recording = field_recording();
    let motion = of(&recording, &MotionSettings::default());
    println!("{:?}", motion.notes);
    assert!((motion.rate_hz - 250.0).abs() < 1.0, "{}", motion.rate_hz);
    assert!(motion.notes[0].contains("2 gaps, longest 24."));
    for (values, derivative, tolerance) in
        [(&motion.position, 0, 1e-5), (&motion.velocity, 1, 1e-4), (&motion.acceleration, 2, 5e-4)]
    {
        let error = relative_error(&motion, &values[0], derivative);
        println!("derivative {derivative}: relative error {error:.1e}");
        assert!(error < tolerance, "derivative {derivative}: {error:e}");
    }
    let efforts = &motion.effort_filtered.as_ref().unwrap()[0];
    let halves: Vec<f64> = efforts.iter().map(|effort| 0.5 * effort).collect();
    assert!(relative_error(&motion, &halves, 2) < 1e-3);

    let back = motion.at_stamps(&motion.position[0]);
    assert_eq!(back.len(), recording.len());
    for (got, t) in back.iter().zip(&recording.time_s).skip(100).take(2700) {
        assert!((got - exact(*t)[0]).abs() < 2e-4, "{t}");
    }
}

fn exact_recording() -> Recording {
    let stamps = even(1000, 100.0);
    let joint = |name| JointChannels {
        position: Some(column(&stamps, 0)),
        velocity: Some(column(&stamps, 1)),
        acceleration: Some(column(&stamps, 2)),
        effort: Some(column(&stamps, 2)),
        ..JointChannels::new(name)
    };
    Recording::new("exact.csv", stamps.clone(), vec![joint("a"), joint("b")]).unwrap()
}

#[test]
fn recorded_accelerations_are_used_as_they_are() {
    let recording = exact_recording();
    let motion = of(&recording, &MotionSettings::default());
    let joint = &recording.joints[0];
    assert!(motion.filter.is_none());
    assert_eq!(Some(&motion.acceleration[0]), joint.acceleration.as_ref());
    assert_eq!(Some(&motion.position[1]), joint.position.as_ref());
    assert_eq!(motion.effort, motion.effort_filtered);
    assert_eq!(motion.independent_share(), 1.0);
    assert_eq!(motion.time_s, recording.time_s);
    assert_eq!(motion.at_stamps(&motion.velocity[0]), motion.velocity[0]);
    let mut columns = vec![vec![1.0, -1.0, 2.0]];
    motion.filter_columns(&mut columns);
    assert_eq!(columns, [[1.0, -1.0, 2.0]]);

    let filtered = of(&recording, &cutoff(10.0));
    let filter = filtered.filter.as_ref().unwrap();
    assert_eq!(filtered.acceleration[0], filter.filter(&motion.acceleration[0]));
    assert!(filtered.independent_share() < 0.2);

    let settings =
        MotionSettings { derivatives: DerivativeSource::FromPosition, ..MotionSettings::default() };
    let derived = of(&recording, &settings);
    assert!(derived.notes[0].starts_with("low-pass cut-off "));
    assert!(derived.notes[0].ends_with(" Hz (from the motion's spectrum)"));
    assert_ne!(derived.acceleration, motion.acceleration);
    assert!(relative_error(&derived, &derived.acceleration[0], 2) < 1e-3);
}

#[test]
fn effort_and_columns_pass_the_same_filter() {
    let recording = field_recording();
    let motion = of(&recording, &cutoff(12.0));
    let raw = motion.effort.clone().unwrap();
    let mut columns = raw.clone();
    motion.filter_columns(&mut columns);
    assert_eq!(Some(&columns), motion.effort_filtered.as_ref());
    assert_ne!(columns, raw);
    let effort = recording.joints[0].effort.as_ref().unwrap();
    assert_eq!(motion.on_grid(effort), raw[0]);
}

#[test]
fn joints_come_in_the_order_asked_for() {
    let motion =
        Motion::from_recording(&exact_recording(), &["b", "a"], &MotionSettings::default())
            .unwrap();
    assert_eq!(motion.joints, ["b", "a"]);
    assert_eq!(motion.position.len(), 2);
}

fn told(error: &RecordingError) -> [String; 3] {
    [error.to_string(), error.place(), error.hint().unwrap_or_default()]
}

#[test]
fn what_is_missing_is_named() {
    let mut recording = exact_recording();
    recording.joints[0].name = "shoulder_lift_joint".into();
    recording.joints[1].name = "elbow_joint".into();
    recording.joints[1].position = None;
    recording.joints[1].acceleration = None;
    let refused = |joints: &[&str], settings: &MotionSettings| {
        told(&Motion::from_recording(&recording, joints, settings).unwrap_err())
    };
    let settings = MotionSettings::default();
    assert_eq!(
        refused(&["Elbow_Join"], &settings),
        [
            "no data for joint `Elbow_Join`",
            "exact.csv",
            "did you mean `elbow_joint`? recorded joints: `shoulder_lift_joint`, `elbow_joint`",
        ]
    );
    assert_eq!(
        refused(&["gripper"], &settings)[2],
        "recorded joints: `shoulder_lift_joint`, `elbow_joint`"
    );
    assert_eq!(
        refused(&["elbow_joint"], &settings),
        [
            "no position column for joint `elbow_joint`",
            "exact.csv",
            "add a column `elbow_joint/position`; recorded: `elbow_joint/velocity`, \
             `elbow_joint/effort`",
        ]
    );
    assert_eq!(refused(&[], &settings)[0], "no joint selected");
    assert_eq!(
        refused(&["shoulder_lift_joint"], &cutoff(70.0)),
        [
            "cut-off 70 Hz is out of range at 100 samples per second",
            "exact.csv",
            "choose a cut-off from 0.01 Hz to below 49 Hz",
        ]
    );

    let recorded = MotionSettings { derivatives: DerivativeSource::Recorded, ..settings.clone() };
    recording.joints[1].position = recording.joints[0].position.clone();
    let error = Motion::from_recording(&recording, &["elbow_joint"], &recorded).unwrap_err();
    assert_eq!(error.to_string(), "no acceleration column for joint `elbow_joint`");

    recording.joints[1].effort = None;
    let motion = of(&recording, &settings);
    assert!(motion.effort.is_none() && motion.effort_filtered.is_none());
    let note = "efforts ignored: none recorded for elbow_joint";
    assert!(motion.notes.iter().any(|line| line == note), "{:?}", motion.notes);

    recording.time_s[5] = recording.time_s[4];
    let error = Motion::from_recording(&recording, &["elbow_joint"], &settings).unwrap_err();
    assert!(error.to_string().starts_with("time stamps decrease"));
}

#[test]
fn the_shortest_recording() {
    let stamps = even(8, 100.0);
    let joint = JointChannels { position: Some(column(&stamps, 0)), ..JointChannels::new("elbow") };
    let recording = Recording::new("short.csv", stamps, vec![joint]).unwrap();
    let motion = of(&recording, &MotionSettings::default());
    assert_eq!(motion.acceleration[0].len(), 8);
    assert!(motion.acceleration[0].iter().all(|a| a.is_finite()));
}
