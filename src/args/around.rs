//! Arguments of report, run, demo, completions and man.

use std::path::PathBuf;

use clap::Args;

use super::OutputArgs;

/// Render a JSON result as a self-contained HTML page, or compare two results
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident diagnose robot.urdf train.csv --json result.json --traces
  armident report result.json -o report.html
  armident report before.json after.json                       (what differs, as text)
  armident report before.json after.json -o compared.html

The page opens in any browser without a network connection. Charts of efforts and residuals require
--traces in the command that wrote the result. The commands check, identify, validate, diagnose and
challenge write the same page directly with --report. Two results of identify, or two of diagnose, are
compared parameter by parameter in standard errors of the difference, and finding by finding.")]
pub(crate) struct ReportArgs {
    /// JSON written by --json of any command; two of them are compared
    #[arg(required = true, num_args = 1..=2, value_name = "RESULT")]
    pub(crate) results: Vec<PathBuf>,
    /// Output file; - for stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Run the steps of an analysis file
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident run                          (armident.toml in this folder)
  armident run ur5/armident.toml --only diagnose
  armident run --dry-run                (print the commands only)

A file with two steps. Paths are relative to the file; the keys of a step are the options of its command:

  [defaults]                            # used by every step whose command has these options
  robot = \"urdf/ur5.urdf\"

  [[step]]
  command = \"check\"
  recordings = [\"train.csv\"]
  fail-on = \"warning\"

  [[step]]
  command = \"diagnose\"
  recordings = [\"train.csv\"]
  holdout = [\"holdout.csv\"]
  save-model = \"diagnosed.json\"
  report = \"report.html\"

The whole file is validated before the first step runs. The first step that fails ends the run with
its exit code.")]
pub(crate) struct RunArgs {
    /// Analysis file
    #[arg(default_value = "armident.toml")]
    pub(crate) file: PathBuf,
    /// Run only this step, by its `name` or else its command; repeatable
    #[arg(long, value_name = "STEP")]
    pub(crate) only: Vec<String>,
    /// Print the commands without running them
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Do not print the command of each step
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Run a complete example: simulate an arm with hidden effects, diagnose it, write a report
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident demo
  armident demo -o demo --seed 3

Writes ur5.urdf, train.csv, holdout.csv, model.json and report.html to the folder.")]
pub(crate) struct DemoArgs {
    /// Output folder (new, or from an earlier demo)
    #[arg(short, long, value_name = "FOLDER", default_value = "armident-demo")]
    pub(crate) output_folder: PathBuf,
    /// Random seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

/// Generate shell completions
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident completions bash > ~/.local/share/bash-completion/completions/armident
  armident completions zsh > ~/.zfunc/_armident")]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

/// Generate manual pages
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident man -o man && man -l man/armident-diagnose.1")]
pub(crate) struct ManArgs {
    /// Output folder for armident.1 and one page per command
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
}
