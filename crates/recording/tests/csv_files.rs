//! What is accepted, and that files come back as they were written.

#![allow(clippy::unwrap_used)] // helpers of tests

use armident_recording::{
    JointChannels, Quantity, Recording, read_csv, read_csv_from, write_csv, write_csv_to,
};
use proptest::prelude::*;

fn rows(n: usize, row: impl Fn(f64) -> String) -> String {
    (0..n).map(|k| row(k as f64 * 0.01) + "\n").collect()
}

fn read(text: &str) -> Recording {
    read_csv_from(text.as_bytes(), "test.csv").unwrap()
}

#[test]
fn plain_file() {
    let text = "t,arm/elbow/position,base/effort,arm/elbow/effort\n".to_owned()
        + &rows(10, |t| format!("{t},{},-1e-3,{}", t * 2.0, t - 3.0));
    let recording = read(&text);
    assert_eq!(recording.joint_names(), ["arm/elbow", "base"]);
    assert_eq!(recording.source, "test.csv");
    assert_eq!(recording.len(), 10);
    assert!(recording.notes.is_empty() && recording.ignored_columns.is_empty());
    let elbow = recording.joint("arm/elbow").unwrap();
    assert_eq!(elbow.position.as_ref().unwrap()[5], 0.1);
    assert_eq!(elbow.effort.as_ref().unwrap()[0], -3.0);
    assert!(elbow.velocity.is_none());
    assert_eq!(recording.joint("base").unwrap().channel(Quantity::Effort).unwrap(), [-1e-3; 10]);
}

#[test]
fn equivalent_texts_give_one_recording() {
    let plain = "t,a/position\n".to_owned() + &rows(12, |t| format!("{t},{}", 1.0 - t));
    let expected = read(&plain);
    let spaced =
        "\n  t , a/position \n".to_owned() + &rows(12, |t| format!(" {t} ,\t{} ", 1.0 - t));
    for (form, text) in [
        ("byte order mark", format!("\u{feff}{plain}")),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("byte order mark and CRLF", format!("\u{feff}{}", plain.replace('\n', "\r\n"))),
        ("spaces", spaced),
        ("blank lines", plain.replace('\n', "\n\n")),
        ("blank CRLF lines", plain.replace('\n', "\r\n  \r\n")),
        ("no line end at the end", plain.trim_end().to_owned()),
        ("quotes", plain.replace("a/position", "\"a/position\"")),
    ] {
        assert_eq!(read(&text), expected, "{form}");
    }
}

#[test]
fn unknown_columns_are_ignored_with_a_note() {
    let text = "t,elbow/position,elbow/torque,elbow/humidity,supply,,base_pos\n".to_owned()
        + &rows(9, |t| format!("{t},{t},{t},warm,,-,1"));
    let recording = read(&text);
    assert_eq!(recording.joint_names(), ["elbow"]);
    assert_eq!(
        recording.ignored_columns,
        ["elbow/torque", "elbow/humidity", "supply", "(column 6 has no name)", "base_pos"]
    );
    assert_eq!(
        recording.notes,
        [
            "ignored column `elbow/torque`; rename it to `elbow/effort` if it is a channel",
            "ignored column `base_pos`; rename it to `base/position` if it is a channel",
            "ignored columns: elbow/humidity, supply, (column 6 has no name)",
        ]
    );
}

#[test]
fn duplicate_stamps_are_dropped_with_a_note() {
    let mut lines: Vec<String> = (0..300).map(|k| format!("{},{k}", f64::from(k) * 0.01)).collect();
    lines.insert(100, lines[99].replace(",99", ",-5"));
    lines.insert(200, lines[199].clone());
    let recording = read(&format!("t,a/position\n{}\n", lines.join("\n")));
    assert_eq!(recording.len(), 300);
    assert_eq!(recording.joint("a").unwrap().position.as_ref().unwrap()[99], 99.0);
    assert_eq!(
        recording.notes,
        ["2 duplicate time stamps in 302 samples, first at t = 0.99 s; dropped"]
    );
}

