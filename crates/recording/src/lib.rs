//! Reads recorded files into checked joint channels.
//!
//! # From a file to a recording
//!
//! [`read_csv`], or [`read_csv_mapped`] with a [`Mapping`] for files with names and units of
//! their own, gives a [`Recording`]: time stamps and joint channels, checked, with notes and
//! [`Finding`]s on what was doubtful or repaired.
//!
//! # Formats
//!
//! Comma-separated UTF-8 text. One header line, one line per sample:
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
//!
//! [`read_recording`] also reads MCAP, the recordings of ROS 2 (feature `mcap`: `sensor_msgs/JointState`
//! of one topic), and Parquet (feature `parquet`: the same columns as above); [`encode`] writes them.
//!
//! Joint names may contain slashes. Other columns are ignored, with a note. Without a column `t`
//! the names of PlotJuggler are understood: `__time` or `time`, then
//! `/joint_states/<joint>/position` and so on. Anything else needs a [`Mapping`].
//!
//! # Defects on reading
//!
//! What can be repaired without guessing is repaired, noted and listed in
//! [`Recording::findings`]; what would change the result is refused with advice; the rest is kept
//! and reported by the quality report of a motion.
//!
//! | defect | repaired | refused |
//! |---|---|---|
//! | stamps that repeat | dropped, up to 1 % of the samples | above |
//! | stamps that go back | sorted, if a mapping says so | otherwise |
//! | NaN | interpolated, up to 3 in a row and 1 % of a channel | above, at the ends, infinite |
//! | empty or unreadable fields | | always |
//! | angles that wrap at a full turn | made continuous | |
//! | frames that repeat the one before while the arm moves | not used, or the clock stood there | |
//! | positions in degrees or mm | | if their velocities show it |
//! | recorded derivatives that contradict the position | | if they would be used |
//!
//! Uneven stamps and gaps are kept: motions are resampled.
//!
//! # Not handled
//!
//! Other formats (ROS 1 bags, SQLite bags, MATLAB, NumPy: it is said what converts them); stamps that differ between
//! channels; delays between position and effort.
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

mod csv;
mod csv_write;
mod draft;
mod error;
mod finding;
mod header;
mod interpolation;
mod mapping;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "parquet")]
mod parquet;
mod raw;
mod read;
mod recording;
mod timing;
mod units;
mod unwrap;
mod velocity_check;
mod whole_file;
mod write;

pub use csv::{read_csv, read_csv_from, read_csv_mapped, read_csv_mapped_from};
pub use csv_write::{write_csv, write_csv_to};
pub use draft::{MISSING_RUN, MISSING_SHARE, REPEATED_SHARE};
pub use error::{Fault, RecordingError};
pub use finding::{Action, Finding, FindingKind, Span, percent, places, spans_of};
pub use interpolation::{BRIDGED_STEPS, Interpolation};
pub use mapping::Mapping;
#[cfg(feature = "mcap")]
pub use mcap::write_mcap_to;
#[cfg(feature = "parquet")]
pub use parquet::write_parquet_to;
pub use raw::{RawColumn, RawColumns};
pub use read::{ReadSettings, read_recording};
pub use recording::{JointChannels, MIN_SAMPLES, Quantity, Recording};
pub use timing::{GAP_STEPS, Gap, Timing};
pub use velocity_check::findings as velocity_findings;
pub use whole_file::{remove_partial_files, write_whole};
pub use write::{Encoded, FileFormat, encode};
