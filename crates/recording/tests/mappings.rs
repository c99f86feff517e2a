//! Mapping files: conversions, error messages, and no panics.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::PathBuf;

use armident_recording::{
    Mapping, Quantity, RawColumns, Recording, RecordingError, read_csv, read_csv_from,
    read_csv_mapped, read_csv_mapped_from,
};
use proptest::prelude::*;

#[path = "../../../tests/shared.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "a test file: each binary uses its part")]
mod shared;

fn stamps() -> Vec<f64> {
    (0..10).map(|k| 0.01 * f64::from(k)).collect()
}

fn mapping(text: &str) -> Mapping {
    Mapping::parse(text, "arm.toml").unwrap()
}

/// A recording of one column `x` that is this value throughout.
fn constant(rule: &str, value: f64) -> Result<Recording, RecordingError> {
    let text = format!("[[channel]]\ncolumn = \"x\"\njoint = \"elbow\"\n{rule}");
    let raw = RawColumns::new("run").with("t", stamps()).with("x", vec![value; 10]);
    Mapping::parse(&text, "arm.toml")?.apply(&raw)
}

#[test]
fn units_gains_gears_and_constants() {
    for (rule, value, expected) in [
        ("quantity = \"position\"", 0.5, 0.5),
        ("quantity = \"position\"\nunit = \"deg\"", 90.0, PI / 2.0),
        ("quantity = \"position\"\nunit = \"turn\"", 0.25, PI / 2.0),
        ("quantity = \"position\"\nunit = \"m\"", 0.4, 0.4),
        ("quantity = \"position\"\nunit = \"mm\"", 40.0, 0.04),
        ("quantity = \"position\"\nunit = \"deg\"\nsign = -1\noffset = 1.0", 90.0, 1.0 - PI / 2.0),
        (
            "quantity = \"position\"\nunit = \"counts\"\ncounts_per_turn = 4096\ngear_ratio = 100",
            1024.0 * 100.0,
            PI / 2.0,
        ),
        ("quantity = \"position\"\nunit = \"counts\"\ngain = 1e-6", 5e5, 0.5),
        ("quantity = \"motor_position\"\ngear_ratio = -50", 25.0, -0.5),
        ("quantity = \"velocity\"\nunit = \"deg/s\"", 180.0, PI),
        ("quantity = \"velocity\"\nunit = \"rpm\"\ngear_ratio = 100", 3000.0, PI),
        ("quantity = \"velocity\"\nunit = \"turn/s\"", 0.5, PI),
        ("quantity = \"velocity\"\nunit = \"mm/s\"", 250.0, 0.25),
        ("quantity = \"velocity\"\nunit = \"counts/s\"\ncounts_per_turn = 1000", 500.0, PI),
        ("quantity = \"acceleration\"\nunit = \"deg/s²\"", 180.0, PI),
        ("quantity = \"effort\"", 3.0, 3.0),
        ("quantity = \"effort\"\nunit = \"N mm\"", 250.0, 0.25),
        ("quantity = \"effort\"\nunit = \"mNm\"", 250.0, 0.25),
        ("quantity = \"effort\"\nunit = \"N\"\nsign = -1", 250.0, -250.0),
        ("quantity = \"effort\"\nunit = \"Nm\"\ngear_ratio = 100", 0.25, 25.0),
        ("quantity = \"effort\"\nunit = \"A\"\ngain = -8.7", 2.0, -17.4),
        ("quantity = \"effort\"\nunit = \"mA\"\ngain = -8.7", 2000.0, -17.4),
        (
            "quantity = \"effort\"\nunit = \"A\"\ntorque_constant = 0.12\ngear_ratio = 100\nsign = -1",
            1.5,
            -18.0,
        ),
        (
            "quantity = \"effort\"\nunit = \"V\"\ntorque_constant = 0.5\nresistance_ohm = 2\n\
             gear_ratio = 3",
            4.0,
            3.0,
        ),
        ("quantity = \"effort\"\nunit = \"counts\"\ngain = 0.01", 250.0, 2.5),
        ("quantity = \"current\"\nunit = \"mA\"", 250.0, 0.25),
        ("quantity = \"voltage\"\nunit = \"mV\"\nsign = -1", 250.0, -0.25),
        ("quantity = \"voltage\"\nunit = \"counts\"\ngain = 0.008361581920903955", 885.0, 7.4),
        ("quantity = \"temperature\"", 28.0, 28.0),
        ("quantity = \"temperature\"\nunit = \"K\"", 300.0, 26.85),
    ] {
        let recording = constant(rule, value).unwrap();
        let (quantity, values) = recording.joints[0].channels().next().unwrap();
        assert!(rule.contains(quantity.suffix()), "{rule}");
        assert!(
            (values[3] - expected).abs() < 1e-12 * expected.abs().max(1.0),
            "{rule}: {values:?}"
        );
    }
}

