//! What can be wrong with a recording, where, and what to do about it.

use std::fmt::Write as _;
use std::io;

use crate::draft::{MISSING_RUN, MISSING_SHARE};
use crate::finding::Finding;
use crate::recording::Quantity;

/// A fault of a recording: what is wrong (`Display`, one sentence), the place, and a hint.
///
/// A command line prints three lines: `error:` the fault, `in:` [`place`](Self::place), `hint:`
/// [`hint`](Self::hint).
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
    /// A fault of the file or signal `source`.
    pub fn new(fault: Fault, source: &str) -> Self {
        Self(Box::new(Inner { fault, source_name: source.to_owned(), line: None, column: None }))
    }

    /// The same fault with the line it was found on, counted from 1.
    pub(crate) fn on_line(mut self, line: u64) -> Self {
        // formats without lines count from 0
        self.0.line = (line > 0).then_some(line);
        self
    }

    /// The same fault with the column it was found in.
    pub fn in_column(mut self, column: &str) -> Self {
        self.0.column = Some(column.to_owned());
        self
    }

    /// The same fault in another source.
    pub fn of_source(mut self, source: &str) -> Self {
        source.clone_into(&mut self.0.source_name);
        self
    }

    /// The kind of the fault with its numbers.
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

    /// Where: ``file.csv, line 12, column `elbow/position` ``, as far as known.
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

    /// What to do about it, where there is something to say beyond the fault itself.
    pub fn hint(&self) -> Option<String> {
        self.0.fault.hint()
    }
}

