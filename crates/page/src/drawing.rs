//! What a page draws beside the numbers of a result: the section `drawing` of a result's JSON.

use serde::{Deserialize, Serialize};

/// Everything that is drawn. Every part may be empty: then the page does without it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Drawing {
    /// How the result came about.
    pub provenance: Provenance,
    /// Joints of the chain in order.
    pub joints: Vec<JointName>,
    /// What recordings and models are compared by.
    pub quantity: DrawnQuantity,
    /// Names of the models compared, the first the one that was given, the last the one found.
    pub models: Vec<String>,
    /// Recordings with predictions, training first.
    pub recordings: Vec<RecordingTraces>,
    /// Where in the motion each joint's residual lies, joints in order.
    pub residuals: Vec<JointResidual>,
    /// What each finding explains, in the order of the findings.
    pub findings: Vec<FindingTraces>,
    /// The arm in the first recording.
    pub skeleton: Option<Skeleton>,
    /// Correlation of the estimates.
    pub correlation: Option<Correlation>,
    /// Rates, gaps and channels of the recordings.
    pub quality: Vec<Quality>,
    /// Low-passes that were used, one sentence each.
    pub filters: Vec<String>,
}

/// What recordings and models are compared by: efforts, or positions where commands and no efforts are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrawnQuantity {
    /// Efforts of the joints.
    #[default]
    Effort,
    /// Positions of the joints.
    Position,
}

impl DrawnQuantity {
    /// Its name.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Effort => "effort",
            Self::Position => "position",
        }
    }

    /// Its unit on a joint.
    pub(crate) fn unit(self, joint: &JointName) -> &str {
        match self {
            Self::Effort => &joint.effort_unit,
            Self::Position => &joint.position_unit,
        }
    }
}

/// Where a result comes from.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// The command line.
    pub command: Vec<String>,
    /// Files read.
    pub inputs: Vec<PageInput>,
    /// Seed of the random numbers; none where none are drawn.
    pub seed: Option<u64>,
}

/// A file that was read.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PageInput {
    /// Path as given.
    pub path: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the bytes, in hexadecimal digits.
    pub sha256: String,
}

/// A joint.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct JointName {
    /// Its name.
    pub name: String,
    /// Unit of its position: rad or m.
    pub position_unit: String,
    /// Unit of its effort: N m or N.
    pub effort_unit: String,
    /// Link that it moves.
    pub link: String,
}

/// Whether a recording was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordingRole {
    /// Fitted, or looked at where nothing is fitted.
    #[default]
    Training,
    /// Held out.
    Holdout,
}

/// Efforts (or positions) of one recording, recorded and predicted, evenly spaced in time.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct RecordingTraces {
    /// Where it comes from.
    pub source: String,
    /// Whether it was fitted.
    pub role: RecordingRole,
    /// Length \[s\].
    pub duration_s: f64,
    /// Time between two values of a series \[s\].
    pub step_s: f64,
    /// Samples that a pair of values (smallest and largest) stands for; 1: every sample is there.
    pub samples_per_pair: usize,
    /// Joints in order.
    pub joints: Vec<EffortTraces>,
}

/// Efforts of one joint \[N m or N\], or its positions \[rad or m\].
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct EffortTraces {
    /// As recorded.
    pub measured: Vec<f64>,
    /// By each model.
    pub predicted: Vec<Vec<f64>>,
    /// Recorded less predicted, by each model.
    pub residual: Vec<Vec<f64>>,
}

/// Where the residual of one joint lies, over all training recordings (all, where there is none).
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct JointResidual {
    /// Standard deviation of the recorded effort \[N m or N\] or position \[rad or m\].
    pub effort_deviation: f64,
    /// Root mean square residual of each model \[N m or N\].
    pub rms: Vec<f64>,
    /// Mean residual by position and speed.
    pub speed_position: Map,
    /// Mean residual by load (effort of the last model) and direction of motion.
    pub load_direction: Map,
    /// Root mean square residual by time; rows are the models.
    pub time: Map,
    /// Amplitude spectral density by frequency \[Hz\], one series a model.
    pub spectrum: PlotSeries,
    /// Amplitude by cycles a turn (or a metre), one series a model.
    pub orders: PlotSeries,
    /// Autocorrelation by lag \[s\], one series a model.
    pub autocorrelation: PlotSeries,
    /// Largest autocorrelation that white noise shows in 95 of 100 lags.
    pub white_bound: f64,
}

