//! Says what physics a model leaves out.
//!
//! [`diagnose`] compares recorded efforts with those of a believed arm in a band of 10 Hz, in units of the
//! noise of the recordings themselves. It looks for the smallest set of laws of the effects library which,
//! beside errors of all links, explains the difference. A law is named when the effort that it alone
//! explains is material against the noise of a recorded sample, and when it lowers the error of blocks
//! of the recordings to which it was not fitted. What remains and depends on some column, but on no law of the
//! library, is described without a name ([`UNMODELLED`]).
//!
//! The result is a list of [`Finding`]s and a [`ArmModel`] that predicts what recordings of other
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

mod change;
mod checks;
mod design;
mod diagnosis;
mod findings;
mod regression;
mod request;
mod selection;
#[cfg(test)]
mod test_arms;
mod uncertainty;

pub use findings::residual_map::{Bin, Character, JointAtlas, Regime, SymmetryTest};

pub use change::diagnose_change;
pub use checks::effort_columns::{Books, DriveGain};
pub use checks::usable::DiagnoseError;
pub use design::known_effort::Known;
pub use diagnosis::{Diagnosis, Errors, diagnose, diagnose_with_placebo};
pub use findings::finding::{Alternative, DoubtfulChange, Finding, FindingEvidence, Value};
pub use findings::next_experiment::NextMotion;
pub use findings::placebo::Placebo;
pub use request::Heard;
pub use uncertainty::minimal_constants::{ConstantEstimate, ConstantEstimates};

pub use armident_effects::UNMODELLED;
