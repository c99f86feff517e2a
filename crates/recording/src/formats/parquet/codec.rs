//! Reads and writes flat columns of numbers.
//!
//! Columns are named as in CSV. Timestamps (pandas, Polars, DuckDB write them for clocks) become
//! seconds from the whole second of the first, to a quarter of a microsecond; null values become
//! NaN; columns without numbers are ignored.

use std::fs::File;
use std::sync::Arc;

use ::parquet::basic::{LogicalType, Repetition, TimeUnit, Type as PhysicalType};
use ::parquet::column::reader::ColumnReader;
use ::parquet::data_type::DoubleType;
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{ColumnDescriptor, Type};

use crate::error::{Fault, RecordingError};
use crate::formats::format::{ColumnRequest, Encoded};
use crate::raw::{RawColumn, RawColumns};
use crate::recording::Recording;

/// Reads the wanted columns.
pub(super) fn read_columns(
    file: File,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let source = request.source();
    let broken = |error: ParquetError| {
        let what = error.to_string();
        RecordingError::new(Fault::Broken { format: "Parquet", what }, source)
    };
    let reader = SerializedFileReader::new(file).map_err(broken)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let names: Vec<String> = schema.columns().iter().map(|c| c.path().string()).collect();
    let wanted = request.wanted(&names, 0)?;
    let mut raw = RawColumns::new(source);
    for (index, (name, wanted)) in names.into_iter().zip(wanted).enumerate() {
        let description = schema.column(index);
        let mut values = None;
        if wanted {
            if !is_numbers(&description) {
                let text = format!("{} values", description.physical_type());
                return Err(
                    RecordingError::new(Fault::NotANumber { text }, source).in_column(&name)
                );
            }
            let mut column = Vec::new();
            for group in 0..reader.num_row_groups() {
                let group = reader.get_row_group(group).map_err(broken)?;
                let pages = group.get_column_reader(index).map_err(broken)?;
                read_column(pages, &description, &mut column).map_err(broken)?;
            }
            values = Some(in_seconds(column, &description, &name, &mut raw.notes));
        }
        raw.columns.push(RawColumn { name, values });
    }
    Ok(raw)
}

fn is_numbers(column: &ColumnDescriptor) -> bool {
    let numbers =
        [PhysicalType::INT32, PhysicalType::INT64, PhysicalType::FLOAT, PhysicalType::DOUBLE];
    column.max_rep_level() == 0 && numbers.contains(&column.physical_type())
}

/// Appends the values of one row group, NaN where there are none.
fn read_column(
    reader: ColumnReader,
    description: &ColumnDescriptor,
    into: &mut Vec<f64>,
) -> Result<(), ParquetError> {
    let full = description.max_def_level();
    macro_rules! of_type {
        ($reader:expr) => {{
            let mut reader = $reader;
            loop {
                let (mut levels, mut values) = (Vec::new(), Vec::new());
                let (rows, _, _) =
                    reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
                if rows == 0 {
                    return Ok(());
                }
                let mut values = values.into_iter().map(|value| value as f64);
                if full == 0 {
                    into.extend(values);
                } else {
                    let mut value_at = |level: &i16| match *level == full {
                        true => values.next().unwrap_or(f64::NAN),
                        false => f64::NAN,
                    };
                    into.extend(levels.iter().map(&mut value_at));
                }
            }
        }};
    }
    match reader {
        ColumnReader::Int32ColumnReader(reader) => of_type!(reader),
        ColumnReader::Int64ColumnReader(reader) => of_type!(reader),
        ColumnReader::FloatColumnReader(reader) => of_type!(reader),
        ColumnReader::DoubleColumnReader(reader) => of_type!(reader),
        _ => Ok(()),
    }
}

/// Rows read at a time.
const BATCH: usize = 1 << 16;

/// Timestamps of a clock as seconds from the whole second of the first.
fn in_seconds(
    mut column: Vec<f64>,
    description: &ColumnDescriptor,
    name: &str,
    notes: &mut Vec<String>,
) -> Vec<f64> {
    let per_s = match description.logical_type_ref() {
        Some(LogicalType::Timestamp(clock)) => match clock.unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        },
        _ => return column,
    };
    let zero = column.first().map_or(0.0, |first| (first / per_s).floor() * per_s);
    for t in &mut column {
        *t = (*t - zero) / per_s;
    }
    notes.push(format!("time origin of `{name}`: {} s", zero / per_s));
    column
}

/// The recording as Parquet, columns as in CSV; every number as it is.
///
/// # Errors
/// The recording is inconsistent.
pub(super) fn write(recording: &Recording) -> Result<Encoded, RecordingError> {
    recording.check()?;
    let fault = |error: ParquetError| {
        let error = std::io::Error::other(error.to_string());
        RecordingError::new(Fault::Io { doing: "written", error }, &recording.source)
    };
    let mut columns = vec![("t".to_owned(), recording.time_s.as_slice())];
    for joint in &recording.joints {
        let named = |(quantity, values)| (format!("{}/{quantity}", joint.name), values);
        columns.extend(joint.channels().map(named));
    }
    let field = |(name, _): &(String, &[f64])| {
        let column = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
        Ok(Arc::new(column.with_repetition(Repetition::REQUIRED).build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, ParquetError>>();
    let schema = fields
        .and_then(|fields| Type::group_type_builder("schema").with_fields(fields).build())
        .map_err(fault)?;
    let mut bytes = Vec::new();
    let write = || -> Result<(), ParquetError> {
        let settings = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), settings)?;
        let mut group = file.next_row_group()?;
        for (_, values) in &columns {
            if let Some(mut column) = group.next_column()? {
                column.typed::<DoubleType>().write_batch(values, None, None)?;
                column.close()?;
            }
        }
        group.close()?;
        file.close()?;
        Ok(())
    };
    write().map_err(fault)?;
    Ok(Encoded { bytes, omitted: Vec::new() })
}
