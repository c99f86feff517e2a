//! `armident check`.

use std::path::PathBuf;

use armident_commands::{Failure, check, expand};

use super::recordings;
use crate::args::CheckArgs;
use crate::failure::Outcome;
use crate::{output, page, robot};

pub(crate) fn run(args: &CheckArgs) -> Result<Outcome, Failure> {
    let files = expand(&args.recordings)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref(), args.page.report.as_ref()])?;
    args.page.check()?;
    let read = recordings::read_quietly(&files, &args.reading)?;
    let found = check(&robot::open(&args.robot, &args.chain)?, &read, args.cutoff_hz)?;
    output::say_all(&args.output, "note", &found.report.notes);
    let files = [&args.robot].into_iter().chain(&files).chain(&args.reading.mapping);
    let drawing = page::drawn(&args.page, files, || found.drawing())?;
    let report = &found.report;
    let (text, warnings) = (report.text(), &report.warnings);
    page::write_result(&args.page, &args.output, &text, report, warnings, drawing.as_ref())
}
