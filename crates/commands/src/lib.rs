//! Each command from its inputs to its result, for the command line and for Python.
//!
//! A command takes a [`GivenRobot`] and [`Recording`](armident_recording::Recording)s, calls the library, and gives a result:
//! the report, which is the JSON, the model where there is one, and what its page draws. Reading and writing of files,
//! messages and exit codes are their callers'. What fails is a [`Failure`] of three lines.
//!
//! ```
//! use std::path::Path;
//! use armident_commands::{ChainOptions, GivenRobot, params};
//!
//! let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/ur5.urdf");
//! let robot = GivenRobot::open(&urdf, ChainOptions::default())?;
//! let (report, _) = params(&robot)?;
//! assert!(report.text().contains("Minimal set: 36 constants"));
//! # Ok::<(), armident_commands::Failure>(())
//! ```

mod accumulate;
mod card;
mod check;
mod closed_loop;
mod compare;
mod convert;
mod diagnose;
mod drawing;
mod excerpt;
mod excite;
mod export;
mod failure;
mod fleet;
mod identify;
mod info;
mod merge;
mod next_motion;
mod params;
mod planned_motion;
mod predict;
mod recordings;
mod rivals;
mod robot;
mod robot_of;
mod servos;
mod simulate;
mod state_files;
mod state_lines;
mod state_table;
mod suite;
mod topics;
mod validate;

pub use accumulate::{Reduction, accumulate, recordings_to_reduce, same_file};
pub use card::{CardFiles, CardOptions, card_files, card_paths};
pub use check::{Checked, check};
pub use closed_loop::predict_closed_loop;
pub use compare::compare;
pub use convert::{ConvertReport, convert, one_to_convert};
pub use diagnose::{DiagnoseOptions, DiagnoseRecordings, Diagnosed, diagnose};
pub use drawing::Drawn;
pub use excerpt::Excerpt;
pub use excite::{ExciteOptions, Excited, excite};
pub use export::{ExportFormat, ExportReport, FalseAlarms, ThresholdsReport, export};
pub use failure::Failure;
pub use fleet::{FleetOptions, fleet};
pub use identify::{
    Identified, IdentifyOptions, PLAN_FILE, PayloadOn, PlannedRecordings, identify,
    identify_planned, plan_in,
};
pub use info::{InfoReport, info};
pub use merge::{Merged, merge};
pub use params::params;
pub use planned_motion::MotionFormat;
pub use predict::{PredictReport, Predicted, predict};
pub use recordings::{ReadingOptions, expand, quality_notes, read_all};
pub use rivals::read_rivals;
pub use robot::{ChainOptions, GivenRobot, chain_notes, chain_warnings};
pub use servos::{
    DiagnosedServos, IdentifiedServos, diagnose_servos, has_commands_only, identify_servos,
};
pub use simulate::{NoiseLevel, SimulateOptions, SimulatedDirection, Simulator};
pub use suite::{SUITE_FILE, SplitRecordings, SuiteEntry, SuiteFile, split_recordings};
pub use validate::{Validated, validate};
