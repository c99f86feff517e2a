//! Turns recorded files into evenly sampled, filtered joint motions with efforts.
//!
//! # From a file to a motion
//!
//! 1. [`read_csv`] gives a [`Recording`]: time stamps and joint channels as they were recorded,
//!    checked, with notes on what was doubtful or repaired.
//! 2. [`Motion::from_recording`] brings the joints asked for onto an even grid ([`EvenGrid`]),
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
//!
//! Joint names may contain slashes. Other columns are ignored, with a note.
//!
//! # Not handled
//!
//! Other formats (ROS bags, MCAP, Parquet, MATLAB); stamps that differ between channels; joint
//! angles that wrap around at ±π; other units than SI; delays between position and effort;
//! channels with missing values (leave the row out instead); the end effects of the filter, which
//! reach two to three periods of the cutoff into the motion: drop these samples.
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
mod cutoff;
mod differentiate;
mod error;
mod header;
mod motion;
mod recording;
mod resample;
mod timing;

pub use butterworth::{
    CUTOFF_SHARE_BOUND, DEFAULT_ORDER, HIGHEST_ORDER, LOWEST_CUTOFF_SHARE, ZeroPhaseLowPass,
};
pub use csv::{read_csv, read_csv_from, write_csv, write_csv_to};
pub use cutoff::{
    CUTOFF_OVER_EDGE, HIGHEST_CUTOFF_SHARE, LOWEST_CUTOFF_HZ, POWER_SHARE, RESTING_RANGE,
    band_edge_hz, default_cutoff_hz,
};
pub use differentiate::differentiate;
pub use error::{Fault, RecordingError};
pub use motion::{DerivativeSource, Motion, MotionSettings};
pub use recording::{JointChannels, MIN_SAMPLES, Quantity, Recording};
pub use resample::{BRIDGED_STEPS, EvenGrid, Interpolation};
pub use timing::{GAP_STEPS, Gap, Timing};
