//! `armident demo`.

use std::collections::BTreeMap;
use std::path::Path;

use armident_effects::{CoulombFriction, Effect, EffectOnJoint, Payload, TorqueRipple};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording, encode, read_csv_from};
use armident_simulation::{EffortNoise, Sensors, SimulatedArm, Trajectory, inverse};
use clap::Parser;

use crate::args::{Cli, Command, DemoArgs};
use crate::failure::Outcome;
use crate::output;
use armident_commands::Failure;

const URDF: &str = include_str!("../../urdf/ur5.urdf");
/// Motions to repeat; only the positions of the bundled recordings are used.
const MOTIONS: [(&str, &str); 2] = [
    ("train.csv", include_str!("../../examples/ur5/train.csv")),
    ("holdout.csv", include_str!("../../examples/ur5/holdout.csv")),
];
/// Effects missing from the URDF: effect, joint, parameters.
const HIDDEN: [(&dyn Effect, &str, &[f64]); 3] = [
    (&Payload, "", &[0.8, 0.0, 0.0, 0.06]),
    (&CoulombFriction, "elbow_joint", &[3.3]),
    (&TorqueRipple, "shoulder_pan_joint", &[1.5, 16.0, 0.4, 0.0, 0.0]),
];
/// Noise of the efforts from base to tip \[N m\].
const EFFORT_NOISE: [f64; 6] = [0.1, 0.1, 0.06, 0.02, 0.02, 0.02];

pub(crate) fn run(args: &DemoArgs) -> Result<Outcome, Failure> {
    let folder = &args.output_folder;
    if !is_free(folder) {
        return Err(Failure::new(
            "the folder contains other files",
            folder.display(),
            Some("choose a new folder: armident demo -o FOLDER"),
        ));
    }
    output::create_folder(folder)?;
    output::write_file(&folder.join("ur5.urdf"), URDF.as_bytes())?;
    let robot = parse_urdf(URDF, "ur5.urdf")?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let chain = DrivingAxisChain::from_chain(&chain);
    let effects: Vec<EffectOnJoint> = HIDDEN
        .iter()
        .map(|(effect, joint, parameters)| EffectOnJoint::new(effect.slug(), *joint, *parameters))
        .collect();
    let arm = SimulatedArm::on_chain(&chain, &effects)?;
    let noise: BTreeMap<String, f64> = chain
        .joint_names()
        .iter()
        .zip(EFFORT_NOISE)
        .map(|(joint, noise)| (joint.to_string(), noise))
        .collect();
    for (k, (file, text)) in MOTIONS.iter().enumerate() {
        let sensors = Sensors {
            effort_noise: Some(EffortNoise::Absolute(noise.clone())),
            encoder_bits: Some(19),
            seed: args.seed.wrapping_mul(1_000_003).wrapping_add(k as u64),
        };
        let exact = inverse(&arm, &motion(&chain, text, file)?)?;
        let recording = logged(sensors.apply(&arm, &exact)?);
        let path = folder.join(file);
        output::write_file(&path, &encode(&recording, &path)?.bytes)?;
    }
    let path = |file: &str| folder.join(file).display().to_string();
    let report = path("report.html");
    let command = [
        "armident".to_owned(),
        "diagnose".to_owned(),
        path("ur5.urdf"),
        path("train.csv"),
        "--holdout".to_owned(),
        path("holdout.csv"),
        "--save-model".to_owned(),
        path("model.json"),
        "--report".to_owned(),
        report.clone(),
    ];
    let hidden: Vec<String> = effects.iter().map(said).collect();
    say(&format!(
        "Simulated UR5 with effects missing from its URDF: {}.\n\n$ {}\n",
        hidden.join(", "),
        command.join(" ")
    ))?;
    let Ok(Cli { command: Command::Diagnose(mut diagnose) }) = Cli::try_parse_from(&command) else {
        return Err(Failure::new(
            "the folder name cannot be used in a command",
            folder.display(),
            None::<String>,
        ));
    };
    diagnose.page.command = Some(command.to_vec());
    let outcome = super::diagnose::run(&diagnose)?;
    say(&format!(
        "\n(A payload and an inertia error of the last link are physically equivalent.)\n\nOpen the report {report} in a browser. Use the model next to it:\n\n$ armident predict {} {} -o {}\n",
        path("model.json"),
        path("holdout.csv"),
        path("predicted.csv")
    ))?;
    Ok(outcome)
}

fn say(text: &str) -> Result<(), Failure> {
    output::write_stdout(text.as_bytes())
}

/// Low-passed motion of a recording, used as a trajectory.
fn motion(chain: &DrivingAxisChain, text: &str, source: &str) -> Result<Trajectory, Failure> {
    let recording = read_csv_from(text.as_bytes(), source)?;
    let joints = chain.joint_names();
    let smooth = Motion::from_recording(&recording, &joints, &MotionSettings::default())?;
    let column = |columns: &[Vec<f64>], j: usize| Some(columns[j].clone());
    let channels = joints
        .iter()
        .enumerate()
        .map(|(j, name)| JointChannels {
            position: column(&smooth.position, j),
            velocity: column(&smooth.velocity, j),
            acceleration: column(&smooth.acceleration, j),
            ..JointChannels::new(*name)
        })
        .collect();
    let planned = Recording::new(source, smooth.time_s, channels)?;
    let names: Vec<String> = joints.iter().map(ToString::to_string).collect();
    Ok(Trajectory::from_recording(&planned, &names, &BTreeMap::new())?)
}

/// Only positions and efforts, as a robot logs them.
fn logged(mut recording: Recording) -> Recording {
    for joint in &mut recording.joints {
        joint.velocity = None;
        joint.acceleration = None;
    }
    recording
}

/// Label, location and size of an effect.
fn said(on_joint: &EffectOnJoint) -> String {
    let title = armident_effects::effect(&on_joint.effect).map_or("", |e| e.law().title);
    let size = on_joint.parameters.first().copied().unwrap_or_default();
    let unit = armident_effects::effect(&on_joint.effect)
        .and_then(|e| e.law().parameters.first())
        .map_or("", |p| p.unit_rotational);
    let place =
        if on_joint.joint.is_empty() { String::new() } else { format!(" on {}", on_joint.joint) };
    format!("{title}{place} ({size} {unit})")
}

/// Whether the demo may write to a folder: new, empty, or from an earlier demo.
fn is_free(folder: &Path) -> bool {
    let Ok(mut entries) = folder.read_dir() else { return true };
    entries.next().is_none() || folder.join("report.html").exists()
}
