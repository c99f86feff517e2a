//! `armident fleet`: robots over their recordings, as data and text.

use armident_fleet::{
    ChangedPart, FleetAnalysis, FleetChange, FleetOutlier, RobotHistory, TrendPoint,
};
use armident_ident::{StateColumns, Term};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::merge::{SetAside, set_aside_text};
use crate::layout::{aligned, significant};
use crate::words::counted;

/// Result of `armident fleet`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetReport {
    /// `armident.fleet/1`.
    schema: String,
    /// Name of the arm in its URDF.
    pub robot: String,
    /// Cut-off of the low-pass \[Hz\].
    pub cutoff_hz: f64,
    /// Probability of a change of a robot that does not change.
    pub false_alarm_rate: f64,
    /// Parameters of the arm.
    pub parameters: Vec<FleetParameter>,
    /// Degrees of freedom of the scatter of recordings.
    pub scatter_freedom: f64,
    /// Recordings that the scatter was estimated from.
    pub scatter_recordings: usize,
    /// The robots.
    pub robots: Vec<FleetRobot>,
    /// Parameters of robots that are unlike the fleet's.
    pub outliers: Vec<FleetOutlierRow>,
    /// Files and states that are not part of it.
    pub set_aside: Vec<SetAside>,
    /// What to know of the result.
    pub warnings: Vec<String>,
}

/// A parameter of the arm.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetParameter {
    /// Its label.
    pub label: String,
    /// Its unit.
    pub unit: String,
    /// Standard deviation between recordings of a robot that does not change.
    pub scatter: f64,
    /// Whether it is a constant of the minimal set.
    pub is_constant: bool,
}

/// A robot over its recordings.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetRobot {
    /// Its name.
    pub robot: String,
    /// Its recordings in their order.
    pub recordings: Vec<String>,
    /// When each was made, since 1970 \[s\], where all have it.
    pub recorded_at_s: Option<Vec<f64>>,
    /// The page of a single diagnosis that stands beside each recording.
    pub pages: Vec<Option<String>>,
    /// Its changes.
    pub changes: Vec<FleetChangeRow>,
    /// One of each parameter.
    pub trends: Vec<FleetTrend>,
}

/// A change of a robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetChangeRow {
    /// `viscous friction`, `body`.
    pub what: String,
    /// The joint that has it, or that moves the link that has it.
    pub joint: String,
    /// The link, of a body.
    pub link: Option<String>,
    /// First recording with it.
    pub recording: String,
    /// Its number, from 1, in the order of the robot's recordings.
    pub number: usize,
    /// First and last number that it may have, by likelihood.
    pub between: [usize; 2],
    /// By how much.
    pub sizes: Vec<FleetSize>,
    /// Label of the parameter that it moves by most standard errors.
    #[serde(default)]
    pub parameter: Option<String>,
    /// Likelihood ratio over its degrees of freedom.
    pub statistic: f64,
    /// What it exceeds.
    pub threshold: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of as large a statistic on a robot that does not change, at most.
    pub false_alarm_probability: f64,
    /// Other parts that explain the recordings as well.
    pub alternatives: Vec<String>,
    /// All that in a sentence.
    pub sentence: String,
}

/// A number of a change, after it less before it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetSize {
    /// Its name.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Its standard error, with the scatter of recordings.
    pub standard_error: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
}

/// A parameter over the recordings of a robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetTrend {
    /// Its value before the first change; none where the recordings do not determine it.
    pub value: Option<f64>,
    /// Standard error of that.
    pub standard_error: Option<f64>,
    /// Drift per recording beside the changes, and its standard error.
    pub drift: Option<[f64; 2]>,
    /// Value and standard error of each recording; none of those that do not determine it.
    pub points: Vec<Option<[f64; 2]>>,
}

/// A parameter of a robot that is unlike the fleet's.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FleetOutlierRow {
    /// The robot.
    pub robot: String,
    /// Label of the parameter.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Median of the fleet.
    pub median: f64,
    /// Standard error of the difference.
    pub standard_error: f64,
    /// Probability of as large a difference of a robot of the fleet, at most.
    pub false_alarm_probability: f64,
}

/// A probability as text.
fn probability(error: f64) -> String {
    if error < 1e-6 { "below 1e-6".to_owned() } else { significant(error, 2, 0.0) }
}

