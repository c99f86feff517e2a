//! The commands, as functions of robots and recordings.

use std::path::{Path, PathBuf};

use armident_commands::{
    self as run, DiagnoseOptions, DiagnoseRecordings, ExciteOptions, ExportFormat, Failure,
    FalseAlarms, FleetOptions, GivenRobot, IdentifyOptions, MotionFormat, PayloadOn,
    PlannedRecordings, ReadingOptions, Reduction, SimulateOptions, SimulatedDirection, Simulator,
};
use armident_effects::EffectOnJoint;
use armident_excitation::{Part, SuiteSettings};
use armident_ident::StructureSearch;
use armident_ident::estimators;
use armident_recording::Recording as Recorded;
use pyo3::prelude::*;

use crate::answer::{Answer, Found};
use crate::error::wrong;
use crate::recording::{Recording, recorded};
use crate::robot::Robot;
use crate::work::done;

/// Sources of a result, which are files or descriptions.
fn sources(given: &GivenRobot, recordings: &[&[Recorded]]) -> Vec<PathBuf> {
    let recordings = recordings.iter().copied().flatten().map(|r| r.source.as_str());
    std::iter::once(given.source.as_str()).chain(recordings).map(PathBuf::from).collect()
}

/// JSON schemas of the results, as pairs of a result's `schema` and its JSON.
#[pyfunction]
pub(crate) fn schemas() -> Vec<(&'static str, String)> {
    let text = |(name, schema): (&'static str, _)| {
        (name, serde_json::to_string(&schema).unwrap_or_default())
    };
    armident_report::schemas().into_iter().map(text).collect()
}

/// Minimal set of an arm.
#[pyfunction]
pub(crate) fn params(py: Python<'_>, robot: &Robot) -> PyResult<Answer> {
    let given = robot.given.clone();
    let files = sources(&given, &[]);
    let (report, notes) = done(py, move || run::params(&given))?;
    Ok(Answer::new(Found::Params(Box::new(report)), "params", files).with_notes(notes))
}

/// Checks of recordings.
#[pyfunction]
pub(crate) fn check(
    py: Python<'_>,
    robot: &Robot,
    recordings: Vec<PyRef<'_, Recording>>,
    cutoff_hz: Option<f64>,
) -> PyResult<Answer> {
    let (given, recordings) = (robot.given.clone(), recorded(&recordings));
    let files = sources(&given, &[&recordings]);
    let found = done(py, move || run::check(&given, &recordings, cutoff_hz))?;
    Ok(Answer::new(Found::Checked(Box::new(found)), "check", files))
}

/// Parameters of an arm from ordinary motion, or from a folder with a plan.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    robot: &Robot,
    recordings: Vec<PyRef<'_, Recording>>,
    holdout: Vec<PyRef<'_, Recording>>,
    plan: Option<PathBuf>,
    cutoff_hz: Option<f64>,
    method: &str,
    cross_validate: bool,
    prior: bool,
    payloads: Vec<(PathBuf, f64, Option<[f64; 3]>, f64)>,
    couplings: bool,
    sublinear: bool,
    raw_estimate: bool,
) -> PyResult<Answer> {
    let Some(estimator) = estimators::by_name(method) else {
        let known = estimators::ALL.map(|estimator| estimator.name()).join(", ");
        let hint = format!("pass one of {known}");
        return Err(wrong(py, format!("unknown estimator `{method}`"), "method", &hint));
    };
    let payload =
        |(file, mass_kg, com_m, com_error_m)| PayloadOn { file, mass_kg, com_m, com_error_m };
    let options = IdentifyOptions {
        cutoff_hz,
        estimator,
        cross_validate,
        prior,
        payloads: payloads.into_iter().map(payload).collect(),
        search: StructureSearch { couplings, sublinear },
        raw_estimate,
    };
    let given = robot.given.clone();
    let (training, holdout) = (recorded(&recordings), recorded(&holdout));
    let mut files = sources(&given, &[&training, &holdout]);
    files.extend(plan.clone());
    let found = done(py, move || match plan {
        Some(plan) => {
            let planned = PlannedRecordings::of(&plan)?;
            let read = run::read_all(&planned.files, &run::ReadingOptions::default(), || ())?;
            run::identify_planned(&given, &planned, read, &options)
        }
        None => run::identify(&given, training, holdout, &options, &|_| ()),
    })?;
    Ok(Answer::new(Found::Identified(Box::new(found)), "identify", files))
}

