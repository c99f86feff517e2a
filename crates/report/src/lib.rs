//! Writes results for people (aligned text) and for programs (JSON with a schema).
//!
//! Every result type has both faces: `serde::Serialize` with a `schema` field, and a `text` method.
//! The fields are described in `docs/json.md`.
//!
//! ```
//! use armident_model::ArmModel;
//! use armident_ident::MinimalSet;
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//!
//! let robot = parse_urdf(include_str!("../../../urdf/stanford.urdf"), "stanford.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
//! let set = MinimalSet::of(&model.rigid_arm())?;
//! let page = armident_report::ParamsReport::new(&model, &set).text();
//! assert!(page.contains("Minimal set: 33 constants for 60 standard parameters"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bar;
mod check;
mod consistency;
mod diagnose;
mod identify;
mod numbers;
mod params;
mod plan;
mod small_terms;
mod table;
mod validate;

pub use bar::Bars;
pub use check::{ChannelRow, CheckReport};
pub use consistency::ConsistencyReport;
pub use diagnose::{DiagnoseInputs, DiagnoseReport, Fits, ReplayPair};
pub use identify::{
    ConstantRow, DriveGainRow, EffectRow, EndogeneityRow, FitReport, FitRows, IdentifyReport,
    LoadRow, MergedRow, StepRow,
};
pub use numbers::{significant, uncertain, unit_told};
pub use params::ParamsReport;
pub use plan::plan_text;
pub use small_terms::{SmallTerm, small_terms_text};
pub use table::aligned;
pub use validate::{EffortErrorRow, ReplayReport, ValidateReport};
