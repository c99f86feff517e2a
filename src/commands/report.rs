//! `armident report`.

use crate::args::ReportArgs;
use crate::failure::Outcome;
use crate::{output, page};
use armident_commands::Failure;

pub(crate) fn run(args: &ReportArgs) -> Result<Outcome, Failure> {
    output::protect([args.result.as_path()], [Some(&args.output_file)])?;
    let text = std::fs::read_to_string(&args.result).map_err(|error| {
        Failure::new(
            format!("cannot read: {error}"),
            args.result.display(),
            Some("pass a file written by --json of any command"),
        )
    })?;
    let html = armident_page::html(&text).map_err(|e| page::failure(&args.result, &e))?;
    if output::is_stdout(&args.output_file) {
        output::write_stdout(html.as_bytes())?;
    } else {
        output::write_file(&args.output_file, html.as_bytes())?;
        let megabytes = html.len() as f64 / 1e6;
        let said = format!("wrote {} ({megabytes:.1} MB)\n", args.output_file.display());
        output::write_stdout(said.as_bytes())?;
    }
    Ok(Outcome::Done)
}
