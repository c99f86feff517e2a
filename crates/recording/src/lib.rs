//! Reads recorded files into checked joint channels.
//!
//! # From a file to a recording
//!
//! [`read_recording`], with a [`Mapping`] for files with names and units of their own, gives a
//! [`Recording`]: time stamps and joint channels, checked, with notes and [`QualityIssue`]s on repairs
//! and doubtful signals. [`read_csv`] and its siblings read CSV only.
//!
//! # Formats
//!
//! CSV is UTF-8 text: one header line, then one line per sample, separated by commas; semicolons, tabs, bars and spaces are
//! recognised:
//!
//! | column | unit |
//! |---|---|
//! | `t` | s, increasing, from any start, not necessarily even |
//! | `<joint>/position` | rad, or m for a prismatic joint |
//! | `<joint>/velocity`, `<joint>/acceleration` | per s, per s² |
//! | `<joint>/effort` | N m, or N for a prismatic joint, on the joint side |
//! | `<joint>/current`, `<joint>/voltage` | A, V |
//! | `<joint>/motor_position` | encoder of the motor, divided by the gear ratio: rad or m |
//! | `<joint>/temperature` | °C |
//! | `<joint>/command` | position that the joint's controller is given: rad or m |
//!
//! NumPy and MATLAB: the same columns as arrays, or arrays of samples by joints. Parquet (feature `parquet`): the same columns.
//! Bags of ROS: messages of joints of one topic, in MCAP (feature `mcap`), SQLite or ROS 1 (feature `all-formats`). [`encode`]
//! writes CSV, NumPy, MCAP and Parquet. [`TableFile`] and [`write_table`] are tables of other things than recordings. HDF5 (feature `all-formats`) has arrays as MATLAB has. Other formats (spreadsheets) are recognised, and the error names a converter. A
//! [`Format`] of another crate joins the list with [`Formats::with`]. [`inspect`] shows what a file with other names holds, and
//! a [`MappingGuess`].
//!
//! Joint names may contain slashes. Other columns are ignored, with a note. Without a column `t`
//! the names of PlotJuggler are understood: `__time` or `time`, then
//! `/joint_states/<joint>/position` and so on. Anything else needs a [`Mapping`].
//!
//! # Defects on reading
//!
//! Defects with a unique repair are repaired, noted and listed in [`Recording::findings`]; defects
//! that would change the result are refused with a hint; others are kept and reported by the
//! quality report of a motion.
//!
//! | defect | repaired | refused |
//! |---|---|---|
//! | duplicate time stamps | dropped, up to 1 % of the samples | above |
//! | decreasing time stamps | sorted, with `sort = true` in a mapping | otherwise |
//! | NaN, empty fields | interpolated, up to 3 in a row and 1 % of a channel | above, at the ends, infinite |
//! | columns without a value | left out | |
//! | channels in rows of their own stamps | interpolated onto those of positions | |
//! | rows of zeros between rows of motion | left out | |
//! | single positions and efforts that jump away and back | interpolated, up to 2 % of a channel | |
//! | efforts of exactly 0 while the joint moves | interpolated, up to 10 in a row and 2 % | |
//! | unreadable fields | | always |
//! | angles that wrap at a full turn | unwrapped | |
//! | duplicate frames while the arm moves | dropped, or the clock pause removed | |
//! | positions in degrees or mm | | if their velocities show it |
//! | recorded derivatives that contradict the position | | if they would be used |
//!
//! Uneven stamps and gaps are kept: motions are resampled.
//!
//! # Not handled
//!
//! Clocks that differ between channels; delays between position and effort.
//!
//! # Example
//!
//! ```
//! use armident_recording::{Quantity, read_csv_from};
//!
//! let mut text = String::from("t,elbow/position,elbow/effort\n");
//! for k in 0..400 {
//!     let t = 0.005 * f64::from(k);
//!     text += &format!("{t},{},{}\n", (6.0 * t).sin(), -7.2 * (6.0 * t).sin());
//! }
//! let recording = read_csv_from(text.as_bytes(), "swing.csv")?;
//!
//! let elbow = recording.joint("elbow").unwrap();
//! assert_eq!(recording.time_s.len(), 400);
//! assert!(elbow.channel(Quantity::Effort).is_some() && elbow.channel(Quantity::Velocity).is_none());
//! # Ok::<(), armident_recording::RecordingError>(())
//! ```

mod error;
mod finding;
mod first_text;
mod foreign_rows;
mod formats;
mod import;
mod inspect;
mod interpolation;
mod limits;
mod mapping;
mod own_stamps;
mod quantity;
mod raw;
mod read;
mod recording;
mod spikes;
mod table;
#[cfg(feature = "parquet")]
mod table_codec;
mod table_column;
mod timing;
mod units;
mod unwrap;
mod velocity_check;
mod whole_file;
mod write;

pub use error::{Fault, RecordingError};
pub use finding::{Action, QualityIssue, QualityIssueKind, Span, percent};
pub use first_text::first_text;
pub use formats::{
    ALL as STANDARD_FORMATS, Bag, ColumnRequest, Csv, Db3, Echo, Encoded, FileStart, Format,
    Formats, Hdf5, Input, JointTopic, Matlab, Mcap, Npz, Parquet, ReadSettings, Rosbag2, Sage,
    Status, StatusLevel, StatusTopic, Support, is_one_recording, write_csv_to,
};
pub use inspect::{Inspection, inspect};
pub use interpolation::{BRIDGED_STEPS, Interpolation};
pub use limits::{MIN_SAMPLES, MISSING_RUN, MISSING_SHARE, REPEATED_SHARE};
pub use mapping::{GuessedChannel, GuessedTime, Mapping, MappingGuess};
pub use quantity::Quantity;
pub use raw::{RawColumn, RawColumns};
pub use read::{
    read_csv, read_csv_from, read_csv_mapped, read_csv_mapped_from, read_recording,
    recording_of_columns,
};
pub use recording::{JointChannels, Recording};
pub use table::{TableFile, tables_are_built, write_table};
pub use table_column::{TableColumn, TableKind};
pub use timing::{GAP_STEPS, Gap, Timing};
pub use velocity_check::findings as velocity_findings;
pub use whole_file::{remove_partial_files, write_whole};
pub use write::{encode, write_csv};
