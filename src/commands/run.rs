//! `armident run`.

use crate::analysis::{Analysis, Step, meant};
use crate::args::{Command, RunArgs};
use crate::failure::Outcome;
use crate::output;
use armident_commands::Failure;

pub(crate) fn run(args: &RunArgs) -> Result<Outcome, Failure> {
    let mut steps = Analysis::read(&args.file)?.steps()?;
    for name in &args.only {
        if !steps.iter().any(|step| step.name == *name) {
            let known: Vec<String> = steps.iter().map(|step| step.name.clone()).collect();
            return Err(Failure::new(
                format!("unknown step `{name}`"),
                args.file.display(),
                Some(meant(name, &known, "valid steps:")),
            ));
        }
    }
    steps.retain(|step| args.only.is_empty() || args.only.contains(&step.name));
    if args.dry_run {
        let lines: String = steps.iter().map(|step| line(step) + "\n").collect();
        output::write_stdout(lines.as_bytes())?;
        return Ok(Outcome::Done);
    }
    // paths are relative to the file
    if let Some(folder) = args.file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::env::set_current_dir(folder).map_err(|error| {
            Failure::new(
                format!("cannot enter the folder: {error}"),
                folder.display(),
                None::<String>,
            )
        })?;
    }
    for (k, step) in steps.into_iter().enumerate() {
        if !args.quiet {
            say(k, &line(&step));
        }
        match super::run(&with_command(step))? {
            Outcome::Done => {}
            failed @ Outcome::FailedOnRequest => return Ok(failed),
        }
    }
    Ok(Outcome::Done)
}

fn say(step: usize, line: &str) {
    let gap = if step == 0 { "" } else { "\n" };
    anstream::eprintln!("{gap}$ {line}");
}

/// The step as one would type it in the folder of the file.
fn line(step: &Step) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:%+@".contains(c);
    let quoted = |word: &String| match !word.is_empty() && word.chars().all(plain) {
        true => word.clone(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    step.argv.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// The command of a step; its page names the step, not `run`.
fn with_command(step: Step) -> Command {
    let mut command = step.command;
    let named = match &mut command {
        Command::Check(args) => &mut args.page.command,
        Command::Identify(args) => &mut args.page.command,
        Command::Diagnose(args) => &mut args.page.command,
        Command::Validate(args) => &mut args.page.command,
        Command::Challenge(args) => &mut args.command,
        _ => return command,
    };
    *named = Some(step.argv);
    command
}
