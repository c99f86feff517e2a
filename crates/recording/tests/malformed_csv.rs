//! Malformed CSV files: error messages, and no panics.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::fmt::Write as _;

use armident_motion::{Motion, MotionSettings};
use armident_recording::{RecordingError, read_csv_from};
use proptest::prelude::*;

/// A valid file of 10 samples at 100 Hz with two joints.
fn valid() -> String {
    let mut text = "t,elbow/position,elbow/effort,wrist/position\n".to_owned();
    for k in 0..10 {
        let t = f64::from(k) * 0.01;
        let _ = writeln!(text, "{t},{},{},{}", 0.5 + t, 3.0 - t, -t);
    }
    text
}

/// The valid file with one line (counted from 1) replaced.
fn with_line(number: usize, line: &str) -> String {
    let text = valid();
    let mut lines: Vec<&str> = text.lines().collect();
    lines[number - 1] = line;
    lines.join("\n") + "\n"
}

fn with_header(header: &str) -> String {
    with_line(1, header)
}

/// Two columns with these stamps.
fn with_stamps(stamps: impl Iterator<Item = f64>) -> String {
    let rows: String = stamps.map(|t| format!("{t},0.5\n")).collect();
    format!("t,elbow/position\n{rows}")
}

fn even(n: usize, step: f64) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| k as f64 * step)
}

fn cases() -> Vec<(&'static str, Vec<u8>)> {
    let text = |name, text: String| (name, text.into_bytes());
    let bytes = |name, bytes: &[u8]| (name, bytes.to_vec());
    let latin_1: Vec<u8> = b"t,\xe9paule/position\n0,1\n".to_vec();
    let latin_1_field: Vec<u8> =
        with_line(4, "0.02,0.5,3\u{b5},0").bytes().filter(|byte| *byte != 0xc2).collect();
    let repeated = even(12, 0.01).map(|t| if t == 0.05 { 0.04 } else { t });
    vec![
        text("empty", String::new()),
        text("white space only", "  \n\n \r\n".into()),
        text("byte order mark only", "\u{feff}".into()),
        text("header only", "t,elbow/position\n".into()),
        text("header only, no line end", "t,elbow/position".into()),
        text("no header", valid().lines().skip(1).collect::<Vec<_>>().join("\n")),
        text(
            "`time` instead of `t`",
            with_header("time,elbow/position,elbow/effort,wrist/position"),
        ),
        text("`# t [s]` instead of `t`", with_header("# t [s],elbow/position,elbow/effort,x")),
        text("stamps in nanoseconds by name", with_header("timestamp_ns,elbow/position,a,b")),
        text("no stamps at all", with_header("index,elbow/position,elbow/effort,wrist/position")),
        text("column twice", with_header("t,elbow/position,elbow/effort,elbow/position")),
        text(
            "column twice after trimming",
            with_header("t,elbow/position,elbow/effort, elbow/effort "),
        ),
        text("`t` twice", with_header("t,elbow/position,t,wrist/position")),
        text("torques only", with_header("t,elbow/torque,wrist/torque,base/torque")),
        text("underscores instead of slashes", with_header("t,elbow_pos,elbow_tau,wrist_pos")),
        text("capital letters", with_header("t,elbow/Position,elbow/Effort,wrist/Position")),
        text("no joint names", with_header("t,/position,/effort,position")),
        text("nothing known", with_header("t,temperature,fan,supply")),
        text(
            "many unknown columns",
            format!("t,{}\n", (0..30).map(|k| format!("c{k}")).collect::<Vec<_>>().join(",")),
        ),
        text("decimal commas between commas", with_line(3, "0,01,0,51,2,99,-0,01")),
        text("quoted decimal comma", with_line(3, "0.01,\"0,51\",2.99,-0.01")),
        text("row too short", with_line(6, "0.04,0.54")),
        text("row too long", with_line(6, "0.04,0.54,2.96,-0.04,7")),
        text("row cut off", valid().trim_end().rsplit_once(',').unwrap().0.into()),
        text("row too short after blank lines", with_line(6, "\n\n0.04,0.54")),
        text("row too short, CRLF", with_line(6, "0.04,0.54").replace('\n', "\r\n")),
        text(
            "row too short in the last line, no line end",
            with_line(11, "0.09,1").trim_end().into(),
        ),
        text("empty field", with_line(5, "0.03,,2.97,-0.03")),
        text("word", with_line(5, "0.03,0.53,n/a,-0.03")),
        text("unit", with_line(5, "0.03,0.53 rad,2.97,-0.03")),
        text("long field", with_line(5, &format!("0.03,{},2.97,-0.03", "x".repeat(500)))),
        text("hexadecimal", with_line(5, "0.03,0x1F,2.97,-0.03")),
        text("stamp is a date", with_line(2, "2024-05-01 12:00:00,0.5,3,0")),
        text("NaN", with_line(7, "0.05,0.55,NaN,-0.05")),
        text("infinite", with_line(7, "0.05,0.55,-inf,-0.05")),
        text("too large for a number", with_line(7, "0.05,0.55,1e999,-0.05")),
        text("stamp NaN", with_line(7, "NaN,0.55,2.95,-0.05")),
        text("NaN before a short row", with_line(7, "0.05,0.55,NaN,-0.05\n0.055,1")),
        text("short row before NaN", with_line(7, "0.045,1\n0.05,0.55,NaN,-0.05")),
        text("time goes backwards", with_line(8, "0.01,0.5,3,0")),
        text("two recordings in one file", with_stamps(even(20, 0.01).chain(even(20, 0.01)))),
        text("header again in the middle", with_line(8, valid().lines().next().unwrap())),
        text("stamp repeated", with_stamps(repeated)),
        text("all stamps the same", with_stamps(even(20, 0.0))),
        text("milliseconds", with_stamps(even(20, 5.0))),
        text("microseconds", with_stamps(even(20, 5000.0))),
        text("nanoseconds since 1970", with_stamps(even(20, 5e6).map(|t| t + 1.7e18))),
        text("days", with_stamps(even(20, 0.002 / 86_400.0))),
        text("row numbers", with_stamps(even(20, 1.0))),
        text("seven samples", with_stamps(even(7, 0.01))),
        text("one sample", with_stamps(even(1, 0.01))),
        ("header in Latin-1", latin_1),
        ("field in Latin-1", latin_1_field),
        text("CR alone as line end", valid().replace('\n', "\r")),
        text("unclosed quote", with_line(5, "0.03,\"0.53,2.97,-0.03")),
        text("header fault below blank lines", "\n\n".to_owned() + &with_header("time,a,b,c")),
        bytes("UTF-16", b"\xff\xfet\0,\0a\0"),
        bytes("gzip", b"\x1f\x8b\x08\x00\x00"),
        bytes("spreadsheet", b"PK\x03\x04\x14\x00"),
        bytes("MCAP", b"\x89MCAP0\r\n\x01"),
        bytes("ROS 1 bag", b"#ROSBAG V2.0\n"),
        bytes("ROS 2 bag", b"SQLite format 3\0"),
        bytes("Parquet", b"PAR1\x15\x04"),
        bytes("HDF5", b"\x89HDF\r\n\x1a\n"),
        bytes("zeros", &[0; 100]),
    ]
}

