//! Arguments of the commands around an analysis.

use std::path::PathBuf;

use clap::Args;

/// Write the result of a command as one self-contained HTML page
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident diagnose robot.urdf train.csv --json result.json --traces
  armident report result.json -o report.html

The page opens in any browser, without a network. Charts of efforts and residuals need --traces in the
command that wrote the result; check, identify, validate, diagnose and challenge write the same page at once with
--report.")]
pub(crate) struct ReportArgs {
    /// JSON written by --json of any command
    pub(crate) result: PathBuf,
    /// File to write; - is stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
}

/// Do the steps of an analysis that a file lists
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident run                          (armident.toml of this folder)
  armident run ur5/armident.toml --only diagnose
  armident run --dry-run                (print the command of every step)

A file of two steps; paths are relative to it, and the keys of a step are the options of its command:

  [defaults]                            # taken by every step whose command has them
  robot = \"urdf/ur5.urdf\"

  [[step]]
  command = \"check\"
  recordings = [\"train.csv\"]
  fail-on = \"warning\"

  [[step]]
  command = \"diagnose\"
  recordings = [\"train.csv\"]
  holdout = [\"holdout.csv\"]
  save-model = \"found.json\"
  report = \"report.html\"

All steps are read before the first is done. The first that fails ends the run with its exit code.")]
pub(crate) struct RunArgs {
    /// File of the steps
    #[arg(default_value = "armident.toml")]
    pub(crate) file: PathBuf,
    /// Do this step alone, by its `name` or else its command; repeat for more
    #[arg(long, value_name = "STEP")]
    pub(crate) only: Vec<String>,
    /// Print the command of every step and do nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Do not say which step is being done
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Show the whole story on a simulated arm: concealed physics, its diagnosis, a report
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident demo
  armident demo -o demo --seed 3

Writes ur5.urdf, train.csv, holdout.csv, model.json and report.html to the folder.")]
pub(crate) struct DemoArgs {
    /// Folder to write to, new or of an earlier demo
    #[arg(short, long, value_name = "FOLDER", default_value = "armident-demo")]
    pub(crate) output_folder: PathBuf,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

/// Print the completions of a shell
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident completions bash > ~/.local/share/bash-completion/completions/armident
  armident completions zsh > ~/.zfunc/_armident")]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

/// Write manual pages
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident man -o man && man -l man/armident-diagnose.1")]
pub(crate) struct ManArgs {
    /// Folder to write armident.1 and a page a command to
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
}
