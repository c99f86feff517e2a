//! Recordings beside predictions, as topics of an MCAP file.

use armident_kinematics::DrivingAxisChain;
use armident_recording::{
    Encoded, JointChannels, JointTopic, Mcap, Quantity, Recording, Status, StatusLevel, StatusTopic,
};
use armident_report::{DiagnoseReport, FindingRow, parameter_label};

use crate::failure::Failure;

/// A recording with the efforts that a model predicts for it.
pub(crate) struct PredictedEfforts<'a> {
    pub(crate) recording: &'a Recording,
    /// `[joint][sample]`, in the order of the chain \[N m or N\].
    pub(crate) efforts: Vec<Vec<f64>>,
}

/// The recordings under `/joint_states`, with `/predicted` and `/residual` (measured minus predicted) and, of a diagnosis,
/// `/findings`. Of several recordings, each has its name before these.
///
/// # Errors
/// A recording that MCAP cannot hold; a build without it.
pub(crate) fn as_mcap(
    chain: &DrivingAxisChain,
    predicted: Vec<PredictedEfforts<'_>>,
    diagnosis: Option<&DiagnoseReport>,
) -> Result<Encoded, Failure> {
    let prefixes = prefixes(&predicted);
    let mut beside = Vec::new();
    let mut statuses = Vec::new();
    let mut recordings = Vec::new();
    for (PredictedEfforts { recording, efforts }, prefix) in predicted.into_iter().zip(&prefixes) {
        let joints = chain.joint_names();
        let residual = joints.iter().zip(&efforts).filter_map(|(name, effort)| {
            let measured = recording.joint(name)?.channel(Quantity::Effort)?;
            Some((*name, measured.iter().zip(effort).map(|(m, p)| m - p).collect()))
        });
        let residual = efforts_of(recording, residual)?;
        beside.push((format!("{prefix}/residual"), residual));
        let efforts = joints.iter().copied().zip(efforts);
        beside.push((format!("{prefix}/predicted"), efforts_of(recording, efforts)?));
        recordings.push((format!("{prefix}/joint_states"), recording));
        if let Some(diagnosis) = diagnosis {
            let at = findings_of(diagnosis, recording);
            statuses.push(StatusTopic { name: format!("{prefix}/findings"), at });
        }
    }
    let topics: Vec<JointTopic<'_>> = recordings
        .into_iter()
        .chain(beside.iter().filter_map(|(name, states)| Some((name.clone(), states.as_ref()?))))
        .map(|(name, states)| JointTopic { name, states })
        .collect();
    Ok(Mcap::write_topics(&topics, &statuses)?)
}

/// What stands before the topics of each recording: nothing of a single one, else `/` and the name of its file.
fn prefixes(predicted: &[PredictedEfforts<'_>]) -> Vec<String> {
    if predicted.len() == 1 {
        return vec![String::new()];
    }
    let mut names: Vec<String> = Vec::new();
    for PredictedEfforts { recording, .. } in predicted {
        let stem = stem(recording);
        // names of topics in ROS: letters, digits and underscores
        let valid = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name = format!("/{}", stem.chars().map(valid).collect::<String>());
        let equal = |names: &[String], name: &str| names.iter().any(|known| known == name);
        let numbered = (2..).map(|k| format!("{name}_{k}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|n| !equal(&names, n));
        names.push(free.unwrap_or(name));
    }
    names
}

/// Name of the file of a recording without its extension.
fn stem(recording: &Recording) -> String {
    let path = std::path::Path::new(&recording.source);
    path.file_stem().map_or_else(|| recording.source.clone(), |s| s.to_string_lossy().into_owned())
}

/// Efforts at the stamps of a recording; none of no joint.
fn efforts_of<'n>(
    recording: &Recording,
    efforts: impl Iterator<Item = (&'n str, Vec<f64>)>,
) -> Result<Option<Recording>, Failure> {
    let joints: Vec<JointChannels> = efforts
        .map(|(name, effort)| JointChannels { effort: Some(effort), ..JointChannels::new(name) })
        .collect();
    if joints.is_empty() {
        return Ok(None);
    }
    let recording = Recording::new(&recording.source, recording.time_s.clone(), joints)?;
    Ok(Some(recording))
}

/// Verdict and findings at the begin of a recording; a finding with a window in this recording at both ends of it.
fn findings_of(diagnosis: &DiagnoseReport, recording: &Recording) -> Vec<(f64, Vec<Status>)> {
    let start_s = recording.time_s[0];
    let verdict = Status {
        level: if diagnosis.verdict == "match" { StatusLevel::Ok } else { StatusLevel::Error },
        name: "verdict".to_owned(),
        message: diagnosis.sentence.clone(),
        subject: diagnosis.robot.clone(),
        values: Vec::new(),
    };
    let status = |finding| status(finding, &diagnosis.robot);
    let lasting = diagnosis.findings.iter().filter(|finding| finding.window.is_none());
    let mut at = vec![(start_s, std::iter::once(verdict).chain(lasting.map(status)).collect())];
    let own = stem(recording);
    let here =
        diagnosis.findings.iter().filter(|finding| finding.recording.as_deref() == Some(&own));
    for finding in here {
        if let Some([from_s, to_s]) = finding.window {
            at.push((start_s + from_s, vec![status(finding)]));
            let over = Status { level: StatusLevel::Ok, ..status(finding) };
            at.push((start_s + to_s, vec![over]));
        }
    }
    at
}

fn status(finding: &FindingRow, robot: &str) -> Status {
    let location = finding.location();
    let needed = finding.parameters.iter().filter(|(_, estimate)| estimate.is_needed());
    let parameters: Vec<(String, String)> =
        needed.map(|(name, estimate)| (parameter_label(name), estimate.text())).collect();
    let listed = parameters.iter().map(|(name, value)| format!("{name} {value}"));
    let message = listed.collect::<Vec<_>>().join(", ");
    let confirmed = match finding.confirmed {
        Some(true) => "yes",
        Some(false) => "no",
        None => "not tested",
    };
    let mut values = parameters;
    values.push(("confidence".to_owned(), format!("{:.2}", finding.confidence)));
    values.push(("confirmed by the hold-out".to_owned(), confirmed.to_owned()));
    let materiality = format!("{:.2} noise levels", finding.evidence.materiality);
    values.push(("materiality".to_owned(), materiality));
    if let Some([from_s, to_s]) = finding.window {
        values.push(("window".to_owned(), format!("{from_s:.2} to {to_s:.2} s")));
    }
    let others = finding.alternatives.iter();
    values.extend(others.map(|other| ("not distinguishable from".to_owned(), other.title())));
    Status {
        level: StatusLevel::Warn,
        name: finding.title(),
        message,
        subject: if location.is_empty() { robot.to_owned() } else { location },
        values,
    }
}