/// The kinds of faults. Lists of names are in file order.
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
        /// What the operating system said.
        error: io::Error,
    },
    /// The first bytes are those of another format.
    #[error("this is {format}, not CSV text")]
    NotCsv {
        /// The format with its article.
        format: &'static str,
    },
    /// A file of a known format that breaks its rules.
    #[error("this is no whole {format} file: {what}")]
    Broken {
        /// The format.
        format: &'static str,
        /// What its reader says.
        what: String,
    },
    /// A format that this build does not read.
    #[error("this is {format}, which this build does not read")]
    NotBuilt {
        /// The format with its article.
        format: &'static str,
        /// The feature that reads it.
        feature: &'static str,
    },
    /// Joint states are in several topics, none of them the usual one.
    #[error("several topics have joint states: {}", .topics.join(", "))]
    SeveralJointStates {
        /// The topics.
        topics: Vec<String>,
    },
    /// No topic has joint states.
    #[error("no topic has messages sensor_msgs/JointState")]
    NoJointStates {
        /// The topics with their messages.
        topics: Vec<String>,
    },
    /// The topic asked for has no joint states.
    #[error("the topic `{topic}` has no messages sensor_msgs/JointState")]
    UnknownTopic {
        /// The topic asked for.
        topic: String,
        /// Topics that have.
        found: Vec<String>,
    },
    /// A message that is not what its schema says.
    #[error("message {number} of the topic `{topic}` cannot be read: at byte {offset}, {what}")]
    BadMessage {
        /// The topic.
        topic: String,
        /// Number of the message in it, from 1.
        number: usize,
        /// Byte in the message, from 0.
        offset: usize,
        /// What is wrong there.
        what: String,
    },
    /// The header is not UTF-8.
    #[error("the header is not UTF-8 text")]
    HeaderNotUtf8,
    /// Joints are in several topics, none of them the usual one.
    #[error("several topics have joints: {}", .topics.join(", "))]
    SeveralTopics {
        /// The topics.
        topics: Vec<String>,
    },
    /// A mapping file is wrong, or does not fit the recording.
    #[error("{what}")]
    Mapping {
        /// What is wrong, one sentence.
        what: String,
        /// What to do.
        advice: String,
    },
    /// The signals are not what their names say.
    #[error("{0}")]
    Refused(Box<Finding>),
    /// Nothing in the file but white space.
    #[error("the file is empty")]
    Empty,
    /// The header has no row below it.
    #[error("there is a header, but no samples below it")]
    HeaderOnly,
    /// The header is one field that contains another separator.
    #[error("the columns are separated by {separator}, not by commas")]
    WrongSeparator {
        /// "semicolons", "tabs", ...
        separator: &'static str,
        /// Whether numbers below are written with decimal commas.
        decimal_commas: bool,
    },
    /// No column is called `t`.
    #[error("there is no column `t` with the time stamps")]
    NoTimeColumn {
        /// A column that looks like time stamps.
        similar: Option<String>,
        /// All columns.
        columns: Vec<String>,
    },
    /// Two columns have the same name.
    #[error("the column `{name}` occurs twice, as columns number {first} and {second}")]
    DuplicateColumn {
        /// Its name.
        name: String,
        /// Number of the first, from 1.
        first: usize,
        /// Number of the second, from 1.
        second: usize,
    },
    /// No column is `<joint>/<quantity>`.
    #[error("there is no joint column")]
    NoJointColumns {
        /// A column that looks like one, and what it would have to be called.
        rename: Option<(String, String)>,
        /// All columns.
        columns: Vec<String>,
    },
    /// A row has more or fewer fields than the header.
    #[error("the row has {found} fields, the header {expected}")]
    RaggedRow {
        /// Fields of the header.
        expected: usize,
        /// Fields of the row.
        found: usize,
    },
    /// A field goes on over the end of its line.
    #[error("a field begins with a quotation mark that is not closed on its line")]
    UnclosedQuote,
    /// A field has nothing in it.
    #[error("the field is empty")]
    EmptyField,
    /// A field is no number.
    #[error("`{text}` is not a number")]
    NotANumber {
        /// The field, shortened.
        text: String,
    },
    /// A value is NaN or infinite.
    #[error("the value is {text}; the recording has {count} such value{} among {total}", plural(*.count))]
    NotFinite {
        /// The first one found.
        text: String,
        /// How many NaN or infinite values there are in all.
        count: usize,
        /// How many values there are.
        total: usize,
    },
    /// Time runs backwards.
    #[error(
        "the time goes backwards, from {previous_s} s to {found_s} s{}",
        several_times(*.count, *.total)
    )]
    TimeBackwards {
        /// The stamp before \[s\].
        previous_s: f64,
        /// The stamp found \[s\].
        found_s: f64,
        /// How often it does so.
        count: usize,
        /// Number of rows.
        total: usize,
    },
    /// Too many samples repeat the stamp before them.
    #[error("{count} of {total} samples repeat the time stamp before them")]
    RepeatedStamps {
        /// Number of repetitions.
        count: usize,
        /// Number of rows.
        total: usize,
    },
    /// The stamps cannot be seconds.
    #[error(
        "the time stamps are not in seconds: the median step is {median_step:?}, so they look like \
         {unit}"
    )]
    NotSeconds {
        /// Median step in whatever unit it is.
        median_step: f64,
        /// "milliseconds", ...
        unit: &'static str,
        /// What the stamps have to be multiplied by.
        factor: f64,
        /// Whether a mapping said that they are seconds.
        by_mapping: bool,
    },
    /// Too short for anything.
    #[error("the recording has {found} sample{}, at least {required} are needed", plural(*.found))]
    TooFewSamples {
        /// Samples present.
        found: usize,
        /// Samples needed.
        required: usize,
    },
    /// A channel has another length than the time stamps.
    #[error("the channel has {found} samples, the time stamps are {expected}")]
    LengthMismatch {
        /// Number of time stamps.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A joint name that cannot be written into a header and read back.
    #[error("`{name}` cannot be the name of a joint")]
    BadJointName {
        /// The name.
        name: String,
    },
    /// Two joints have the same name.
    #[error("the joint `{joint}` occurs twice")]
    DuplicateJoint {
        /// Its name.
        joint: String,
    },
    /// A joint without a single channel.
    #[error("the joint `{joint}` has no channel")]
    NoChannels {
        /// Its name.
        joint: String,
    },
    /// A motion of no joints was asked for.
    #[error("no joint was asked for")]
    NoJointsRequested,
    /// A joint asked for is not recorded.
    #[error("nothing is recorded of the joint `{joint}`")]
    UnknownJoint {
        /// The joint asked for.
        joint: String,
        /// The recorded joint with the most similar name.
        nearest: Option<String>,
        /// The recorded joints.
        recorded: Vec<String>,
    },
    /// A joint asked for lacks a channel that is needed.
    #[error("the {quantity} of the joint `{joint}` is not recorded")]
    MissingChannel {
        /// The joint asked for.
        joint: String,
        /// What is missing.
        quantity: Quantity,
        /// What is recorded of this joint.
        recorded: Vec<Quantity>,
    },
    /// More of the time span is gap than recorded.
    #[error(
        "most of the recording is missing: {gaps} gap{} among {samples} samples where {expected} \
         are due", plural(*.gaps)
    )]
    MostlyGaps {
        /// Number of gaps.
        gaps: usize,
        /// Samples present.
        samples: usize,
        /// Samples that the duration holds at the median step.
        expected: usize,
    },
    /// The low-pass cannot be built.
    #[error("a cutoff of {cutoff_hz} Hz is not possible at {rate_hz} samples per second")]
    CutoffOutOfRange {
        /// The cutoff asked for.
        cutoff_hz: f64,
        /// The sample rate.
        rate_hz: f64,
        /// Lowest cutoff at this rate.
        lowest_hz: f64,
        /// Bound that the cutoff must stay below at this rate.
        below_hz: f64,
    },
    /// The low-pass cannot be built.
    #[error("{order} is not a possible order of the low-pass filter")]
    OrderOutOfRange {
        /// The order asked for.
        order: usize,
        /// The highest order.
        highest: usize,
    },
}

