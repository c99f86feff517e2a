//! Data of `armident check`.

use std::collections::BTreeMap;

use armident_ident::checks::{self as check, ChannelKind, RecordingCheck};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::by_joint::or_nan;

/// Outcome of one check, best first.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum CheckVerdict {
    /// Nothing against it, and the recordings would show a fault.
    Ok,
    /// Inconclusive: the recordings would not show a fault.
    #[default]
    #[serde(rename = "cannot_tell")]
    Inconclusive,
    /// More likely wrong than not, or of little use.
    Doubtful,
    /// Wrong beyond a thousand to one.
    Wrong,
}

impl CheckVerdict {
    /// All verdicts, worst first.
    pub const WORST_FIRST: [Self; 4] = [Self::Wrong, Self::Doubtful, Self::Inconclusive, Self::Ok];

    /// The verdict in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Inconclusive => "inconclusive",
            Self::Doubtful => "doubtful",
            Self::Wrong => "wrong",
        }
    }
}

impl From<check::Verdict> for CheckVerdict {
    fn from(verdict: check::Verdict) -> Self {
        match verdict {
            check::Verdict::Ok => Self::Ok,
            check::Verdict::Inconclusive => Self::Inconclusive,
            check::Verdict::Doubtful => Self::Doubtful,
            check::Verdict::Wrong => Self::Wrong,
        }
    }
}

/// What a check is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CheckTopic {
    /// Sample rate against the bandwidth of the motion.
    Rate,
    /// Noise of a channel.
    Noise,
    /// Sign, unit and gravity of an effort column.
    Channel,
    /// Which joint each column belongs to.
    Order,
    /// Where gravity points.
    Gravity,
    /// Whether a joint counts as its axis does, with position and effort.
    JointSign,
    /// Whether the distances of the axes are those of the arm.
    Geometry,
    /// Delay between effort and motion.
    Delay,
    /// Whether efforts and positions are recorded by one clock.
    Clock,
    /// Whether the motion determines the constants.
    Excitation,
    /// What the samples show without a model.
    #[default]
    Quality,
    /// Whether a column is the command of a joint, and how far the position is behind it.
    Command,
}

impl CheckTopic {
    /// The topic in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Noise => "noise",
            Self::Channel => "effort column",
            Self::Order => "joint order",
            Self::Gravity => "gravity",
            Self::JointSign => "joint sign",
            Self::Geometry => "geometry",
            Self::Delay => "delay",
            Self::Clock => "clock",
            Self::Excitation => "excitation",
            Self::Quality => "quality",
            Self::Command => "command",
        }
    }
}

impl From<check::Topic> for CheckTopic {
    fn from(topic: check::Topic) -> Self {
        match topic {
            check::Topic::Rate => Self::Rate,
            check::Topic::Noise => Self::Noise,
            check::Topic::Channel => Self::Channel,
            check::Topic::Order => Self::Order,
            check::Topic::Gravity => Self::Gravity,
            check::Topic::JointSign => Self::JointSign,
            check::Topic::Geometry => Self::Geometry,
            check::Topic::Delay => Self::Delay,
            check::Topic::Clock => Self::Clock,
            check::Topic::Excitation => Self::Excitation,
            check::Topic::Quality => Self::Quality,
            check::Topic::Command => Self::Command,
        }
    }
}

/// One check with its verdict.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CheckRow {
    /// What was checked.
    pub topic: CheckTopic,
    /// The joint; `null` for the arm as a whole.
    pub joint: Option<String>,
    /// The verdict.
    pub verdict: CheckVerdict,
    /// The number behind the verdict; `null` where there is none.
    pub value: Option<f64>,
    /// Unit of the number.
    pub unit: String,
    /// 95 % interval of the number; `null` where there is none.
    pub interval_95: Option<[f64; 2]>,
    /// One sentence.
    pub message: String,
    /// What to do.
    pub advice: Option<String>,
}

impl CheckRow {
    /// Of a check.
    pub fn of(found: &check::Check) -> Self {
        Self {
            topic: found.topic.into(),
            joint: found.joint.clone(),
            verdict: found.verdict.into(),
            value: found.value,
            unit: found.unit.to_owned(),
            interval_95: found.interval_95,
            message: found.message.clone(),
            advice: found.advice.clone(),
        }
    }

    /// `joint: ` of a check of one joint.
    pub fn prefix(&self) -> String {
        self.joint.as_ref().map_or_else(String::new, |joint| format!("{joint}: "))
    }
}

