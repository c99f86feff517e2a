//! HDF5 and MATLAB files of version 7.3, which are HDF5: their arrays, also in groups (cargo feature `all-formats`).

use super::format::{FileStart, Format, Support};
#[cfg(feature = "all-formats")]
use {
    super::arrays::{Array, Content, columns, with_short_names},
    super::format::{ColumnRequest, Input},
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
    ::hdf5_pure::{AttrValue, DType, Dataset, File, Group, Object},
    std::io::Read as _,
};
#[cfg(not(feature = "all-formats"))]
use {
    super::format::{ColumnRequest, Input},
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
};

/// HDF5 files, MATLAB's of version 7.3 among them.
#[derive(Debug, Clone, Copy)]
pub struct Hdf5;

const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";
const MATLAB: &[u8] = b"MATLAB 7.3 MAT-file";
/// Deepest group that is read.
#[cfg(feature = "all-formats")]
const DEEPEST: usize = 6;
/// Most numbers of one array.
#[cfg(feature = "all-formats")]
const LARGEST: u64 = 1 << 28;

impl Format for Hdf5 {
    fn name(&self) -> &'static str {
        "HDF5"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["h5", "hdf5"]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "all-formats") { Support::Read } else { Support::Feature("all-formats") }
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(MAGIC) || start.bytes.starts_with(MATLAB)
    }

    #[cfg(not(feature = "all-formats"))]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        // a file of another version or format is nearer than another program
        let (format, advice) = if input.start().starts_with(MATLAB) {
            (
                "MATLAB file of version 7.3",
                "save it for version 7 in MATLAB: `save('log.mat', '-v7')`, or build armident with `--features all-formats`",
            )
        } else {
            (
                "HDF5 file",
                "build armident with `--features all-formats`, or write its arrays by `numpy.savez(\"log.npz\", **arrays)`; \
                 the Python package h5py reads them",
            )
        };
        Err(RecordingError::new(Fault::Unsupported { format, advice }, request.source()))
    }

    #[cfg(feature = "all-formats")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let fault = |fault| RecordingError::new(fault, request.source());
        let mut bytes = Vec::new();
        input
            .into_reader()
            .read_to_end(&mut bytes)
            .map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        let broken = |what: String| fault(Fault::Broken { format: "HDF5", what });
        let file = File::from_bytes(bytes).map_err(|error| broken(error.to_string()))?;
        let (mut arrays, mut lost) = (Vec::new(), Vec::new());
        group(&file.root(), "", 0, &mut arrays, &mut lost);
        if arrays.is_empty() && !lost.is_empty() {
            return Err(broken(lost.join("; ")));
        }
        let mut raw = columns(with_short_names(arrays), request)?;
        if !lost.is_empty() {
            raw.notes.push(format!("arrays that cannot be read: {}", lost.join("; ")));
        }
        Ok(raw)
    }
}

/// Adds the arrays of a group, named `<group>.<array>`, and what cannot be read.
#[cfg(feature = "all-formats")]
fn group(
    within: &Group,
    name: &str,
    depth: usize,
    arrays: &mut Vec<Array>,
    lost: &mut Vec<String>,
) {
    let full = |own: &str| match name {
        "" => own.to_owned(),
        name => format!("{name}.{own}"),
    };
    match within.datasets() {
        Ok(names) => {
            for own in names {
                let read = within.dataset(&own).map_err(|error| error.to_string());
                match read.and_then(|dataset| content(&dataset)) {
                    Ok(content) => arrays.push(Array { name: full(&own), content }),
                    Err(what) => lost.push(format!("`{}`: {what}", full(&own))),
                }
            }
        }
        Err(error) => lost.push(error.to_string()),
    }
    if depth == DEEPEST {
        return;
    }
    // what cells of MATLAB refer to is found through them
    for own in within.groups().unwrap_or_default().into_iter().filter(|own| !own.starts_with('#')) {
        if let Ok(inner) = within.group(&own) {
            group(&inner, &full(&own), depth + 1, arrays, lost);
        }
    }
}

#[cfg(feature = "all-formats")]
fn content(dataset: &Dataset) -> Result<Content, String> {
    let in_words = |error: hdf5_pure::Error| error.to_string();
    let shape = dataset.shape().map_err(in_words)?;
    let count = shape.iter().try_fold(1_u64, |all, n| all.checked_mul(*n)).unwrap_or(u64::MAX);
    if count > LARGEST {
        return Err(format!("{count} numbers, at most {LARGEST} are read"));
    }
    let class = match dataset.attrs().ok().and_then(|mut attrs| attrs.remove("MATLAB_class")) {
        Some(AttrValue::AsciiString(class) | AttrValue::String(class)) => class,
        _ => String::new(),
    };
    Ok(match dataset.dtype().map_err(in_words)? {
        DType::ObjectReference => cells(dataset)?,
        DType::String | DType::VariableLengthString => {
            Content::Texts(dataset.read_string().map_err(in_words)?)
        }
        _ if class == "char" => Content::Texts(vec![letters(dataset)?]),
        DType::F32
        | DType::F64
        | DType::I8
        | DType::I16
        | DType::I32
        | DType::I64
        | DType::U8
        | DType::U16
        | DType::U32
        | DType::U64 => {
            let values = dataset.read_f64().map_err(in_words)?;
            if values.len() as u64 != count {
                return Err(format!("{} values, expected {count}", values.len()));
            }
            Content::Numbers(shape.into_iter().map(|n| n as usize).collect(), values)
        }
        other => Content::Other(other.to_string()),
    })
}

/// Texts of a cell array; anything else in it is not read.
#[cfg(feature = "all-formats")]
fn cells(dataset: &Dataset) -> Result<Content, String> {
    let of = |object: Object| match object {
        Object::Dataset(inner) => letters(&inner).ok(),
        _ => None,
    };
    let objects = dataset.dereference().map_err(|error| error.to_string())?;
    let texts: Option<Vec<String>> = objects.into_iter().map(of).collect();
    Ok(texts.map_or_else(|| Content::Other("cells".to_owned()), Content::Texts))
}

/// A row of letters, which MATLAB stores as UTF-16.
#[cfg(feature = "all-formats")]
fn letters(dataset: &Dataset) -> Result<String, String> {
    if !matches!(dataset.dtype(), Ok(DType::U16)) {
        return Err("no letters".to_owned());
    }
    let letters = dataset.read_u16().map_err(|error| error.to_string())?;
    Ok(String::from_utf16_lossy(&letters).trim_end_matches('\0').to_owned())
}
