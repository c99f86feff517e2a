//! Pages in a browser: they open without a network and without an error, and every chart is drawn.
//!
//! Needs Chromium with its driver and Python. Without them the browser's part is skipped, and says so.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::shared::{project, skipped};
use crate::tool::{list, number, read_json, run, scratch, string, text};

const TRAIN: &str = "examples/ur5/train.csv";
const HOLDOUT: &str = "examples/ur5/holdout.csv";

/// Whether a program starts.
fn there(program: &str) -> bool {
    let version = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    version.is_ok_and(|v| v.status.success())
}

/// A page of every kind, in one folder.
fn pages(folder: &Path) -> Vec<String> {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let urdf = "urdf/ur5.urdf";
    let model = path("ur5.json");
    let (diagnosis, params) = (path("diagnosis.json"), path("params.json"));
    run(&[
        "identify",
        urdf,
        TRAIN,
        "--holdout",
        HOLDOUT,
        "--save-model",
        &model,
        "--report",
        &path("identify.html"),
    ])
    .fine();
    run(&["validate", &model, HOLDOUT, "--no-replay", "--report", &path("validate.html")]).fine();
    let wrong = "examples/ur5/wrong.toml";
    run(&["check", urdf, TRAIN, "--mapping", wrong, "--report", &path("check.html")]).fine();
    run(&[
        "diagnose",
        urdf,
        TRAIN,
        "--holdout",
        HOLDOUT,
        "--json",
        &diagnosis,
        "--traces",
        "--report",
        &path("diagnose.html"),
    ])
    .fine();
    // a result without what is drawn, and one that has no page of its own
    let mut plain = read_json(Path::new(&diagnosis));
    plain.as_object_mut().unwrap().remove("drawing").unwrap();
    std::fs::write(path("plain.json"), plain.to_string()).unwrap();
    run(&["params", urdf, "--json", &params]).fine();
    // a scoreboard at once, and again from its JSON
    let board = path("board.json");
    let args =
        ["challenge", "--cases", "2", "--seed", "3", "--kind", "clean", "--robot", "scara", "-q"];
    run(&[&args[..], &["--json", &board, "--report", &path("at_once.html")]].concat()).fine();
    let at_once = std::fs::read_to_string(path("at_once.html")).unwrap();
    assert!(at_once.contains("armident challenge --cases 2 --seed 3"));
    for (result, page) in
        [("plain.json", "plain.html"), ("params.json", "params.html"), ("board.json", "board.html")]
    {
        run(&["report", &path(result), "-o", &path(page)]).fine();
    }
    ["identify", "validate", "check", "diagnose", "plain", "params", "board"]
        .map(|name| format!("{name}.html"))
        .to_vec()
}

fn size(path: &Path) -> u64 {
    path.metadata().unwrap().len()
}

#[test]
fn every_page_opens_in_browser() {
    let folder = scratch("page");
    let pages = pages(&folder);
    for page in &pages {
        let path = folder.join(page);
        assert!((1_500_000..3_000_000).contains(&size(&path)), "{page}: {}", size(&path));
        let html = std::fs::read_to_string(&path).unwrap();
        // nothing is loaded from anywhere
        for attribute in ["src=", "href=\"http", "url(", "@import"] {
            assert!(!html.contains(attribute), "{page} holds {attribute}");
        }
    }
    let missing: Vec<&str> =
        ["chromium", "chromedriver", "python3"].into_iter().filter(|p| !there(p)).collect();
    if !missing.is_empty() {
        skipped("page", &format!("no {} here", missing.join(", ")));
        return;
    }
    let output = Command::new("python3")
        .arg(project("tests/page.py"))
        .arg(&folder)
        .args(&pages)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
    let seen: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(seen.len(), pages.len(), "{said}");
    for page in &seen {
        assert_eq!(page["ready"], true, "{page}");
        assert!(list(&page["errors"]).is_empty(), "{page}");
        assert!(list(&page["requests"]).is_empty(), "{page}");
        assert_eq!(page["drawn"], page["charts"], "{page}");
        // nothing is wider than a phone
        assert!(number(&page["overflow"]) <= 0.0, "{page}");
        let charts = number(&page["charts"]);
        match string(&page["page"]) {
            "params.html" => assert_eq!(charts, 0.0, "{page}"),
            // errors, what the residual of each joint goes with, how far the constants are off
            "plain.html" => assert_eq!(charts, 8.0, "{page}"),
            // reliability, confusion, errors over their floors
            "board.html" => {
                assert_eq!(charts, 3.0, "{page}");
                assert_eq!(page["hovered"], true, "{page}");
            }
            // six joints with at least three charts each, the arm, the errors over time
            name => {
                if name == "diagnose.html" {
                    // a finding that is clicked lights its joint, its regime and its time range
                    let lit = list(&page["lit"]);
                    let (title, shown) = (string(&lit[1]), string(&lit[2]));
                    assert!(shown.starts_with(title) && lit[4] == true, "{page}");
                    assert_eq!(lit[0], true, "no cell of a residual map is framed: {page}");
                    assert!(shown.contains("; regime: ") && shown.contains("; acts "), "{page}");
                }
                assert!(charts >= 20.0, "{page}");
                assert_eq!(page["hovered"], true, "{page}");
            }
        }
    }
}

