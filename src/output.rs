//! Data on stdout, messages on stderr, files written whole.

use std::io::Write;
use std::path::{Path, PathBuf};

use armident_commands::Failure;
use armident_recording::write_whole;
use armident_report::Bars;
use serde::Serialize;

use crate::args::{FailOn, OutputArgs};
use crate::failure::{NOTE, Outcome, WARNING};

/// Writes a result: text on stdout unless JSON goes there, JSON if requested, warnings on stderr.
pub(crate) fn write_result(
    output: &OutputArgs,
    text: &str,
    json: &impl Serialize,
    warnings: &[String],
) -> Result<Outcome, Failure> {
    say_all(output, "warning", warnings);
    let mut text_on_stdout = true;
    if let Some(path) = &output.json {
        let mut document = serde_json::to_string_pretty(json).map_err(|error| {
            Failure::new(format!("cannot write JSON: {error}"), path.display(), None::<String>)
        })?;
        document.push('\n');
        if is_stdout(path) {
            text_on_stdout = false;
            write_stdout(document.as_bytes())?;
        } else {
            write_file(path, document.as_bytes())?;
        }
    }
    if text_on_stdout {
        write_stdout(text.as_bytes())?;
    }
    Ok(if output.fail_on == Some(FailOn::Warning) && !warnings.is_empty() {
        Outcome::FailedOnRequest
    } else {
        Outcome::Done
    })
}

/// One line on stderr per message, unless quiet.
pub(crate) fn say_all(output: &OutputArgs, kind: &str, messages: &[String]) {
    if !output.quiet {
        let style = if kind == "warning" { WARNING } else { NOTE };
        for message in messages {
            anstream::eprintln!("{style}{kind}:{style:#} {message}");
        }
    }
}

/// A count with its noun, which agrees: "1 joint", "2 joints".
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// Bar characters that stdout supports.
pub(crate) fn bars() -> Bars {
    if supports_unicode::on(supports_unicode::Stream::Stdout) { Bars::Unicode } else { Bars::Ascii }
}

pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

pub(crate) fn write_stdout(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        // a closed pipe (`| head`) is not a failure
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::new(format!("cannot write: {error}"), "stdout", None::<String>)),
        Ok(()) => Ok(()),
    }
}

/// Writes a file, whole or not at all.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_whole(path, |file| file.write_all(bytes))
        .map_err(|error| Failure::unwritable(path, &error))
}

/// Creates a folder and its parents.
pub(crate) fn create_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| Failure::unwritable(path, &error))
}

/// Refuses to write a result over one of its inputs.
pub(crate) fn protect<'a>(
    inputs: impl IntoIterator<Item = &'a Path>,
    outputs: impl IntoIterator<Item = Option<&'a PathBuf>>,
) -> Result<(), Failure> {
    let inputs: Vec<&Path> = inputs.into_iter().collect();
    for written in outputs.into_iter().flatten() {
        if inputs.iter().any(|input| armident_commands::same_file(written, input)) {
            return Err(Failure::new(
                "the output would overwrite an input file",
                written.display(),
                Some("write to another file"),
            ));
        }
    }
    Ok(())
}
