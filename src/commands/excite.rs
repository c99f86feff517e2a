//! `armident excite`.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use armident_commands::{
    Failure, MotionFormat, SUITE_FILE, SuiteEntry, SuiteFile, chain_notes, expand, read_rivals,
};
use armident_excitation::{ExciteRequest, SuiteSettings, excite};
use armident_report::{ExciteReport, MotionRow};
use serde::de::DeserializeOwned;

use super::recordings;
use crate::args::ExciteArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &ExciteArgs) -> Result<Outcome, Failure> {
    let read = [Some(args.robot.as_path()), args.diagnosis.as_deref()];
    output::protect(read.into_iter().flatten(), [args.output.json.as_ref()])?;
    let model = robot::open(&args.robot, &args.chain)?.arm(None)?;
    args.format.iter().try_for_each(|format| format.check(&model.chain))?;
    let limits = table(args.limits.as_deref(), LIMITS_HINT)?;
    let keep_out = table(args.keep_out.as_deref(), KEEP_OUT_HINT)?;
    let rivals = match &args.diagnosis {
        Some(path) => read_rivals(path, &model.chain)?,
        None => Vec::new(),
    };
    let settings = SuiteSettings {
        seconds: args.seconds,
        rate_hz: args.rate_hz,
        budget: Duration::from_secs_f64(args.budget),
        seed: args.seed,
        parts: args.only.clone(),
    };
    let files = expand(&args.given)?;
    let given = recordings::read_all(&files, &args.reading, &args.output)?;
    let request = ExciteRequest {
        chain: &model.chain,
        limits: &limits,
        given: &given,
        keep_out: &keep_out,
        rivals: &rivals,
        settings: &settings,
    };
    let suite = {
        let _progress = Progress::of(&args.output, "designing motions");
        excite(&request).map_err(|error| Failure::excitation(&error, args.limits.as_deref()))?
    };
    output::create_folder(&args.output_folder)?;
    for motion in &suite.motions {
        for format in &args.format {
            let bytes = format.bytes(&motion.motion, &model.chain)?;
            let name = format!("{}.{}", motion.name, format.extension());
            output::write_file(&args.output_folder.join(name), &bytes)?;
        }
    }
    let joints: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let report = ExciteReport::new(&model.chain.robot, &joints, &suite);
    let first = args.format.first().map_or("csv", |format| MotionFormat::extension(*format));
    let document = list(&model.chain.robot, report.motions(), first)?;
    output::write_file(&args.output_folder.join(SUITE_FILE), document.as_bytes())?;
    let notes = [chain_notes(&model), report.notes().to_vec()].concat();
    output::say_all(&args.output, "note", &notes);
    let warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    output::write_result(&args.output, &report.text(), &report, &warnings)
}

const LIMITS_HINT: &str = "a table for each joint with lower, upper, velocity, acceleration, jerk, effort or noise, all numbers";
const KEEP_OUT_HINT: &str = "a table for each region: centre and size (and rpy) of a box, or point and normal of a plane, three numbers each";

/// Tables of a file by their names; none without a file.
fn table<T: DeserializeOwned>(
    path: Option<&Path>,
    hint: &str,
) -> Result<BTreeMap<String, T>, Failure> {
    let Some(path) = path else { return Ok(BTreeMap::new()) };
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::new(
            format!("cannot read: {error}"),
            path.display(),
            Some("`armident excite --help` shows an example"),
        )
    })?;
    toml::from_str(&text).map_err(|error| Failure::of_toml(&error, &text, path, hint))
}

fn list(robot: &str, motions: &[MotionRow], extension: &str) -> Result<String, Failure> {
    let entry = |motion: &MotionRow| SuiteEntry {
        file: format!("{}.{extension}", motion.name),
        split: motion.split,
        seconds: motion.seconds,
        purpose: motion.purpose.to_owned(),
    };
    let file = SuiteFile {
        schema: SuiteFile::SCHEMA.to_owned(),
        robot: robot.to_owned(),
        motion: motions.iter().map(entry).collect(),
    };
    let text = toml::to_string(&file).map_err(|error| {
        Failure::new(format!("cannot write TOML: {error}"), SUITE_FILE, None::<String>)
    })?;
    Ok(format!(
        "# Motions in the order of recording; record each as a file of the same name.\n{text}"
    ))
}
