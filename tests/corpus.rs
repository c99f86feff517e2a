//! URDFs of real arms from public repositories (the shared data; `index.toml` holds what an
//! independent program measured on them).

use std::f64::consts::PI;
use std::path::Path;

use armident_kinematics::load_urdf;
use serde_json::Value;

use crate::shared::shared;
use crate::tool::{list, number, run, text};

/// The default tolerance of `--snap-rpy`.
const SNAPPED_RAD: f64 = 1e-4;
/// Closer than this to a multiple of π/12 an angle is that multiple as far as a rank can tell: the
/// index was made with a rank cut of 1e-9.
const EXACT_RAD: f64 = 1e-9;

fn chain(robot: &toml::Table) -> Vec<&str> {
    robot["chain_joints"].as_array().unwrap().iter().map(|j| j.as_str().unwrap()).collect()
}

/// Origin angles between base and tip that the tool takes as a multiple of π/12 and the index does
/// not: written with too few digits.
fn rounded_angles(urdf: &Path, tip: &str) -> Vec<f64> {
    let robot = load_urdf(urdf).unwrap();
    let mut link = robot.links.iter().position(|l| l.name == tip).unwrap();
    let mut rounded = Vec::new();
    while let Some(joint) = robot.joints.iter().find(|j| j.child == link) {
        for angle in joint.origin_rpy_rad {
            let off = (angle - (angle * 12.0 / PI).round() * PI / 12.0).abs();
            if off > EXACT_RAD && off < SNAPPED_RAD {
                rounded.push(angle);
            }
        }
        link = joint.parent;
    }
    rounded
}

fn params(urdf: &Path, options: &[&str]) -> Result<Value, String> {
    let ran = run(&[&["params", text(urdf), "--json", "-"], options].concat());
    match ran.code {
        0 => Ok(ran.json()),
        1 => Err(ran.stderr),
        code => panic!("{}: exit code {code}: {}", urdf.display(), ran.stderr),
    }
}

fn is_in_words(refusal: &str) -> bool {
    let rest = |start: &str| refusal.lines().find_map(|line| line.strip_prefix(start));
    ["error: ", "   in: ", " hint: "]
        .iter()
        .all(|start| rest(start).is_some_and(|words| words.split_whitespace().count() > 0))
}

/// Every URDF is read, or refused in words; the default tip is that of the index as far as the number
/// of joints goes; size and rank agree with one another, and with the index.
///
/// A size below that of the index is explained by angles of the URDF that are rounded multiples of
/// π/12: the index takes 1.5708 as it stands, so that axes are a little off parallel and constants
/// become just determinable (theory, section 7). No other difference is accepted.
#[test]
fn set_sizes_match_independent_program() {
    let Some(folder) = shared("corpus::sizes", "urdf-corpus") else { return };
    let index: toml::Table =
        std::fs::read_to_string(folder.join("index.toml")).unwrap().parse().unwrap();
    let robots = index["robot"].as_array().unwrap();
    let (mut refused, mut explained, mut unexplained, mut compared) =
        (Vec::new(), Vec::new(), Vec::new(), 0);
    for robot in robots.iter().map(|r| r.as_table().unwrap()) {
        let file = robot["file"].as_str().unwrap();
        let urdf = folder.join(file);
        let tip = robot["tip"].as_str().unwrap();
        let by_default = match params(&urdf, &[]) {
            Ok(found) => found,
            Err(said) => {
                assert!(is_in_words(&said), "{file}: {said}");
                refused.push(format!("{file}: {}", said.lines().next().unwrap_or_default()));
                continue;
            }
        };
        if by_default["n"] != chain(robot).len() {
            unexplained.push(format!("{file}: default chain of {} joints", by_default["n"]));
        }
        let found =
            params(&urdf, &["--base", robot["base"].as_str().unwrap(), "--tip", tip]).unwrap();
        assert_eq!(found["joint_names"], serde_json::json!(chain(robot)), "{file}");
        let size = list(&found["minimal"]).len();
        let rank = number(&found["rank_numeric"]);
        if found["confirmed"] != true {
            unexplained.push(format!("{file}: {size} constants, rank {rank}, not confirmed"));
        }
        let Some(expected) = robot.get("minimal_set_size_chain") else { continue };
        compared += 1;
        let expected = expected.as_integer().unwrap() as usize;
        if size == expected {
            continue;
        }
        let rounded = rounded_angles(&urdf, tip);
        let line = format!("{file}: {size}, index {expected}, rounded angles {rounded:?}");
        if size < expected && !rounded.is_empty() { &mut explained } else { &mut unexplained }
            .push(line);
    }
    println!("{compared} sizes compared; refused:\n  {}", refused.join("\n  "));
    println!("smaller than in the index, by snapping:\n  {}", explained.join("\n  "));
    assert!(unexplained.is_empty(), "{}", unexplained.join("\n"));
    assert!(compared >= 90 && refused.len() <= 1 && explained.len() <= 7);
}