/// A number with as many digits as a file needs.
fn short(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// `viscous friction of joint elbow`, `body on link forearm`.
fn place(part: ChangedPart, columns: &StateColumns<'_>) -> String {
    let joint = &columns.model().chain.joints[part.joint()];
    match part {
        ChangedPart::Law { .. } => format!("{} of joint `{}`", part.name(), joint.name),
        ChangedPart::Body { .. } => format!("a body on link `{}`", joint.child_link),
    }
}

/// Label of the parameter of a change whose recordings, between the changes before and behind it, differ by most standard
/// errors.
fn moved_most(
    change: &FleetChange,
    of: &RobotHistory,
    columns: &StateColumns<'_>,
) -> Option<String> {
    let others = || of.changes.iter().map(|other| other.from);
    let begin = others().filter(|&from| from < change.from).max().unwrap_or(0);
    let end = others().filter(|&from| from > change.from).min().unwrap_or(of.recordings.len());
    // mean and its variance, weighted
    let mean = |points: &[Option<TrendPoint>]| {
        let weight = |point: &TrendPoint| point.standard_error.powi(-2);
        let total: f64 = points.iter().flatten().map(weight).sum();
        let sum: f64 = points.iter().flatten().map(|point| weight(point) * point.value).sum();
        (total > 0.0).then(|| (sum / total, 1.0 / total))
    };
    let moves = |term: &Term| match (*term, change.part) {
        (Term::Effect { joint, effect, .. }, ChangedPart::Law { joint: of_joint, law }) => {
            joint == of_joint && effect == law
        }
        (Term::Constant(_), ChangedPart::Body { .. }) => true,
        _ => false,
    };
    let terms = columns.problem().terms.iter().zip(&of.trends).enumerate();
    let differences = terms.filter(|(_, (term, _))| moves(term)).filter_map(|(k, (_, trend))| {
        let (before, first_variance) = mean(&trend.points[begin..change.from])?;
        let (after, second_variance) = mean(&trend.points[change.from..end])?;
        Some((k, (after - before).abs() / (first_variance + second_variance).sqrt()))
    });
    let (k, _) = differences.max_by(|a, b| a.1.total_cmp(&b.1))?;
    columns.arm().parameters.get(k).cloned()
}

impl FleetChangeRow {
    fn new(change: &FleetChange, of: &RobotHistory, columns: &StateColumns<'_>) -> Self {
        let joint = &columns.model().chain.joints[change.part.joint()];
        let recording = of.recordings[change.from].clone();
        let number = change.from + 1;
        let number_of = |size: &armident_fleet::SizeOfChange| {
            let digits = |x: f64| significant(x, 3, 0.0);
            let (low, high) = size.interval;
            let (value, unit) = (digits(size.value), size.unit);
            format!("{value} {unit} (95 % interval {} to {})", digits(low), digits(high))
        };
        let count = of.recordings.len();
        let from = format!("from recording {number} of {count} on (`{recording}`)");
        let between = match change.between {
            (first, last) if first == last => String::new(),
            (first, last) => format!("; it may be at recordings {} to {}", first + 1, last + 1),
        };
        let what = match change.part {
            ChangedPart::Law { .. } => {
                let sizes: Vec<String> = change.sizes.iter().map(number_of).collect();
                let rises = change.sizes.first().is_some_and(|size| size.value > 0.0);
                let verb = if rises { "rises by" } else { "changes by" };
                format!("{} {verb} {}", place(change.part, columns), sizes.join(", "))
            }
            ChangedPart::Body { .. } => match change.sizes.iter().find(|s| s.name == "mass") {
                Some(mass) => {
                    let verb = if mass.value > 0.0 { "gains" } else { "loses" };
                    let positive = armident_fleet::SizeOfChange {
                        value: mass.value.abs(),
                        interval: match mass.value > 0.0 {
                            true => mass.interval,
                            false => (-mass.interval.1, -mass.interval.0),
                        },
                        ..mass.clone()
                    };
                    format!("link `{}` {verb} a body of {}", joint.child_link, number_of(&positive))
                }
                None => format!(
                    "link `{}` gains or loses a body, whose mass these motions do not determine",
                    joint.child_link
                ),
            },
        };
        let alternatives: Vec<String> =
            change.alternatives.iter().map(|part| place(*part, columns)).collect();
        let rivals = match alternatives.is_empty() {
            true => String::new(),
            false => format!("; not distinguished from {}", alternatives.join(", ")),
        };
        let sentence = format!(
            "{}: {what} {from}{between}{rivals}; probability of a false alarm {}",
            of.robot,
            probability(change.error)
        );
        let sizes = change.sizes.iter().map(|size| FleetSize {
            parameter: size.name.to_owned(),
            unit: size.unit.to_owned(),
            value: size.value,
            standard_error: size.standard_error,
            interval: size.interval.into(),
        });
        Self {
            what: change.part.name().to_owned(),
            joint: joint.name.clone(),
            link: matches!(change.part, ChangedPart::Body { .. }).then(|| joint.child_link.clone()),
            recording,
            number,
            between: [change.between.0 + 1, change.between.1 + 1],
            sizes: sizes.collect(),
            parameter: moved_most(change, of, columns),
            statistic: change.statistic,
            threshold: change.threshold,
            degrees_of_freedom: change.degrees,
            false_alarm_probability: change.error,
            alternatives,
            sentence,
        }
    }
}

impl FleetReport {
    /// Its schema.
    pub const SCHEMA: &'static str = "armident.fleet/1";

    /// Robots of a fleet and what differs between them; `page` finds the page of a recording.
    pub fn new(
        columns: &StateColumns<'_>,
        analysis: &FleetAnalysis<'_>,
        robots: &[RobotHistory],
        outliers: &[FleetOutlier],
        set_aside: Vec<SetAside>,
        warnings: Vec<String>,
        page: impl Fn(&str) -> Option<String>,
    ) -> Self {
        let problem = columns.problem();
        let names = columns.model().chain.joint_names();
        let unit = |term: &Term| match *term {
            Term::Constant(k) => problem.set().constants[k].unit(),
            Term::Effect { joint, .. } => {
                let kind = problem.arm().joints[joint].kind;
                term.parameter().map_or("", |parameter| parameter.unit(kind))
            }
            Term::Shared { .. } | Term::Load { .. } => "",
        };
        let scatter = analysis.scatter();
        let parameters: Vec<FleetParameter> = problem
            .terms
            .iter()
            .zip(&scatter.deviations)
            .map(|(term, scatter)| FleetParameter {
                label: problem.label(term, &names),
                unit: unit(term).to_owned(),
                scatter: short(*scatter),
                is_constant: matches!(term, Term::Constant(_)),
            })
            .collect();
        let row = |of: &FleetOutlier| FleetOutlierRow {
            robot: robots[of.robot].robot.clone(),
            parameter: parameters[of.parameter].label.clone(),
            unit: parameters[of.parameter].unit.clone(),
            value: of.value,
            median: of.median,
            standard_error: of.standard_error,
            false_alarm_probability: of.error,
        };
        let outliers = outliers.iter().map(row).collect();
        let robots = robots
            .iter()
            .map(|of| FleetRobot {
                robot: of.robot.clone(),
                recordings: of.recordings.clone(),
                recorded_at_s: of.recorded_at_s.clone(),
                pages: of.recordings.iter().map(|recording| page(recording)).collect(),
                changes: (of.changes.iter())
                    .map(|change| FleetChangeRow::new(change, of, columns))
                    .collect(),
                trends: (of.trends.iter().enumerate())
                    .map(|(k, trend)| FleetTrend {
                        value: of.errors[k].map(|_| short(of.values[k])),
                        standard_error: of.errors[k].map(short),
                        drift: trend.drift.map(|(slope, error)| [short(slope), short(error)]),
                        points: (trend.points.iter())
                            .map(|point| {
                                point.map(|point| [short(point.value), short(point.standard_error)])
                            })
                            .collect(),
                    })
                    .collect(),
            })
            .collect();
        Self {
            schema: Self::SCHEMA.to_owned(),
            robot: columns.model().chain.robot.clone(),
            cutoff_hz: columns.arm().cutoff_hz,
            false_alarm_rate: analysis.settings().false_alarm_rate,
            parameters,
            scatter_freedom: scatter.freedom,
            scatter_recordings: scatter.recordings,
            robots,
            outliers,
            set_aside,
            warnings,
        }
    }

    /// Recordings of all robots.
    pub fn recordings(&self) -> usize {
        self.robots.iter().map(|robot| robot.recordings.len()).sum()
    }

    /// Changes of all robots.
    pub fn changes(&self) -> impl Iterator<Item = &FleetChangeRow> {
        self.robots.iter().flat_map(|robot| &robot.changes)
    }

    /// What was found, in a line.
    pub fn headline(&self) -> String {
        let changed = self.robots.iter().filter(|robot| !robot.changes.is_empty()).count();
        format!(
            "{}, {}: {} of {}; {} unlike the fleet",
            counted(self.robots.len(), "robot"),
            counted(self.recordings(), "recording"),
            counted(self.changes().count(), "change"),
            counted(changed, "robot"),
            counted(self.outliers.len(), "parameter"),
        )
    }

    /// The result as text.
    pub fn text(&self) -> String {
        let mut text = format!("{}: {}\n", self.robot, self.headline());
        let rate = 100.0 * self.false_alarm_rate;
        text +=
            &format!("\nChanges (a robot that does not change has one with at most {rate} %)\n");
        for change in self.changes() {
            text += &format!("  {}\n", change.sentence);
        }
        if self.changes().next().is_none() {
            text += "  none\n";
        }
        if !self.outliers.is_empty() {
            text += "\nUnlike the median of the fleet\n";
            let number = |x: f64| significant(x, 3, 0.0);
            let rows: Vec<Vec<String>> = (self.outliers.iter())
                .map(|of| {
                    let (value, median) = (number(of.value), number(of.median));
                    let error = number(of.standard_error);
                    vec![of.robot.clone(), of.parameter.clone(), value, median, error]
                })
                .collect();
            let head = ["robot", "parameter", "value", "median", "std error"];
            text += &aligned(&head, &rows, 2);
        }
        text + &set_aside_text(&self.set_aside)
    }
}
