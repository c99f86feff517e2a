//! `armident convert`.

use armident_commands::{Failure, convert, one_to_convert};

use super::recordings;
use crate::args::ConvertArgs;
use crate::failure::Outcome;
use crate::output;

pub(crate) fn run(args: &ConvertArgs) -> Result<Outcome, Failure> {
    let path = &args.output_file;
    output::protect([args.recording.as_path()], [Some(path), args.output.json.as_ref()])?;
    let file = one_to_convert(&args.recording, path)?;
    let recording = recordings::read_all(&[file], &args.reading, &args.output)?.remove(0);
    let (encoded, report) = convert(&recording, path)?;
    output::write_file(path, &recordings::bytes_of(encoded, path, &args.output))?;
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &report.text(), &report, &[])
}