/// `--report` and `report` of the same result with its traces draw the same page.
#[test]
fn report_option_equals_report_command() {
    let folder = scratch("page_both");
    let path = |name: &str| -> PathBuf { folder.join(name) };
    let (json, at_once, later) = (path("v.json"), path("at_once.html"), path("later.html"));
    run(&[
        "validate",
        "urdf/ur5.urdf",
        HOLDOUT,
        "--no-replay",
        "--json",
        text(&json),
        "--traces",
        "--report",
        text(&at_once),
    ])
    .fine();
    let said = run(&["report", text(&json), "-o", text(&later)]).fine();
    assert!(said.stdout.starts_with("wrote "), "{}", said.stdout);
    assert_eq!(std::fs::read(at_once).unwrap(), std::fs::read(later).unwrap());
    let drawing = &read_json(&json)["drawing"];
    // the bytes that were read are named by their digest
    let inputs = list(&drawing["provenance"]["inputs"]);
    assert_eq!(inputs.len(), 2);
    assert!(inputs.iter().all(|i| string(&i["sha256"]).len() == 64));
}

/// The page names the heavier forearm and how large it is, and no peak of the recording is lost in it.
#[test]
fn drawing_contains_the_recording() {
    let folder = scratch("page_drawing");
    let json = folder.join("d.json");
    run(&["diagnose", "urdf/ur5.urdf", TRAIN, "--json", text(&json), "--traces"]).fine();
    let result = read_json(&json);
    let drawing = &result["drawing"];
    let findings = list(&result["findings"]);
    assert_eq!(list(&drawing["findings"]).len(), findings.len());
    let forearm = findings.iter().position(|f| f["link"] == "link_3").unwrap();
    let traces = &drawing["findings"][forearm];
    // the elbow's efforts show the missing 0.6 kg as the slope over the effort of one kilogram
    let view = list(&traces["views"]).iter().find(|view| view["joint"] == 2).unwrap();
    let column =
        |name: &str| -> Vec<Option<f64>> { list(&view[name]).iter().map(Value::as_f64).collect() };
    let points: Vec<(f64, f64)> =
        column("x").iter().zip(column("law")).filter_map(|(x, y)| Some(((*x)?, y?))).collect();
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
    // of a link named beside exact ones the view holds its first moment too
    assert!((0.3..0.9).contains(&slope), "{slope}");
    let [without, with] = [0, 1].map(|k| number(&traces["joints"][2][k]));
    assert!(without > 5.0 * with, "{without} {with}");
    // the largest recorded effort of every joint is in the drawing
    let recorded = armident_recording::read_csv(project(TRAIN)).unwrap();
    for (joint, drawn) in recorded.joints.iter().zip(list(&drawing["recordings"][0]["joints"])) {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let kept: Vec<f64> = list(&drawn["measured"]).iter().map(number).collect();
        let recorded = largest(joint.effort.as_ref().unwrap());
        assert!((largest(&kept) / recorded - 1.0).abs() < 1e-4, "{}", joint.name);
    }
}

