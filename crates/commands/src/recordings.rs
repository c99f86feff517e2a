//! Recordings of a command: files and folders, channels that it needs, notes.

use std::path::{Path, PathBuf};

use armident_kinematics::nearest;
use armident_motion::{Motion, MotionSettings, findings};
use armident_recording::{
    Action, Formats, GuessedChannel, Mapping, MappingGuess, QualityIssueKind, Quantity,
    ReadSettings, Recording, is_one_recording, read_recording,
};

use crate::failure::Failure;

/// Files as given, and folders of bags of ROS 2; other folders are replaced by their recordings, sorted by name.
///
/// # Errors
/// A folder that cannot be read or has no recording.
pub fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let extensions = Formats::standard().extensions();
    let mut files = Vec::new();
    for path in paths {
        let episodes = episodes(path);
        if !episodes.is_empty() {
            files.extend(episodes);
        } else if is_one_recording(path) {
            files.push(path.clone());
        } else if path.is_dir() {
            let entries = std::fs::read_dir(path).map_err(|error| {
                Failure::new(
                    format!("cannot read the folder: {error}"),
                    path.display(),
                    None::<String>,
                )
            })?;
            let mut found: Vec<PathBuf> = entries
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|path| has_extension(path, &extensions))
                .collect();
            found.sort();
            if found.is_empty() {
                let hint = format!(
                    "pass recordings as files (.{}), or a folder of them",
                    extensions.join(", .")
                );
                return Err(Failure::new(
                    "no recordings in the folder",
                    path.display(),
                    Some(hint),
                ));
            }
            files.extend(found);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

/// Whether the name of a file ends in one of these extensions, in any case.
pub(crate) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().map(|end| end.to_string_lossy().to_lowercase());
    extension.is_some_and(|end| extensions.contains(&end.as_str()))
}

/// Files of episodes of a LeRobot dataset, `data/chunk-000/*.parquet`; none of other folders.
fn episodes(dataset: &Path) -> Vec<PathBuf> {
    if !dataset.join("meta/info.json").is_file() {
        return Vec::new();
    }
    let inside = |folder: PathBuf| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        let mut found: Vec<PathBuf> =
            entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        found.sort();
        found
    };
    let files = inside(dataset.join("data")).into_iter().flat_map(inside);
    files.filter(|file| file.extension().is_some_and(|end| end == "parquet")).collect()
}

/// How recordings are read.
#[derive(Debug, Clone, Default)]
pub struct ReadingOptions {
    /// TOML file that maps columns to joints, quantities and units.
    pub mapping: Option<PathBuf>,
    /// Joint state topic of MCAP files; none: the only one, else `/joint_states`.
    pub topic: Option<String>,
}

/// Reads all files, with the mapping if one is given; `done` is called after each.
///
/// # Errors
/// A file that cannot be read or is refused, see [`read_recording`].
pub fn read_all(
    files: &[PathBuf],
    reading: &ReadingOptions,
    done: impl Fn(),
) -> Result<Vec<Recording>, Failure> {
    let mapping = reading.mapping.as_deref().map(Mapping::load).transpose()?;
    files
        .iter()
        .map(|file| {
            let settings =
                ReadSettings { mapping: mapping.as_ref(), topic: reading.topic.as_deref() };
            let recording = read_recording(file, &settings)?;
            done();
            Ok(recording)
        })
        .collect()
}

/// Notes on the quality of recordings: findings that were kept, and stamps or rows that are not used. Repairs on reading
/// are in the recordings' own notes.
pub fn quality_notes(recordings: &[Recording]) -> Vec<String> {
    let worth_noting = [
        QualityIssueKind::Stuck,
        QualityIssueKind::Saturated,
        QualityIssueKind::Gap,
        QualityIssueKind::SuspectedUnit,
    ];
    let not_used = [QualityIssueKind::LateStamps, QualityIssueKind::HeldEfforts];
    let mut notes = Vec::new();
    for recording in recordings {
        for finding in findings(recording) {
            let is_kept = finding.action == Action::Kept && worth_noting.contains(&finding.kind);
            if is_kept || not_used.contains(&finding.kind) {
                notes.push(format!("{}: {}", recording.source, finding.message));
            }
        }
    }
    notes
}

