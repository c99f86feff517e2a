//! Minimal inertia sets, experiment plans, and estimation with uncertainty.
//!
//! ```text
//! τ = Y(q, q̇, q̈) x + Σ φ(motion) p + noise
//! ```
//!
//! | question | answer |
//! | --- | --- |
//! | which constants `x` the efforts depend on | [`MinimalSet`] (Theorem 2 and Algorithm M) |
//! | which experiments determine them one joint at a time | [`experiment::plan`] |
//! | their values from such experiments | [`identify_planned`] (Algorithm 2) |
//! | their values from ordinary motion, friction included | [`identify`] |
//! | controllers and friction of an arm with commands and no efforts | [`identify_servos`] |
//! | the same step by step | [`BatchProblem`], [`estimators`] |
//! | the physically consistent links nearest to an estimate | [`ConsistencyProblem`] |
//! | whether the columns of recordings are what their headers say | [`checks::check`] |
//! | how good a model is on a hold-out | [`validation`] |
//! | the arm with its effects, to predict and to save | [`armident_model::ArmModel`] |
//!
//! Rooms from low to high, each using only those before it: `inference` (statistics that know no robot), `used_samples`,
//! `minimal_set`, `consistency`, `experiment`,
//! `regression`, `estimators`, `structure`, `calibration`, `checks`, `validation`, `servo`, `identify`.

mod calibration;
pub mod checks;
mod consistency;
pub mod estimators;
pub mod experiment;
mod identify;
mod minimal_set;
mod recording_state;
mod regression;
mod servo;
mod structure;
mod used_samples;
pub mod validation;

pub use calibration::{DriveGain, DriveGains, SensedGear, SensedValue, dead_zone_shares};
pub use consistency::{ConsistencyError, ConsistencyProblem, Consistent, EffectUnknown};
pub use identify::{
    Identification, IdentifyError, IdentifyErrors, IdentifyRequest, JointFriction,
    PlannedIdentification, PlannedRequest, Prepared, Stage, identify, identify_planned,
};
pub use minimal_set::{Constant, ConstantKind, DroppedConstant, MinimalSet, Theorem2, algorithm1};
pub use recording_state::{
    JointTriangle, MergedIdentification, RecordingState, ReducedArm, StateColumns, StateError,
};
pub use regression::{
    BatchEstimate, BatchProblem, BatchSettings, Coupling, Endogeneity, EstimateNote, JointFit,
    JointRows, KnownLoad, LAWS, MergedTerm, Term, without_loads,
};
pub use servo::{
    COMMAND_WINDOW_S, CommandFault, CommandReplay, CommandReplayError, Lag, OF_ROUNDING,
    ServoAblation, ServoError, ServoIdentification, ServoJointFit, ServoParameter, ServoRequest,
    ServoValue, check_commands, identify_servos, replay_commands,
};
pub use structure::{
    CouplingFound, ReversalCandidates, Structure, StructureSearch, SublinearFound,
};
pub use used_samples::used_samples;
