//! `armident report`.

use std::path::Path;

use armident_commands::{Failure, compare};

use crate::args::ReportArgs;
use crate::failure::Outcome;
use crate::{output, page};

pub(crate) fn run(args: &ReportArgs) -> Result<Outcome, Failure> {
    let inputs = args.results.iter().map(|path| path.as_path());
    output::protect(inputs, [args.output_file.as_ref(), args.output.json.as_ref()])?;
    match &args.results[..] {
        [first, second] => compared(args, first, second),
        results => of_one(args, results.first().map_or(Path::new(""), |path| path)),
    }
}

/// Two results side by side: text on stdout, or a page there.
fn compared(args: &ReportArgs, first: &Path, second: &Path) -> Result<Outcome, Failure> {
    let found = compare(first, second)?;
    let mut text = found.text(output::bars());
    if let Some(path) = &args.output_file {
        let json = serde_json::to_string(&found).map_err(|error| {
            Failure::new(format!("cannot write JSON: {error}"), path.display(), None::<String>)
        })?;
        let html = armident_page::html(&json).map_err(|error| page::failure(first, &error))?;
        if output::is_stdout(path) {
            text = html;
        } else {
            output::write_file(path, html.as_bytes())?;
            text += &written(path, &html);
        }
    }
    output::say_all(&args.output, "note", &found.notes);
    output::write_result(&args.output, &text, &found, &found.warnings)
}

/// The page of a result.
fn of_one(args: &ReportArgs, result: &Path) -> Result<Outcome, Failure> {
    let Some(path) = &args.output_file else {
        return Err(Failure::new(
            "the page of one result needs a file to be written to",
            result.display(),
            Some("add -o report.html, or pass a second result to compare with"),
        ));
    };
    if args.output.json.is_some() {
        return Err(Failure::new(
            "one result, which is JSON already",
            "--json",
            Some("omit the option, or pass a second result to compare with"),
        ));
    }
    let text = std::fs::read_to_string(result).map_err(|error| {
        Failure::new(
            format!("cannot read: {error}"),
            result.display(),
            Some("pass a file written by --json of any command"),
        )
    })?;
    let html = armident_page::html(&text).map_err(|e| page::failure(result, &e))?;
    if output::is_stdout(path) {
        output::write_stdout(html.as_bytes())?;
    } else {
        output::write_file(path, html.as_bytes())?;
        output::write_stdout(written(path, &html).as_bytes())?;
    }
    Ok(Outcome::Done)
}

fn written(path: &Path, html: &str) -> String {
    format!("wrote {} ({:.1} MB)\n", path.display(), html.len() as f64 / 1e6)
}