#[test]
fn stamps_start_at_any_time() {
    let text = "t,a/position\n".to_owned() + &rows(50, |t| format!("{:.6},{t}", 1.7e9 + t));
    assert_eq!(read(&text).time_s[0], 1.7e9);
    let text = "t,a/position\n".to_owned() + &rows(50, |t| format!("{:.6},{t}", t - 5.0));
    assert_eq!(read(&text).time_s[0], -5.0);
}

#[test]
fn files_round_trip_on_disk() {
    let folder = std::env::temp_dir().join(format!("armident-recording-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("swing.csv");
    let time_s: Vec<f64> = (0..20).map(|k| f64::from(k) / 300.0).collect();
    let joint = JointChannels {
        position: Some(time_s.iter().map(|t| t.sin()).collect()),
        ..JointChannels::new("elbow")
    };
    let recording = Recording::new(path.display().to_string(), time_s, vec![joint]).unwrap();
    write_csv(&path, &recording).unwrap();
    assert_eq!(read_csv(&path).unwrap(), recording);

    let error = read_csv(folder.join("missing.csv")).unwrap_err();
    assert_eq!(error.to_string(), "the file does not exist");
    assert_eq!(error.place(), folder.join("missing.csv").display().to_string());
    assert_eq!(read_csv(&folder).unwrap_err().to_string(), "this is a directory, not a recording");
    let error = write_csv(folder.join("no/such/folder.csv"), &recording).unwrap_err();
    assert!(error.to_string().starts_with("the file cannot be written: "));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Gives the text in pieces of one byte, then fails if told to.
struct Trickle<'a>(&'a [u8], bool);

impl std::io::Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self.0 {
            [first, rest @ ..] => {
                buffer[0] = *first;
                self.0 = rest;
                Ok(1)
            }
            [] if self.1 => Err(std::io::Error::other("cable pulled")),
            [] => Ok(0),
        }
    }
}

#[test]
fn slow_sources_are_read_and_failing_refused() {
    let text = "\u{feff}t,a/position\r\n".to_owned() + &rows(12, |t| format!("{t},{t}\r"));
    let recording = read_csv_from(Trickle(text.as_bytes(), false), "test.csv").unwrap();
    assert_eq!(recording, read(&text));
    let error = read_csv_from(Trickle(text.as_bytes(), true), "test.csv").unwrap_err();
    assert_eq!(error.to_string(), "the file cannot be read: cable pulled");
    assert_eq!(error.place(), "test.csv");
}

#[test]
fn inconsistent_recordings_are_not_written() {
    let mut recording = read(&("t,a/position\n".to_owned() + &rows(9, |t| format!("{t},{t}"))));
    recording.time_s.pop();
    let mut out = Vec::new();
    assert!(write_csv_to(&mut out, &recording).is_err());
    assert!(out.is_empty());
}

/// Any finite value: all exponents, subnormal numbers, both zeros.
fn value() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
}

/// Values between which no step can be taken for a full turn, which reading would undo.
fn joints() -> impl Strategy<Value = Vec<JointChannels>> {
    let name = "[a-z\"',;/ _é.-]{0,6}[a-z0-9\"]";
    let value = value().prop_filter("no turn", |value| !(1.0..20.0).contains(&value.abs()));
    let channels = proptest::collection::vec(
        proptest::option::of(proptest::collection::vec(value, 10)),
        Quantity::ALL.len(),
    );
    let joint = (name, channels).prop_map(|(name, channels)| {
        let mut joint = JointChannels::new(name.trim());
        for (quantity, values) in Quantity::ALL.into_iter().zip(channels) {
            *joint.channel_mut(quantity) = values;
        }
        joint.effort.get_or_insert_with(|| vec![0.25; 10]);
        joint
    });
    proptest::collection::vec(joint, 1..4).prop_map(|mut joints| {
        joints.sort_by(|a, b| a.name.cmp(&b.name));
        joints.dedup_by(|a, b| a.name == b.name);
        joints
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn round_trip_keeps_every_bit(
        joints in joints(),
        start_s in -1e4..1e4,
        steps_s in proptest::collection::vec(1e-3..0.1, 10),
    ) {
        let time_s: Vec<f64> = steps_s
            .iter()
            .scan(start_s, |t, step| {
                *t += step;
                Some(*t)
            })
            .collect();
        let recording = Recording::new("x", time_s, joints).unwrap();
        let mut text = Vec::new();
        write_csv_to(&mut text, &recording).unwrap();
        let again = read_csv_from(text.as_slice(), "x").unwrap();
        prop_assert_eq!(again.joint_names(), recording.joint_names());
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&again.time_s), bits(&recording.time_s));
        for (again, joint) in again.joints.iter().zip(&recording.joints) {
            for quantity in Quantity::ALL {
                prop_assert_eq!(
                    again.channel(quantity).map(bits),
                    joint.channel(quantity).map(bits)
                );
            }
        }
        prop_assert!(again.notes.is_empty());
    }
}