#[test]
fn units_of_time() {
    for (unit, per_s) in [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("µs", 1e6), ("ns", 1e9)] {
        let text = format!(
            "[time]\ncolumn = \"clock\"\nunit = \"{unit}\"\n[[channel]]\ncolumn = \"{{joint}}/{{quantity}}\""
        );
        let clock = stamps().iter().map(|t| (t + 5.0) * per_s).collect();
        let raw = RawColumns::new("run").with("clock", clock).with("elbow/position", vec![0.5; 10]);
        let recording = mapping(&text).apply(&raw).unwrap();
        for (got, t) in recording.time_s.iter().zip(stamps()) {
            assert!((got - t - 5.0).abs() < 1e-12, "{unit}");
        }
    }
}

#[test]
fn back_emf_is_subtracted_on_request() {
    let text = |back_emf: &str| {
        format!(
            "[[channel]]\ncolumn = \"pwm\"\njoint = \"servo\"\nquantity = \"effort\"\nunit = \"V\"\n\
             torque_constant = 0.3\nresistance_ohm = 2.0\ngear_ratio = 10\nsign = -1\n{back_emf}\n\
             [[channel]]\ncolumn = \"{{joint}}/velocity\""
        )
    };
    let raw = RawColumns::new("run")
        .with("t", stamps())
        .with("pwm", vec![4.0; 10])
        .with("servo/velocity", vec![0.5; 10]);
    let effort = |text: &str| {
        let recording = mapping(text).apply(&raw).unwrap();
        (recording.joints[0].effort.as_ref().unwrap()[0], recording.notes)
    };
    let (without, notes) = effort(&text(""));
    assert!((without + 10.0 * 0.3 / 2.0 * 4.0).abs() < 1e-12);
    assert_eq!(
        notes,
        [
            "effort of servo computed from voltage; back-EMF appears as viscous friction of 4.5000 N m \
          s/rad"
        ]
    );
    let (with, notes) = effort(&text("back_emf = true"));
    assert!((with - (without - 4.5 * 0.5)).abs() < 1e-12);
    assert!(notes.is_empty());
}

#[test]
fn coupled_motors_give_joint_channels() {
    let text = r#"
        [[channel]]
        column = "{joint}.q"
        quantity = "position"
        [[channel]]
        column = "{joint}.v"
        quantity = "velocity"
        [[channel]]
        column = "{joint}.i"
        quantity = "effort"
        unit = "A"
        gain = 0.12
        [[coupling]]
        joints = ["joint_5", "joint_6"]
        motors = ["m5", "m6"]
        matrix = [[45, 0], [32, 32]]
        offset = [0, 0.5]
    "#;
    let column = |f: fn(f64) -> f64| stamps().into_iter().map(f).collect::<Vec<f64>>();
    let raw = RawColumns::new("run")
        .with("t", stamps())
        .with("j1.q", column(|t| 2.0 * t))
        .with("m5.q", column(|t| 45.0 * t))
        .with("m6.q", column(|t| 32.0 * (t - 0.3)))
        .with("m5.v", column(|_| 45.0))
        .with("m6.v", column(|t| 32.0 * (1.0 + t)))
        .with("m5.i", column(|t| 1.0 + t))
        .with("m6.i", column(|t| 2.0 - t));
    let recording = mapping(text).apply(&raw).unwrap();
    assert_eq!(recording.joint_names(), ["j1", "joint_5", "joint_6"]);
    let of = |joint: &str, quantity| recording.joint(joint).unwrap().channel(quantity).unwrap();
    for (k, t) in stamps().into_iter().enumerate() {
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");
        near(of("joint_5", Quantity::Position)[k], t);
        near(of("joint_6", Quantity::Position)[k], 0.5 - 0.3);
        near(of("joint_6", Quantity::Velocity)[k], t);
        near(of("joint_5", Quantity::Effort)[k], 0.12 * (45.0 * (1.0 + t) + 32.0 * (2.0 - t)));
        let power = |a: (f64, f64), b: (f64, f64)| a.0 * b.0 + a.1 * b.1;
        let joints = |q| (of("joint_5", q)[k], of("joint_6", q)[k]);
        near(
            power(joints(Quantity::Velocity), joints(Quantity::Effort)),
            power((45.0, 32.0 * (1.0 + t)), (0.12 * (1.0 + t), 0.12 * (2.0 - t))),
        );
    }
}

