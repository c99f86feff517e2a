//! `armident completions` and `armident man`: what shells and manuals know of the command line.

use clap::CommandFactory;

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Outcome;
use crate::output;
use armident_commands::Failure;

pub(crate) fn completions(args: &CompletionsArgs) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "armident", &mut script);
    output::write_stdout(&script)?;
    Ok(Outcome::Done)
}

pub(crate) fn man(args: &ManArgs) -> Result<Outcome, Failure> {
    let folder = &args.output_folder;
    output::create_folder(folder)?;
    let mut cli = Cli::command().disable_help_subcommand(true);
    cli.build();
    for command in std::iter::once(&cli).chain(cli.get_subcommands()) {
        let page = clap_mangen::Man::new(command.clone());
        let mut text = Vec::new();
        page.render(&mut text).map_err(|error| Failure::unwritable(folder, &error))?;
        output::write_file(&folder.join(page.get_filename()), &text)?;
    }
    Ok(Outcome::Done)
}