/// Joints with a position in every one of the recordings, in the order of the first.
pub(crate) fn joints_with_position(recordings: &[Recording]) -> Vec<String> {
    let has = |recording: &Recording, name: &str| {
        recording.joint(name).is_some_and(|j| j.channel(Quantity::Position).is_some())
    };
    let Some(first) = recordings.first() else { return Vec::new() };
    first
        .joint_names()
        .into_iter()
        .filter(|name| recordings.iter().all(|r| has(r, name)))
        .map(ToOwned::to_owned)
        .collect()
}

/// Low-passed motions of the joints with their efforts.
pub(crate) fn motions_with_effort(
    recordings: &[Recording],
    joints: &[&str],
    cutoff_hz: Option<f64>,
) -> Result<Vec<Motion>, Failure> {
    let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
    recordings
        .iter()
        .map(|recording| {
            let motion = Motion::from_recording(recording, joints, &settings)?;
            if motion.effort.is_none() {
                let without: Vec<&str> = joints
                    .iter()
                    .copied()
                    .filter(|j| {
                        recording.joint(j).is_none_or(|c| c.channel(Quantity::Effort).is_none())
                    })
                    .collect();
                return Err(no_effort(recording, &without));
            }
            Ok(motion)
        })
        .collect()
}

/// A recording lacks the effort of some joints.
pub(crate) fn no_effort(recording: &Recording, joints: &[&str]) -> Failure {
    let hint = joints.iter().find_map(|joint| misspelt_effort(recording, joint));
    let hint = hint.or_else(|| ignored_command(recording, joints));
    Failure::new(
        format!("no effort column for {}", joints.join(", ")),
        &recording.source,
        Some(hint.unwrap_or_else(|| {
            "provide <joint>/effort in N m or N for every chain joint (convert currents and \
             voltages with --mapping FILE, see docs/mapping.md), or lock joints without \
             one with --lock JOINT=VALUE"
                .to_owned()
        })),
    )
}

/// Hint for an ignored column whose name is close to the effort of a joint.
fn misspelt_effort(recording: &Recording, joint: &str) -> Option<String> {
    let like = |found: &str, wanted: &str| nearest(found, &[wanted.to_owned()]).is_some();
    recording.ignored_columns.iter().find_map(|column| {
        let (of, quantity) = column.rsplit_once('/')?;
        let misspelt = (of == joint && like(quantity, "effort"))
            || (quantity == "effort" && like(of, joint) && recording.joint(of).is_none());
        misspelt.then(|| format!("did you mean `{joint}/effort` instead of `{column}`?"))
    })
}

/// Hint for ignored columns whose names suggest commands of all these joints: with them no efforts are needed.
fn ignored_command(recording: &Recording, joints: &[&str]) -> Option<String> {
    let names: Vec<String> = joints.iter().map(|joint| (*joint).to_owned()).collect();
    // a command is one beside a position
    let positions = joints.iter().map(|joint| format!("{joint}/position"));
    let columns: Vec<String> = positions.chain(recording.ignored_columns.clone()).collect();
    let guess = MappingGuess::of(&columns, &names);
    let column = |joint: &&str| {
        let is_it = |c: &&GuessedChannel| c.quantity == Quantity::Command && c.joint == **joint;
        Some(format!("`{}`", guess.channels.iter().find(is_it)?.column))
    };
    let columns = joints.iter().map(column).collect::<Option<Vec<String>>>()?;
    (!columns.is_empty()).then(|| {
        format!(
            "{} may be commands, with which no efforts are needed: write a mapping with `armident info {} --write-mapping \
             mapping.toml`, check it, and pass --mapping mapping.toml",
            columns.join(", "),
            recording.source
        )
    })
}

/// Notes of all motions with their source, without duplicates.
pub(crate) fn notes<'a>(motions: impl IntoIterator<Item = &'a Motion>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for motion in motions {
        for note in &motion.notes {
            let line = format!("{}: {note}", motion.source);
            if !all.contains(&line) {
                all.push(line);
            }
        }
    }
    all
}