#[test]
fn placeholders_match_joints_and_quantities() {
    let raw = RawColumns::new("run")
        .with("time", stamps())
        .with("q1_deg", vec![90.0; 10])
        .with("q2_deg", vec![-90.0; 10])
        .with("elbow_motor_position", vec![0.1; 10])
        .with("", vec![0.0; 10])
        .with("fan", vec![0.0; 10]);
    let text = r#"
        [[channel]]
        column = "{joint}_{quantity}"
        [[channel]]
        column = "q{joint}_deg"
        joint = "joint_{joint}"
        quantity = "position"
        unit = "deg"
        sign = { joint_2 = -1 }
    "#;
    let recording = mapping(text).apply(&raw).unwrap();
    assert_eq!(recording.joint_names(), ["joint_1", "joint_2", "elbow"]);
    let first = |k: usize| recording.joints[k].channels().next().unwrap();
    assert_eq!(first(0).1[0], first(1).1[0]);
    assert_eq!(first(2).0, Quantity::MotorPosition);
    assert_eq!(recording.ignored_columns, ["(column 5 has no name)", "fan"]);
    assert_eq!(recording.notes, ["ignored columns: (column 5 has no name), fan"]);
}

#[test]
fn rows_are_sorted_on_request() {
    let mut t = stamps();
    t.swap(4, 5);
    let raw = RawColumns::new("run").with("t", t.clone()).with("a/position", t);
    let plain = mapping("[[channel]]\ncolumn = \"{joint}/{quantity}\"");
    assert!(plain.apply(&raw).unwrap_err().to_string().starts_with("time stamps decrease"));
    let sorting = mapping("[time]\nsort = true\n[[channel]]\ncolumn = \"{joint}/{quantity}\"");
    let recording = sorting.apply(&raw).unwrap();
    assert_eq!(recording.joints[0].position.as_ref(), Some(&recording.time_s));
    assert_eq!(
        recording.notes,
        ["time stamps decrease 1 time in 10 samples, first to t = 0.04 s; rows sorted"]
    );
}

#[test]
fn plotjuggler_exports_need_no_mapping() {
    let rows: String = stamps().iter().map(|t| format!("{},{t},1,2,3,x\n", 1.7e9 + t)).collect();
    let read = |header: &str| read_csv_from(format!("{header}\n{rows}").as_bytes(), "pj.csv");
    let recording = read(
        "__time,/joint_states/elbow/position,/joint_states/elbow/velocity,\
         /joint_states/wrist/effort,/command/elbow/position,/rosout/msg",
    )
    .unwrap();
    assert_eq!(recording.joint_names(), ["elbow", "wrist"]);
    assert_eq!(recording.joints[0].velocity.as_ref().unwrap()[0], 1.0);
    assert_eq!(recording.ignored_columns, ["/command/elbow/position", "/rosout/msg"]);
    assert_eq!(
        recording.notes,
        [
            "PlotJuggler export: time from `__time`, joints from topic /joint_states",
            "ignored columns: /command/elbow/position, /rosout/msg",
        ]
    );
    let recording = read("time,/arm/states/elbow/position,/arm/states/elbow/effort,a,b,c").unwrap();
    assert_eq!(recording.joint_names(), ["elbow"]);
    let error = read("time,/left/elbow/position,/right/elbow/position,a,b,c").unwrap_err();
    assert_eq!(error.to_string(), "several topics have joints: /left, /right");
    assert_eq!(error.place(), "pj.csv, line 1");
    assert_eq!(
        error.hint().unwrap(),
        "choose one in a mapping file: `column = \"/left/{joint}/{quantity}\"`"
    );
    // as does this advice
    let chosen = mapping("[[channel]]\ncolumn = \"/left/{joint}/{quantity}\"");
    let text = format!("time,/left/elbow/position,/right/elbow/position,a,b,c\n{rows}");
    let recording = read_csv_mapped_from(text.as_bytes(), "pj.csv", &chosen).unwrap();
    assert_eq!(recording.joint_names(), ["elbow"]);
}

