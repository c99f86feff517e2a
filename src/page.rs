//! Pages: what `--report` and `--traces` add to a result.

use std::path::{Path, PathBuf};

use armident_commands::{Drawn, Failure};
use armident_page::{Drawing, PageError, Provenance};
use serde::Serialize;

use crate::args::{OutputArgs, PageArgs};
use crate::failure::Outcome;
use crate::output;

impl PageArgs {
    /// Whether anything is to be drawn.
    pub(crate) fn wanted(&self) -> bool {
        self.report.is_some() || self.traces
    }

    /// Refuses what cannot be written, before the work is done.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match &self.report {
            Some(path) if output::is_stdout(path) => Err(Failure::new(
                "the page cannot be written to stdout",
                "--report",
                Some("pass a file, for example --report report.html"),
            )),
            _ => Ok(()),
        }
    }
}

/// Writes a result and its page. `drawing` is what is drawn, if anything is.
pub(crate) fn write_result<T: Serialize>(
    pages: &PageArgs,
    args: &OutputArgs,
    text: &str,
    result: &T,
    warnings: &[String],
    drawing: Option<&Drawing>,
) -> Result<Outcome, Failure> {
    let Some(drawing) = drawing else {
        return output::write_result(args, text, result, warnings);
    };
    let drawn = Drawn { result, drawing };
    let outcome = if pages.traces {
        output::write_result(args, text, &drawn, warnings)?
    } else {
        output::write_result(args, text, result, warnings)?
    };
    if let Some(path) = &pages.report {
        let document = serde_json::to_string(&drawn).map_err(|error| {
            Failure::new(format!("cannot write JSON: {error}"), path.display(), None::<String>)
        })?;
        let page = armident_page::html(&document).map_err(|e| failure(path, &e))?;
        output::write_file(path, page.as_bytes())?;
        let megabytes = page.len() as f64 / 1e6;
        output::say_all(args, "note", &[format!("wrote {} ({megabytes:.1} MB)", path.display())]);
    }
    Ok(outcome)
}

/// A page that could not be made of a file.
pub(crate) fn failure(path: &Path, error: &PageError) -> Failure {
    let place = match error {
        PageError::NotJson { line, .. } => format!("{}, line {line}", path.display()),
        _ => path.display().to_string(),
    };
    Failure::new(error, place, Some("pass a file written by --json of any command"))
}

/// What is drawn of a result, with its origin; nothing where nothing is wanted.
pub(crate) fn drawn<'a>(
    pages: &PageArgs,
    files: impl IntoIterator<Item = &'a PathBuf>,
    draw: impl FnOnce() -> Result<Drawing, Failure>,
) -> Result<Option<Drawing>, Failure> {
    if !pages.wanted() {
        return Ok(None);
    }
    Ok(Some(Drawing { provenance: provenance(pages, files), ..draw()? }))
}

/// The command line, and the files that were read for it.
pub(crate) fn provenance<'a>(
    pages: &PageArgs,
    files: impl IntoIterator<Item = &'a PathBuf>,
) -> Provenance {
    let own = || std::iter::once("armident".to_owned()).chain(std::env::args().skip(1)).collect();
    let command = pages.command.clone().unwrap_or_else(own);
    Provenance::of(command, files.into_iter().map(PathBuf::as_path))
}
