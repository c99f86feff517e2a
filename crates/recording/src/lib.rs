//! Turns recorded files into evenly sampled, filtered joint motions with efforts.
//!
//! # From a file to a motion
//!
//! 1. [`read_csv`], or [`read_csv_mapped`] with a [`Mapping`] for files with names and units of
//!    their own, gives a [`Recording`]: time stamps and joint channels, checked, with notes and
//!    [`Finding`]s on what was doubtful or repaired.
//! 2. [`quality()`] measures the recording and lists what else is doubtful in it.
//! 3. [`Motion::from_recording`] brings the joints asked for onto an even grid ([`EvenGrid`]),
//!    filters the position ([`ZeroPhaseLowPass`]) and differentiates it ([`differentiate()`]).
//!    Recorded velocities are not used, because drives smooth them with delay; only where
//!    accelerations are recorded too, as in exact simulations, are both taken as they are.
//!
//! # Filtered regression
//!
//! The efforts of an arm are linear in its inertial parameters: effort = regressor × parameters, at
//! every instant. A linear filter without delay, applied over time to the effort and to each column
//! of the regressor, leaves the parameters untouched: filtered effort = filtered regressor ×
//! parameters. So the noise above the band of the motion can be removed from both sides, provided
//! both go through the *same* filter. [`Motion`] therefore keeps the filter, gives the effort raw
//! and filtered, and filters columns with [`Motion::filter_columns`]. Filtered samples are no
//! longer independent; [`Motion::independent_share`] says how many are left.
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
//! and told by [`quality()`].
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
//! Other formats (ROS 1 bags, SQLite bags, MATLAB, NumPy: it is said what converts them); stamps that differ between channels; delays
//! between position and effort; the end effects of the filter on efforts and regressor columns, which reach two to
//! three periods of the cutoff into the motion: drop these samples. Positions and speeds are
//! continued ([`Continuation`]) before they are filtered.
//!
//! # Example
//!
//! ```
//! use armident_recording::{Motion, MotionSettings, read_csv_from};
//!
//! let mut text = String::from("t,elbow/position,elbow/effort\n");
//! for k in 0..400 {
//!     let t = 0.005 * f64::from(k);
//!     text += &format!("{t},{},{}\n", (6.0 * t).sin(), -7.2 * (6.0 * t).sin());
//! }
//! let recording = read_csv_from(text.as_bytes(), "swing.csv")?;
//!
//! let settings = MotionSettings { cutoff_hz: Some(20.0), ..MotionSettings::default() };
//! let motion = Motion::from_recording(&recording, &["elbow"], &settings)?;
//!
//! assert!((motion.rate_hz - 200.0).abs() < 1e-9);
//! let middle = motion.len() / 2;
//! let exact = -36.0 * (6.0 * motion.time_s[middle]).sin();
//! assert!((motion.acceleration[0][middle] - exact).abs() < 1e-3 * 36.0);
//! # Ok::<(), armident_recording::RecordingError>(())
//! ```

mod butterworth;
mod csv;
mod csv_write;
mod cutoff;
mod differentiate;
mod draft;
mod ends;
mod error;
mod finding;
mod header;
mod mapping;
#[cfg(feature = "mcap")]
mod mcap;
mod motion;
#[cfg(feature = "parquet")]
mod parquet;
mod quality;
mod raw;
mod read;
mod recording;
mod repeated_frames;
mod resample;
mod runs;
mod timing;
mod units;
mod unwrap;
mod velocity_check;
mod whole_file;
mod write;

pub use butterworth::{
    CUTOFF_SHARE_BOUND, DEFAULT_ORDER, HIGHEST_ORDER, LOWEST_CUTOFF_SHARE, ZeroPhaseLowPass,
};
pub use csv::{read_csv, read_csv_from, read_csv_mapped, read_csv_mapped_from};
pub use csv_write::{write_csv, write_csv_to};
pub use cutoff::{
    CUTOFF_OVER_EDGE, HIGHEST_CUTOFF_SHARE, LOWEST_CUTOFF_HZ, POWER_SHARE, RESTING_RANGE,
    band_edge_hz, common_cutoff_hz, default_cutoff_hz,
};
pub use differentiate::differentiate;
pub use draft::{MISSING_RUN, MISSING_SHARE, REPEATED_SHARE};
pub use ends::{Continuation, QUARTIC_TERMS, Quartics};
pub use error::{Fault, RecordingError};
pub use finding::{Action, Finding, FindingKind, Span};
pub use mapping::Mapping;
#[cfg(feature = "mcap")]
pub use mcap::write_mcap_to;
pub use motion::{DerivativeSource, Motion, MotionSettings};
#[cfg(feature = "parquet")]
pub use parquet::write_parquet_to;
pub use quality::{
    ChannelQuality, QualityReport, differences, findings, quality, stuck_effort_shares,
};
pub use raw::{RawColumn, RawColumns};
pub use read::{ReadSettings, read_recording};
pub use recording::{JointChannels, MIN_SAMPLES, Quantity, Recording};
pub use resample::{BRIDGED_STEPS, EvenGrid, Interpolation};
pub use timing::{GAP_STEPS, Gap, Timing};
pub use whole_file::{remove_partial_files, write_whole};
pub use write::{Encoded, FileFormat, encode};
