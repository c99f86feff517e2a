//! Recordings written as comma-separated text: a column `t` \[s\], then `<joint>/<quantity>`.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::error::{Fault, RecordingError};
use crate::recording::Recording;
use crate::whole_file::write_whole;

/// Writes a CSV file: `t` and the channels. Numbers have as many digits as bring back the same
/// value; notes and ignored columns are not written.
///
/// # Errors
/// The recording is inconsistent, or the file cannot be written.
pub fn write_csv(path: impl AsRef<Path>, recording: &Recording) -> Result<(), RecordingError> {
    let path = path.as_ref();
    recording.check()?;
    let source = path.display().to_string();
    let mut failed = None;
    let written = write_whole(path, |file| {
        write_csv_to(file, recording).map_err(|error| {
            let said = io::Error::other(error.to_string());
            failed = Some(error);
            said
        })
    });
    match (failed, written) {
        (Some(error), _) => Err(error.of_source(&source)),
        (None, Err(error)) => {
            Err(RecordingError::new(Fault::Io { doing: "written", error }, &source))
        }
        (None, Ok(())) => Ok(()),
    }
}

/// Writes CSV text, as [`write_csv`].
///
/// # Errors
/// The recording is inconsistent, or the writer fails.
pub fn write_csv_to(writer: impl Write, recording: &Recording) -> Result<(), RecordingError> {
    recording.check()?;
    let channels: Vec<(String, &[f64])> = recording
        .joints
        .iter()
        .flat_map(|joint| {
            let named = |(quantity, values)| (format!("{}/{quantity}", joint.name), values);
            joint.channels().map(named)
        })
        .collect();
    let columns: Vec<&[f64]> = [recording.time_s.as_slice()]
        .into_iter()
        .chain(channels.iter().map(|(_, values)| *values))
        .collect();
    let fault =
        |error| RecordingError::new(Fault::Io { doing: "written", error }, &recording.source);

    let mut out = BufWriter::with_capacity(1 << 16, writer);
    let mut names = csv::Writer::from_writer(Vec::new());
    let header = std::iter::once("t").chain(channels.iter().map(|(name, _)| name.as_str()));
    names.write_record(header).map_err(|error| fault(error.into()))?;
    let names = names.into_inner().map_err(|error| fault(error.into_error()))?;
    let mut write_all = || -> io::Result<()> {
        out.write_all(&names)?;
        for row in 0..recording.len() {
            for (index, column) in columns.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                write!(out, "{separator}{}", column[row])?;
            }
            out.write_all(b"\n")?;
        }
        out.flush()
    };
    write_all().map_err(fault)
}