/// Effects that a model lacks.
#[pyfunction]
pub(crate) fn diagnose(
    py: Python<'_>,
    robot: &Robot,
    recordings: Vec<PyRef<'_, Recording>>,
    holdout: Vec<PyRef<'_, Recording>>,
    reference: Vec<PyRef<'_, Recording>>,
    placebo: Option<usize>,
    replay: bool,
    trust_columns: bool,
    next_motion: Option<PathBuf>,
) -> PyResult<(Answer, Option<Recording>)> {
    let given = robot.given.clone();
    let [training, holdout, reference] =
        [recordings, holdout, reference].map(|recordings| recorded(&recordings));
    let files = sources(&given, &[&training, &holdout, &reference]);
    let mut found = done(py, move || {
        let recordings =
            DiagnoseRecordings { training: &training, holdout: &holdout, reference: &reference };
        let options = DiagnoseOptions {
            trust_columns,
            placebo,
            no_replay: !replay,
            next_motion: next_motion.as_deref(),
        };
        run::diagnose(&given, recordings, &options)
    })?;
    let next = found.next_motion.take().map(|recorded| Recording { recorded });
    Ok((Answer::new(Found::Diagnosed(Box::new(found)), "diagnose", files), next))
}

/// Effort errors of a model on recordings.
#[pyfunction]
pub(crate) fn validate(
    py: Python<'_>,
    robot: &Robot,
    recordings: Vec<PyRef<'_, Recording>>,
    cutoff_hz: Option<f64>,
    replay: bool,
) -> PyResult<Answer> {
    let (given, recordings) = (robot.given.clone(), recorded(&recordings));
    let files = sources(&given, &[&recordings]);
    let found = done(py, move || run::validate(&given, recordings, cutoff_hz, replay, &[]))?;
    Ok(Answer::new(Found::Validated(Box::new(found)), "validate", files))
}

/// Efforts of a motion, with the result of the command.
#[pyfunction]
pub(crate) fn predict(
    py: Python<'_>,
    robot: &Robot,
    motion: &Recording,
    cutoff_hz: Option<f64>,
) -> PyResult<(Answer, Recording)> {
    let (given, motion) = (robot.given.clone(), motion.recorded.clone());
    let files = sources(&given, &[std::slice::from_ref(&motion)]);
    let found = done(py, move || run::predict(&given, &motion, cutoff_hz))?;
    let answer = Answer::new(Found::Predicted(found.report), "predict", files);
    Ok((answer, Recording { recorded: found.channels }))
}

/// Recordings of trajectories in software, and notes.
#[pyfunction]
pub(crate) fn simulate(
    py: Python<'_>,
    robot: &Robot,
    trajectories: Vec<PyRef<'_, Recording>>,
    forward: bool,
    torque_noise: Option<&str>,
    encoder_bits: Option<u32>,
    rate_hz: Option<f64>,
    effects: Vec<(String, String, Vec<f64>)>,
    seed: u64,
) -> PyResult<(Vec<Recording>, Vec<String>)> {
    let effort_noise = torque_noise.map(str::parse).transpose().map_err(|what| {
        wrong(py, what, "torque_noise", "pass N m or N, or a share such as \"5%\"")
    })?;
    if encoder_bits.is_some_and(|bits| !(4..=40).contains(&bits)) {
        let what = "encoder_bits must be between 4 and 40".to_owned();
        return Err(wrong(py, what, "encoder_bits", "pass bits per turn or metre"));
    }
    let effects: Vec<EffectOnJoint> = effects
        .into_iter()
        .map(|(effect, joint, parameters)| EffectOnJoint::new(effect, joint, parameters))
        .collect();
    let direction = if forward { SimulatedDirection::Forward } else { SimulatedDirection::Inverse };
    let options = SimulateOptions { direction, effort_noise, encoder_bits, rate_hz, effects, seed };
    let (given, trajectories) = (robot.given.clone(), recorded(&trajectories));
    let (recordings, notes) = done(py, move || {
        let simulator = Simulator::new(&given, &trajectories, options)?;
        let mut notes = simulator.notes.clone();
        notes.extend(simulator.warnings.iter().cloned());
        let mut recordings = Vec::new();
        for (k, trajectory) in trajectories.iter().enumerate() {
            let (recording, own) = simulator.record(trajectory, k)?;
            recordings.push(recording);
            notes.extend(own);
        }
        Ok::<_, Failure>((recordings, notes))
    })?;
    Ok((recordings.into_iter().map(|recorded| Recording { recorded }).collect(), notes))
}

