//! `armident simulate`.

use std::path::{Path, PathBuf};

use armident_recording::Recording;
use armident_simulation::{
    ArmState, EffortNoise, ForwardSettings, Sensors, SimulatedArm, Trajectory, forward, inverse,
};
use serde::Serialize;

use super::plan::PLAN_FILE;
use super::recordings;
use crate::args::{Direction, Noise, SimulateArgs};
use crate::failure::{Failure, Outcome};
use crate::output::counted;
use crate::progress::Progress;
use crate::{output, robot};

/// What was simulated, in short; the numbers are in the CSVs.
#[derive(Serialize)]
struct SimulateReport {
    schema: &'static str,
    robot: String,
    direction: &'static str,
    effects: Vec<armident_effects::EffectOnJoint>,
    seed: u64,
    recordings: Vec<Written>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Written {
    trajectory: String,
    recording: String,
    samples: usize,
}

pub(crate) fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    let plan = match &args.trajectories[..] {
        [folder] => recordings::plan_in(folder),
        _ => None,
    };
    let files = recordings::expand(&args.trajectories)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref()])?;
    let trajectories: Vec<Recording> = recordings::read_all(&files, &args.reading, &args.output)?;
    let recorded = match args.direction {
        Direction::Inverse => recordings::joints_with_position(&trajectories),
        Direction::Forward => trajectories
            .first()
            .map(|r| r.joint_names().into_iter().map(ToOwned::to_owned).collect())
            .unwrap_or_default(),
    };
    let (model, lost) = robot::load(&args.robot, &args.chain, Some(&recorded))?.simulated();
    let lost: Vec<String> = lost.iter().map(|what| format!("not simulated: {what}")).collect();
    output::say_all(&args.output, "note", &lost);
    let joints: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let mut effects = model.effects.clone();
    effects.extend(args.effect.iter().cloned());
    let arm = SimulatedArm::on_chain(&model.chain, &effects)?;

    let one_file = files.len() == 1 && plan.is_none() && !args.output_path.is_dir();
    if !one_file {
        output::create_folder(&args.output_path)?;
    }
    let mut written = Vec::new();
    let mut notes = Vec::new();
    let progress = Progress::through(&args.output, "simulating", files.len());
    for (k, (file, trajectory)) in files.iter().zip(&trajectories).enumerate() {
        let exact = match args.direction {
            Direction::Inverse => {
                let mut motion = Trajectory::from_recording(
                    trajectory,
                    &joints,
                    &std::collections::BTreeMap::new(),
                )?;
                if let Some(rate_hz) = args.rate_hz {
                    motion = motion.resampled(rate_hz)?;
                }
                notes.extend(motion.notes.iter().map(|n| format!("{}: {n}", file.display())));
                inverse(&arm, &motion)?
            }
            Direction::Forward => {
                let settings =
                    ForwardSettings { rate_hz: args.rate_hz, ..ForwardSettings::default() };
                forward(&arm, trajectory, start_state(trajectory, &joints), &settings)?
            }
        };
        let sensors = Sensors {
            effort_noise: args.torque_noise.map(|noise| match noise {
                Noise::Relative(share) => EffortNoise::Relative(share),
                Noise::Absolute(sigma) => {
                    EffortNoise::Absolute(joints.iter().map(|name| (name.clone(), sigma)).collect())
                }
            }),
            encoder_bits: args.encoder_bits,
            // every file its own noise, the same for the same command line
            seed: args.seed.wrapping_mul(1_000_003).wrapping_add(k as u64),
        };
        let recording = sensors.apply(&arm, &exact)?;
        let path =
            if one_file { args.output_path.clone() } else { target(&args.output_path, file) };
        if output::same_file(&path, file) {
            return Err(Failure::new(
                "the output would overwrite its input trajectory",
                path.display(),
                Some("write to another folder"),
            ));
        }
        let bytes = recordings::encoded(&recording, &path, &args.output)?;
        output::write_file(&path, &bytes)?;
        written.push(Written {
            trajectory: file.display().to_string(),
            recording: path.display().to_string(),
            samples: recording.len(),
        });
        progress.part_done();
    }
    drop(progress);
    if let Some(plan) = plan {
        let bytes = std::fs::read(&plan).map_err(|error| {
            Failure::new(format!("cannot read: {error}"), plan.display(), None::<String>)
        })?;
        output::write_file(&args.output_path.join(PLAN_FILE), &bytes)?;
    }
    let report = SimulateReport {
        schema: "armident.simulate/1",
        robot: model.chain.robot.clone(),
        direction: if args.direction == Direction::Inverse { "inverse" } else { "forward" },
        effects,
        seed: args.seed,
        recordings: written,
        notes,
        warnings: model.chain.warnings.iter().map(ToString::to_string).collect(),
    };
    let samples: usize = report.recordings.iter().map(|w| w.samples).sum();
    let text = format!(
        "wrote {} ({}, {})\n",
        args.output_path.display(),
        counted(report.recordings.len(), "recording"),
        counted(samples, "sample")
    );
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &text, &report, &report.warnings)
}

/// The recorded state at the first sample; at rest at zero where nothing is recorded.
fn start_state(recording: &Recording, joints: &[String]) -> ArmState {
    let first = |pick: fn(&armident_recording::JointChannels) -> &Option<Vec<f64>>| {
        joints
            .iter()
            .map(|name| {
                recording
                    .joint(name)
                    .and_then(|j| pick(j).as_ref())
                    .and_then(|column| column.first().copied())
                    .unwrap_or(0.0)
            })
            .collect()
    };
    ArmState { position: first(|j| &j.position), velocity: first(|j| &j.velocity) }
}

fn target(folder: &Path, trajectory: &Path) -> PathBuf {
    folder.join(trajectory.file_name().unwrap_or(trajectory.as_os_str()))
}
