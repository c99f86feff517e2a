//! Scores diagnoses: `score_cases CASES_DIR RESULTS_DIR [--json FILE]`.
//!
//! `CASES_DIR/<case>/truth.json` is compared with `RESULTS_DIR/<case>/out.json` and `predicted.csv`.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "it is a command")]

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (cases, results, json) = match words[..] {
        [cases, results] => (cases, results, None),
        [cases, results, "--json", file] => (cases, results, Some(file)),
        _ => {
            eprintln!("usage: score_cases CASES_DIR RESULTS_DIR [--json FILE]");
            return ExitCode::from(2);
        }
    };
    let board = match armident_challenge::score_cases(Path::new(cases), Path::new(results)) {
        Ok(board) => board,
        Err(error) => {
            eprintln!("error: {error}\n  in: {}", error.place());
            if let Some(hint) = error.hint() {
                eprintln!("  hint: {hint}");
            }
            return ExitCode::FAILURE;
        }
    };
    print!("{}", board.text());
    if let Some(file) = json {
        let written = serde_json::to_string_pretty(&board)
            .map_err(std::io::Error::from)
            .and_then(|text| std::fs::write(file, text));
        if let Err(error) = written {
            eprintln!("error: the scoreboard cannot be written: {error}\n  in: {file}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
