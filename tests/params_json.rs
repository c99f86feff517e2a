//! `params --json`: the shared golden data's names and values.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use crate::shared::shared;
use crate::tool::{list, number, read_json, run, string, text};

/// What the golden data holds beyond the result of `params`.
const GOLDEN_ONLY: [&str; 2] = ["states", "max_difference_from_pinocchio_unsnapped"];
/// What the result of `params` holds beyond the golden data: judgements, a person's warnings, and
/// in rows the unit of a constant and the links of a body.
const OURS_ONLY: [&str; 8] = [
    "warnings",
    "ignored_elements",
    "confirmed",
    "sufficiency_error",
    "rank_smallest_kept",
    "rank_largest_dropped",
    "unit",
    "urdf_links",
];
/// Differs by nature: where the file lies, and remarks.
const NOT_COMPARED: [&str; 3] = ["schema", "urdf", "note"];

/// Field names of the result, as one path a line: what programs rely on.
const FIELDS: &str = "\
E0_in_base axis_pairs base_link child_links confirmed constants constants.U constants.k \
constants.mhat count_theorem2 delta dh dh.b dh.beta dh.d dh.joint dh.theta dh.type dropped \
gravity gravity_E0 ignored_elements joint_names links links.child_link_in_E links.com links.inertia_com \
links.mass links.urdf_links locked minimal minimal.label minimal.unit minimal.value n note r \
rank_largest_dropped rank_numeric rank_smallest_kept robot s schema sigma snap_error \
standard_parameters sufficiency_error theorem2 theorem2.item theorem2.joint theorem2.label \
theorem2.value tip_link types urdf warnings";

/// Names of objects in the result whose keys are joints or labels.
const MAPS: [&str; 4] = ["delta", "sigma", "locked", "regrouped_into"];

fn collect_fields(prefix: &str, value: &Value, into: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let path =
                    if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
                into.insert(path.clone());
                if !MAPS.contains(&name.as_str()) {
                    collect_fields(&path, value, into);
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect_fields(prefix, item, into)),
        _ => {}
    }
}

fn fields(value: &Value, left_out: &[&str]) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    collect_fields("", value, &mut all);
    all.retain(|path| !path.split('.').any(|name| left_out.contains(&name)));
    all
}

/// The names a program finds, without any shared data at hand.
#[test]
fn scara_has_all_fields() {
    let found = run(&["params", "urdf/scara.urdf", "--json", "-"]).fine().json();
    let expected: BTreeSet<String> = FIELDS.split(' ').map(str::to_owned).collect();
    assert_eq!(fields(&found, &[]), expected);
    assert_eq!(found["schema"], "armident.params/1");
    assert_eq!(found["types"], "RRPR");
    assert_eq!((&found["r"], &found["s"]), (&Value::from(1), &Value::Null));
    assert_eq!(found["delta"], serde_json::json!({"1": 0, "2": 1, "4": 1}));
    let n = found["n"].as_u64().unwrap() as usize;
    for per_joint in ["joint_names", "child_links", "dh", "links", "constants"] {
        assert_eq!(list(&found[per_joint]).len(), n, "{per_joint}");
    }
    assert_eq!(list(&found["axis_pairs"]).len(), n - 1);
    assert_eq!(list(&found["minimal"]).len(), 8);
    assert_eq!(found["warnings"], serde_json::json!([]));
    assert_eq!(found["dropped"], serde_json::json!([]));
    assert!(list(&found["minimal"]).iter().all(|c| !string(&c["unit"]).is_empty()));
}

/// Equal names, texts and shapes, numbers within the tolerance.
fn assert_alike(place: &str, found: &Value, expected: &Value, tolerance: f64) {
    match (found, expected) {
        (Value::Number(_), Value::Number(_)) => {
            let (f, e) = (number(found), number(expected));
            assert!((f - e).abs() <= tolerance, "{place}: found {f}, expected {e}");
        }
        (Value::Array(f), Value::Array(e)) => {
            assert_eq!(f.len(), e.len(), "{place}");
            for (k, (f, e)) in f.iter().zip(e).enumerate() {
                assert_alike(&format!("{place}[{k}]"), f, e, tolerance);
            }
        }
        (Value::Object(f), Value::Object(e)) => {
            for (name, e) in e {
                if GOLDEN_ONLY.contains(&name.as_str()) || NOT_COMPARED.contains(&name.as_str()) {
                    continue;
                }
                let f = f.get(name).unwrap_or_else(|| panic!("{place}: no field `{name}`"));
                assert_alike(&format!("{place}.{name}"), f, e, tolerance);
            }
            let more: Vec<&String> = f
                .keys()
                .filter(|k| !e.contains_key(*k) && !OURS_ONLY.contains(&k.as_str()))
                .collect();
            assert!(more.is_empty(), "{place}: fields beside the golden ones: {more:?}");
        }
        _ => assert_eq!(found, expected, "{place}"),
    }
}

fn check(golden_path: &Path) {
    let golden = read_json(golden_path);
    let urdf = golden_path.with_extension("urdf");
    let (base, tip) = (string(&golden["base_link"]), string(&golden["tip_link"]));
    let gravity: Vec<String> =
        list(&golden["gravity"]).iter().map(|g| number(g).to_string()).collect();
    let mut args = vec!["params", text(&urdf), "--json", "-", "--base", base, "--tip", tip];
    let gravity = gravity.join(",");
    args.extend(["--gravity", &gravity]);
    let found = run(&args).fine().json();
    let robot = string(&golden["robot"]);
    // theory, section 12
    let tolerance = if robot == "ur5" { 1e-7 } else { 1e-9 };
    assert_alike(robot, &found, &golden, tolerance);
    assert_eq!(fields(&found, &OURS_ONLY), fields(&golden, &GOLDEN_ONLY), "{robot}");
    assert_eq!(found["schema"], "armident.params/1");
    assert!(found["warnings"].is_array());
    assert_eq!(found["confirmed"], true);
}

#[test]
fn golden_arms_match() {
    let Some(folder) = shared("params_json::golden_arms", "golden") else { return };
    for arm in ["stanford", "puma560", "scara", "gantry", "ur5", "panda"] {
        check(&folder.join(format!("{arm}.json")));
    }
}
