//! `armident accumulate`.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use armident_commands::{Failure, ReadingOptions, expand, read_all};
use armident_ident::{RecordingState, StateColumns};
use armident_report::{AccumulateReport, SetAside};

use super::merge::read_states;
use crate::args::AccumulateArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &AccumulateArgs) -> Result<Outcome, Failure> {
    let files = expand(&args.recordings)?;
    let inputs = files.iter().chain([&args.robot]).map(std::path::PathBuf::as_path);
    output::protect(inputs, [Some(&args.output_file), args.output.json.as_ref()])?;
    let model = robot::open(&args.robot, &args.chain)?.arm(None)?;
    let columns = StateColumns::new(&model, args.cutoff_hz)?;
    // what an interrupted run has written is kept; its last line may be cut off
    let before = match args.output_file.exists() {
        true => read_states(&args.output_file)?,
        false => (Vec::new(), Vec::new()),
    };
    if let ([], [fault, ..]) = (&before.0[..], &before.1[..]) {
        return Err(Failure::new(
            "the output file holds something else",
            &fault.file,
            Some("choose another output file; it is not overwritten"),
        ));
    }
    let mut known = BTreeSet::new();
    for state in &before.0 {
        columns.check(state).map_err(|error| {
            Failure::new(
                error,
                args.output_file.display(),
                Some("pass the same robot and cut-off, or another output file"),
            )
        })?;
        known.insert(state.recording.clone());
    }
    let reading =
        ReadingOptions { mapping: args.reading.mapping.clone(), topic: args.reading.topic.clone() };
    let mut file = None;
    let (mut reduced, mut there, mut set_aside) = (Vec::new(), Vec::new(), Vec::new());
    let progress = Progress::through(&args.output, "reducing recordings", files.len());
    for path in &files {
        let name = path.display().to_string();
        if known.contains(&name) {
            there.push(name);
            progress.part_done();
            continue;
        }
        let state = read_all(std::slice::from_ref(path), &reading, || ())
            .map_err(|failure| failure.what().to_owned())
            .and_then(|recordings| {
                let recording = recordings.into_iter().next().ok_or("no recording in it")?;
                columns.reduce(&recording).map_err(|error| error.to_string())
            });
        match state {
            Ok(state) => {
                let state = RecordingState { recording: name.clone(), ..state };
                let line = serde_json::to_string(&state).map_err(|error| {
                    Failure::new(format!("cannot write JSON: {error}"), &name, None::<String>)
                })?;
                if file.is_none() {
                    file = Some(append(&args.output_file, !before.1.is_empty())?);
                }
                if let Some(file) = &mut file {
                    file.write_all((line + "\n").as_bytes())
                        .map_err(|error| Failure::unwritable(&args.output_file, &error))?;
                }
                known.insert(name.clone());
                reduced.push(name);
            }
            Err(reason) => set_aside.push(SetAside { file: name, reason }),
        }
        progress.part_done();
    }
    drop(progress);
    if reduced.is_empty() && there.is_empty() {
        let reason = set_aside.first().map_or("there is none", |first| first.reason.as_str());
        return Err(Failure::new(
            format!("no recording could be reduced: {reason}"),
            args.recordings[0].display(),
            Some("`armident check` shows what a recording lacks"),
        ));
    }
    let report = AccumulateReport::new(reduced, there, set_aside);
    output::write_result(&args.output, &report.text(), &report, &[])
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
