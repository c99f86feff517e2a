//! Faults of recordings, their locations and hints.

use std::fmt::Write as _;
use std::io;

use crate::finding::QualityIssue;
use crate::limits::{MISSING_RUN, MISSING_SHARE};
use crate::quantity::Quantity;

/// A fault of a recording (`Display`, one clause) with its location and a hint.
///
/// A command line prints three lines: `error:` the fault, `in:` [`place`](Self::place), `hint:`
/// [`hint`](Self::hint).
///
/// Formats and users of recordings make their own:
///
/// ```
/// use armident_recording::{Fault, RecordingError};
///
/// let error = RecordingError::new(Fault::EmptyField, "run.csv").in_column("elbow/effort");
/// assert_eq!(error.to_string(), "empty field");
/// assert_eq!(error.place(), "run.csv, column `elbow/effort`");
/// ```
#[derive(Debug, thiserror::Error)]
#[error("{}", .0.fault)]
pub struct RecordingError(Box<Inner>);

#[derive(Debug)]
struct Inner {
    fault: Fault,
    source_name: String,
    line: Option<u64>,
    column: Option<String>,
}

impl RecordingError {
    /// A fault of the file or signal `source`, a path or a description.
    pub fn new(fault: Fault, source: &str) -> Self {
        Self(Box::new(Inner { fault, source_name: source.to_owned(), line: None, column: None }))
    }

    /// The same fault on a line of the file, counted from 1; 0 means no line, as in binary formats.
    #[must_use]
    pub fn on_line(mut self, line: u64) -> Self {
        self.0.line = (line > 0).then_some(line);
        self
    }

    /// The same fault in a column or channel: `t`, `elbow/effort`.
    #[must_use]
    pub fn in_column(mut self, column: &str) -> Self {
        self.0.column = Some(column.to_owned());
        self
    }

    /// The same fault in another source, for faults of parts that do not know their file.
    #[must_use]
    pub fn of_source(mut self, source: &str) -> Self {
        source.clone_into(&mut self.0.source_name);
        self
    }

    /// Kind of the fault with its numbers.
    pub fn fault(&self) -> &Fault {
        &self.0.fault
    }

    /// The file or signal.
    pub fn source_name(&self) -> &str {
        &self.0.source_name
    }

    /// Line of the file, from 1, where it is known.
    pub fn line(&self) -> Option<u64> {
        self.0.line
    }

    /// Name of the column, where it is known.
    pub fn column(&self) -> Option<&str> {
        self.0.column.as_deref()
    }

    /// The location: ``file.csv, line 12, column `elbow/position` ``, as far as known.
    pub fn place(&self) -> String {
        let mut place = self.0.source_name.clone();
        if let Some(line) = self.0.line {
            let _ = write!(place, ", line {line}");
        }
        if let Some(column) = &self.0.column {
            let _ = write!(place, ", column `{column}`");
        }
        place
    }

    /// What the user can do, if that does not follow from the fault.
    pub fn hint(&self) -> Option<String> {
        self.0.fault.hint()
    }
}

/// Advice on columns with other names than the standard ones.
const GUESS: &str = "or map them: `armident info LOG --write-mapping mapping.toml`";