fn message(error: &RecordingError) -> String {
    let hint = error.hint().map_or(String::new(), |hint| format!(" hint: {hint}\n"));
    format!("error: {error}\n   in: {}\n{hint}", error.place())
}

#[test]
fn messages_of_invalid_mappings() {
    let channel = |keys: &str| format!("[[channel]]\ncolumn = \"q1\"\njoint = \"elbow\"\n{keys}");
    let position = |keys: &str| channel(&format!("quantity = \"position\"\n{keys}"));
    let effort = |keys: &str| channel(&format!("quantity = \"effort\"\n{keys}"));
    let coupling = |keys: &str| format!("{}\n[[coupling]]\n{keys}", position(""));
    let of_files = [
        ("nothing", String::new()),
        ("no TOML", "[[channel]\ncolumn = 1".into()),
        ("unknown table", "[chanel]\n".into()),
        ("single brackets", "[channel]\ncolumn = \"a\"".into()),
        ("unknown key", position("units = \"deg\"")),
        ("unknown unit", position("unit = \"degree per second\"")),
        ("unit of another quantity", position("unit = \"deg/s\"")),
        ("unknown unit of time", "[time]\nunit = \"min\"\n".to_owned() + &position("")),
        ("unknown quantity", channel("quantity = \"torque\"")),
        ("no quantity", channel("")),
        ("no joint", "[[channel]]\ncolumn = \"a/position\"".into()),
        ("no column", "[[channel]]\njoint = \"a\"".into()),
        ("text for a number", position("gear_ratio = \"100\"")),
        ("sign that is a gain", position("sign = -57.3")),
        ("infinite", position("offset = inf")),
        ("negative resistance", effort("unit = \"V\"\ntorque_constant = 1\nresistance_ohm = -1")),
        ("current without gain", effort("unit = \"A\"")),
        ("voltage without resistance", effort("unit = \"V\"\ntorque_constant = 0.1")),
        ("counts without size", position("unit = \"counts\"")),
        ("gain and its parts", effort("unit = \"A\"\ngain = 1\ntorque_constant = 1")),
        ("gear of a temperature", channel("quantity = \"temperature\"\ngear_ratio = 2")),
        ("torque constant of a torque", effort("torque_constant = 2")),
        ("other braces", "[[channel]]\ncolumn = \"{name}/position\"".into()),
        (
            "placeholder on one side",
            "[[channel]]\ncolumn = \"{joint}/position\"\njoint = \"a\"".into(),
        ),
        (
            "unit of any quantity",
            "[[channel]]\ncolumn = \"{joint}/{quantity}\"\nunit = \"deg\"".into(),
        ),
        ("empty table", effort("gain = {}")),
        ("coupling without matrix", coupling("joints = [\"a\"]\nmotors = [\"m\"]")),
        (
            "singular coupling",
            coupling("joints = [\"a\", \"b\"]\nmotors = [\"m\", \"n\"]\nmatrix = [[1, 2], [2, 4]]"),
        ),
        (
            "ragged coupling",
            coupling("joints = [\"a\", \"b\"]\nmotors = [\"m\", \"n\"]\nmatrix = [[1, 2], [2]]"),
        ),
        (
            "motor without joint",
            coupling("joints = [\"a\"]\nmotors = [\"m\", \"n\"]\nmatrix = [[1]]"),
        ),
    ];
    let raw = RawColumns::new("run.csv")
        .with("t", stamps())
        .with("shoulder_deg", vec![0.5; 10])
        .with("elbow_deg", vec![0.5; 10])
        .with("elbow_amps", vec![0.5; 10]);
    let rule = |column: &str, rest: &str| {
        format!("[[channel]]\ncolumn = \"{column}\"\nquantity = \"position\"\n{rest}\n")
    };
    let of_columns = [
        ("misspelt column", rule("elbow_degs", "joint = \"elbow\"")),
        ("misspelt pattern", rule("{joint}_degrees", "")),
        ("misspelt time", "[time]\ncolumn = \"stamp\"\n".to_owned() + &rule("{joint}_deg", "")),
        ("joint without column", rule("{joint}_deg", "offset = { elbw = 0.5 }")),
        (
            "two columns for one channel",
            rule("elbow_deg", "joint = \"elbow\"") + &rule("elbow_amps", "joint = \"elbow\""),
        ),
        (
            "motor that is not there",
            rule("{joint}_deg", "")
                + "[[coupling]]\njoints = [\"a\", \"b\"]\nmotors = [\"elbow\", \"wrist\"]\n\
                   matrix = [[1, 0], [1, 1]]",
        ),
        (
            "joint that is there already",
            rule("{joint}_deg", "")
                + "[[coupling]]\njoints = [\"shoulder\"]\nmotors = [\"elbow\"]\nmatrix = [[2]]",
        ),
        (
            "back-EMF without velocity",
            "[[channel]]\ncolumn = \"elbow_deg\"\njoint = \"elbow\"\nquantity = \"effort\"\n\
             unit = \"V\"\ntorque_constant = 1\nresistance_ohm = 1\nback_emf = true"
                .into(),
        ),
    ];
    let mut book = String::new();
    for (name, text) in of_files {
        let error = Mapping::parse(&text, "arm.toml").expect_err(name);
        let _ = writeln!(book, "== {name}\n{}", message(&error));
    }
    for (name, text) in of_columns {
        let error = mapping(&text).apply(&raw).expect_err(name);
        let _ = writeln!(book, "== {name}\n{}", message(&error));
    }
    let no_time = RawColumns::new("run.csv").with("a_deg", vec![0.0; 10]);
    let error = mapping(&rule("{joint}_deg", "")).apply(&no_time).unwrap_err();
    let _ = writeln!(book, "== no time\n{}", message(&error));
    let ms: Vec<f64> = (0..10).map(|k| 10.0 * f64::from(k)).collect();
    let slow = RawColumns::new("run.csv").with("t", ms).with("a_deg", vec![0.0; 10]);
    let error = mapping(&rule("{joint}_deg", "")).apply(&slow).unwrap_err();
    let _ = writeln!(book, "== milliseconds without unit\n{}", message(&error));
    let error = Mapping::load("no/such/arm.toml").unwrap_err();
    let _ = writeln!(book, "== no file\n{}", message(&error));
    insta::assert_snapshot!(book);
}

