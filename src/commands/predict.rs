//! `armident predict`.

use armident_diagnose::DiagnosedModel;
use armident_ident::ArmModel;
use armident_recording::{JointChannels, Motion, MotionSettings, Recording};
use serde::Serialize;

use super::recordings;
use crate::args::PredictArgs;
use crate::failure::{Failure, Outcome};
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
            "the prediction and the JSON cannot both go to stdout",
            "--output-file, --json",
            Some("write one of them to a file"),
        ));
    }
    let mut motions =
        recordings::read_all(std::slice::from_ref(&args.motion), &args.reading, &args.output)?;
    let recording = motions.remove(0);
    let recorded = recordings::joints_with_position(std::slice::from_ref(&recording));
    let (model, learned) = robot::load_whole(&args.robot, &args.chain, Some(&recorded))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let progress = Progress::of(&args.output, "predicting");
    let (result, cutoff_hz, notes) = match learned {
        Some(learned) => {
            let diagnosed = DiagnosedModel { arm: model.clone(), learned };
            let efforts = diagnosed.predict(&recording)?;
            let channels = names
                .iter()
                .zip(efforts)
                .map(|(name, effort)| JointChannels {
                    effort: Some(effort),
                    ..JointChannels::new(name)
                })
                .collect();
            let result = Recording::new("prediction", recording.time_s.clone(), channels)?;
            (result, None, recording.notes.clone())
        }
        None => {
            let cutoff_hz = armident_recording::common_cutoff_hz(
                std::slice::from_ref(&recording),
                &joints,
                args.cutoff_hz.or(model.cutoff_hz),
            )?;
            let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
            let motion = model
                .motion_of(Motion::from_recording(&recording, &joints, &settings)?, &recording);
            (predicted_efforts(&model, &motion)?, cutoff_hz, motion.notes)
        }
    };
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
            "{}: effort of {} joints at {} samples, written to {}\n",
            report.robot,
            report.joints.len(),
            report.samples,
            args.output_file.display()
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &text, &report, &warnings)
}

/// `t` and the effort of every joint at every stamp of the motion.
pub(crate) fn predicted_efforts(model: &ArmModel, motion: &Motion) -> Result<Recording, Failure> {
    let predicted = model.predict(motion)?;
    let channels = motion
        .joints
        .iter()
        .zip(&predicted)
        .map(|(name, effort)| JointChannels {
            effort: Some(motion.at_stamps(effort)),
            ..JointChannels::new(name)
        })
        .collect();
    Ok(Recording::new("prediction", motion.stamps_s.clone(), channels)?)
}
