//! `fleet`: robots over their recordings, from states or from the recordings themselves.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use alphanumeric_sort::{compare_path, compare_str};
use armident_fleet::{FleetAnalysis, FleetSettings, outliers};
use armident_ident::{RecordingState, StateColumns};
use armident_model::ArmModel;
use armident_recording::{Formats, is_one_recording};
use armident_report::{FleetReport, SetAside};

use crate::accumulate::{Reduction, accumulate};
use crate::failure::Failure;
use crate::recordings::{ReadingOptions, has_extension};
use crate::robot::GivenRobot;
use crate::robot_of::{RobotOf, folder_of, robot_of as robot_in};
use crate::state_files::{Place, StateReader, heads, holds_states};
use crate::state_lines::Head;

/// Recordings that the scatter is estimated from, at most: more make it no better known than it need be.
const SCATTER_RECORDINGS: usize = 400;

/// How a fleet is read.
#[derive(Debug, Clone)]
pub struct FleetOptions {
    /// Pattern of paths with `{robot}`, or `column:NAME`; none: the robot of the state, else the folder of the recording.
    pub robot_of: Option<String>,
    /// File of states that recordings are reduced to, continued where it exists.
    pub states: Option<PathBuf>,
    /// Low-pass \[Hz\] of recordings that are reduced.
    pub cutoff_hz: f64,
    /// Probability that a change of a robot that does not change is reported.
    pub false_alarm_rate: f64,
    /// How recordings are read.
    pub reading: ReadingOptions,
}

/// One recording of a robot.
struct Entry {
    recording: String,
    recorded_at_s: Option<f64>,
    place: Place,
}

/// Robots by name, with their recordings.
type Robots = BTreeMap<String, Vec<Entry>>;

/// Trends, changes and outliers of the robots of one arm; `done` is called after each recording that is reduced and each
/// robot.
///
/// # Errors
/// Inputs that cannot be read, no state of this arm. Single recordings and states that cannot be used are set aside.
pub fn fleet(
    robot: &GivenRobot,
    inputs: &[PathBuf],
    options: &FleetOptions,
    done: impl Fn(),
) -> Result<FleetReport, Failure> {
    let Some(robot_of) = RobotOf::of(options.robot_of.as_deref()) else {
        let given = options.robot_of.as_deref().unwrap_or_default();
        return Err(Failure::new(
            format!("expected `{{robot}}` once in the pattern or `column:NAME`, found `{given}`"),
            "--robot-of",
            Some(
                "pass a pattern of paths, for example '{robot}/*.csv', or a column, for example column:robot",
            ),
        ));
    };
    let model = robot.arm(None)?;
    let (mut state_files, recordings) = files(inputs)?;
    let mut set_aside = Vec::new();
    if !recordings.is_empty() {
        let Some(states) = &options.states else {
            return Err(Failure::new(
                "recordings need a file for their states",
                recordings.first().map(|path| path.display().to_string()).unwrap_or_default(),
                Some("add --states states.jsonl; the next run continues it"),
            ));
        };
        let how = Reduction {
            cutoff_hz: options.cutoff_hz,
            reading: &options.reading,
            robot_column: robot_of.column(),
        };
        let report = accumulate(robot, &recordings, states, &how, &done)?;
        set_aside.extend(report.into_set_aside());
        if !state_files.contains(states) {
            state_files.push(states.clone());
        }
    }
    let (robots, cutoffs) = robots(&state_files, &model, robot_of, &mut set_aside)?;
    let cutoff_hz = common_cutoff(&cutoffs).unwrap_or(options.cutoff_hz);
    let columns = StateColumns::new(&model, cutoff_hz)?;
    let settings = FleetSettings { false_alarm_rate: options.false_alarm_rate };
    let no_states = |reason: Option<&SetAside>| {
        let what = reason.map_or("no state of a recording", |first| first.reason.as_str());
        let place = inputs.first().map(|path| path.display().to_string()).unwrap_or_default();
        Failure::new(
            what,
            place,
            Some("pass states that `armident accumulate` made for this robot"),
        )
    };
    let mut reader = StateReader::default();
    let sample = sample(&robots, &columns, &mut reader)?;
    if sample.is_empty() {
        let all = robots.values().flatten().next();
        let reason = match all {
            Some(entry) => usable(&columns, entry, &mut reader)?.err(),
            None => set_aside.first().cloned(),
        };
        return Err(no_states(reason.as_ref()));
    }
    let analysis = FleetAnalysis::learn(&columns, &sample, settings).map_err(|error| {
        no_states(Some(&SetAside { file: String::new(), reason: error.to_string() }))
    })?;
    drop(sample);
    let mut histories = Vec::new();
    for (name, entries) in &robots {
        let mut states = Vec::new();
        for entry in entries {
            match usable(&columns, entry, &mut reader)? {
                Ok(state) => states.push(state),
                Err(aside) => set_aside.push(aside),
            }
        }
        if !states.is_empty() {
            let history = analysis.robot(name, &states);
            histories.push(history.map_err(|error| Failure::new(error, name, None::<String>))?);
        }
        done();
    }
    let unlike = outliers(&histories, options.false_alarm_rate, analysis.scatter().freedom);
    let warnings = warnings(&histories, analysis.scatter().freedom);
    Ok(FleetReport::new(&columns, &analysis, &histories, &unlike, set_aside, warnings, page_of))
}