const WHOLE: &str = r#"[time]
column = "t"
unit = "s"
sort = false
[[channel]]
column = "elbow/current"
joint = "elbow"
quantity = "effort"
unit = "A"
gain = { elbow = -8.7 }
[[channel]]
column = "{joint}/{quantity}"
[[coupling]]
joints = ["a", "b"]
motors = ["m", "n"]
matrix = [[45, 0], [32.0, 0x20]]
offset = [0, 1_000.5]
"#;

fn some_columns() -> RawColumns {
    let mut raw = RawColumns::new("run").with("t", stamps());
    for name in ["elbow/current", "m/position", "n/position", "wrist/effort", "x"] {
        raw = raw.with(name, vec![0.25; 10]);
    }
    raw
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn mutated_mappings_never_panic(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<u8>()), 1..6),
    ) {
        const LIKELY: &[u8] = b"0123456789.,-_eE\n[]{}\"'=# tjnaif";
        let mut bytes = WHOLE.as_bytes().to_vec();
        for (place, kind, byte) in edits {
            let at = place.index(bytes.len());
            let likely = LIKELY[byte as usize % LIKELY.len()];
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] = likely,
                2 => bytes.insert(at, likely),
                _ => { bytes.remove(at); }
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        match Mapping::parse(&text, "arm.toml") {
            Ok(mapping) => match mapping.apply(&some_columns()) {
                Ok(recording) => recording.check().unwrap(),
                Err(error) => prop_assert!(!message(&error).is_empty()),
            },
            Err(error) => prop_assert!(!message(&error).is_empty()),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn identity_mapping_equals_plain_reading(
        columns in proptest::collection::btree_map(
            ("[a-z/_]{0,4}[a-z]", 0..Quantity::ALL.len()),
            proptest::collection::vec(-1e3..1e3, 10),
            1..6,
        ),
    ) {
        let mut header = "t".to_owned();
        for (joint, quantity) in columns.keys() {
            let _ = write!(header, ",{joint}/{}", Quantity::ALL[*quantity]);
        }
        let mut text = header + "\n";
        for (k, t) in stamps().iter().enumerate() {
            let _ = write!(text, "{t}");
            for values in columns.values() {
                let _ = write!(text, ",{}", values[k]);
            }
            text.push('\n');
        }
        let plain = read_csv_from(text.as_bytes(), "run").unwrap();
        let identity = mapping("[[channel]]\ncolumn = \"{joint}/{quantity}\"");
        let mapped = read_csv_mapped_from(text.as_bytes(), "run", &identity).unwrap();
        prop_assert_eq!(mapped, plain);
    }
}

fn shared_recording(file: &str) -> Option<PathBuf> {
    shared::shared("mappings", &format!("data/{file}"))
}

const TIAGO: &str = r#"
[[channel]]
column = "{joint}/current"
quantity = "effort"
unit = "A"
[channel.gain]
arm_1_joint = 13.6
arm_2_joint = 13.6
arm_3_joint = -8.7
arm_4_joint = -8.7
arm_5_joint = -20.6
arm_6_joint = -20.6
arm_7_joint = -20.6
[[channel]]
column = "{joint}/position"
"#;

#[test]
fn motor_currents_of_an_arm_become_efforts() {
    let Some(path) = shared_recording("tiago-arm/train.csv") else { return };
    let mapped = read_csv_mapped(&path, &mapping(TIAGO)).unwrap();
    let plain = read_csv(&path).unwrap();
    assert_eq!(mapped.joint_names(), plain.joint_names());
    assert_eq!(mapped.joint("torso_lift_joint").unwrap().effort, None);
    assert!(mapped.ignored_columns.contains(&"torso_lift_joint/current".to_owned()));
    for (joint, gain) in [("arm_1_joint", 13.6), ("arm_4_joint", -8.7), ("arm_7_joint", -20.6)] {
        let (mapped, plain) = (mapped.joint(joint).unwrap(), plain.joint(joint).unwrap());
        assert_eq!(mapped.position, plain.position);
        let efforts = mapped.effort.as_ref().unwrap().iter();
        let pairs = efforts.zip(plain.current.as_ref().unwrap());
        // outliers that several joints have together stay: that is decided on the channels that are read
        let others = pairs.filter(|(e, current)| (*e - gain * *current).abs() > 1e-12).count();
        assert!(others < 55, "{joint}: {others} of 5500");
    }
    assert!(mapped.notes[0].starts_with("effort computed from current: arm_1_joint, arm_2_joint"));
}

#[test]
fn voltage_of_a_servo_becomes_effort() {
    let Some(path) = shared_recording("bam-xl330/sin_sin_kp100.csv") else { return };
    let text = "[[channel]]\ncolumn = \"{joint}/voltage\"\nquantity = \"effort\"\nunit = \"V\"\n\
                torque_constant = 0.36601\nresistance_ohm = 2.8114\n\
                [[channel]]\ncolumn = \"{joint}/{quantity}\"";
    let mapped = read_csv_mapped(&path, &mapping(text)).unwrap();
    let plain = read_csv(&path).unwrap();
    let (servo, plain) = (&mapped.joints[0], &plain.joints[0]);
    assert_eq!((&servo.position, &servo.temperature), (&plain.position, &plain.temperature));
    let efforts = servo.effort.as_ref().unwrap().iter();
    for (effort, voltage) in efforts.zip(plain.voltage.as_ref().unwrap()) {
        assert!((effort - 0.36601 / 2.8114 * voltage).abs() < 1e-12);
    }
    assert!(
        mapped.notes[0].ends_with("viscous friction of 0.0477 N m s/rad"),
        "{:?}",
        mapped.notes
    );
}
