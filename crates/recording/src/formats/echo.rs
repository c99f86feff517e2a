//! Text of `ros2 topic echo --csv` on joint states: rows without a header.
//!
//! A row is seconds, nanoseconds, frame, the names of all joints, then their positions, velocities and efforts, of which
//! velocities or efforts may be empty.

use std::io::Read as _;

use super::format::{ColumnRequest, FileStart, Format, Input, Support};
use crate::error::{Fault, RecordingError, plural};
use crate::quantity::Quantity;
use crate::raw::RawColumns;

/// Rows of joint states as ROS 2 prints them.
#[derive(Debug, Clone, Copy)]
pub struct Echo;

/// Quantities of a row, in their order.
const QUANTITIES: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Effort];
/// Seconds from this on are those of a clock; their origin becomes the first \[s\].
const CLOCK_S: i64 = 100_000_000;

/// One row.
struct Row<'t> {
    sec: i64,
    nanosec: u32,
    names: Vec<&'t str>,
    values: Vec<f64>,
}

impl<'t> Row<'t> {
    /// None if the line is no joint state.
    fn of(line: &'t str) -> Option<Self> {
        let mut fields = line.split(',').map(str::trim);
        let sec = fields.next()?.parse().ok()?;
        let nanosec = fields.next()?.parse().ok().filter(|n| *n < 1_000_000_000)?;
        let frame = fields.next()?;
        let rest: Vec<&str> = fields.collect();
        let count = rest.iter().take_while(|field| field.parse::<f64>().is_err()).count();
        let names = rest[..count].to_vec();
        let numbers = rest[count..].iter().map(|field| field.parse());
        let values = numbers.collect::<Result<Vec<f64>, _>>().ok()?;
        let is_state = frame.parse::<f64>().is_err()
            && count > 0
            && names.iter().all(|name| !name.is_empty())
            && [1, 2, 3].iter().any(|lists| values.len() == lists * count);
        is_state.then_some(Self { sec, nanosec, names, values })
    }
}

impl Format for Echo {
    fn name(&self) -> &'static str {
        "ros2 topic echo"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &[]
    }

    fn support(&self) -> Support {
        Support::Read
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        let line = start.bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
        std::str::from_utf8(line).is_ok_and(|line| Row::of(line).is_some())
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
        let mut rows: Vec<(u64, Row<'_>)> = Vec::new();
        let lines: Vec<(u64, &str)> =
            (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).collect();
        let (mut others, mut is_truncated) = (0, false);
        for (k, (number, line)) in lines.iter().enumerate() {
            match (Row::of(line), rows.first()) {
                (Some(row), Some((_, first))) if row.names.len() != first.names.len() => {
                    others += 1;
                }
                (Some(row), _) => rows.push((*number, row)),
                // a killed program leaves a part of a line
                (None, Some(_)) if k + 1 == lines.len() => is_truncated = true,
                (None, _) => {
                    let fields = |line: &str| line.split(',').count();
                    let (expected, found) = (fields(lines[0].1), fields(line));
                    if found != expected {
                        return Err(fault(Fault::RaggedRow { expected, found }).on_line(*number));
                    }
                    let text: String = line.chars().take(40).collect();
                    return Err(fault(Fault::NotANumber { text }).on_line(*number));
                }
            }
        }
        let Some((_, first)) = rows.first() else { return Err(fault(Fault::Empty)) };
        let (names, lists) = (first.names.clone(), first.values.len() / first.names.len());
        let zero = if first.sec > CLOCK_S { first.sec } else { 0 };
        let mut columns = vec![Vec::new(); 1 + lists * names.len()];
        for (number, row) in &rows {
            let places: Option<Vec<usize>> = (names.iter())
                .map(|name| row.names.iter().position(|other| other == name))
                .collect();
            let Some(places) = places.filter(|_| row.values.len() == lists * names.len()) else {
                others += 1;
                continue;
            };
            columns[0].push((row.sec - zero) as f64 + f64::from(row.nanosec) / 1e9);
            for (joint, place) in places.iter().enumerate() {
                for list in 0..lists {
                    columns[1 + list * names.len() + joint]
                        .push(row.values[list * names.len() + place]);
                }
            }
            raw.lines.push(*number);
        }
        let mut columns = columns.into_iter();
        raw = raw.with("t", columns.next().unwrap_or_default());
        for quantity in &QUANTITIES[..lists] {
            for name in &names {
                raw = raw.with(format!("{name}/{quantity}"), columns.next().unwrap_or_default());
            }
        }
        raw.notes.push(
            "joint states without a header, as `ros2 topic echo --csv` prints them".to_owned(),
        );
        if zero != 0 {
            raw.notes.push(format!("time origin: {zero} s"));
        }
        if lists == 2 {
            let note = "rows have two lists of numbers, read as positions and velocities";
            raw.notes.push(note.to_owned());
        }
        if others > 0 {
            raw.notes.push(format!("ignored {others} row{} with other joints", plural(others)));
        }
        if is_truncated {
            raw.notes.push(
                "truncated file (its last row is incomplete); read up to that point".to_owned(),
            );
        }
        request.wanted(&raw.names(), 0)?;
        Ok(raw)
    }
}
