//! What each result shows: lists of sections, in the order of the text and of the page. A new section is a file
//! and a line here.

mod card;
mod check;
mod comparison;
mod diagnosis;
mod identify;
mod model;
mod validate;

pub use diagnosis::{
    ErrorWithoutLaw, InconclusiveChange, InconclusiveChanges, MinimalSetEstimate, NextMotionResult,
    PlaceboTest, PositionErrors, PositionFit, ReferenceSpeed, ReplayPair,
};

use crate::results::{CheckReport, ComparisonReport, IdentifyReport, ModelCard, ValidateReport};
use crate::section::{DiagnosisSection, Section, shows};

/// Sections of `armident diagnose`.
pub const DIAGNOSIS: &[&dyn DiagnosisSection] = &[
    &diagnosis::Faults,
    &diagnosis::DriveGains,
    &diagnosis::Findings,
    &diagnosis::ResidualMap,
    &shows::<model::SmallTerms>(),
    &shows::<model::PlaceholderLinks>(),
    &model::LinkErrors,
    &shows::<model::Projection>(),
    &shows::<model::LowPassedEfforts>(),
    &shows::<model::ClockOfEfforts>(),
    &shows::<model::ComparisonBandwidth>(),
    &shows::<model::RegularisedCoulomb>(),
    &shows::<model::Presliding>(),
    &shows::<model::SublinearViscous>(),
    &shows::<model::Transmissions>(),
    &shows::<diagnosis::ReferenceSpeed>(),
    &shows::<diagnosis::InconclusiveChanges>(),
    &diagnosis::EffortError,
    &shows::<diagnosis::PositionFit>(),
    &shows::<diagnosis::ReplayPair>(),
    &shows::<diagnosis::MinimalSetEstimate>(),
    &shows::<diagnosis::PlaceboTest>(),
    &shows::<diagnosis::NextMotionResult>(),
];

/// Sections of `armident identify`.
pub const IDENTIFY: &[&dyn Section<IdentifyReport>] = &[
    &identify::Constants,
    &identify::DriveGains,
    &identify::SensedGears,
    &identify::Payloads,
    &identify::JointEffects,
    &identify::Significance,
    &identify::Problem,
    &identify::EffortError,
];

/// Sections of `armident validate`.
pub const VALIDATE: &[&dyn Section<ValidateReport>] =
    &[&validate::EffortError, &validate::PositionError, &validate::Replay];

/// Sections of `armident check`.
pub const CHECK: &[&dyn Section<CheckReport>] =
    &[&check::Checks, &check::Columns, &check::Excitation];

/// Sections of two results side by side.
pub const COMPARISON: &[&dyn Section<ComparisonReport>] =
    &[&comparison::Findings, &comparison::Parameters, &comparison::EffortError];

/// Sections of a model card.
pub const CARD: &[&dyn Section<ModelCard>] =
    &[&card::Parameters, &card::Links, &card::Effort, &card::Inputs];