impl Fault {
    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::SeveralTopics { topics } => format!(
                "choose one by a mapping file: `column = \"{}/{{joint}}/{{quantity}}\"`",
                topics.first().map_or("/joint_states", String::as_str)
            ),
            Self::SeveralJointStates { topics } => {
                let first = topics.first().map_or("/joint_states", String::as_str);
                format!("choose one, for example by --topic {first}")
            }
            Self::Broken { .. } => "was the file copied whole? `mcap recover` may help".to_owned(),
            Self::NotBuilt { feature, .. } => {
                format!("build armident with `--features {feature}`, or export CSV")
            }
            Self::NoJointStates { topics } => {
                format!("record /joint_states too; the topics are {}", listed(topics))
            }
            Self::UnknownTopic { found, .. } => {
                format!("topics with joint states are {}", listed(found))
            }
            Self::BadMessage { .. } => {
                "was the file written by another version of the message, or damaged?".to_owned()
            }
            Self::Mapping { advice, .. } => advice.clone(),
            Self::Refused(finding) => return finding.advice.clone(),
            Self::NotFound | Self::NoJointsRequested | Self::Io { .. } => return None,
            Self::IsDirectory => "name one CSV file in it".to_owned(),
            Self::NotCsv { format } if converter(format).is_some() => {
                converter(format).unwrap_or_default().to_owned()
            }
            Self::NotCsv { .. } => "export it as comma-separated UTF-8 text: a column `t` in \
                                    seconds, then `<joint>/position` and so on"
                .to_owned(),
            Self::HeaderNotUtf8 => "save the file as UTF-8".to_owned(),
            Self::Empty | Self::HeaderOnly => {
                "the first line names the columns: `t`, `<joint>/position`, `<joint>/effort`; one \
                 line per sample follows"
                    .to_owned()
            }
            Self::WrongSeparator { decimal_commas: true, .. } => {
                "separate the columns by commas and write decimal points: `0.5`, not `0,5`"
                    .to_owned()
            }
            Self::WrongSeparator { .. } => "separate the columns by commas".to_owned(),
            Self::NoTimeColumn { similar: Some(name), .. } => {
                format!("rename the column `{name}` to `t`; it must be in seconds")
            }
            Self::NoTimeColumn { similar: None, columns } => {
                format!("add a column `t` in seconds; the columns are {}", listed(columns))
            }
            Self::DuplicateColumn { .. } => "delete or rename one of the two".to_owned(),
            Self::NoJointColumns { rename: Some((from, to)), .. } => {
                format!("rename the column `{from}` to `{to}`, and the others alike")
            }
            Self::NoJointColumns { rename: None, columns } => format!(
                "name the columns `<joint>/<quantity>`, for example `elbow/position`; the columns \
                 are {}",
                listed(columns)
            ),
            Self::RaggedRow { expected, found } if found >= &(2 * expected - 1) => {
                "decimal commas? write decimal points: `0.5`, not `0,5`".to_owned()
            }
            Self::RaggedRow { expected, found } if found > expected => {
                "is a name missing in the header, or a decimal comma in the row?".to_owned()
            }
            Self::RaggedRow { .. } => "was the file cut off or written to while it was copied? \
                                       complete or delete the row"
                .to_owned(),
            Self::UnclosedQuote => "delete or close the quotation mark".to_owned(),
            Self::EmptyField => {
                "delete the row: a lost sample may be left out, its place is interpolated"
                    .to_owned()
            }
            Self::NotANumber { text } if text.replacen(',', ".", 1).parse::<f64>().is_ok() => {
                "write a decimal point instead of the comma".to_owned()
            }
            Self::NotANumber { .. } => {
                "write a number such as `-0.25` or `1e-3`, without a unit".to_owned()
            }
            Self::NotFinite { text, .. } if is_nan(text) => format!(
                "delete these rows: lost samples may be left out, their places are interpolated \
                 (NaN is filled in up to {MISSING_RUN} in a row and {:.0} % of a channel, between \
                 numbers)",
                100.0 * MISSING_SHARE
            ),
            Self::NotFinite { .. } => {
                "delete these rows: lost samples may be left out, their places are interpolated"
                    .to_owned()
            }
            Self::TimeBackwards { .. } => "sort the rows by time (a mapping file does it with \
                                           `sort = true` under [time]), or split the file where a \
                                           new recording begins"
                .to_owned(),
            Self::RepeatedStamps { .. } => {
                "write the stamps with more digits, or keep one row per stamp".to_owned()
            }
            Self::NotSeconds { by_mapping: true, .. } => {
                "state the unit under [time] in the mapping file: unit = \"ms\", \"us\" or \"ns\""
                    .to_owned()
            }
            Self::NotSeconds { median_step: 1.0, .. } => {
                "multiply the column `t` by the sampling period in seconds".to_owned()
            }
            Self::NotSeconds { factor, .. } => format!("multiply the column `t` by {factor:?}"),
            Self::TooFewSamples { .. } => "give a longer recording".to_owned(),
            Self::LengthMismatch { .. } => "give every channel one value per stamp".to_owned(),
            Self::BadJointName { .. } => {
                "a name is not empty and has no line breaks and no space around it".to_owned()
            }
            Self::DuplicateJoint { .. } => "give every joint once".to_owned(),
            Self::NoChannels { .. } => "give its position at least".to_owned(),
            Self::UnknownJoint { nearest: Some(name), recorded, .. } => {
                format!("did you mean `{name}`? recorded joints are {}", listed(recorded))
            }
            Self::UnknownJoint { nearest: None, recorded, .. } => {
                format!("recorded joints are {}", listed(recorded))
            }
            Self::MissingChannel { joint, quantity, recorded } => {
                let recorded: Vec<String> =
                    recorded.iter().map(|channel| format!("{joint}/{channel}")).collect();
                format!("add a column `{joint}/{quantity}`; recorded are {}", listed(&recorded))
            }
            Self::MostlyGaps { .. } => "split the file at the gaps".to_owned(),
            Self::CutoffOutOfRange { lowest_hz, below_hz, .. } => {
                format!("choose a cutoff from {lowest_hz} Hz to below {below_hz} Hz")
            }
            Self::OrderOutOfRange { highest, .. } => format!("choose an order from 1 to {highest}"),
        };
        Some(hint)
    }
}

/// What turns a format into one that is read.
fn converter(format: &str) -> Option<&'static str> {
    Some(match format {
        "a ROS 1 bag" => "convert it by `mcap convert in.bag out.mcap` (mcap.dev/guides/cli)",
        "an SQLite file (a ROS 2 bag?)" => {
            "convert it by `mcap convert in.db3 out.mcap` (mcap.dev/guides/cli), or by `ros2 bag \
             convert`"
        }
        "a MATLAB file" | "an HDF5 file" => {
            "in MATLAB: `writematrix([t q dq tau], 'log.csv')`, with a first line `t, \
             <joint>/position, ...`; in Python scipy.io.loadmat (h5py for version 7.3) reads it"
        }
        "a NumPy file" => {
            "in Python: `numpy.savetxt(\"log.csv\", columns, delimiter=\",\", \
             header=\"t,<joint>/position,...\", comments=\"\")`"
        }
        _ => return None,
    })
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
    if count < 2 { String::new() } else { format!(", and so {count} times in {total} samples") }
}

fn is_nan(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(f64::is_nan)
}

pub(crate) fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
