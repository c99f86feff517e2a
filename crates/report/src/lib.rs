//! Writes results for people (aligned text) and for programs (JSON with a schema).
//!
//! Every result is plain data with a schema: what `--json` writes, `armident report` reads, and `docs/json.md`
//! describes. It is shown in sections ([`Section`]): plain data again, which a terminal shows as aligned text and a
//! page as HTML. A new section is one file and its line in a list.
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

mod layout;
mod results;
mod schemas;
mod section;
mod sections;
mod text;
mod words;

pub use layout::{
    Bars, Block, Cell, Column, Table, aligned, percent, render, significant, uncertain,
    unit_after_number,
};
pub use results::{
    AccumulateReport, AlternativeRow, ByJoint, CardEffort, CardInput, CardLink, ChannelRow,
    CharacterRow, CheckReport, CheckRow, CheckTopic, CheckVerdict, ComparedResult, ComparisonError,
    ComparisonReport, ConsistencyReport, ConstantCheckRow, ConstantRow, DiagnoseInputs,
    DiagnoseReport, DriveGainOfMasses, DriveGainRow, EffectRow, EffortErrorRow, EffortErrors,
    EndogeneityRow, ErrorDifference, EstimateRow, EvidenceRow, ExciteReport, FindingDifference,
    FindingRow, FitReport, FitRows, Fits, FleetChangeRow, FleetOutlierRow, FleetParameter,
    FleetReport, FleetRobot, FleetSize, FleetTrend, IdentifyReport, InputCheckRows, JointResiduals,
    MergeReport, MergedRow, ModelCard, MoreData, MotionRow, NOT_IDENTIFIED, ParameterDifference,
    ParameterRow, ParamsReport, PayloadRow, PositionsUnderCommands, Regressor, RegressorBin,
    ReplayReport, SensedGearRow, SensedNumber, ServoNumber, ServoRow, ServosReport, SetAside,
    StepRow, ValidateReport, VariableShare, in_noise_levels, plan_text,
};
pub use schemas::schemas;
pub use section::{DiagnosisSection, Section, SectionData, Shows, Source, shows};
pub use sections::{
    ErrorWithoutLaw, InconclusiveChange, InconclusiveChanges, MinimalSetEstimate, NextMotionResult,
    PlaceboTest, PositionErrors, PositionFit, ReferenceSpeed, ReplayPair,
};
pub use text::text_of_sections;
pub use words::{capital, counted, effect_at, effect_label, location, parameter_label, sentence};

/// Lists of the sections of each result.
pub mod standard_sections {
    pub use crate::sections::{CARD, CHECK, COMPARISON, DIAGNOSIS, IDENTIFY, VALIDATE};
}
