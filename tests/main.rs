//! The acceptance suite. One binary; each module is one promise of the tool.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failed test may panic"
)]

/// location of the optional shared data, and reports of skipped tests
mod shared;
/// runs the program: exit code, stdout, stderr, result files
mod tool;

/// chain, constants, minimal set and states against numbers of an independent program
mod golden;

/// the arms of `urdf/`: the printed page of each, poses against the URDF, the table of its README
mod arms;
/// a hundred URDFs of real arms: read or rejected with a message; set sizes of an independent program
mod corpus;
/// `params --json`: field names and values of the shared golden data
mod params_json;

/// exit codes, streams, and messages of eighty wrong command lines
mod cli;
/// no bytes in any input file make the program panic
mod no_panic;
/// the steps of `armident.toml`
mod run;

/// generated cases, their diagnosis and score
mod challenge;
/// `check` on recordings with and without faults
mod check;
/// an arm of MuJoCo from its commands, and back
mod commands;
/// two results side by side, and the model card
mod comparison;
/// a fixed small sample of the coverage study
mod coverage;
/// the demo without input files; completions and manual pages
mod demo;
/// hidden effects are found and located, absent effects are not, and the model predicts
mod diagnose;
/// the suite of motions of `excite`, recorded in simulation and identified
mod excite;
/// models as URDF and MJCF, and effects that these formats do not support
mod export;
/// a law added from outside the crates
mod extend;
/// an estimator from outside the library
mod extend_estimator;
/// a log format of another crate
mod extend_format;
/// reproductions of users' reports
mod field;
/// robots of a fleet over their recordings
mod fleet;
/// MCAP compared with CSV
mod formats;
/// logs with other names: what they hold, the guessed mapping, conversions
mod info;
/// states of recordings, merged
mod merge;
/// pages of results in a browser
mod page;
/// exported URDF and MJCF in Pinocchio and MuJoCo
mod peers;
/// plan, simulate, identify, predict: the simulated parameters are recovered
mod pipeline;
/// public recordings of real arms: rank, error against plain least squares, rejected inputs
mod real_data;
/// recordings beside predictions, as topics of MCAP
mod topics;

/// a section of a diagnosis that this file adds
mod extend_section;
/// `docs/json.md` and the schemas of the results
mod json_docs;

/// figures in prose and the tables they come from
mod figures;
/// dependencies between crates, and forbidden content of files
mod flow;
/// the commands of README.md and of the book, and their output; the catalogue of effects
mod readme;
/// the structure inside crates: rooms, circles, names, sources of methods
mod rooms;
/// names of laws stand in one crate
mod slugs;
/// the vocabulary of text and code
mod words;
