//! Formats that are recognised but not read, with their converters.

use super::format::{EXPORT_CSV, FileStart, Format, Support};

/// All of them. The first match counts, so the more specific stand first.
pub(super) const ALL: &[&dyn Format] = &[
    &Known { name: "UTF-16 text", magic: b"\xff\xfe", ..KNOWN },
    &Known { name: "UTF-16 text", magic: b"\xfe\xff", ..KNOWN },
    &Known {
        name: "ROS 1 bag",
        extensions: &["bag"],
        magic: b"#ROSBAG",
        converter: "convert it by `mcap convert in.bag out.mcap` (mcap.dev/guides/cli)",
        ..KNOWN
    },
    &Known {
        name: "SQLite database (ROS 2 bag)",
        extensions: &["db3"],
        magic: b"SQLite format 3",
        converter: "convert it by `mcap convert in.db3 out.mcap` (mcap.dev/guides/cli), or by \
                    `ros2 bag convert`",
        ..KNOWN
    },
    &Known { name: "gzip archive", extensions: &["gz"], magic: b"\x1f\x8b", ..KNOWN },
    &Known {
        name: "MATLAB file",
        extensions: &["mat"],
        magic: b"MATLAB 5.0 MAT-file",
        converter: MATLAB,
        ..KNOWN
    },
    &Known {
        name: "HDF5 file",
        extensions: &["mat", "h5"],
        magic: b"\x89HDF",
        converter: MATLAB,
        ..KNOWN
    },
    &Known {
        name: "NumPy file",
        extensions: &["npy"],
        magic: b"\x93NUMPY",
        converter: NUMPY,
        ..KNOWN
    },
    // a ZIP archive; only the extension distinguishes it
    &Known {
        name: "NumPy file",
        extensions: &["npz"],
        magic: ZIP,
        needs_extension: true,
        converter: NUMPY,
    },
    &Known {
        name: "ZIP archive or spreadsheet",
        extensions: &["zip", "xlsx"],
        magic: ZIP,
        ..KNOWN
    },
    &Binary,
];

const ZIP: &[u8] = b"PK\x03\x04";
const MATLAB: &str = "in MATLAB: `writematrix([t q dq tau], 'log.csv')`, with a first line `t, \
                      <joint>/position, ...`; in Python scipy.io.loadmat (h5py for version 7.3) \
                      reads it";
const NUMPY: &str = "in Python: `numpy.savetxt(\"log.csv\", columns, delimiter=\",\", \
                     header=\"t,<joint>/position,...\", comments=\"\")`";

/// A format with magic bytes.
#[derive(Debug)]
struct Known {
    name: &'static str,
    extensions: &'static [&'static str],
    magic: &'static [u8],
    /// Whether the extension must fit too.
    needs_extension: bool,
    converter: &'static str,
}

const KNOWN: Known =
    Known { name: "", extensions: &[], magic: &[], needs_extension: false, converter: EXPORT_CSV };

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
            && (!self.needs_extension || start.has_extension(self.extensions))
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
