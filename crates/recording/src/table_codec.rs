//! Tables in Parquet: columns of texts, numbers and lists of numbers.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use ::parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType, ZstdLevel};
use ::parquet::column::reader::ColumnReader;
use ::parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::{ColumnPath, PrimitiveTypeBuilder, Type, TypePtr};

use crate::error::{Fault, RecordingError};
use crate::table_column::{TableColumn, TableKind};

/// Rows read at a time.
const BATCH: usize = if cfg!(test) { 2 } else { 1 << 12 };

/// An open file.
pub(crate) struct Reader {
    file: SerializedFileReader<File>,
    source: String,
}

impl Reader {
    pub(crate) fn open(path: &Path) -> Result<Self, RecordingError> {
        let source = path.display().to_string();
        let file = File::open(path)
            .map_err(|error| RecordingError::new(Fault::Io { doing: "opened", error }, &source))?;
        let file = SerializedFileReader::new(file).map_err(|error| broken(&error, &source))?;
        Ok(Self { file, source })
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let root = self.file.metadata().file_metadata().schema();
        root.get_fields().iter().map(|field| field.name().to_owned()).collect()
    }

    pub(crate) fn groups(&self) -> usize {
        self.file.num_row_groups()
    }

    pub(crate) fn column(
        &self,
        group: usize,
        name: &str,
    ) -> Result<Option<TableColumn>, RecordingError> {
        self.read(group, name).map_err(|error| broken(&error, &self.source).in_column(name))
    }

    fn read(&self, group: usize, name: &str) -> Result<Option<TableColumn>, ParquetError> {
        let schema = self.file.metadata().file_metadata().schema_descr();
        let of_name =
            |k: &usize| schema.column(*k).path().parts().first().is_some_and(|p| p == name);
        let mut leaves = (0..schema.num_columns()).filter(of_name);
        let (Some(index), None) = (leaves.next(), leaves.next()) else { return Ok(None) };
        let column = schema.column(index);
        let full = column.max_def_level();
        let lists = column.max_rep_level();
        let reader = self.file.get_row_group(group)?.get_column_reader(index)?;
        let (mut levels, mut begins) = (Vec::new(), Vec::new());
        macro_rules! values {
            ($reader:expr) => {{
                let (mut reader, mut values) = ($reader, Vec::new());
                while reader
                    .read_records(BATCH, Some(&mut levels), Some(&mut begins), &mut values)?
                    .0
                    > 0
                {}
                values
            }};
        }
        Ok(match reader {
            ColumnReader::ByteArrayColumnReader(reader) if lists == 0 => {
                let values = values!(reader);
                let texts: Result<Vec<String>, ParquetError> =
                    values.iter().map(|value| Ok(value.as_utf8()?.to_owned())).collect();
                Some(TableColumn::Text(with_gaps(texts?, &levels, full)))
            }
            ColumnReader::DoubleColumnReader(reader) => {
                let values = values!(reader);
                match lists {
                    0 => Some(TableColumn::Number(with_gaps(values, &levels, full))),
                    1 => {
                        let gap = column.self_type().is_optional().then(|| full - 1);
                        Some(TableColumn::Numbers(in_lists(values, &levels, &begins, full, gap)))
                    }
                    _ => None,
                }
            }
            ColumnReader::Int64ColumnReader(reader) if lists == 0 => {
                Some(TableColumn::Whole(with_gaps(values!(reader), &levels, full)))
            }
            ColumnReader::Int32ColumnReader(reader) if lists == 0 => {
                let values = values!(reader).into_iter().map(i64::from).collect();
                Some(TableColumn::Whole(with_gaps(values, &levels, full)))
            }
            _ => None,
        })
    }
}

fn broken(error: &ParquetError, source: &str) -> RecordingError {
    RecordingError::new(Fault::Broken { format: "Parquet", what: error.to_string() }, source)
}

/// Values with nothing where a row has none.
fn with_gaps<T>(values: Vec<T>, levels: &[i16], full: i16) -> Vec<Option<T>> {
    if full == 0 {
        return values.into_iter().map(Some).collect();
    }
    let mut values = values.into_iter();
    levels.iter().map(|level| if *level == full { values.next() } else { None }).collect()
}

/// Lists of rows; a level of `gap` is an entry without a value, one below it a list without entries.
fn in_lists(
    values: Vec<f64>,
    levels: &[i16],
    begins: &[i16],
    full: i16,
    gap: Option<i16>,
) -> Vec<Vec<f64>> {
    let mut lists: Vec<Vec<f64>> = Vec::new();
    let mut values = values.into_iter();
    for (level, begin) in levels.iter().zip(begins) {
        if *begin == 0 {
            lists.push(Vec::new());
        }
        let Some(list) = lists.last_mut() else { continue };
        if *level == full {
            list.extend(values.next());
        } else if Some(*level) == gap {
            list.push(f64::NAN);
        }
    }
    lists
}

/// A value that may be missing.
fn primitive(name: &str, physical: PhysicalType) -> PrimitiveTypeBuilder<'_> {
    Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL)
}

