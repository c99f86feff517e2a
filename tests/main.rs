//! The acceptance suite. One binary; each module is one promise of the tool.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failed test may panic"
)]

/// where the optional shared data lies, and how a skipped test says so
mod shared;
/// runs the program: exit code, stdout, stderr, result files
mod tool;

/// chain, constants, minimal set and states against numbers of an independent program
mod golden;

/// the arms of `urdf/`: the printed page of each, poses against the URDF, the table of its README
mod arms;
/// a hundred URDFs of real arms: read or refused in words; set sizes of an independent program
mod corpus;
/// `params --json`: field names and values of the shared golden data
mod params_json;

/// exit codes, streams, and what is said about eighty wrong command lines
mod cli;
/// no bytes in any input file make the program panic
mod no_panic;
/// the steps of `armident.toml`
mod run;

/// cases made, diagnosed unseen and scored
mod challenge;
/// recordings as they are and spoiled: what `check` says of them
mod check;
/// a fixed small sample of the study of the intervals
mod coverage;
/// the story without any file; completions and manual pages
mod demo;
/// one concealed effect is named and located, what is not there is not, and the model predicts
mod diagnose;
/// models as URDF and MJCF, and what these formats cannot hold
mod export;
/// MCAP beside CSV
mod formats;
/// pages of results in a browser
mod page;
/// exported URDF and MJCF in Pinocchio and MuJoCo
mod peers;
/// plan, simulate, identify, predict: what was put in comes out
mod pipeline;
/// public recordings of real arms: rank, error against a plain baseline, refusals
mod real_data;

/// a section of a diagnosis that this file adds
mod extend_section;
/// `docs/json.md` and the schemas of the results
mod json_docs;

/// who may depend on whom, and what no file may hold
mod flow;
/// the commands of README.md and of the book, and their output; the catalogue of effects
mod readme;