/// A model as URDF, MJCF or C: the result of the command and the text.
#[pyfunction]
pub(crate) fn export(
    py: Python<'_>,
    robot: &Robot,
    path: PathBuf,
    format: Option<&str>,
    false_alarms_per_hour: Option<f64>,
    without_contact: Vec<PyRef<'_, Recording>>,
    holdout: Vec<PyRef<'_, Recording>>,
    observer_gain: Option<f64>,
) -> PyResult<(Answer, String)> {
    let format = match format {
        Some("urdf") => Some(ExportFormat::Urdf),
        Some("mjcf") => Some(ExportFormat::Mjcf),
        Some("drake-sdf") => Some(ExportFormat::DrakeSdf),
        Some("isaaclab") => Some(ExportFormat::IsaacLab),
        Some("usd") => Some(ExportFormat::Usd),
        Some("c") => Some(ExportFormat::C),
        Some(other) => {
            let what = format!("unknown format `{other}`");
            return Err(wrong(
                py,
                what,
                "format",
                "pass urdf, mjcf, drake-sdf, isaaclab, usd or c",
            ));
        }
        None => None,
    };
    let given = robot.given.clone();
    let (contact_free, holdout) = (recorded(&without_contact), recorded(&holdout));
    let files = sources(&given, &[&contact_free, &holdout]);
    let (text, report) = done(py, move || {
        let false_alarms = false_alarms_per_hour.map(|per_hour| FalseAlarms {
            per_hour,
            gain: observer_gain,
            recordings: &contact_free,
            holdout: &holdout,
        });
        let path: &Path = &path;
        let format = format.map_or_else(|| ExportFormat::of_path(path), Ok)?;
        let (files, report) = run::export(&given, format, path, false_alarms)?;
        for (path, text) in &files {
            write(path, text.as_bytes())?;
        }
        let text = files.into_iter().next().map(|(_, text)| text).unwrap_or_default();
        Ok((text, report))
    })?;
    Ok((Answer::new(Found::Exported(Box::new(report)), "export", files), text))
}

/// What logs hold; the guessed mapping of the first is written where a path is given.
#[pyfunction]
pub(crate) fn info(
    py: Python<'_>,
    recordings: Vec<PathBuf>,
    robot: Option<&Robot>,
    write_mapping: Option<PathBuf>,
    mapping: Option<PathBuf>,
    topic: Option<String>,
) -> PyResult<Answer> {
    let given = robot.map(|robot| robot.given.clone());
    let (files, report) = done(py, move || {
        let files = run::expand(&recordings)?;
        let joints = given.map_or_else(|| Ok(Vec::new()), |given| given.joint_names())?;
        let report = run::info(&files, &joints, &ReadingOptions { mapping, topic })?;
        if let Some(path) = &write_mapping {
            write(path, report.mapping()?.as_bytes())?;
        }
        Ok((files, report))
    })?;
    Ok(Answer::new(Found::Informed(report), "info", files))
}

/// A recording as a file with standard names: the result and the channels that the format cannot hold.
#[pyfunction]
pub(crate) fn convert(
    py: Python<'_>,
    recording: &Recording,
    path: PathBuf,
) -> PyResult<(Answer, Vec<String>)> {
    let recording = recording.recorded.clone();
    let files = vec![PathBuf::from(&recording.source)];
    let (omitted, report) = done(py, move || {
        let (encoded, report) = run::convert(&recording, &path)?;
        write(&path, &encoded.bytes)?;
        Ok((encoded.omitted, report))
    })?;
    Ok((Answer::new(Found::Converted(report), "convert", files), omitted))
}

/// The one file that is converted to a name.
#[pyfunction]
pub(crate) fn one_to_convert(
    py: Python<'_>,
    recording: PathBuf,
    path: PathBuf,
) -> PyResult<PathBuf> {
    done(py, move || run::one_to_convert(&recording, &path))
}