/// Kinds of faults. Lists of names are in file order.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// No file has this name.
    #[error("the file does not exist")]
    NotFound,
    /// The path names a directory.
    #[error("this is a directory, not a recording")]
    IsDirectory,
    /// The operating system refused.
    #[error("the file cannot be {doing}: {error}")]
    Io {
        /// "opened", "read" or "written".
        doing: &'static str,
        /// Message of the operating system.
        error: io::Error,
    },
    /// Text was expected, the first bytes are those of another format.
    #[error("expected CSV, found {found}")]
    NotCsv {
        /// Name of the format.
        found: &'static str,
        /// How to convert it.
        advice: &'static str,
    },
    /// A format that is recognised, but neither read nor written.
    #[error("unsupported format: {format}")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// How to convert it.
        advice: &'static str,
    },
    /// A file that breaks the rules of its format.
    #[error("truncated or corrupt {format} file: {what}")]
    Broken {
        /// Name of the format.
        format: &'static str,
        /// Message of its reader.
        what: String,
    },
    /// A bag of ROS 2 whose files or messages are compressed as a whole.
    #[error("the bag is compressed ({compression}), expected plain files")]
    CompressedBag {
        /// Compression and what it is applied to.
        compression: String,
    },
    /// A bag of ROS 2 without any of its files.
    #[error("none of the files of the bag is in its folder: {}", listed(.files))]
    MissingBagFiles {
        /// Files that `metadata.yaml` lists.
        files: Vec<String>,
    },
    /// A format that needs a cargo feature which this build lacks.
    #[error("{format} is not supported by this build")]
    NotBuilt {
        /// Name of the format.
        format: &'static str,
        /// The cargo feature.
        feature: &'static str,
    },
    /// Joint states are in several topics, none of them `/joint_states`.
    #[error("several topics have joint states: {}", .topics.join(", "))]
    SeveralJointStates {
        /// The topics.
        topics: Vec<String>,
    },
    /// No topic has joint states.
    #[error("no topic has sensor_msgs/JointState messages")]
    NoJointStates {
        /// The topics with their messages.
        topics: Vec<String>,
    },
    /// The selected topic has no joint states.
    #[error("topic `{topic}` has no sensor_msgs/JointState messages")]
    UnknownTopic {
        /// The selected topic.
        topic: String,
        /// Topics that have.
        found: Vec<String>,
    },
    /// A message that does not match its schema.
    #[error("invalid message {number} of topic `{topic}`: at byte {offset}, {what}")]
    BadMessage {
        /// The topic.
        topic: String,
        /// Number of the message in it, from 1.
        number: usize,
        /// Byte in the message, from 0.
        offset: usize,
        /// The fault there.
        what: String,
    },
    /// The header is not UTF-8.
    #[error("header is not UTF-8 text")]
    HeaderNotUtf8,
    /// Joints are in several topics, none of them `/joint_states`.
    #[error("several topics have joints: {}", .topics.join(", "))]
    SeveralTopics {
        /// The topics.
        topics: Vec<String>,
    },
    /// A mapping file is invalid, or does not fit the recording.
    #[error("{what}")]
    Mapping {
        /// The fault, one clause.
        what: String,
        /// What the user can do.
        advice: String,
    },
    /// The signals contradict their names or units.
    #[error("{0}")]
    Refused(Box<QualityIssue>),
    /// Only white space in the file.
    #[error("empty file")]
    Empty,
    /// A header without rows.
    #[error("header without samples")]
    HeaderOnly,
    /// No column is called `t`.
    #[error("missing time column `t`")]
    NoTimeColumn {
        /// A column that looks like time stamps.
        similar: Option<String>,
        /// All columns.
        columns: Vec<String>,
    },
    /// Two columns have the same name.
    #[error("duplicate column `{name}` (columns {first} and {second})")]
    DuplicateColumn {
        /// Its name.
        name: String,
        /// Number of the first, from 1.
        first: usize,
        /// Number of the second, from 1.
        second: usize,
    },
    /// No column is `<joint>/<quantity>`.
    #[error("no joint columns")]
    NoJointColumns {
        /// A column that looks like one, and its standard name.
        rename: Option<(String, String)>,
        /// All columns.
        columns: Vec<String>,
    },
    /// A row has more or fewer fields than the header.
    #[error("row has {found} fields, expected {expected} as in the header")]
    RaggedRow {
        /// Fields of the header.
        expected: usize,
        /// Fields of the row.
        found: usize,
    },
    /// A quoted field that continues on the next line.
    #[error("unclosed quotation mark")]
    UnclosedQuote,
    /// A field without a value.
    #[error("empty field")]
    EmptyField,
    /// A field is no number.
    #[error("`{text}` is not a number")]
    NotANumber {
        /// The field, shortened.
        text: String,
    },
    /// A column has values of another type.
    #[error("column has {found}, expected a number in each row")]
    WrongColumnType {
        /// What it has instead.
        found: String,
    },
    /// A value is NaN or infinite.
    #[error(
        "value is {text}; {count} of {total} values in the recording {} NaN or infinite",
        if *.count == 1 { "is" } else { "are" }
    )]
    NotFinite {
        /// The first one.
        text: String,
        /// Number of NaN or infinite values.
        count: usize,
        /// Number of values.
        total: usize,
    },
    /// Time stamps decrease.
    #[error(
        "time stamps decrease, from {previous_s} s to {found_s} s{}",
        several_times(*.count, *.total)
    )]
    TimeBackwards {
        /// The stamp before \[s\].
        previous_s: f64,
        /// The stamp found \[s\].
        found_s: f64,
        /// Number of decreases.
        count: usize,
        /// Number of rows.
        total: usize,
    },
    /// Too many duplicate time stamps.
    #[error("{count} duplicate time stamp{} among {total}", plural(*.count))]
    RepeatedStamps {
        /// Number of duplicates.
        count: usize,
        /// Number of rows.
        total: usize,
    },
    /// The stamps cannot be seconds.
    #[error("time stamps appear to be in {unit} (median step {median_step:?})")]
    NotSeconds {
        /// Median step in the unit of the stamps.
        median_step: f64,
        /// "milliseconds", ...
        unit: &'static str,
        /// Factor to seconds.
        factor: f64,
        /// Whether a mapping is used.
        by_mapping: bool,
    },
    /// Too few samples.
    #[error("recording too short: {found} sample{}, at least {required} required", plural(*.found))]
    TooFewSamples {
        /// Samples present.
        found: usize,
        /// Samples required.
        required: usize,
    },
    /// A channel has another length than the time stamps.
    #[error("channel has {found} samples, expected {expected} as time stamps")]
    LengthMismatch {
        /// Number of time stamps.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A joint name that a header cannot hold.
    #[error("`{name}` is not a valid joint name")]
    BadJointName {
        /// The name.
        name: String,
    },
    /// Two joints have the same name.
    #[error("duplicate joint `{joint}`")]
    DuplicateJoint {
        /// Its name.
        joint: String,
    },
    /// A joint without channels.
    #[error("joint `{joint}` has no channels")]
    NoChannels {
        /// Its name.
        joint: String,
    },
    /// A motion of no joints.
    #[error("no joint selected")]
    NoJointsRequested,
    /// A selected joint is not recorded.
    #[error("no data for joint `{joint}`")]
    UnknownJoint {
        /// The selected joint.
        joint: String,
        /// The recorded joint with the most similar name.
        nearest: Option<String>,
        /// The recorded joints.
        recorded: Vec<String>,
    },
    /// A selected joint lacks a channel that is needed.
    #[error("no {quantity} column for joint `{joint}`")]
    MissingChannel {
        /// The selected joint.
        joint: String,
        /// The missing channel.
        quantity: Quantity,
        /// The channels of this joint.
        recorded: Vec<Quantity>,
    },
    /// More of the time span is gap than recorded.
    #[error("{samples} of {expected} expected samples present ({gaps} gap{})", plural(*.gaps))]
    MostlyGaps {
        /// Number of gaps.
        gaps: usize,
        /// Samples present.
        samples: usize,
        /// Duration over median step.
        expected: usize,
    },
    /// A cut-off that the low-pass filter cannot have.
    #[error("cut-off {cutoff_hz} Hz is out of range at {rate_hz} samples per second")]
    CutoffOutOfRange {
        /// The cut-off.
        cutoff_hz: f64,
        /// The sample rate.
        rate_hz: f64,
        /// Lowest cut-off at this rate.
        lowest_hz: f64,
        /// Upper bound of the cut-off at this rate, excluded.
        below_hz: f64,
    },
    /// An order that the low-pass filter cannot have.
    #[error("low-pass order {order} is out of range")]
    OrderOutOfRange {
        /// The order.
        order: usize,
        /// The highest order.
        highest: usize,
    },
}

