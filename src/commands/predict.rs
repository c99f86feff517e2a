//! `armident predict`.

use armident_recording::{JointChannels, Recording};
use serde::Serialize;

use super::recordings;
use armident_model::Prediction;

use crate::args::PredictArgs;
use crate::failure::{Failure, Outcome};
use crate::output::counted;
use crate::progress::Progress;
use crate::{output, robot};

/// What was predicted, in short; the numbers are in the CSV.
#[derive(Serialize)]
struct PredictReport {
    schema: &'static str,
    robot: String,
    motion: String,
    samples: usize,
    joints: Vec<String>,
    cutoff_hz: Option<f64>,
    effects: Vec<armident_effects::EffectOnJoint>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

pub(crate) fn run(args: &PredictArgs) -> Result<Outcome, Failure> {
    output::protect(
        [args.robot.as_path(), args.motion.as_path()],
        [Some(&args.output_file), args.output.json.as_ref()],
    )?;
    let json_on_stdout = args.output.json.as_deref().is_some_and(output::is_stdout);
    if output::is_stdout(&args.output_file) && json_on_stdout {
        return Err(Failure::new(
            "prediction and JSON cannot both be written to stdout",
            "--output-file, --json",
            Some("write one of them to a file"),
        ));
    }
    let mut motions =
        recordings::read_all(std::slice::from_ref(&args.motion), &args.reading, &args.output)?;
    let recording = motions.remove(0);
    let recorded = recordings::joints_with_position(std::slice::from_ref(&recording));
    let model = robot::load(&args.robot, &args.chain, Some(&recorded))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let progress = Progress::of(&args.output, "predicting");
    // a diagnosed model has its own low-pass
    let cutoff_hz = match model.band {
        Some(_) => None,
        None => armident_motion::common_cutoff_hz(
            std::slice::from_ref(&recording),
            &model.chain.joint_names(),
            args.cutoff_hz.or(model.cutoff_hz),
        )?,
    };
    let Prediction { efforts, notes } = model.predict(&recording, cutoff_hz)?;
    let result = as_recording(&names, &recording, efforts)?;
    drop(progress);
    let bytes = recordings::encoded(&result, &args.output_file, &args.output)?;

    let warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    let report = PredictReport {
        schema: "armident.predict/1",
        robot: model.chain.robot.clone(),
        motion: recording.source.clone(),
        samples: result.len(),
        joints: names,
        cutoff_hz,
        effects: model.effects.clone(),
        notes,
        warnings: warnings.clone(),
    };
    let to_stdout = output::is_stdout(&args.output_file);
    let text = if to_stdout {
        output::write_stdout(&bytes)?;
        String::new()
    } else {
        output::write_file(&args.output_file, &bytes)?;
        format!(
            "wrote {} ({}, {})\n",
            args.output_file.display(),
            counted(report.joints.len(), "joint"),
            counted(report.samples, "sample")
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &text, &report, &warnings)
}

/// `t` and the effort of every joint at every stamp of a motion.
pub(crate) fn as_recording(
    joints: &[String],
    motion: &Recording,
    efforts: Vec<Vec<f64>>,
) -> Result<Recording, Failure> {
    let of_joint = |(name, effort): (&String, Vec<f64>)| JointChannels {
        effort: Some(effort),
        ..JointChannels::new(name)
    };
    let channels = joints.iter().zip(efforts).map(of_joint).collect();
    Ok(Recording::new("prediction", motion.time_s.clone(), channels)?)
}
