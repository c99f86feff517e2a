//! Finds the physical effects that a model of an arm lacks, from recordings.
//!
//! ```text
//! y = W b + Phi x + e,   b ~ N(0, s^2 I),   e ~ N(0, R)
//! ```
//!
//! | symbol | shape | meaning |
//! | --- | --- | --- |
//! | `y` | rows | measured minus predicted efforts of all joints in a band of 10 Hz |
//! | `W b` | rows x directions | errors of all link inertias, nuisance parameters of relative size `s` |
//! | `Phi x` | rows x columns | laws of the effects library at joints, links and neighbours, and smooth terms |
//! | `R` | rows | noise of the recordings in the band, and model discrepancy |
//!
//! [`diagnose`] selects the smallest set of columns by a description length with `b` marginalised, moves the operating
//! point (tilt, delay, encoder zeros, gains, springs) with each fit, and keeps a law where it is *material* (its
//! effort alone exceeds a share of the noise of one recorded sample, all else refitted) and lowers the
//! *cross-validated* error of blocks of the recordings. Structure that depends on some column, but on no law, is a smooth
//! term ([`UNMODELLED`]).
//!
//! The result is a list of [`Finding`]s with standard errors and alternatives, and an
//! [`ArmModel`](armident_model::ArmModel) that predicts the efforts of other motions.
//!
//! ```
//! use armident_diagnose::{DiagnoseRequest, diagnose};
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//! use armident_model::ArmModel;
//! use armident_recording::read_csv;
//!
//! # let examples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/ur5");
//! let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf")?;
//! let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
//! let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
//! let (train, holdout) = ([read_csv(examples.join("train.csv"))?], [read_csv(examples.join("holdout.csv"))?]);
//! let request = DiagnoseRequest { holdout: &holdout, ..DiagnoseRequest::new(&model, &train) };
//! let diagnosis = diagnose(&request)?;
//!
//! // the forearm is 0.6 kg heavier than the URDF says
//! let forearm = diagnosis.findings.iter().find(|f| f.link.as_deref() == Some("link_3")).unwrap();
//! assert_eq!((forearm.effect.as_str(), forearm.confirmed), ("link_inertia_error", Some(true)));
//! assert!((forearm.parameters["delta_mass"].value - 0.6).abs() < 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Limits: effects clearly below the noise of one sample are not reported; of laws with the same effort in these motions
//! one is reported, the others are its alternatives; contacts push on the tip.

mod checks;
mod design;
mod diagnosis;
mod error;
mod findings;
mod pipeline;
mod regression;
mod request;
mod selection;
#[cfg(test)]
mod test_arms;
mod uncertainty;

pub use checks::effort_columns::{InferredDriveGain, InputChecks};
pub use checks::usable::Unusable;
pub use diagnosis::{Diagnosis, Errors, OpenPair};
pub use error::{DiagnoseError, WrongColumns};
pub use findings::finding::{Alternative, DoubtfulChange, Finding, FindingEvidence};
pub use findings::from_commands::{ServoDiagnosis, diagnose_servos};
pub use findings::numbers::Value;
pub use findings::placebo::Placebo;
pub use findings::residual_map::{Bin, Character, JointAtlas, Regime, SymmetryTest};
pub use request::{DiagnoseRequest, diagnose};
pub use uncertainty::minimal_constants::{ConstantEstimate, ConstantEstimates};

pub use armident_effects::UNMODELLED;
