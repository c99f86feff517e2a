//! Formats that are recognised but not read, with their converters.

use super::format::{EXPORT_CSV, FileStart, Format, Support};

/// All of them. The first match counts, so the more specific stand first.
pub(super) const ALL: &[&dyn Format] = &[
    &Known { name: "UTF-16 text", magic: b"\xff\xfe", ..KNOWN },
    &Known { name: "UTF-16 text", magic: b"\xfe\xff", ..KNOWN },
    &Known { name: "gzip archive", extensions: &["gz"], magic: b"\x1f\x8b", ..KNOWN },
    &Known { name: "NumPy file", extensions: &["npy"], magic: b"\x93NUMPY", converter: NUMPY },
    &Known {
        name: "ZIP archive or spreadsheet",
        extensions: &["zip", "xlsx"],
        magic: ZIP,
        ..KNOWN
    },
    &Binary,
];

const ZIP: &[u8] = b"PK\x03\x04";
const NUMPY: &str = "put the time and the arrays of joints into one file: `numpy.savez(\"log.npz\", t=t, q=q, tau=tau)`";

/// A format with magic bytes.
#[derive(Debug)]
struct Known {
    name: &'static str,
    extensions: &'static [&'static str],
    magic: &'static [u8],
    converter: &'static str,
}

const KNOWN: Known = Known { name: "", extensions: &[], magic: &[], converter: EXPORT_CSV };

impl Format for Known {
    fn name(&self) -> &'static str {
        self.name
    }

    fn extensions(&self) -> &'static [&'static str] {
        self.extensions
    }

    fn support(&self) -> Support {
        Support::Convert(self.converter)
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(self.magic)
    }
}

/// Anything else that is no text.
#[derive(Debug)]
struct Binary;

impl Format for Binary {
    fn name(&self) -> &'static str {
        "binary data"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &[]
    }

    fn support(&self) -> Support {
        Support::Convert(EXPORT_CSV)
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.contains(&0)
    }
}