fn message(error: &RecordingError) -> String {
    let mut lines = format!("error: {error}\n   in: {}\n", error.place());
    if let Some(hint) = error.hint() {
        let _ = writeln!(lines, " hint: {hint}");
    }
    lines
}

#[test]
fn messages_of_malformed_files() {
    let mut book = String::new();
    for (name, bytes) in cases() {
        let error = read_csv_from(bytes.as_slice(), "swing.csv");
        let message = message(&error.expect_err(name));
        assert!(message.lines().all(|line| line.len() < 400), "{name}: {message}");
        let _ = writeln!(book, "== {name}\n{message}");
    }
    insta::assert_snapshot!(book);
}

#[test]
fn base_of_the_cases_is_valid() {
    assert_eq!(read_csv_from(valid().as_bytes(), "swing.csv").unwrap().len(), 10);
}

#[test]
fn other_separators_are_recognised() {
    let commas = read_csv_from(valid().as_bytes(), "swing.csv").unwrap();
    for (separator, decimal, note) in [
        (";", ".", "columns are separated by semicolons"),
        (";", ",", "columns are separated by semicolons, numbers have decimal commas"),
        ("\t", ".", "columns are separated by tabs"),
        ("  ", ".", "columns are separated by spaces"),
    ] {
        let text = valid().replace(',', separator).replace('.', decimal);
        let recording = read_csv_from(text.as_bytes(), "swing.csv").unwrap();
        assert_eq!(recording.joints, commas.joints);
        assert_eq!(recording.notes, [note]);
    }
}

/// Reads, and if that succeeds makes motions too.
fn read_any(bytes: &[u8]) {
    match read_csv_from(bytes, "swing.csv") {
        Ok(recording) => {
            recording.check().unwrap();
            let joints = recording.joint_names();
            for cutoff_hz in [None, Some(5.0)] {
                let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
                if let Err(error) = Motion::from_recording(&recording, &joints, &settings) {
                    assert!(!message(&error).is_empty());
                }
            }
        }
        Err(error) => assert!(!message(&error).is_empty()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn mutated_bytes_never_panic(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<u8>()), 1..8),
    ) {
        const LIKELY: &[u8] = b"0123456789.,;-+eE\n\r\"/ tNaninf\t\xff\0";
        let mut bytes = valid().into_bytes();
        for (place, kind, byte) in edits {
            let at = place.index(bytes.len());
            let likely = LIKELY[byte as usize % LIKELY.len()];
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] = likely,
                2 => bytes.insert(at, likely),
                _ if bytes.len() > 1 => { bytes.remove(at); }
                _ => {}
            }
        }
        read_any(&bytes);
    }

    #[test]
    fn truncated_files_never_panic(at in any::<prop::sample::Index>()) {
        let text = valid();
        read_any(&text.as_bytes()[..at.index(text.len())]);
    }

    #[test]
    fn any_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        read_any(&bytes);
    }
}