/// A column as pyarrow declares it: every value may be missing.
fn field(name: &str, kind: TableKind) -> Result<TypePtr, ParquetError> {
    Ok(Arc::new(match kind {
        TableKind::Text => primitive(name, PhysicalType::BYTE_ARRAY)
            .with_logical_type(Some(LogicalType::String))
            .build()?,
        TableKind::Number => primitive(name, PhysicalType::DOUBLE).build()?,
        TableKind::Whole => primitive(name, PhysicalType::INT64).build()?,
        TableKind::Numbers => {
            let element = Arc::new(primitive("element", PhysicalType::DOUBLE).build()?);
            let list = Type::group_type_builder("list")
                .with_repetition(Repetition::REPEATED)
                .with_fields(vec![element])
                .build()?;
            Type::group_type_builder(name)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(Some(LogicalType::List))
                .with_fields(vec![Arc::new(list)])
                .build()?
        }
    }))
}

pub(crate) fn write(
    out: &mut dyn io::Write,
    columns: &[(&str, TableKind)],
    mut next: impl FnMut() -> io::Result<Option<Vec<TableColumn>>>,
) -> io::Result<()> {
    let fields = columns.iter().map(|(name, kind)| field(name, *kind)).collect::<Result<_, _>>();
    let schema = fields
        .and_then(|fields| Type::group_type_builder("schema").with_fields(fields).build())
        .map_err(io::Error::other)?;
    let mut settings =
        WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default()));
    for (name, kind) in columns {
        // numbers of a list do not repeat
        if *kind == TableKind::Numbers {
            let parts = [*name, "list", "element"].map(ToOwned::to_owned).to_vec();
            settings = settings.set_column_dictionary_enabled(ColumnPath::new(parts), false);
        }
    }
    let settings = Arc::new(settings.build());
    let mut file = SerializedFileWriter::new(Vec::new(), Arc::new(schema), settings)?;
    while let Some(values) = next()? {
        let mut group = file.next_row_group()?;
        for column in &values {
            write_column(&mut group, column)?;
        }
        group.close()?;
        // what is written does not stay in memory
        file.flush()?;
        out.write_all(file.inner())?;
        file.inner_mut().clear();
    }
    let rest = file.into_inner()?;
    out.write_all(&rest)
}

/// Values and levels of a column.
fn write_column(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    column: &TableColumn,
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("more columns than the table has".to_owned());
    let mut writer = group.next_column()?.ok_or_else(missing)?;
    match column {
        TableColumn::Text(texts) => {
            let values: Vec<ByteArray> =
                texts.iter().flatten().map(|text| text.as_bytes().to_vec().into()).collect();
            writer.typed::<ByteArrayType>().write_batch(&values, Some(&present(texts)), None)?;
        }
        TableColumn::Number(numbers) => {
            let values: Vec<f64> = numbers.iter().flatten().copied().collect();
            writer.typed::<DoubleType>().write_batch(&values, Some(&present(numbers)), None)?;
        }
        TableColumn::Whole(numbers) => {
            let values: Vec<i64> = numbers.iter().flatten().copied().collect();
            writer.typed::<Int64Type>().write_batch(&values, Some(&present(numbers)), None)?;
        }
        TableColumn::Numbers(lists) => {
            let values: Vec<f64> = lists.iter().flatten().copied().collect();
            let (mut levels, mut begins) = (Vec::new(), Vec::new());
            for list in lists {
                // an empty list has one entry of levels, and no value
                levels.extend(if list.is_empty() { vec![1] } else { vec![3; list.len()] });
                begins.push(0);
                begins.extend(std::iter::repeat_n(1, list.len().saturating_sub(1)));
            }
            writer.typed::<DoubleType>().write_batch(&values, Some(&levels), Some(&begins))?;
        }
    }
    writer.close()?;
    Ok(())
}

/// Levels of values that may be missing.
fn present<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|value| i16::from(value.is_some())).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;

    #[test]
    fn table_is_read_as_written() {
        let columns = [
            ("name", TableKind::Text),
            ("x", TableKind::Number),
            ("n", TableKind::Whole),
            ("list", TableKind::Numbers),
        ];
        let group = |first: f64| {
            vec![
                TableColumn::Text(vec![Some("a".to_owned()), None, Some(String::new())]),
                TableColumn::Number(vec![None, Some(first), Some(f64::MIN_POSITIVE)]),
                TableColumn::Whole(vec![Some(i64::MAX), Some(-1), None]),
                TableColumn::Numbers(vec![vec![first, 0.1], Vec::new(), vec![1.0 / 3.0; 5000]]),
            ]
        };
        let path = std::env::temp_dir().join(format!("armident_table_{}", std::process::id()));
        let mut groups = [1.5, 2.5].into_iter();
        let mut file = File::create(&path).unwrap();
        write(&mut file, &columns, || Ok(groups.next().map(group))).unwrap();
        let table = Reader::open(&path).unwrap();
        assert_eq!(
            (table.groups(), table.names()),
            (2, ["name", "x", "n", "list"].map(str::to_owned).to_vec())
        );
        for (index, first) in [1.5, 2.5].into_iter().enumerate() {
            for ((name, _), expected) in columns.iter().zip(group(first)) {
                assert_eq!(table.column(index, name).unwrap(), Some(expected));
            }
        }
        assert_eq!(table.column(0, "other").unwrap(), None);
        std::fs::remove_file(&path).unwrap();
    }
}
