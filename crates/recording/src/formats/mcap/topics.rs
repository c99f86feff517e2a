//! What an MCAP file holds beside one recording.

use super::Mcap;
use crate::error::RecordingError;
use crate::formats::format::Encoded;
use crate::recording::Recording;

/// A topic of joint states (`sensor_msgs/msg/JointState`), one a stamp.
#[derive(Debug, Clone)]
pub struct JointTopic<'a> {
    /// Name of the topic: `/predicted`.
    pub name: String,
    /// Positions, velocities and efforts of joints.
    pub states: &'a Recording,
}

/// A topic of statuses (`diagnostic_msgs/msg/DiagnosticArray`).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StatusTopic {
    /// Name of the topic: `/findings`.
    pub name: String,
    /// Stamps \[s\] with the statuses that hold from then on.
    pub at: Vec<(f64, Vec<Status>)>,
}

/// Level of a status.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StatusLevel {
    /// As expected.
    #[default]
    Ok,
    /// Of note.
    Warn,
    /// Wrong.
    Error,
}

/// One status.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Status {
    /// Level.
    pub level: StatusLevel,
    /// Name; a later status of the same name replaces it.
    pub name: String,
    /// One line.
    pub message: String,
    /// The thing that it is about: joint, link or robot.
    pub subject: String,
    /// Details, each a key with its value.
    pub values: Vec<(String, String)>,
}

impl Mcap {
    /// Joint states of several topics, and statuses, as one file. Stamps before 0 are shifted by whole seconds, the same in
    /// all topics.
    ///
    /// # Errors
    /// A recording is inconsistent or too long for the stamps of ROS; a build without the feature `mcap`.
    pub fn write_topics(
        joints: &[JointTopic<'_>],
        statuses: &[StatusTopic],
    ) -> Result<Encoded, RecordingError> {
        #[cfg(feature = "mcap")]
        return super::writer::write_topics(joints, statuses);
        #[cfg(not(feature = "mcap"))]
        {
            let _ = statuses;
            let source = joints.first().map_or("", |topic| topic.states.source.as_str());
            let fault = crate::error::Fault::NotBuilt { format: "MCAP", feature: "mcap" };
            Err(RecordingError::new(fault, source))
        }
    }
}