impl Fault {
    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::SeveralTopics { topics } => format!(
                "choose one in a mapping file: `column = \"{}/{{joint}}/{{quantity}}\"`",
                topics.first().map_or("/joint_states", String::as_str)
            ),
            Self::SeveralJointStates { topics } => {
                let first = topics.first().map_or("/joint_states", String::as_str);
                format!("choose one, for example by --topic {first}")
            }
            Self::Broken { format: "MCAP", .. } => {
                "copy the file again, or try `mcap recover`".to_owned()
            }
            Self::Broken { format: "SQLite", .. } => {
                "copy the file again, or try `sqlite3 log.db3 .recover | sqlite3 recovered.db3`"
                    .to_owned()
            }
            Self::Broken { .. } => "copy the file again".to_owned(),
            Self::CompressedBag { .. } => {
                "write it without compression: `ros2 bag convert -i BAG -o \
                 out.yaml`, where out.yaml is `output_bags: [{uri: plain, all_topics: true}]`"
                    .to_owned()
            }
            Self::MissingBagFiles { .. } => {
                "copy the files beside `metadata.yaml`, or pass one of them".to_owned()
            }
            Self::NotBuilt { feature, .. } => {
                format!("build armident with `--features {feature}`, or export CSV")
            }
            Self::NoJointStates { topics } => {
                format!("record /joint_states too; topics in the file: {}", listed(topics))
            }
            Self::UnknownTopic { found, .. } => {
                format!("topics with joint states: {}", listed(found))
            }
            Self::BadMessage { .. } => {
                "check that the file is intact and uses the standard message definition".to_owned()
            }
            Self::Mapping { advice, .. } => advice.clone(),
            Self::Refused(finding) => return finding.advice.clone(),
            Self::NotFound | Self::NoJointsRequested | Self::Io { .. } => return None,
            Self::IsDirectory => "pass one of the files in it".to_owned(),
            Self::NotCsv { advice, .. } | Self::Unsupported { advice, .. } => (*advice).to_owned(),
            Self::HeaderNotUtf8 => "save the file as UTF-8".to_owned(),
            Self::Empty | Self::HeaderOnly => {
                "name the columns in the first line: `t`, `<joint>/position`, `<joint>/effort`; \
                 write one line per sample below"
                    .to_owned()
            }
            Self::NoTimeColumn { similar: Some(name), .. } => {
                format!("rename column `{name}` to `t`; its unit must be seconds; {GUESS}")
            }
            Self::NoTimeColumn { similar: None, columns } => {
                let columns = listed(columns);
                format!("add a column `t` in seconds; columns in the file: {columns}; {GUESS}")
            }
            Self::DuplicateColumn { .. } => "delete or rename one of the two".to_owned(),
            Self::NoJointColumns { rename: Some((from, to)), .. } => {
                format!("rename column `{from}` to `{to}`, and the others likewise; {GUESS}")
            }
            Self::NoJointColumns { rename: None, columns } => format!(
                "name columns `<joint>/<quantity>`, for example `elbow/position`; columns in the \
                 file: {}; {GUESS}",
                listed(columns)
            ),
            Self::RaggedRow { expected, found } if found >= &(2 * expected - 1) => {
                "use decimal points: `0.5`, not `0,5`".to_owned()
            }
            Self::RaggedRow { expected, found } if found > expected => {
                "add the missing name to the header, or use decimal points in the row".to_owned()
            }
            Self::RaggedRow { .. } => {
                "incomplete row, possibly from an interrupted copy: complete or delete it"
                    .to_owned()
            }
            Self::UnclosedQuote => "close the quotation mark on its line, or delete it".to_owned(),
            Self::EmptyField => "delete the row; missing samples are interpolated".to_owned(),
            Self::NotANumber { text } if text.replacen(',', ".", 1).parse::<f64>().is_ok() => {
                "use a decimal point instead of the comma".to_owned()
            }
            Self::NotANumber { .. } => {
                "write a number such as `-0.25` or `1e-3`, without a unit".to_owned()
            }
            Self::WrongColumnType { .. } => "write it as floating-point numbers, lists with the same number of \
                                             entries in each row, or map other columns to the joints with \
                                             `--mapping FILE`"
                .to_owned(),
            Self::NotFinite { text, .. } if is_nan(text) => format!(
                "delete these rows; missing samples are interpolated (as is NaN, up to \
                 {MISSING_RUN} in a row and {:.0} % of a channel, between numbers)",
                100.0 * MISSING_SHARE
            ),
            Self::NotFinite { .. } => {
                "delete these rows; missing samples are interpolated".to_owned()
            }
            Self::TimeBackwards { .. } => "sort the rows by time (`sort = true` under [time] of a \
                                           mapping file), or split the file where a new recording \
                                           begins"
                .to_owned(),
            Self::RepeatedStamps { .. } => {
                "write the stamps with more digits, or keep one row per stamp".to_owned()
            }
            Self::NotSeconds { by_mapping: true, .. } => {
                "set the unit under [time] in the mapping file: unit = \"ms\", \"us\" or \"ns\""
                    .to_owned()
            }
            Self::NotSeconds { median_step: 1.0, .. } => {
                "multiply column `t` by the sampling period in seconds".to_owned()
            }
            Self::NotSeconds { factor, .. } => format!("multiply column `t` by {factor:?}"),
            Self::TooFewSamples { .. } => "provide a longer recording".to_owned(),
            Self::LengthMismatch { .. } => {
                "provide one value per time stamp in every channel".to_owned()
            }
            Self::BadJointName { .. } => {
                "use a name without line breaks and without spaces at its ends".to_owned()
            }
            Self::DuplicateJoint { .. } => "provide every joint once".to_owned(),
            Self::NoChannels { .. } => "provide at least a position column".to_owned(),
            Self::UnknownJoint { nearest: Some(name), recorded, .. } => {
                format!("did you mean `{name}`? recorded joints: {}", listed(recorded))
            }
            Self::UnknownJoint { nearest: None, recorded, .. } => {
                format!("recorded joints: {}", listed(recorded))
            }
            Self::MissingChannel { joint, quantity, recorded } => {
                let recorded: Vec<String> =
                    recorded.iter().map(|channel| format!("{joint}/{channel}")).collect();
                format!("add a column `{joint}/{quantity}`; recorded: {}", listed(&recorded))
            }
            Self::MostlyGaps { .. } => "split the file at the gaps".to_owned(),
            Self::CutoffOutOfRange { lowest_hz, below_hz, .. } => {
                format!("choose a cut-off from {lowest_hz} Hz to below {below_hz} Hz")
            }
            Self::OrderOutOfRange { highest, .. } => format!("choose an order from 1 to {highest}"),
        };
        Some(hint)
    }
}

/// Names in backquotes, the first twelve of them.
pub(crate) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    if names.len() > SHOWN {
        text.push(format!("and {} more", names.len() - SHOWN));
    }
    text.join(", ")
}

fn several_times(count: usize, total: usize) -> String {
    if count < 2 { String::new() } else { format!(" ({count} times in {total} samples)") }
}

fn is_nan(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(f64::is_nan)
}

pub(crate) fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