/// The state of a recording, or why it cannot be used.
fn usable(
    columns: &StateColumns<'_>,
    entry: &Entry,
    reader: &mut StateReader,
) -> Result<Result<RecordingState, SetAside>, Failure> {
    Ok(reader.read(&entry.place)?.and_then(|state| match columns.check(&state) {
        Ok(()) => Ok(state),
        Err(error) => Err(SetAside { file: entry.recording.clone(), reason: error.to_string() }),
    }))
}

/// What limits the result.
fn warnings(histories: &[armident_fleet::RobotHistory], freedom: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if freedom < 10.0 {
        warnings.push(format!(
            "few recordings follow each other on one robot: their scatter has {freedom:.1} degrees of freedom, so that only \
             large changes are reported [scatter]"
        ));
    }
    let single = histories.iter().filter(|history| history.recordings.len() == 1).count();
    if single > 0 {
        warnings.push(format!(
            "{single} of {} robots have one recording, in which no change can be seen; are the robots distinguished? \
             (--robot-of) [single]",
            histories.len()
        ));
    }
    warnings
}

/// The page of a diagnosis that stands beside a recording.
fn page_of(recording: &str) -> Option<String> {
    let page = Path::new(recording).with_extension("html");
    page.is_file().then(|| page.display().to_string())
}

/// Files of states and recordings among the inputs and below their folders.
fn files(inputs: &[PathBuf]) -> Result<(Vec<PathBuf>, Vec<PathBuf>), Failure> {
    let extensions = Formats::standard().extensions();
    let (mut states, mut recordings) = (Vec::new(), Vec::new());
    let mut waiting: Vec<(PathBuf, bool)> =
        inputs.iter().rev().map(|path| (path.clone(), true)).collect();
    while let Some((path, is_given)) = waiting.pop() {
        if is_one_recording(&path) {
            recordings.push(path);
        } else if path.is_dir() {
            let entries = std::fs::read_dir(&path).map_err(|error| {
                let what = format!("cannot read the folder: {error}");
                Failure::new(what, path.display(), None::<String>)
            })?;
            let mut inside: Vec<PathBuf> =
                entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
            inside.sort_by(|a, b| compare_path(b, a));
            waiting.extend(inside.into_iter().map(|path| (path, false)));
        } else if holds_states(&path) {
            states.push(path);
        } else {
            if is_given || has_extension(&path, &extensions) {
                recordings.push(path);
            }
        }
    }
    Ok((states, recordings))
}

