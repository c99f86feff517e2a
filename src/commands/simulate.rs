//! `armident simulate`.

use std::path::{Path, PathBuf};

use armident_commands::{
    Failure, PLAN_FILE, SimulateOptions, SimulatedDirection, Simulator, expand, plan_in,
};
use armident_recording::Recording;
use serde::Serialize;

use super::recordings;
use crate::args::{Direction, SimulateArgs};
use crate::failure::Outcome;
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
        [folder] => plan_in(folder),
        _ => None,
    };
    let files = expand(&args.trajectories)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref()])?;
    let trajectories: Vec<Recording> = recordings::read_all(&files, &args.reading, &args.output)?;
    let robot = robot::open(&args.robot, &args.chain)?;
    let options = SimulateOptions {
        direction: match args.direction {
            Direction::Inverse => SimulatedDirection::Inverse,
            Direction::Forward => SimulatedDirection::Forward,
        },
        effort_noise: args.torque_noise,
        encoder_bits: args.encoder_bits,
        rate_hz: args.rate_hz,
        effects: args.effect.clone(),
        seed: args.seed,
    };
    let simulator = Simulator::new(&robot, &trajectories, options)?;
    output::say_all(&args.output, "note", &simulator.notes);

    let one_file = files.len() == 1 && plan.is_none() && !args.output_path.is_dir();
    if !one_file {
        output::create_folder(&args.output_path)?;
    }
    let mut written = Vec::new();
    let mut notes = Vec::new();
    let progress = Progress::through(&args.output, "simulating", files.len());
    for (k, (file, trajectory)) in files.iter().zip(&trajectories).enumerate() {
        let (recording, said) = simulator.record(trajectory, k)?;
        notes.extend(said);
        let path =
            if one_file { args.output_path.clone() } else { target(&args.output_path, file) };
        if armident_commands::same_file(&path, file) {
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
        robot: simulator.robot,
        direction: if args.direction == Direction::Inverse { "inverse" } else { "forward" },
        effects: simulator.effects,
        seed: args.seed,
        recordings: written,
        notes,
        warnings: simulator.warnings,
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

fn target(folder: &Path, trajectory: &Path) -> PathBuf {
    folder.join(trajectory.file_name().unwrap_or(trajectory.as_os_str()))
}