/// What one effort column is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ChannelRow {
    /// The joint.
    pub joint: String,
    /// Joint whose column most likely holds this joint's effort.
    pub column: String,
    /// Probability of `joint_effort`, `sign_flipped`, `other_gain`, `other_gain_flipped` and `without_gravity`.
    pub probability: BTreeMap<String, f64>,
    /// Most likely gain, recorded over joint effort.
    #[serde(deserialize_with = "or_nan")]
    pub gain: f64,
    /// Its 95 % interval.
    pub gain_95: [Option<f64>; 2],
    /// Standard deviation of the column.
    #[serde(deserialize_with = "or_nan")]
    pub sd: f64,
    /// Root mean square residual of a free fit to the column.
    #[serde(deserialize_with = "or_nan")]
    pub residual_rms: f64,
    /// Standard deviation of the URDF's effort on this motion \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub urdf_sd: f64,
}

/// How well the recordings alone determine one constant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ConstantCheckRow {
    /// Label of the paper.
    pub label: String,
    /// Joint name.
    pub joint: String,
    /// Unit.
    pub unit: String,
    /// Size by the URDF: the sum over all links, each off by its own size.
    pub size: f64,
    /// Standard error from the recordings alone; `null` where they do not determine the constant.
    pub standard_error: Option<f64>,
    /// `ok` up to a tenth of the size, `doubtful` up to the size, `cannot_tell` beyond.
    pub verdict: CheckVerdict,
    /// Why the constant is poorly determined.
    pub reason: Option<String>,
}

/// Result of `armident check`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CheckReport {
    /// `armident.check/2`.
    pub schema: String,
    /// Robot name.
    pub robot: String,
    /// Recordings checked.
    pub recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Cut-off frequency of the low-pass \[Hz\]; `null` where recorded accelerations were used.
    pub cutoff_hz: Option<f64>,
    /// The worst of the verdicts.
    pub verdict: CheckVerdict,
    /// The checks, those of the arm first.
    pub checks: Vec<CheckRow>,
    /// What each effort column is.
    pub channels: Vec<ChannelRow>,
    /// Constants of the minimal set.
    pub constants: Vec<ConstantCheckRow>,
    /// Rank of the recordings alone.
    pub rank: usize,
    /// Number of parameters.
    #[serde(alias = "unknowns")]
    pub parameters: usize,
    /// Measurements without a model, per recording: `timing`, `channels` (range, `noise`, `step`, `band_edge_hz`,
    /// shares), `findings`.
    pub quality: Vec<serde_json::Value>,
    /// Warnings, each with its code in brackets; a check that is `wrong` is a warning `[check-wrong]`.
    pub warnings: Vec<String>,
    /// Notes: automatic choices and repairs.
    pub notes: Vec<String>,
}

impl CheckReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.check/2";

    /// Of what was found; checks that are wrong are added to the warnings.
    pub fn new(
        robot: &str,
        recordings: Vec<String>,
        joints: Vec<String>,
        cutoff_hz: Option<f64>,
        found: &RecordingCheck,
        mut warnings: Vec<String>,
        notes: Vec<String>,
    ) -> Self {
        let channels = (found.channels.iter().zip(&joints).zip(&found.order))
            .map(|((channel, joint), &held_by)| {
                let kinds = ChannelKind::ALL.iter().map(|kind| kind.name().to_owned());
                ChannelRow {
                    joint: joint.clone(),
                    column: joints[held_by].clone(),
                    probability: kinds.zip(channel.probability).collect(),
                    gain: channel.gain,
                    gain_95: channel.gain_95.map(Some),
                    sd: channel.sd,
                    residual_rms: channel.residual_rms,
                    urdf_sd: channel.urdf_sd,
                }
            })
            .collect();
        let checks: Vec<CheckRow> = found.checks.iter().map(CheckRow::of).collect();
        let wrong = checks.iter().filter(|check| check.verdict == CheckVerdict::Wrong);
        warnings.extend(wrong.map(|check| {
            let (prefix, topic) = (check.prefix(), check.topic.words());
            format!("{prefix}{topic}: {} [check-wrong]", check.message)
        }));
        let constants = found.constants.iter().map(|constant| ConstantCheckRow {
            label: constant.label.clone(),
            joint: constant.joint.clone(),
            unit: constant.unit.to_owned(),
            size: constant.size,
            standard_error: constant.standard_error,
            verdict: constant.verdict.into(),
            reason: constant.reason.clone(),
        });
        let quality = found.quality.iter().filter_map(|of| serde_json::to_value(of).ok());
        Self {
            schema: Self::SCHEMA.to_owned(),
            robot: robot.to_owned(),
            recordings,
            cutoff_hz,
            verdict: found.verdict().into(),
            checks,
            channels,
            constants: constants.collect(),
            rank: found.rank.0,
            parameters: found.rank.1,
            quality: quality.collect(),
            joints,
            warnings,
            notes,
        }
    }

    /// Number of checks with a verdict.
    pub fn count(&self, verdict: CheckVerdict) -> usize {
        self.checks.iter().filter(|check| check.verdict == verdict).count()
    }
}
