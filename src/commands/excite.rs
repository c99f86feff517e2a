//! `armident excite`.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use armident_commands::{Failure, SUITE_FILE, SuiteEntry, SuiteFile, chain_notes, expand};
use armident_excitation::{ExciteRequest, GivenLimits, SuiteSettings, excite};
use armident_recording::write_csv_to;
use armident_report::{ExciteReport, MotionRow};

use super::recordings;
use crate::args::ExciteArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &ExciteArgs) -> Result<Outcome, Failure> {
    output::protect([args.robot.as_path()], [args.output.json.as_ref()])?;
    let model = robot::open(&args.robot, &args.chain)?.arm(None)?;
    let limits = args.limits.as_deref().map_or_else(|| Ok(BTreeMap::new()), read_limits)?;
    let settings = SuiteSettings {
        seconds: args.seconds,
        rate_hz: args.rate_hz,
        budget: Duration::from_secs_f64(args.budget),
        seed: args.seed,
        parts: args.only.clone(),
    };
    let files = expand(&args.given)?;
    let given = recordings::read_all(&files, &args.reading, &args.output)?;
    let request =
        ExciteRequest { chain: &model.chain, limits: &limits, given: &given, settings: &settings };
    let suite = {
        let _progress = Progress::of(&args.output, "designing motions");
        excite(&request).map_err(|error| Failure::excitation(&error, args.limits.as_deref()))?
    };
    output::create_folder(&args.output_folder)?;
    for motion in &suite.motions {
        let mut bytes = Vec::new();
        write_csv_to(&mut bytes, &motion.motion)?;
        output::write_file(&args.output_folder.join(format!("{}.csv", motion.name)), &bytes)?;
    }
    let joints: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let report = ExciteReport::new(&model.chain.robot, &joints, &suite);
    let document = list(&model.chain.robot, report.motions())?;
    output::write_file(&args.output_folder.join(SUITE_FILE), document.as_bytes())?;
    let notes = [chain_notes(&model), report.notes().to_vec()].concat();
    output::say_all(&args.output, "note", &notes);
    let warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    output::write_result(&args.output, &report.text(), &report, &warnings)
}

/// The limits of a file, by joint.
fn read_limits(path: &Path) -> Result<BTreeMap<String, GivenLimits>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::new(
            format!("cannot read: {error}"),
            path.display(),
            Some("`armident excite --help` shows an example"),
        )
    })?;
    let hint = "a table for each joint with lower, upper, velocity, acceleration, jerk, effort or noise, all numbers";
    toml::from_str(&text).map_err(|error| Failure::of_toml(&error, &text, path, hint))
}

fn list(robot: &str, motions: &[MotionRow]) -> Result<String, Failure> {
    let entry = |motion: &MotionRow| SuiteEntry {
        file: format!("{}.csv", motion.name),
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
