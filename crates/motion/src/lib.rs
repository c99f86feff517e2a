//! Turns recorded channels into joint motion: grid, low-pass, derivatives, noise, standstills.
//!
//! 1. [`quality()`] measures a recording and lists what is doubtful in it.
//! 2. [`Motion::from_recording`] brings the joints asked for onto an even grid ([`EvenGrid`]),
//!    filters the position ([`ZeroPhaseLowPass`]) and differentiates it ([`differentiate()`]).
//!    Recorded velocities are not used, because drives smooth them with delay; only where
//!    accelerations are recorded too, as in exact simulations, are both used as recorded.
//! 3. [`BandMotion`] is the same for the diagnosis: kinematics below 25 Hz, compared in a band ([`Band`]),
//!    with the noise of each channel and the standstills of each joint ([`Standstill`]).
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
//! # Not handled
//!
//! The end effects of the filter on efforts and regressor columns, which reach two to
//! three periods of the cutoff into the motion: drop these samples. Positions and speeds are
//! continued ([`EndExtension`]) before they are filtered.
//!
//! # Example
//!
//! ```
//! use armident_motion::{Motion, MotionSettings};
//! use armident_recording::read_csv_from;
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

mod band_motion;
mod compare_band;
mod cutoff;
mod decimate;
mod differentiate;
mod drive_low_pass;
mod duplicate_frames;
mod effort_clock;
mod end_extension;
mod grid;
mod held_efforts;
mod late_signals;
mod low_pass;
mod motion;
mod noise_spectrum;
mod observations;
mod periodogram;
mod quality;
mod recorded_velocity;
mod sampling_clock;
mod standstill;
mod stuck;

pub use band_motion::BandMotion;
pub use compare_band::{BAND_HZ, Band, EDGE_S};
pub use cutoff::{
    CUTOFF_OVER_EDGE, HIGHEST_CUTOFF_SHARE, LOWEST_CUTOFF_HZ, POWER_SHARE, band_edge_hz,
    common_cutoff_hz, default_cutoff_hz,
};
pub use decimate::{kinematics_filter, later, low_pass};
pub use differentiate::differentiate;
pub use drive_low_pass::reported;
pub use effort_clock::by_clock;
pub use end_extension::{EndExtension, QUARTIC_TERMS, Quartics};
pub use grid::EvenGrid;
pub use late_signals::{LateSignals, SignalLag};
pub use low_pass::{
    CUTOFF_SHARE_BOUND, DEFAULT_ORDER, HIGHEST_ORDER, LOWEST_CUTOFF_SHARE, ZeroPhaseLowPass,
};
pub use motion::{DerivativeSource, Motion, MotionSettings};
pub use observations::Observations;
pub use periodogram::Periodogram;
pub use quality::{
    ChannelQuality, QualityReport, differences, findings, quality, stuck_effort_shares,
};
pub use recorded_velocity::with_recorded_velocity;
pub use sampling_clock::SamplingClock;
pub use standstill::{ChannelSeries, Kind, Standstill, continued, filter_between};
pub use stuck::{RESTING_RANGE, quantisation_step};