/// Motions of an identification, in a folder.
#[pyfunction]
pub(crate) fn excite(
    py: Python<'_>,
    robot: &Robot,
    folder: PathBuf,
    limits: Option<PathBuf>,
    keep_out: Option<PathBuf>,
    diagnosis: Option<PathBuf>,
    formats: Vec<String>,
    given: Vec<PyRef<'_, Recording>>,
    seconds: f64,
    budget: f64,
    rate_hz: f64,
    only: Vec<String>,
    seed: u64,
) -> PyResult<Answer> {
    let format = |name: &String| {
        let known = MotionFormat::ALL.map(MotionFormat::name).join(", ");
        let found = MotionFormat::ALL.into_iter().find(|format| format.name() == name);
        let (what, hint) = (format!("unknown format `{name}`"), format!("pass one of {known}"));
        found.ok_or_else(|| wrong(py, what, "format", &hint))
    };
    let part = |name: &String| {
        let known = Part::ALL.map(Part::name).join(", ");
        let found = Part::ALL.into_iter().find(|part| part.name() == name);
        let (what, hint) = (format!("unknown part `{name}`"), format!("pass some of {known}"));
        found.ok_or_else(|| wrong(py, what, "only", &hint))
    };
    for (name, value) in [("seconds", seconds), ("rate_hz", rate_hz)] {
        if !(value.is_finite() && value > 0.0) {
            let what = format!("expected a positive number, found {value}");
            return Err(wrong(py, what, name, "pass a number above 0"));
        }
    }
    if !(budget.is_finite() && budget >= 0.0) {
        let what = format!("expected seconds, found {budget}");
        return Err(wrong(py, what, "budget", "pass a number of seconds"));
    }
    let formats: Vec<MotionFormat> = formats.iter().map(format).collect::<PyResult<_>>()?;
    let settings = SuiteSettings {
        seconds,
        rate_hz,
        budget: std::time::Duration::from_secs_f64(budget),
        seed,
        parts: only.iter().map(part).collect::<PyResult<_>>()?,
    };
    let (robot, given) = (robot.given.clone(), recorded(&given));
    let files = sources(&robot, &[&given]);
    let found = done(py, move || {
        let options = ExciteOptions {
            limits: limits.as_deref(),
            keep_out: keep_out.as_deref(),
            diagnosis: diagnosis.as_deref(),
            formats: &formats,
            given: &given,
            settings,
        };
        let found = run::excite(&robot, &options)?;
        std::fs::create_dir_all(&folder).map_err(|error| Failure::unwritable(&folder, &error))?;
        for (name, bytes) in &found.files {
            write(&folder.join(name), bytes)?;
        }
        Ok(found)
    })?;
    Ok(Answer::new(Found::Excited(Box::new(found)), "excite", files))
}

/// Recordings reduced to states in a file.
#[pyfunction]
pub(crate) fn accumulate(
    py: Python<'_>,
    robot: &Robot,
    recordings: Vec<PathBuf>,
    output_file: PathBuf,
    cutoff_hz: f64,
    mapping: Option<PathBuf>,
    topic: Option<String>,
) -> PyResult<Answer> {
    let given = robot.given.clone();
    let (files, report) = done(py, move || {
        let files = run::recordings_to_reduce(&recordings, &output_file)?;
        let reading = ReadingOptions { mapping, topic };
        let how = Reduction { cutoff_hz, reading: &reading, robot_column: None };
        let report = run::accumulate(&given, &files, &output_file, &how, || ())?;
        Ok((files, report))
    })?;
    Ok(Answer::new(Found::Accumulated(report), "accumulate", files))
}

/// An arm from states of its recordings.
#[pyfunction]
pub(crate) fn merge(py: Python<'_>, robot: &Robot, states: Vec<PathBuf>) -> PyResult<Answer> {
    let given = robot.given.clone();
    let files = states.clone();
    let found = done(py, move || run::merge(&given, &states))?;
    Ok(Answer::new(Found::Merged(Box::new(found)), "merge", files))
}

/// Robots over their recordings, from states or from the recordings, which are reduced to a file of states.
#[pyfunction]
pub(crate) fn fleet(
    py: Python<'_>,
    robot: &Robot,
    inputs: Vec<PathBuf>,
    robot_of: Option<String>,
    states: Option<PathBuf>,
    cutoff_hz: f64,
    false_alarm_rate: f64,
    mapping: Option<PathBuf>,
    topic: Option<String>,
) -> PyResult<Answer> {
    let given = robot.given.clone();
    let files = inputs.clone();
    let reading = ReadingOptions { mapping, topic };
    let options = FleetOptions { robot_of, states, cutoff_hz, false_alarm_rate, reading };
    let report = done(py, move || run::fleet(&given, &inputs, &options, || ()))?;
    Ok(Answer::new(Found::Fleet(Box::new(report)), "fleet.follow", files))
}

/// Writes a file, whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    armident_recording::write_whole(path, |file| std::io::Write::write_all(file, bytes))
        .map_err(|error| Failure::unwritable(path, &error))
}
