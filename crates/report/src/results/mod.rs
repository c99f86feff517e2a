//! Results of the commands as data: what their JSON holds.

mod by_joint;
mod card;
pub(crate) mod check;
mod comparison;
mod consistency;
pub(crate) mod constants;
pub(crate) mod diagnosis;
mod excite;
mod fleet;
mod identify;
mod merge;
mod parameters;
mod params;
mod plan;
mod servos;
mod units;
mod validate;

pub use by_joint::ByJoint;
pub use card::{CardEffort, CardInput, CardLink, ModelCard};
pub use check::{ChannelRow, CheckReport, CheckRow, CheckTopic, CheckVerdict, ConstantCheckRow};
pub(crate) use comparison::DIFFERS;
pub use comparison::{
    ComparedResult, ComparisonError, ComparisonReport, ErrorDifference, FindingDifference,
    ParameterDifference,
};
pub use consistency::ConsistencyReport;
pub use constants::{ConstantRow, NOT_IDENTIFIED};
pub use diagnosis::{
    AlternativeRow, CharacterRow, DiagnoseInputs, DiagnoseReport, DriveGainOfMasses, EffortErrors,
    EstimateRow, EvidenceRow, FindingRow, Fits, InputCheckRows, JointResiduals, MoreData,
    Regressor, RegressorBin, VariableShare, in_noise_levels,
};
pub use excite::{ExciteReport, MotionRow};
pub use fleet::{
    FleetChangeRow, FleetOutlierRow, FleetParameter, FleetReport, FleetRobot, FleetSize, FleetTrend,
};
pub use identify::{
    DriveGainRow, EffectRow, EndogeneityRow, FitReport, FitRows, IdentifyReport, MergedRow,
    PayloadRow, SensedGearRow, SensedNumber, StepRow,
};
pub use merge::{AccumulateReport, MergeReport, SetAside};
pub use parameters::ParameterRow;
pub use params::ParamsReport;
pub use plan::plan_text;
pub use servos::{ServoNumber, ServoRow, ServosReport};
pub use validate::{EffortErrorRow, PositionsUnderCommands, ReplayReport, ValidateReport};