/// Values on a grid: `values[model][row y][column x]`, empty cells none.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Map {
    /// Middles of the columns.
    pub x: Vec<f64>,
    /// Middles of the rows.
    pub y: Vec<f64>,
    /// Values by model, row, column.
    pub values: Vec<Vec<Vec<Option<f64>>>>,
}

/// Several series over the same abscissa.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PlotSeries {
    /// Abscissa.
    pub x: Vec<f64>,
    /// `values[series][point]`.
    pub values: Vec<Vec<Option<f64>>>,
}

/// What the recordings show of one finding: their efforts less those of the model without it, and less
/// those of the model with it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FindingTraces {
    /// Root mean square residual without the finding where it acts, and with it, by joint
    /// \[N m or N\]; none where it does not act.
    pub joints: Vec<Option<[f64; 2]>>,
    /// Share of the samples of each joint in which it acts.
    pub share: Vec<f64>,
    /// Means over classes of the motion; the first is where the law lives.
    pub views: Vec<FindingView>,
    /// Where in the residual maps it acts, of the joints on which it does.
    pub regions: Vec<FindingRegion>,
}

/// Parts of the residual maps of one joint in which a finding acts: rectangles
/// \[left, right, bottom, top\] over cells in most of whose samples its effort is above a tenth of its largest.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FindingRegion {
    /// Joint, from 0.
    pub joint: usize,
    /// In the map by position and speed.
    pub speed_position: Vec<[f64; 4]>,
    /// In the map by load and direction of motion.
    pub load_direction: Vec<[f64; 4]>,
}

/// Mean residuals over classes of one abscissa, on one joint.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FindingView {
    /// What the abscissa is, with its unit.
    pub over: String,
    /// Joint, from 0.
    pub joint: usize,
    /// Middles of the classes.
    pub x: Vec<f64>,
    /// Mean residual of the model without the finding.
    pub without: Vec<Option<f64>>,
    /// Mean residual of the model with it.
    pub with: Vec<Option<f64>>,
    /// Tenth and ninetieth percentile of the residual without it.
    pub spread: Vec<Option<[f64; 2]>>,
    /// Mean effort of the finding itself.
    pub law: Vec<Option<f64>>,
}

/// The arm in motion: points of its links in the base frame \[m\].
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Skeleton {
    /// Recording of the motion.
    pub source: String,
    /// Times \[s\].
    pub time_s: Vec<f64>,
    /// Per time the points x, y, z of base, joints in order and tip.
    pub points_m: Vec<Vec<[f64; 3]>>,
}

/// Correlation of estimates.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Correlation {
    /// Names of the parameters.
    pub labels: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<Option<f64>>>,
}

/// What can be measured of a recording without a model.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Quality {
    /// Where it comes from.
    pub source: String,
    /// Whether it was fitted.
    pub role: RecordingRole,
    /// Number of samples.
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Length \[s\].
    pub duration_s: f64,
    /// Standard deviation of the steps over the step.
    pub jitter: f64,
    /// Number of gaps.
    pub gaps: usize,
    /// Longest gap \[s\].
    pub longest_gap_s: f64,
    /// What was repaired or is doubtful, one sentence each.
    pub findings: Vec<String>,
    /// Channels.
    pub channels: Vec<Channel>,
}

/// What can be measured of a channel, in its unit.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Channel {
    /// Joint and quantity.
    pub name: String,
    /// Smallest value.
    pub smallest: f64,
    /// Largest value.
    pub largest: f64,
    /// Standard deviation of the white noise.
    pub noise: Option<f64>,
    /// Step in which values are quantised.
    pub step: Option<f64>,
    /// Share of samples in flat tops.
    pub saturated_share: f64,
    /// Share of samples that repeat although the joint moves.
    pub stuck_share: f64,
}
