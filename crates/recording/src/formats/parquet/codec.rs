//! Reads and writes flat columns of numbers.
//!
//! Columns are named as in CSV. A list of the same length in each row is a column per entry, as LeRobot writes joints: the
//! entries have the names of `meta/info.json` above the file, or numbers. Timestamps (pandas, Polars, DuckDB write them for clocks) become
//! seconds from the whole second of the first, to a quarter of a microsecond; null values become
//! NaN; columns without numbers are ignored.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use ::parquet::basic::{ConvertedType, LogicalType, Repetition, TimeUnit, Type as PhysicalType};
use ::parquet::column::reader::ColumnReader;
use ::parquet::data_type::DoubleType;
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{ColumnDescriptor, Type};

use super::dataset;
use crate::error::{Fault, RecordingError};
use crate::formats::format::{ColumnRequest, Encoded};
use crate::raw::{RawColumn, RawColumns};
use crate::recording::Recording;

/// Reads the wanted columns.
pub(super) fn read_columns(
    file: File,
    path: &Path,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let source = request.source();
    let broken = |error: ParquetError| {
        let what = error.to_string();
        RecordingError::new(Fault::Broken { format: "Parquet", what }, source)
    };
    let wrong_type = |column: &ColumnDescriptor| {
        let found = type_in_words(column).to_owned();
        RecordingError::new(Fault::WrongColumnType { found }, source)
    };
    let reader = SerializedFileReader::new(file).map_err(broken)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let rows = usize::try_from(reader.metadata().file_metadata().num_rows()).unwrap_or(0);
    let read = |index: usize, values: &mut Vec<f64>| -> Result<(), ParquetError> {
        for group in 0..reader.num_row_groups() {
            let pages = reader.get_row_group(group)?.get_column_reader(index)?;
            read_column(pages, &schema.column(index), values)?;
        }
        Ok(())
    };
    // lists are read before the request sees names, as only their values show how many entries they have
    let mut lists: Vec<Option<Vec<Vec<f64>>>> = Vec::new();
    let mut names: Vec<(usize, Option<usize>, String)> = Vec::new();
    for (index, column) in schema.columns().iter().enumerate() {
        let name = match column.max_rep_level() {
            1 => column.path().parts().first().cloned().unwrap_or_default(),
            _ => column.path().string(),
        };
        let mut list = None;
        if column.max_rep_level() == 1 && is_number(column) {
            let mut values = Vec::new();
            read(index, &mut values).map_err(broken)?;
            list = columns_of_list(&values, rows);
        }
        match &list {
            Some(columns) => {
                let entries = dataset::entries(path, &name, columns.len());
                let named = |k: usize| match &entries {
                    Some(entries) => format!("{name}.{}", entries[k]),
                    None => format!("{name}_{}", k + 1),
                };
                names.extend((0..columns.len()).map(|k| (index, Some(k), named(k))));
            }
            None => names.push((index, None, name)),
        }
        lists.push(list);
    }
    let all: Vec<String> = names.iter().map(|(_, _, name)| name.clone()).collect();
    // where lists of numbers cannot be columns, their names are what is missed
    let uneven =
        schema.columns().iter().zip(&lists).find(|(column, list)| {
            column.max_rep_level() == 1 && is_number(column) && list.is_none()
        });
    let wanted = request.wanted(&all, 0).map_err(|missing| match uneven {
        Some((column, _)) => {
            let name = column.path().parts().first().cloned().unwrap_or_default();
            wrong_type(column).in_column(&name)
        }
        None => missing,
    })?;
    let mut raw = RawColumns::new(source);
    for ((index, entry, name), wanted) in names.into_iter().zip(wanted) {
        let description = schema.column(index);
        let list = entry.and_then(|k| Some(lists[index].as_ref()?[k].clone()));
        let mut values = None;
        if wanted && list.is_some() {
            values = list;
        } else if wanted {
            if !is_number(&description) || description.max_rep_level() > 0 {
                return Err(wrong_type(&description).in_column(&name));
            }
            let mut column = Vec::new();
            read(index, &mut column).map_err(broken)?;
            values = Some(in_seconds(column, &description, &name, &mut raw.notes));
        }
        raw.columns.push(RawColumn { name, values });
    }
    let episodes = schema.columns().iter().position(|c| c.path().string() == dataset::EPISODE);
    if let Some(index) = episodes {
        let mut episode = Vec::new();
        read(index, &mut episode).map_err(broken)?;
        dataset::one_after_the_other(&mut raw, &episode);
    }
    Ok(raw)
}

fn is_number(column: &ColumnDescriptor) -> bool {
    let numbers =
        [PhysicalType::INT32, PhysicalType::INT64, PhysicalType::FLOAT, PhysicalType::DOUBLE];
    numbers.contains(&column.physical_type())
}

/// Whether it has integers that count a power of ten: their `type_scale`.
fn is_decimal(column: &ColumnDescriptor) -> bool {
    matches!(column.logical_type_ref(), Some(LogicalType::Decimal { .. }))
        || column.converted_type() == ConvertedType::DECIMAL
}

/// What a column has that is no number in each row.
fn type_in_words(column: &ColumnDescriptor) -> &'static str {
    if column.max_rep_level() > 1 {
        return "lists of lists";
    }
    if column.max_rep_level() == 1 && is_number(column) {
        return "lists of different lengths";
    }
    match column.physical_type() {
        PhysicalType::BOOLEAN => "true and false",
        PhysicalType::INT96 => "time stamps in the old INT96 type",
        _ if is_decimal(column) => "decimal numbers of fixed precision in more than 64 bits",
        _ => "text",
    }
}

/// Entries of lists that have the same length in every row, a column each; none of other lists, and of lists too long for
/// joints: images.
fn columns_of_list(values: &[f64], rows: usize) -> Option<Vec<Vec<f64>>> {
    const LONGEST: usize = 100;
    let count = values.len().checked_div(rows)?;
    let is_even = (1..=LONGEST).contains(&count) && values.len() == count * rows;
    is_even.then(|| {
        (0..count).map(|k| values.iter().skip(k).step_by(count).copied().collect()).collect()
    })
}

/// Appends the values of one row group, NaN where there are none.
fn read_column(
    reader: ColumnReader,
    description: &ColumnDescriptor,
    into: &mut Vec<f64>,
) -> Result<(), ParquetError> {
    let full = description.max_def_level();
    let per_unit =
        if is_decimal(description) { 10_f64.powi(description.type_scale()) } else { 1.0 };
    macro_rules! of_type {
        ($reader:expr) => {{
            let mut reader = $reader;
            loop {
                let (mut levels, mut values) = (Vec::new(), Vec::new());
                // of lists only: where each begins
                let mut begins = Vec::new();
                let (rows, _, _) = reader.read_records(
                    BATCH,
                    Some(&mut levels),
                    Some(&mut begins),
                    &mut values,
                )?;
                if rows == 0 {
                    return Ok(());
                }
                let mut values = values.into_iter().map(|value| value as f64 / per_unit);
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
