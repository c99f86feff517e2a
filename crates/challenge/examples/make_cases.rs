//! Makes cases: `make_cases --cases N --seed S --kind field|clean|null [--effect SLUG] [--robot NAME]
//! [--perturbed] -o DIR`.
//!
//! Robots are the arms of `urdf/`; without `--effect` every effect of the library takes its turn.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "it is a command")]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armident_challenge::{CaseKind, CaseRequest, ChallengeError, case_effects, generate};

/// Arms whose joints load one another enough for every kind of effect.
const ROBOTS: [&str; 10] = [
    "ur5",
    "panda",
    "stanford",
    "scara",
    "iiwa14",
    "puma560",
    "tx40",
    "ur10",
    "kinova_gen3",
    "gantry",
];

struct Arguments {
    cases: u64,
    seed: u64,
    kind: String,
    effect: Option<String>,
    robot: Option<String>,
    perturbed: bool,
    output: PathBuf,
}

fn arguments() -> Option<Arguments> {
    let mut given = Arguments {
        cases: 1,
        seed: 1,
        kind: "clean".to_owned(),
        effect: None,
        robot: None,
        perturbed: false,
        output: PathBuf::new(),
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--cases" => given.cases = words.next()?.parse().ok()?,
            "--seed" => given.seed = words.next()?.parse().ok()?,
            "--kind" => given.kind = words.next()?,
            "--effect" => given.effect = words.next(),
            "--robot" => given.robot = words.next(),
            "--perturbed" => given.perturbed = true,
            "-o" => given.output = words.next()?.into(),
            _ => return None,
        }
    }
    let known = matches!(given.kind.as_str(), "clean" | "field" | "null");
    (known && !given.output.as_os_str().is_empty()).then_some(given)
}

fn main() -> ExitCode {
    let Some(given) = arguments() else {
        eprintln!(
            "usage: make_cases --cases N --seed S --kind field|clean|null [--effect SLUG] \
             [--robot NAME] [--perturbed] -o DIR"
        );
        return ExitCode::from(2);
    };
    for k in 0..given.cases {
        let started = std::time::Instant::now();
        // an arm that does not show the effect makes place for the next
        let tried = (0..ROBOTS.len()).map(|turn| one(&given, k, turn));
        let usable = |tried: &Result<String, ChallengeError>| {
            !matches!(tried, Err(ChallengeError::Invisible { .. } | ChallengeError::Simulation(_)))
        };
        match tried.take(if given.robot.is_some() { 1 } else { ROBOTS.len() }).find(usable) {
            Some(Ok(line)) => println!("{line} ({:.1} s)", started.elapsed().as_secs_f64()),
            Some(Err(error)) => {
                eprintln!("error: case {k}: {error}\n  in: {}", error.place());
                return ExitCode::FAILURE;
            }
            None => eprintln!("error: case {k}: no arm shows its effects"),
        }
    }
    ExitCode::SUCCESS
}

fn one(given: &Arguments, k: u64, turn: usize) -> Result<String, ChallengeError> {
    let seed = given.seed.wrapping_mul(1_000_003).wrapping_add(k);
    let robot = match &given.robot {
        Some(robot) => robot.as_str(),
        None => ROBOTS[(seed as usize + turn) % ROBOTS.len()],
    };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf").join(robot);
    let file = file.with_extension("urdf");
    let robot_urdf = std::fs::read_to_string(&file).map_err(|error| ChallengeError::Io {
        doing: "read",
        path: file,
        error,
    })?;
    let field = given.kind == "field" || (given.kind == "null" && k % 2 == 1);
    let kind = if field { CaseKind::Field } else { CaseKind::Clean };
    let effects = match &given.effect {
        _ if given.kind == "null" => Vec::new(),
        Some(effect) => vec![effect.clone()],
        None => case_effects(kind, seed),
    };
    let name = format!("{}{:04}", &given.kind[..1], k + 1);
    let request = CaseRequest {
        name: name.clone(),
        robot: robot.to_owned(),
        robot_urdf,
        seed,
        kind,
        // nulls take turns: exact, field, inertial errors alone, field
        background: match (given.kind.as_str(), k % 4) {
            ("null", 0) => Some(0.0),
            ("null", 2) => Some(0.03),
            _ => None,
        },
        perturbed: given.perturbed,
        effects,
    };
    let case = generate(&request)?;
    case.write(&given.output.join(&name))?;
    let seen: Vec<String> = case
        .truth
        .effects
        .iter()
        .map(|e| format!("{} margin {:.1}", e.effect, e.naming_margin.unwrap_or_default()))
        .collect();
    Ok(format!(
        "{name} {robot}: {}",
        if seen.is_empty() { "null".to_owned() } else { seen.join(", ") }
    ))
}
