//! A model that was identified, written as URDF and MJCF, and read again.

use crate::shared::project;
use crate::tool::{list, number, read_json, run, run_in, scratch, string, text};

#[test]
fn exported_urdf_predicts_the_same_efforts() {
    let folder = scratch("export");
    let examples = project("examples/ur5");
    let (urdf, train) = (project("urdf/ur5.urdf"), examples.join("train.csv"));
    let model = folder.join("ur5.json");
    let identified =
        run(&["identify", text(&urdf), text(&train), "--save-model", text(&model), "--json", "-"])
            .fine()
            .json();
    // the model's links are real, and so are those of the file
    assert!(number(&identified["consistency"]["distance_in_standard_errors"]) < 1.0);
    let again = folder.join("ur5.urdf");
    let report = run(&["export", text(&model), "-o", text(&again), "--json", "-"]).fine().json();
    assert_eq!(report["schema"], "armident.export/1");
    assert_eq!(report["format"], "URDF");
    let lost = |report: &serde_json::Value, effect: &str| {
        list(&report["lost"]).iter().filter(|l| l["effect"] == effect).count()
    };
    assert_eq!((lost(&report, "torque_offset"), lost(&report, "rotor_inertia")), (6, 4));

    // `params` gives the same minimal set for the file as for the model
    let (one, other) = (
        run(&["params", text(&model), "--json", "-"]).fine().json(),
        run(&["params", text(&again), "--json", "-"]).fine().json(),
    );
    for (a, b) in list(&one["minimal"]).iter().zip(list(&other["minimal"])) {
        assert_eq!(a["label"], b["label"]);
        assert!((number(&a["value"]) - number(&b["value"])).abs() < 1e-6, "{a} {b}");
    }
    let unphysical = list(&other["warnings"]).iter().any(|w| string(w).contains("unphysical"));
    assert!(!unphysical, "{}", other["warnings"]);

    let mjcf = folder.join("ur5.xml");
    run(&["export", text(&model), "-o", text(&mjcf), "--json", text(&folder.join("m.json"))])
        .fine();
    let report = read_json(&folder.join("m.json"));
    assert_eq!((lost(&report, "torque_offset"), lost(&report, "rotor_inertia")), (6, 0));
    // what goes to stdout is the file
    let printed = run(&["export", text(&model), "-o", "-", "--format", "mjcf", "-q"]).fine();
    assert_eq!(printed.stdout, std::fs::read_to_string(&mjcf).unwrap());
}

#[test]
fn unknown_extension_requires_format() {
    let folder = scratch("export_format");
    let urdf = project("urdf/scara.urdf");
    let ran = run_in(&folder, &["export", text(&urdf), "-o", "scara.dae"]);
    assert_eq!(ran.code, 1);
    assert_eq!(
        ran.stderr,
        "error: cannot infer the output format from `scara.dae`\n   in: scara.dae\n hint: use the \
         extension .urdf, .xml for MJCF, .sdf, .usda, .py for Isaac Lab, or .c, or pass --format\n"
    );
    assert!(!folder.join("scara.dae").exists());
}

/// An inconsistent estimate is kept with --raw-estimate, with a note at the export.
#[test]
fn raw_estimate_skips_projection() {
    let folder = scratch("raw_estimate");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let model = folder.join("raw.json");
    let args = ["identify", text(&urdf), text(&train), "--raw-estimate", "--json", "-"];
    let found = run(&[&args[..], &["--save-model", text(&model)]].concat()).fine().json();
    assert!(found["consistency"].is_null());
    assert!(list(&found["constants"]).iter().all(|c| c["consistent"].is_null()));
    let ran = run(&["export", text(&model), "-o", text(&folder.join("raw.urdf"))]).fine();
    assert!(ran.stderr.contains("not physically consistent"), "{}", ran.stderr);
}

/// Source and header are written side by side; what they compute is tested in `armident-export`.
#[test]
fn c_source_has_its_header_beside_it() {
    let folder = scratch("export_c");
    let (urdf, source) = (project("urdf/panda.urdf"), folder.join("arm.c"));
    let report = run(&["export", text(&urdf), "-o", text(&source), "--json", "-"]).fine().json();
    assert_eq!((&report["format"], list(&report["lost"]).len()), (&"C".into(), 0));
    let header = std::path::PathBuf::from(string(&report["header"]));
    assert_eq!(header, folder.join("panda.h"));
    let written = std::fs::read_to_string(&source).unwrap();
    assert!(written.contains("#include \"panda.h\""));
    assert!(std::fs::read_to_string(header).unwrap().contains("void panda_inverse_dynamics("));
    let refused = run(&["export", text(&urdf), "-o", "-", "--format", "c"]);
    assert_eq!(refused.code, 1);
    assert_eq!(
        refused.stderr,
        "error: C source has a header beside it and cannot be written to stdout\n   in: \
         --output-file\n hint: write it to a file, such as robot.c\n"
    );
}
