//! `excite`: the motions of an identification, and their files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use armident_excitation::{ExciteRequest, SuiteSettings, excite as designed};
use armident_recording::Recording;
use armident_report::{ExciteReport, MotionRow};
use serde::de::DeserializeOwned;

use crate::failure::Failure;
use crate::planned_motion::MotionFormat;
use crate::rivals::read_rivals;
use crate::robot::{GivenRobot, chain_notes, chain_warnings};
use crate::suite::{SUITE_FILE, SuiteEntry, SuiteFile};

/// How motions are designed.
#[derive(Debug, Clone)]
pub struct ExciteOptions<'a> {
    /// TOML file of the limits of joints that differ from those of the robot.
    pub limits: Option<&'a Path>,
    /// TOML file of boxes and planes that the arm keeps out of.
    pub keep_out: Option<&'a Path>,
    /// JSON of a diagnosis whose findings are separated from their alternatives.
    pub diagnosis: Option<&'a Path>,
    /// Formats of the motions, at least one.
    pub formats: &'a [MotionFormat],
    /// Recordings that exist already.
    pub given: &'a [Recording],
    /// Length, rate, budget, seed and parts.
    pub settings: SuiteSettings,
}

/// Motions of an identification.
#[derive(Debug)]
pub struct Excited {
    /// The result.
    pub report: ExciteReport,
    /// Notes on chain and motions.
    pub notes: Vec<String>,
    /// Warnings on the arm.
    pub warnings: Vec<String>,
    /// Names of files and what is in them; their list is the last.
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

/// Designs the motions of an identification.
///
/// # Errors
/// Limits or regions that cannot be read; an arm without limits; motions that a format cannot hold.
pub fn excite(robot: &GivenRobot, options: &ExciteOptions<'_>) -> Result<Excited, Failure> {
    let model = robot.arm(None)?;
    options.formats.iter().try_for_each(|format| format.check(&model.chain))?;
    let limits = table(options.limits, LIMITS_HINT)?;
    let keep_out = table(options.keep_out, KEEP_OUT_HINT)?;
    let rivals = match options.diagnosis {
        Some(path) => read_rivals(path, &model.chain)?,
        None => Vec::new(),
    };
    let request = ExciteRequest {
        chain: &model.chain,
        limits: &limits,
        given: options.given,
        keep_out: &keep_out,
        rivals: &rivals,
        settings: &options.settings,
    };
    let suite = designed(&request).map_err(|error| Failure::excitation(&error, options.limits))?;
    let mut files = Vec::new();
    for motion in &suite.motions {
        for format in options.formats {
            let name = format!("{}.{}", motion.name, format.extension());
            files.push((PathBuf::from(name), format.bytes(&motion.motion, &model.chain)?));
        }
    }
    let joints: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let report = ExciteReport::new(&model.chain.robot, &joints, &suite);
    let first = options.formats.first().map_or("csv", |format| format.extension());
    let document = list(&model.chain.robot, report.motions(), first)?;
    files.push((PathBuf::from(SUITE_FILE), document.into_bytes()));
    let notes = [chain_notes(&model), report.notes().to_vec()].concat();
    Ok(Excited { report, notes, warnings: chain_warnings(&model), files })
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