#[test]
fn rejects_files_that_are_no_result() {
    let folder = scratch("page_refused");
    let (bad, other) = (folder.join("bad.json"), folder.join("other.json"));
    std::fs::write(&bad, "{\n\"a\": \n").unwrap();
    std::fs::write(&other, "{\"schema\": \"somebody/1\"}").unwrap();
    for (file, expected) in [(&bad, "bad.json, line"), (&other, "`somebody/1`")] {
        let failed = run(&["report", text(file), "-o", text(&folder.join("page.html"))]);
        assert_eq!(failed.code, 1);
        assert!(failed.stderr.contains(expected), "{}", failed.stderr);
        assert_eq!(failed.stderr.lines().count(), 3, "{}", failed.stderr);
    }
    // a field of another form is told, and no page is written
    std::fs::write(&other, "{\"schema\": \"armident.validate/1\", \"joints\": 3}").unwrap();
    let failed = run(&["report", text(&other), "-o", text(&folder.join("page.html"))]);
    assert!(failed.stderr.contains("not of the form"), "{}", failed.stderr);
    assert!(!folder.join("page.html").exists());
}

/// Results with the keys of schema 1 have pages with all that they hold.
#[test]
fn older_results_are_rendered() {
    let folder = scratch("page_older");
    let (result, page) = (folder.join("result.json"), folder.join("page.html"));
    let diagnosis = r#"{"schema": "armident.diagnosis/1", "robot": "arm", "joints": ["elbow", "wrist"],
        "verdict": "mismatch", "recordings": ["train.csv"], "holdout_recordings": [],
        "reference_recordings": ["before.csv"], "inertial_error": 0.05, "inertias_matter_on": ["elbow"],
        "books": {"faults": [], "drive_gains": [], "unchecked": "no gravity"},
        "findings": [{"effect": "coulomb_friction", "joints": ["elbow"], "link": null, "window": null,
            "recording": null, "parameters": {"level": {"value": 2.5, "stderr": 0.1, "unit": "N m"}},
            "confidence": 0.97, "confirmed": null,
            "evidence": {"materiality": 3, "least_materiality": 0.61, "joint": "elbow"},
            "alternatives": [{"effect": "torque_offset", "joints": ["elbow"], "link": null, "left_more": 0.13,
                "separated_by": null}]}],
        "effort_noise": {"elbow": 0.1}, "links_off_standard_errors": 1.75, "narrowed_to_hz": 5.0,
        "small_terms": [{"effect": "viscous_friction", "joint": "wrist",
            "parameters": {"coefficient": {"value": 0.31, "unit": "N m s/rad"}}}],
        "friction_fades_below": {"elbow": 0.29}, "friction_builds_up_over": {"wrist": 0.0014},
        "friction_bends": {"elbow": 7.5}, "beyond_reference": {"elbow": 1.2},
        "doubtful_changes": [{"effect": "torque_ripple", "joints": ["wrist"], "link": null, "chance": 0.03,
            "maybe_before": false}],
        "atlas": [{"joint": "elbow", "before": 4, "rigid": 3, "after": 1, "noise": 0.2, "whiteness_p": 0.5,
            "symmetries": [{"function": "sign(v)", "share_before": 0.9, "share_after": 0,
                "points_to": "Coulomb friction"}], "regimes": []}],
        "unexplained": ["elbow"],
        "placebo": {"terms": 20, "improve": 3, "named": 0, "largest": 0.49},
        "next_motion": {"file": "next.csv", "description": "elbow oscillates", "told_apart": 1, "pairs": 2,
            "separation": 4.5},
        "constants": [{"label": "U1_33", "joint": "elbow", "unit": "kg m2", "value": 1.5, "standard_error": 0.1,
            "interval_95": [1.3, 1.7], "urdf": 1.0, "from_prior": 0.4}],
        "warnings": []}"#;
    let identified = r#"{"schema": "armident.identify/1", "method": "batch", "estimator": "irls", "robot": "arm",
        "joints": ["elbow"], "unknowns": 3, "rank": 2, "independent_share": 0.1, "not_essential": ["U1_33"],
        "loads": [{"recordings": ["a.csv"], "mass_kg": 2, "centre_m": [0, 0, 0.1], "found": true}],
        "constants": [{"label": "U1_33", "joint": "elbow", "unit": "kg m2", "value": 1.5, "standard_error": 0.1,
            "interval_95": [1.3, 1.7], "urdf": 1.0, "consistent": 1.4, "from_prior": 0.4, "undetermined": 0}]}"#;
    let checked = r#"{"schema": "armident.check/1", "robot": "arm", "joints": ["elbow"], "rank": 2, "unknowns": 3,
        "verdict": "cannot_tell", "checks": [{"topic": "channel", "joint": "elbow", "verdict": "cannot_tell",
            "value": null, "unit": "", "interval_95": null, "message": "dead zone", "advice": "move it"}]}"#;
    for (document, expected) in [
        (
            diagnosis,
            &[
                "1 change since the reference",
                "Residual up to 5 times the noise on elbow",
                "Input checks skipped: no gravity.",
                "(threshold 0.61)",
                "the residual is only 0.13 noise levels larger",
                "viscous friction: wrist 0.31 N m s/rad",
                "about 5 % (prior scale), which is material on elbow",
                "1.75 standard errors from the estimate",
                "Comparison bandwidth reduced to 5 Hz",
                "regularised (linear in speed) below: elbow 0.29 rad or m/s",
                "over this travel after a reversal: wrist 0.0014 rad or m",
                "c = elbow 7.5 N m or N",
                "Reference maximum speed: elbow 1.2 rad or m/s",
                "torque ripple on wrist (p = 0.03)",
                "of 20 wrong terms, 3 lower the cross-validated error and 0 would be reported",
                "It separates 1 of 2 pairs of alternatives",
                "sign(v) explains 90 % of the residual variance (Coulomb friction)",
                "40 % prior",
            ][..],
        ),
        (
            identified,
            &[
                "2 of 3 parameters are identified",
                "effective sample size 10 %",
                "Payload of 2 kg in a.csv, centre of mass estimated at (0.0000, 0.0000, 0.1000) m",
                "2 of 3 parameters are significant",
                "40 % prior",
            ][..],
        ),
        (checked, &["2 of 3 parameters", "inconclusive", "effort column"][..]),
    ] {
        std::fs::write(&result, document).unwrap();
        run(&["report", text(&result), "-o", text(&page)]).fine();
        let html = std::fs::read_to_string(&page).unwrap().replace("&#39;", "'");
        for expected in expected {
            assert!(html.contains(expected), "{expected} is not on the page");
        }
    }
}