/// 200 rows at 50 Hz of two joints as text, each row changed by `edit`.
fn swing(edit: impl Fn(usize, f64, [String; 4]) -> String) -> String {
    let mut text = "t,a/position,a/effort,b/position,b/effort\n".to_owned();
    for k in 0..200 {
        let t = 0.02 * f64::from(k);
        let cells = [(1.3 * t).sin(), 9.0 * (1.7 * t).cos(), 1.0 + (0.9 * t).cos(), 20.0 + t.sin()];
        text += &edit(k as usize, t, cells.map(|x| format!("{x:.6}")));
        text += "\n";
    }
    text
}

#[test]
fn rows_of_a_second_publisher_are_left_out_or_merged() {
    let whole =
        read_csv_from(swing(|_, t, c| format!("{t},{}", c.join(","))).as_bytes(), "x").unwrap();
    assert!(whole.findings.is_empty(), "{:?}", whole.findings);
    let zeros = swing(|k, t, c| {
        let zeros = if k % 7 == 6 { format!("\n{},0,0,0,0.0", t + 0.004) } else { String::new() };
        format!("{t},{}{zeros}", c.join(","))
    });
    let read = read_csv_from(zeros.as_bytes(), "x").unwrap();
    assert_eq!((&read.joints, &read.time_s), (&whole.joints, &whole.time_s));
    assert!(read.notes[0].starts_with("28 rows of zeros"), "{:?}", read.notes);

    let own =
        swing(|_, t, c| format!("{t},{},,{},\n{},,{},,{}", c[0], c[2], t + 0.004, c[1], c[3]));
    let read = read_csv_from(own.as_bytes(), "x").unwrap();
    assert_eq!((read.len(), read.time_s[1]), (199, 0.04));
    let note = "effort in rows of their own stamps (201 of 400 rows, of another publisher); interpolated onto the 199 rows of position";
    assert_eq!(read.notes, [note]);
    let exact = |k: usize| 9.0 * (1.7 * (read.time_s[k] - 0.004)).cos();
    let effort = read.joints[0].effort.as_ref().unwrap();
    assert!((0..199).all(|k| (effort[k] - exact(k)).abs() < 1e-3));
}

#[test]
fn empty_columns_are_left_out() {
    let text = swing(|_, t, c| format!("{t},{},{},{},", c[0], c[1], c[2]));
    let read = read_csv_from(text.as_bytes(), "x").unwrap();
    assert!(read.joints[1].effort.is_none());
    assert_eq!(read.notes, ["columns without a value left out: b/effort"]);
}

#[test]
fn single_bad_values_are_interpolated() {
    let text = swing(|k, t, mut c| {
        if k == 40 {
            c[0] = "-2.9".to_owned();
        }
        if k == 150 {
            c[3] = "0".to_owned();
        }
        format!("{t},{}", c.join(","))
    });
    let read = read_csv_from(text.as_bytes(), "x").unwrap();
    let t = 0.8_f64;
    assert!((read.joints[0].position.as_ref().unwrap()[40] - (1.3 * t).sin()).abs() < 1e-4);
    assert!((read.joints[1].effort.as_ref().unwrap()[150] - 20.0 - 3.0_f64.sin()).abs() < 1e-3);
    assert_eq!(read.notes.len(), 2, "{:?}", read.notes);
    assert!(read.notes[0].starts_with("a/position: 1 of 200 values jump away and back"));
    assert!(
        read.notes[1].starts_with("b/effort: 1 of 200 values are exactly 0"),
        "{:?}",
        read.notes
    );
}