/// Recordings of each robot in their order, and the cut-offs of all of them.
fn robots(
    files: &[PathBuf],
    model: &ArmModel,
    robot_of: RobotOf<'_>,
    set_aside: &mut Vec<SetAside>,
) -> Result<(Robots, Vec<f64>), Failure> {
    let names = model.chain.joint_names();
    let mut known: BTreeMap<String, (String, Entry)> = BTreeMap::new();
    let (mut cutoffs, mut faults) = (Vec::new(), Vec::new());
    for file in files {
        let each = |head: Head, place: Place| {
            if head.schema != RecordingState::SCHEMA {
                let expected = RecordingState::SCHEMA;
                let reason = format!("expected schema `{expected}`, found `{}`", head.schema);
                faults.push(SetAside { file: head.recording, reason });
                return;
            }
            if head.arm.joints == names {
                cutoffs.push(head.arm.cutoff_hz);
            }
            let path = head.recording.replace('\\', "/");
            let robot = match robot_of {
                RobotOf::Pattern(pattern) => robot_in(pattern, &path)
                    .ok_or_else(|| "its path does not have the pattern of --robot-of".to_owned()),
                RobotOf::Column(name) => head
                    .named
                    .or(head.robot)
                    .ok_or_else(|| format!("its state has no robot by the column `{name}`")),
                RobotOf::Folder => Ok(head
                    .robot
                    .or_else(|| folder_of(&path))
                    .unwrap_or_else(|| model.chain.robot.clone())),
            };
            let robot = match robot {
                Ok(robot) => robot,
                Err(reason) => {
                    faults.push(SetAside { file: head.recording, reason });
                    return;
                }
            };
            let recorded_at_s = head.recorded_at_s;
            let entry = Entry { recording: head.recording.clone(), recorded_at_s, place };
            // a recording that was reduced anew stands further below
            known.insert(head.recording, (robot, entry));
        };
        heads(file, robot_of.column(), each, set_aside)?;
    }
    set_aside.extend(faults);
    let mut robots = Robots::new();
    for (robot, entry) in known.into_values() {
        robots.entry(robot).or_default().push(entry);
    }
    for entries in robots.values_mut() {
        entries.sort_by(|a, b| compare_str(&a.recording, &b.recording));
        if entries.iter().all(|entry| entry.recorded_at_s.is_some()) {
            entries.sort_by(|a, b| {
                a.recorded_at_s.partial_cmp(&b.recorded_at_s).unwrap_or(std::cmp::Ordering::Equal)
            });
        }
    }
    Ok((robots, cutoffs))
}

/// The cut-off of most states \[Hz\].
fn common_cutoff(cutoffs: &[f64]) -> Option<f64> {
    let mut sorted = cutoffs.to_vec();
    sorted.sort_by(f64::total_cmp);
    let runs = sorted.chunk_by(|a, b| (a - b).abs() < 1e-9);
    runs.max_by_key(|run| run.len()).map(|run| run[0])
}

/// Successive recordings of some robots, for the scatter.
fn sample(
    robots: &Robots,
    columns: &StateColumns<'_>,
    reader: &mut StateReader,
) -> Result<Vec<Vec<RecordingState>>, Failure> {
    let several: Vec<&Vec<Entry>> = robots.values().filter(|entries| entries.len() > 1).collect();
    let of: Vec<&Vec<Entry>> = if several.is_empty() { robots.values().collect() } else { several };
    // runs of several recordings: a robot's own parameters are estimated too
    let count = of.len().min(SCATTER_RECORDINGS / 8);
    let mut sample = Vec::new();
    for index in 0..count {
        let entries = of[index * of.len() / count];
        let each = (SCATTER_RECORDINGS / count).min(entries.len());
        // from the middle of a long history
        let start = (entries.len() - each) / 2;
        let mut states = Vec::new();
        for entry in &entries[start..start + each] {
            states.extend(usable(columns, entry, reader)?);
        }
        if !states.is_empty() {
            sample.push(states);
        }
    }
    Ok(sample)
}
