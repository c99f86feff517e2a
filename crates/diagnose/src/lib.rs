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
//! Limits: what differs by clearly less than the noise of a sample is not named; of laws that are the same
//! effort in these motions one is named; contacts push on the tip.

mod alternatives;
mod atlas;
mod background;
mod band;
mod books;
mod change;
mod constants;
mod contact;
mod crossval;
mod diagnosis;
mod evidence;
mod findings;
mod flexible;
mod learn;
mod material;
mod model;
mod next_motion;
mod noise;
mod placebo;
mod problem;
mod ripple;
mod rows;
mod search;
mod select;
mod signals;
mod transmission;
mod without;

pub use atlas::{Bin, Character, JointAtlas, Regime, SymmetryTest};
pub use books::{Books, DriveGain, Heard};
pub use change::diagnose_change;
pub use constants::{ConstantEstimate, ConstantEstimates};
pub use diagnosis::{DiagnoseError, Diagnosis, Errors, diagnose, diagnose_with_placebo};
pub use findings::{Alternative, Finding, FindingEvidence, Value};
pub use flexible::{Axis, Basis, Factor, FlexibleTerm, Form, Quantity};
pub use model::{DiagnosedModel, Learned};
pub use next_motion::NextMotion;
pub use placebo::Placebo;
pub use transmission::{Transmission, TransmissionTerm};

/// Name of a finding for structure that no law of the library explains.
pub const UNMODELLED: &str = "unmodelled";