/// A hold-out too short to judge whiteness, a replay that never came to its end: `null` in the results, and no
/// fault of theirs.
#[test]
fn unidentified_parameters_are_shown() {
    let folder = scratch("page_null");
    let (result, page) = (folder.join("result.json"), folder.join("page.html"));
    let diagnosis = r#"{"schema": "armident.diagnosis/1", "robot": "arm", "joints": ["elbow"],
        "sentence": "the recordings show nothing", "effort_noise": {"elbow": 0.1},
        "whiteness_p": {"elbow": null},
        "replay": {"window_s": 0.5, "before": {"elbow": null}, "after": {"elbow": 0.25}}}"#;
    let validated = r#"{"schema": "armident.validate/1", "joints": ["elbow"],
        "after": {"elbow": {"rmse": 1, "relative": 0.1, "rmse_raw": 1, "whiteness_p": null}},
        "replay_before": {"window_s": 0.5, "windows": 0, "diverged": 2,
                          "position_rms": {"elbow": null}, "velocity_rms": {"elbow": null}}}"#;
    for document in [diagnosis, validated] {
        std::fs::write(&result, document).unwrap();
        run(&["report", text(&result), "-o", text(&page)]).fine();
        assert!(std::fs::read_to_string(&page).unwrap().contains("elbow"));
        std::fs::remove_file(&page).unwrap();
    }
}
