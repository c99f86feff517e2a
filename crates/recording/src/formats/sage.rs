//! Motor states of SAGE (Isaac Sim): a list of all joints in each field, names of the joints in `joint_list.txt` and positions
//! that they are given in `control.csv` beside the file.

use std::io::Read as _;

use super::format::{ColumnRequest, FileStart, Format, Input, Support};
use crate::error::{Fault, RecordingError};
use crate::raw::RawColumns;

/// Files `state_motor.csv` of SAGE.
#[derive(Debug, Clone, Copy)]
pub struct Sage;

/// First columns of the header.
const HEADER: &[u8] = b"type,timestamp,positions";
/// The type of rows that are states of motors.
const STATE: &str = "STATE_MOTOR";
/// The type of rows that are commands.
const CONTROL: &str = "CONTROL";
/// Stamps are microseconds where one step is longer than this.
const LONGEST_STEP: f64 = 100.0;

impl Format for Sage {
    fn name(&self) -> &'static str {
        "SAGE"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &[]
    }

    fn support(&self) -> Support {
        Support::Read
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(HEADER)
    }

    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let fault = |fault| RecordingError::new(fault, request.source());
        let beside = |name: &str| {
            std::fs::read_to_string(input.path().with_file_name(name)).unwrap_or_default()
        };
        let (names, control) = (beside("joint_list.txt"), beside("control.csv"));
        let names: Vec<&str> =
            names.lines().map(str::trim).filter(|name| !name.is_empty()).collect();
        let mut text = String::new();
        input
            .into_reader()
            .read_to_string(&mut text)
            .map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        let mut raw = RawColumns::new(request.source());
        let Table { lists, mut stamps, columns, lines } =
            Table::of(&text, STATE, request.source())?;
        let command = match control.is_empty() {
            true => None,
            false => Table::of(&control, CONTROL, "control.csv").ok(),
        };
        raw.lines = lines;
        let state_stamps = stamps.clone();
        if stamps.windows(2).any(|pair| pair[1] - pair[0] > LONGEST_STEP) {
            let first = stamps[0];
            stamps.iter_mut().for_each(|t| *t = (*t - first) / 1e6);
            raw.notes.push(format!("stamps in microseconds; time origin: {} s", first / 1e6));
        }
        raw = raw.with("t", stamps);
        let joints = columns.len() / lists.len().max(1);
        if !names.is_empty() && names.len() != joints {
            let (expected, found) = (names.len(), joints);
            return Err(
                fault(Fault::LengthMismatch { expected, found }).in_column("joint_list.txt")
            );
        }
        for (k, column) in columns.into_iter().enumerate() {
            let (list, joint) = (k / joints, k % joints);
            let Some(quantity) = lists.get(list) else { continue };
            let name = match names.get(joint) {
                Some(name) => format!("{name}/{quantity}"),
                None => format!("joint_{}/{quantity}", joint + 1),
            };
            raw = raw.with(name, column);
        }
        if let Some(commands) = command.as_ref().and_then(|table| table.held_at(&state_stamps)) {
            for (joint, column) in commands.into_iter().take(joints).enumerate() {
                let name = match names.get(joint) {
                    Some(name) => format!("{name}/command"),
                    None => format!("joint_{}/command", joint + 1),
                };
                raw = raw.with(name, column);
            }
            raw.notes.push("commands from control.csv beside the file".to_owned());
        }
        if names.is_empty() {
            let note = "no joint_list.txt beside the file: joints are numbered";
            raw.notes.push(note.to_owned());
        }
        request.wanted(&raw.names(), 0)?;
        Ok(raw)
    }
}

/// Rows of one type: stamps, and a column for each entry of each list.
struct Table {
    lists: Vec<String>,
    stamps: Vec<f64>,
    columns: Vec<Vec<f64>>,
    lines: Vec<u64>,
}

impl Table {
    fn of(text: &str, kind: &str, source: &str) -> Result<Self, RecordingError> {
        let fault = |fault| RecordingError::new(fault, source);
        let mut rows = ::csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
        let header = rows.headers().map_err(|_| fault(Fault::HeaderNotUtf8))?.clone();
        let lists: Vec<String> = header.iter().skip(2).map(quantity).collect();
        let (mut stamps, mut columns) = (Vec::new(), Vec::<Vec<f64>>::new());
        let mut lines = Vec::new();
        for row in rows.records() {
            let row = row.map_err(|error| {
                let error = std::io::Error::other(error.to_string());
                fault(Fault::Io { doing: "read", error })
            })?;
            if row.get(0) != Some(kind) {
                continue;
            }
            let line = row.position().map_or(0, ::csv::Position::line);
            let wrong = |text: &str| {
                let text = text.chars().take(40).collect();
                fault(Fault::NotANumber { text }).on_line(line)
            };
            let stamp = row.get(1).unwrap_or_default();
            let mut values = Vec::new();
            for field in row.iter().skip(2) {
                let inside = field.trim().trim_start_matches('[').trim_end_matches(']');
                for text in inside.split(',').map(str::trim).filter(|text| !text.is_empty()) {
                    values.push(text.parse::<f64>().map_err(|_| wrong(text))?);
                }
            }
            if columns.is_empty() {
                if values.is_empty() || !values.len().is_multiple_of(lists.len()) {
                    let (expected, found) = (lists.len(), values.len());
                    return Err(fault(Fault::RaggedRow { expected, found }).on_line(line));
                }
                columns.resize(values.len(), Vec::new());
            }
            if values.len() != columns.len() {
                let (expected, found) = (columns.len(), values.len());
                return Err(fault(Fault::RaggedRow { expected, found }).on_line(line));
            }
            stamps.push(stamp.parse::<f64>().map_err(|_| wrong(stamp))?);
            lines.push(line);
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
        }
        if stamps.is_empty() {
            return Err(fault(Fault::HeaderOnly));
        }
        Ok(Self { lists, stamps, columns, lines })
    }

    /// The columns at other stamps, each value held until the next; none where stamps decrease.
    fn held_at(&self, stamps: &[f64]) -> Option<Vec<Vec<f64>>> {
        let at = |column: &Vec<f64>| {
            let place = |stamp: &f64| self.stamps.partition_point(|own| own <= stamp).max(1) - 1;
            stamps.iter().map(|stamp| column[place(stamp)]).collect()
        };
        let is_sorted = self.stamps.windows(2).all(|pair| pair[0] <= pair[1]);
        is_sorted.then(|| self.columns.iter().map(at).collect())
    }
}

/// The standard name of a list, or its own.
fn quantity(list: &str) -> String {
    let name = list.trim();
    crate::mapping::synonym(name).map_or(name, |(quantity, _)| quantity.suffix()).to_owned()
}
