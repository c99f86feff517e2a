//! Data of `armident diagnose`: what several sections read. Sections keep data of their own beside it.

mod finding;
mod input_checks;
mod report;
mod residual_map;
mod verdict;

pub use finding::{AlternativeRow, CharacterRow, EstimateRow, EvidenceRow, FindingRow};
pub use input_checks::{DriveGainOfMasses, InputCheckRows};
pub use report::{DiagnoseInputs, DiagnoseReport, EffortErrors, Fits, MoreData};
pub use residual_map::{JointResiduals, Regressor, RegressorBin, VariableShare};
pub use verdict::in_noise_levels;
pub(crate) use verdict::worse_on_holdout;
