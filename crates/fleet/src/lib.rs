//! States of many recordings of many robots to trends, changes and outliers.
//!
//! | question | answer |
//! | --- | --- |
//! | how much recordings of a robot that does not change scatter | [`Scatter`] |
//! | which friction or which body changed, on which robot, at which recording | [`FleetAnalysis::robot`] |
//! | how each parameter moves from recording to recording | [`RobotHistory::trends`] |
//! | which robots differ from the others | [`outliers`] |
//!
//! All is computed from [states](armident_ident::RecordingState), those of one robot at a time.

mod analysis;
mod changes;
mod explanation;
mod history;
mod information;
mod outlier;
mod scatter;
mod series;

pub use analysis::{FleetAnalysis, FleetError, FleetSettings};
pub use changes::{FleetChange, SizeOfChange};
pub use explanation::{ChangedPart, Explanation};
pub use history::{ParameterTrend, RobotHistory, TrendPoint};
pub use outlier::{FleetOutlier, outliers};
pub use scatter::Scatter;
