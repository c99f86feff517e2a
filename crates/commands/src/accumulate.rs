//! `accumulate`: recordings reduced to states, one line of a file each.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use armident_ident::{RecordingState, StateColumns};
use armident_page::Provenance;
use armident_report::{AccumulateReport, SetAside};

use crate::failure::Failure;
use crate::recordings::{ReadingOptions, read_all};
use crate::robot::GivenRobot;
use crate::state_files::{Head, heads};

/// Reduces recordings to states in a file, which is continued where it exists: what it holds of the same content, read in the
/// same way, is not reduced again. `done` is called after each. `cutoff_hz`: low-pass \[Hz\], the same for all recordings that are merged.
///
/// # Errors
/// An output file that holds something else, or states of another arm; no recording that can be reduced. Single recordings
/// that cannot are set aside.
pub fn accumulate(
    robot: &GivenRobot,
    files: &[PathBuf],
    output_file: &Path,
    cutoff_hz: f64,
    reading: &ReadingOptions,
    done: impl Fn(),
) -> Result<AccumulateReport, Failure> {
    let model = robot.arm(None)?;
    let columns = StateColumns::new(&model, cutoff_hz)?;
    // what an interrupted run has written is kept; its last line may be cut off
    let (mut known, mut contents) = (BTreeSet::new(), BTreeSet::new());
    let (mut faults, mut other) = (Vec::new(), None);
    if output_file.exists() {
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
        heads(output_file, each, &mut faults)?;
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
    let how = settings_digest(reading);
    let mut file = None;
    let (mut reduced, mut there, mut set_aside) = (Vec::new(), Vec::new(), Vec::new());
    for path in files {
        let name = path.display().to_string();
        let content = content_of(path, &how);
        if known.contains(&name) || contents.contains(&content) {
            there.push(name);
            done();
            continue;
        }
        let state = read_all(std::slice::from_ref(path), reading, || ())
            .map_err(|failure| failure.what().to_owned())
            .and_then(|recordings| {
                let recording = recordings.into_iter().next().ok_or("no recording in it")?;
                columns.reduce(&recording).map_err(|error| error.to_string())
            });
        match state {
            Ok(state) => {
                let (recording, kept) = (name.clone(), Some(content.clone()));
                let state = RecordingState { recording, content: kept, ..state };
                let line = serde_json::to_string(&state).map_err(|error| {
                    Failure::new(format!("cannot write JSON: {error}"), &name, None::<String>)
                })?;
                if file.is_none() {
                    file = Some(append(output_file, !faults.is_empty())?);
                }
                if let Some(file) = &mut file {
                    file.write_all((line + "\n").as_bytes())
                        .map_err(|error| Failure::unwritable(output_file, &error))?;
                }
                contents.insert(content);
                reduced.push(name);
            }
            Err(reason) => set_aside.push(SetAside { file: name, reason }),
        }
        done();
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
