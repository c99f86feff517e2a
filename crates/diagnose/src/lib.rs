//! Says what physics a model leaves out.
//!
//! [`diagnose`] compares recorded efforts with those of a believed arm in a band of 10 Hz, in units of the
//! noise of the recordings themselves. It looks for the smallest set of laws of the effects library which,
//! beside errors of all links, explains the difference. A law is named when the effort that it alone
//! explains is material against the noise of a recorded sample, and when it lowers the error of stretches
//! of the recordings to which it was not fitted. What remains and depends on some column, but on no law of the
//! library, is described without a name ([`UNMODELLED`]).
//!
//! The result is a list of [`Finding`]s and a [`DiagnosedModel`] that predicts what recordings of other
//! motions would show. [`Diagnosis::errors`] compares it with the believed model on recordings kept out.
//!
//! ```
//! use armident_model::ArmModel;
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//! use armident_recording::read_csv;
//!
//! # let examples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/ur5");
//! let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let believed = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
//! let mut diagnosis = armident_diagnose::diagnose(&believed, &[read_csv(examples.join("train.csv"))?])?;
//! let holdout = [read_csv(examples.join("holdout.csv"))?];
//! diagnosis.confirm(&diagnosis.see(&holdout)?)?;
//!
//! // the forearm is 0.6 kg heavier than the URDF says
//! let forearm = diagnosis.findings.iter().find(|f| f.link.as_deref() == Some("link_3")).unwrap();
//! assert_eq!((forearm.effect.as_str(), forearm.confirmed), ("link_inertia_error", Some(true)));
//! assert!((forearm.parameters["delta_mass"].value - 0.6).abs() < 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Limits: what differs by clearly less than the noise of a sample is not named; of laws that are the same
//! effort in these motions one is named; contacts push on the tip.

mod ablation;
mod alternatives;
mod atlas;
mod background;
mod bands;
mod bending;
mod bodies;
mod books;
mod certain;
mod chance;
mod change;
mod constants;
mod contact;
mod crossval;
mod diagnosis;
mod evidence;
mod findings;
mod flexible;
mod hidden;
mod learn;
#[cfg(test)]
mod made;
mod material;
mod misfit;
mod next_motion;
mod placebo;
mod problem;
mod real_links;
mod refine;
mod ripple;
mod rows;
mod scales;
mod scatter;
mod search;
mod select;
mod shape_scatter;
mod sprung;
mod transmission;
mod turning;
mod whitened;

pub use atlas::{Bin, Character, JointAtlas, Regime, SymmetryTest};

pub use books::{Books, DriveGain, Heard};
pub use change::{Known, diagnose_change};
pub use constants::{ConstantEstimate, ConstantEstimates};
pub use diagnosis::{DiagnoseError, Diagnosis, Errors, diagnose, diagnose_with_placebo};
pub use findings::{Alternative, DoubtfulChange, Finding, FindingEvidence, Value};
pub use next_motion::NextMotion;
pub use placebo::Placebo;

/// Name of a finding for structure that no law of the library explains.
pub const UNMODELLED: &str = "unmodelled";
