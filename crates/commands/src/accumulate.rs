//! `accumulate`: recordings reduced to states, one line of a file each, or as rows of a table.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use armident_ident::{RecordingState, StateColumns};
use armident_page::Provenance;
use armident_recording::{first_text, tables_are_built};
use armident_report::{AccumulateReport, SetAside};

use crate::failure::Failure;
use crate::recordings::{ReadingOptions, expand, read_all};
use crate::robot::GivenRobot;
use crate::state_files::heads;
use crate::state_lines::Head;
use crate::state_table::{is_named_table, with_lines};

/// How recordings are reduced.
#[derive(Debug, Clone, Copy)]
pub struct Reduction<'a> {
    /// Low-pass \[Hz\], the same for all recordings that are merged.
    pub cutoff_hz: f64,
    /// How recordings are read.
    pub reading: &'a ReadingOptions,
    /// Column of the recordings whose text names the robot.
    pub robot_column: Option<&'a str>,
}

/// Recordings to reduce from files and folders. A file of states that stands in a folder of recordings is none of them; one that is
/// named is not left out.
///
/// # Errors
/// As [`expand`].
pub fn recordings_to_reduce(
    given: &[PathBuf],
    output_file: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let mut files = expand(given)?;
    files.retain(|file| given.contains(file) || !same_file(file, output_file));
    Ok(files)
}

/// Whether two paths name the same existing file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// Reduces recordings to states in a file, which is continued where it exists: what it holds of the same content, read in the
/// same way, is not reduced again. `done` is called after each.
///
/// # Errors
/// An output file that holds something else, or states of another arm; no recording that can be reduced. Single recordings
/// that cannot are set aside.
pub fn accumulate(
    robot: &GivenRobot,
    files: &[PathBuf],
    output_file: &Path,
    how: &Reduction<'_>,
    done: impl Fn(),
) -> Result<AccumulateReport, Failure> {
    let Reduction { cutoff_hz, reading, robot_column } = *how;
    let model = robot.arm(None)?;
    let columns = StateColumns::new(&model, cutoff_hz)?;
    let is_table = is_named_table(output_file);
    if is_table {
        tables_are_built(output_file)?;
    }
    // a table is written as a whole: states are lines beside it until then
    let lines = if is_table { beside(output_file) } else { output_file.to_owned() };
    let files_of_states = [output_file, &lines];
    let files_of_states = &files_of_states[usize::from(!is_table)..];
    // what an interrupted run has written is kept; its last line may be cut off
    let (mut known, mut contents) = (BTreeSet::new(), BTreeSet::new());
    let (mut faults, mut other) = (Vec::new(), None);
    for of in files_of_states.iter().filter(|of| of.exists()) {
        let each = |head: Head, _| {
            if let Err(error) = columns.check_arm(&head.recording, &head.schema, &head.arm) {
                other.get_or_insert(error);
            }
            match head.content {
                Some(content) => contents.insert(content),
                // of an earlier version: by its name
                None => known.insert(head.recording),
            };
        };
        heads(of, None, each, &mut faults)?;
    }
    if let Some(error) = other {
        let hint = "pass the same robot and cut-off, or another output file";
        return Err(Failure::new(error, output_file.display(), Some(hint)));
    }
    if let (true, [fault, ..]) = (known.is_empty() && contents.is_empty(), &faults[..]) {
        return Err(Failure::new(
            "the output file holds something else",
            &fault.file,
            Some("choose another output file; it is not overwritten"),
        ));
    }
    let digest = settings_digest(reading);
    let mut file = None;
    let (mut reduced, mut there, mut set_aside) = (Vec::new(), Vec::new(), Vec::new());
    for path in files {
        let name = path.display().to_string();
        let content = content_of(path, &digest);
        if known.contains(&name) || contents.contains(&content) {
            there.push(name);
            done();
            continue;
        }
        let reduce = || {
            let read = read_all(std::slice::from_ref(path), reading, || ());
            let recordings = read.map_err(|failure| failure.what().to_owned())?;
            let recording = recordings.into_iter().next().ok_or("no recording in it")?;
            let state = columns.reduce(&recording).map_err(|error| error.to_string())?;
            let Some(column) = robot_column else { return Ok(state) };
            let robot = first_text(path, column).map_err(|error| error.to_string())?;
            let robot = robot.ok_or_else(|| format!("no column `{column}` with the robot"))?;
            Ok::<_, String>(RecordingState { robot: Some(robot), ..state })
        };
        let state = reduce();
        match state {
            Ok(state) => {
                let (recording, kept) = (name.clone(), Some(content.clone()));
                let state = RecordingState { recording, content: kept, ..state };
                let line = serde_json::to_string(&state).map_err(|error| {
                    Failure::new(format!("cannot write JSON: {error}"), &name, None::<String>)
                })?;
                if file.is_none() {
                    file = Some(append(&lines, !faults.is_empty())?);
                }
                if let Some(file) = &mut file {
                    file.write_all((line + "\n").as_bytes())
                        .map_err(|error| Failure::unwritable(&lines, &error))?;
                }
                contents.insert(content);
                reduced.push(name);
            }
            Err(reason) => set_aside.push(SetAside { file: name, reason }),
        }
        done();
    }
    drop(file);
    if is_table && lines.exists() {
        with_lines(output_file, &lines)?;
        std::fs::remove_file(&lines).map_err(|error| Failure::unwritable(&lines, &error))?;
    }
    if reduced.is_empty() && there.is_empty() {
        let reason = set_aside.first().map_or("there is none", |first| first.reason.as_str());
        return Err(Failure::new(
            format!("no recording could be reduced: {reason}"),
            files.first().map(|path| path.display().to_string()).unwrap_or_default(),
            Some("`armident check` shows what a recording lacks"),
        ));
    }
    Ok(AccumulateReport::new(reduced, there, set_aside))
}

/// The file of lines beside a table that is not yet written.
fn beside(table: &Path) -> PathBuf {
    let mut name = table.as_os_str().to_owned();
    name.push(".jsonl");
    PathBuf::from(name)
}

/// How recordings are read, as text that differs where they are read in another way.
fn settings_digest(reading: &ReadingOptions) -> String {
    let mapping = reading.mapping.as_deref().map(digest).unwrap_or_default();
    format!("{}:{mapping}", reading.topic.as_deref().unwrap_or_default())
}

/// Digest of a recording's bytes and how they are read; the cut-off is in the state itself.
fn content_of(path: &Path, how: &str) -> String {
    let digest = digest(path);
    if how == ":" { digest } else { format!("{digest}:{how}") }
}

fn digest(path: &Path) -> String {
    let of = Provenance::of(Vec::new(), [path]).inputs.pop();
    of.map_or_else(String::new, |input| input.sha256)
}

/// The file opened behind its last line, which an interrupted run may have cut off.
fn append(path: &Path, is_cut_off: bool) -> Result<File, Failure> {
    let unwritable = |error: std::io::Error| Failure::unwritable(path, &error);
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(unwritable)?;
    if is_cut_off {
        file.write_all(b"\n").map_err(unwritable)?;
    }
    Ok(file)
}
