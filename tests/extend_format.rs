//! A log format of another crate, read and written beside the standard ones.

use std::io::{Read as _, Write as _};
use std::path::PathBuf;

use armident_recording::{
    ColumnRequest, Encoded, Fault, FileStart, Format, Formats, Input, Mapping, RawColumns,
    ReadSettings, Recording, RecordingError, Support,
};

use crate::tool::scratch;

/// One column a line: its name, then its numbers.
#[derive(Debug)]
struct Lines;

const MAGIC: &[u8] = b"LINES\n";

impl Format for Lines {
    fn name(&self) -> &'static str {
        "LINES"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["lines"]
    }

    fn support(&self) -> Support {
        Support::ReadWrite
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(MAGIC)
    }

    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let fault = |fault| RecordingError::new(fault, request.source());
        let mut text = String::new();
        input
            .into_reader()
            .read_to_string(&mut text)
            .map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        let mut raw = RawColumns::new(request.source());
        for (line, (number, words)) in (2..).zip(text.lines().enumerate().skip(1)) {
            let mut words = words.split(' ');
            let name = words.next().unwrap_or_default();
            let values: Result<Vec<f64>, _> = words.map(str::parse).collect();
            let values = values.map_err(|_| {
                let text = format!("column {number}");
                fault(Fault::NotANumber { text }).on_line(line).in_column(name)
            })?;
            raw = raw.with(name, values);
        }
        raw.notes.push("columns from lines".to_owned());
        Ok(raw)
    }

    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        let mut bytes = MAGIC.to_vec();
        let fault =
            |error| RecordingError::new(Fault::Io { doing: "written", error }, &recording.source);
        let mut line = |name: &str, values: &[f64]| {
            let numbers: Vec<String> = values.iter().map(ToString::to_string).collect();
            writeln!(bytes, "{name} {}", numbers.join(" ")).map_err(fault)
        };
        line("t", &recording.time_s)?;
        for joint in &recording.joints {
            for (quantity, values) in joint.channels() {
                line(&format!("{}/{quantity}", joint.name), values)?;
            }
        }
        Ok(Encoded { bytes, omitted: Vec::new() })
    }
}

/// A format that is read only, recognised by its extension.
#[derive(Debug)]
struct Tabs;

impl Format for Tabs {
    fn name(&self) -> &'static str {
        "TSV"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["tsv"]
    }

    fn support(&self) -> Support {
        Support::Read
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.has_extension(self.extensions())
    }
}

fn recording() -> Recording {
    let mut joint = armident_recording::JointChannels::new("elbow");
    joint.position = Some((0..20).map(|k| (0.1 * f64::from(k)).sin()).collect());
    joint.effort = Some(vec![90.0; 20]);
    let time_s = (0..20).map(|k| 0.01 * f64::from(k)).collect();
    Recording::new("made", time_s, vec![joint]).unwrap()
}

fn written(formats: &Formats<'_>, folder: &str, name: &str) -> PathBuf {
    let path = scratch(folder).join(name);
    let encoded = formats.by_extension(&path).write(&recording()).unwrap();
    std::fs::write(&path, encoded.bytes).unwrap();
    path
}

#[test]
fn foreign_format_round_trips() {
    let formats = Formats::standard().with(&Lines);
    assert_eq!(
        formats.extensions(),
        ["lines", "csv", "mcap", "npz", "mat", "parquet", "db3", "bag", "h5", "hdf5"]
    );
    let path = written(&formats, "extend_format_round_trip", "run.lines");
    let found = formats.read(&path, &ReadSettings::default()).unwrap();
    assert_eq!((found.time_s, found.joints), (recording().time_s, recording().joints));
    assert_eq!(found.notes, ["columns from lines"]);
}

#[test]
fn foreign_format_is_mapped_and_checked() {
    let formats = Formats::standard().with(&Lines);
    let path = written(&formats, "extend_format_mapped", "run.lines");
    let text = "[[channel]]\ncolumn = \"{joint}/effort\"\nunit = \"N mm\"\nquantity = \"effort\"\n";
    let mapping = Mapping::parse(text, "map.toml").unwrap();
    let settings = ReadSettings { mapping: Some(&mapping), topic: None };
    let found = formats.read(&path, &settings).unwrap();
    assert!((found.joints[0].effort.as_ref().unwrap()[0] - 0.09).abs() < 1e-15);
    assert_eq!(found.ignored_columns, ["elbow/position"]);

    std::fs::write(&path, [MAGIC, b"t 0 1\nelbow/position 0 up\n"].concat()).unwrap();
    let error = formats.read(&path, &ReadSettings::default()).unwrap_err();
    assert_eq!(error.line(), Some(3));
    assert_eq!(error.column(), Some("elbow/position"));
}

#[test]
fn foreign_format_leaves_standard_ones_alone() {
    let formats = Formats::standard().with(&Lines).with(&Tabs);
    let path = written(&formats, "extend_format_csv", "run.csv");
    assert_eq!(formats.read(&path, &ReadSettings::default()).unwrap().joints, recording().joints);
    assert_eq!(formats.by_extension("run.tsv".as_ref()).name(), "CSV");
    assert_eq!(formats.by_extension("run.mcap".as_ref()).name(), "MCAP");

    let path = written(&formats, "extend_format_tsv", "run.lines").with_extension("tsv");
    std::fs::write(&path, "t\telbow/position\n").unwrap();
    let error = formats.read(&path, &ReadSettings::default()).unwrap_err();
    assert_eq!(error.to_string(), "unsupported format: TSV");
}

/// Without the foreign format its files are read as text.
#[test]
fn standard_list_does_not_know_foreign_formats() {
    let path = written(&Formats::standard().with(&Lines), "extend_format_unknown", "run.lines");
    assert!(Formats::standard().read(&path, &ReadSettings::default()).is_err());
}
