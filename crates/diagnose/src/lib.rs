//! Says what physics a model leaves out.

mod background;
mod band;
mod contact;
mod crossval;
mod diagnosis;
mod evidence;
mod flexible;
mod material;
mod model;
mod noise;
mod problem;
mod ripple;
mod rows;
mod search;
mod select;
mod signals;
mod transmission;

pub use diagnosis::{
    Alternative, DiagnoseError, Diagnosis, Errors, Finding, FindingEvidence, Value, diagnose,
};
pub use flexible::{Axis, Basis, Factor, FlexibleTerm, Form, Quantity};
pub use model::{DiagnosedModel, Learned};
pub use transmission::{Transmission, TransmissionTerm};

/// Name of a finding for structure that no law of the library explains.
pub const UNMODELLED: &str = "unmodelled";
