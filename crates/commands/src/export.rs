//! `export`: a model in another format.

use std::path::{Path, PathBuf};

use armident_export::{
    AlarmThresholds, Exported, Held, Lost, ObservedAlarms, controller, controller_with_alarm,
    drake_sdf, isaac_lab, mjcf, urdf, usd,
};
use armident_model::ArmModel;
use armident_motion::EvenGrid;
use armident_recording::Recording;
use armident_report::{aligned, counted, percent, significant};
use serde::Serialize;

use crate::failure::Failure;
use crate::robot::{GivenRobot, chain_warnings};

/// A format that models are exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// Links, limits, damping and friction.
    Urdf,
    /// MuJoCo format: also armature, gravity and motors.
    Mjcf,
    /// SDFormat for Drake: links, limits, damping, friction and rotor inertia.
    DrakeSdf,
    /// Actuators of Isaac Lab, as Python source.
    IsaacLab,
    /// USD overlay: masses of links, rotor inertia and friction of joints.
    Usd,
    /// C99 source for a controller, with a header beside it.
    C,
}

impl ExportFormat {
    /// The format of a file extension.
    ///
    /// # Errors
    /// Another extension.
    pub fn of_path(path: &Path) -> Result<Self, Failure> {
        let end = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match end.as_str() {
            "urdf" => Ok(Self::Urdf),
            "xml" | "mjcf" => Ok(Self::Mjcf),
            "sdf" => Ok(Self::DrakeSdf),
            "py" => Ok(Self::IsaacLab),
            "usda" => Ok(Self::Usd),
            "c" => Ok(Self::C),
            _ => Err(Failure::new(
                format!("cannot infer the output format from `{}`", path.display()),
                path.display(),
                Some(
                    "use the extension .urdf, .xml for MJCF, .sdf, .usda, .py for Isaac Lab, or .c, or pass --format",
                ),
            )),
        }
    }
}

/// What was written and what the format could not hold.
#[derive(Debug, Clone, Serialize)]
pub struct ExportReport {
    schema: &'static str,
    robot: String,
    model: String,
    /// Name of the format.
    pub format: &'static str,
    /// File that was written.
    pub file: String,
    /// Header beside it, for C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header: Option<String>,
    /// Thresholds of the observer, for C with a false-alarm rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thresholds: Option<ThresholdsReport>,
    /// Joints of the arm in order.
    pub joints: Vec<String>,
    /// Effects that the format holds.
    pub held: Vec<Held>,
    /// Effects that it cannot hold.
    pub lost: Vec<Lost>,
    /// Other omissions and assumed values.
    pub notes: Vec<String>,
    /// Warnings on the arm.
    pub warnings: Vec<String>,
}

/// Thresholds of the observer, and alarms on recordings that they are not of.
#[derive(Debug, Clone, Serialize)]
pub struct ThresholdsReport {
    /// Recordings that the thresholds are of.
    pub recordings: Vec<String>,
    /// Recordings that they are tried on.
    pub holdout_recordings: Vec<String>,
    /// The thresholds.
    #[serde(flatten)]
    pub of: AlarmThresholds,
    /// Alarms on the hold-out; none without one.
    pub holdout: Option<ObservedAlarms>,
}

impl ThresholdsReport {
    /// Human-readable text.
    pub fn text(&self) -> String {
        let number = |x: f64| significant(x, 3, 0.0);
        let of = &self.of;
        let mut text = format!(
            "\nThresholds of the observer: {} false alarms per hour, gain {} 1/s, {} Hz\n",
            number(of.false_alarms_per_hour),
            number(of.gain),
            number(of.rate_hz)
        );
        let rows: Vec<Vec<String>> = of
            .joints
            .iter()
            .map(|joint| {
                let ends = |of: &[f64]| [of.first(), of.last()].map(|x| x.map_or(f64::NAN, |x| *x));
                let [[slow, fast], [low, high], [least, most]] =
                    [ends(&joint.speed), ends(&joint.threshold), ends(&joint.detectable)];
                let numbers = [slow, low, least, fast, high, most].map(number);
                std::iter::once(joint.joint.clone()).chain(numbers).collect()
            })
            .collect();
        let header =
            ["joint", "slow", "threshold", "detectable", "fast", "threshold", "detectable"];
        text += &aligned(&header, &rows, 1);
        let observed = |name: &str, alarms: &ObservedAlarms| {
            let count = counted(alarms.alarms, "alarm");
            let (seconds, rate) = (number(3600.0 * alarms.hours), number(alarms.per_hour));
            format!("{name}: {count} in {seconds} s, {rate} per hour\n")
        };
        text += &observed("recordings of the thresholds", &of.observed);
        if let Some(holdout) = &self.holdout {
            text += &observed("hold-out", holdout);
        }
        text
    }
}

/// A false-alarm rate, and the recordings without contact that show it.
#[derive(Debug, Clone, Copy)]
pub struct FalseAlarms<'a> {
    /// False alarms per hour of the whole arm.
    pub per_hour: f64,
    /// Gain of the observer \[1/s\]; none: 30, or a tenth of the rate of the slowest recording.
    pub gain: Option<f64>,
    /// Recordings that the thresholds are of.
    pub recordings: &'a [Recording],
    /// Recordings that they are tried on.
    pub holdout: &'a [Recording],
}

/// Gain of the observer, unless recordings are too slow for it \[1/s\].
const OBSERVER_GAIN: f64 = 30.0;
/// Alarms of recordings from which a rate is known within a factor of 2 (`false_alarms_are_as_rare_as_requested` in
/// `crates/export/tests`).
const TESTED_ALARMS: f64 = 10.0;
/// Steps of a recording within a time constant of the observer.
const STEPS: f64 = 10.0;

impl FalseAlarms<'_> {
    fn thresholds(&self, model: &ArmModel) -> Result<ThresholdsReport, Failure> {
        let gain = match self.gain {
            Some(gain) => gain,
            None => {
                let mut slowest = f64::INFINITY;
                for recording in self.recordings.iter().chain(self.holdout) {
                    slowest = slowest.min(EvenGrid::of(recording)?.rate_hz());
                }
                OBSERVER_GAIN.min(slowest / STEPS)
            }
        };
        let of = AlarmThresholds::of(model, self.recordings, self.per_hour, gain)?;
        let holdout =
            (!self.holdout.is_empty()).then(|| of.observed_on(model, self.holdout)).transpose()?;
        let sources = |of: &[Recording]| of.iter().map(|r| r.source.clone()).collect();
        let (recordings, holdout_recordings) = (sources(self.recordings), sources(self.holdout));
        Ok(ThresholdsReport { recordings, holdout_recordings, of, holdout })
    }
}

/// The model in another format, as the texts of the files to be written, `file` first, and what it could not hold.
///
/// # Errors
/// A chain that cannot be chosen; recordings that give no thresholds.
pub fn export(
    robot: &GivenRobot,
    format: ExportFormat,
    file: &Path,
    false_alarms: Option<FalseAlarms<'_>>,
) -> Result<(Vec<(PathBuf, String)>, ExportReport), Failure> {
    let model = robot.arm(None)?;
    let (simulated, without_place) = model.simulated();
    let thresholds = match (false_alarms, format) {
        (Some(alarms), ExportFormat::C) => Some(alarms.thresholds(&model)?),
        (Some(_), _) => {
            return Err(Failure::new(
                "thresholds of an observer are for C source",
                "--false-alarms-per-hour",
                Some("write to a file with the extension .c, or omit the option"),
            ));
        }
        (None, _) => None,
    };
    let (name, without_place, exported) = match format {
        ExportFormat::Urdf => ("URDF", without_place, urdf(&simulated)),
        ExportFormat::Mjcf => ("MJCF", without_place, mjcf(&simulated)),
        ExportFormat::DrakeSdf => ("SDFormat", without_place, drake_sdf(&simulated)),
        ExportFormat::IsaacLab => ("Isaac Lab", without_place, isaac_lab(&simulated)),
        ExportFormat::Usd => ("USD", without_place, usd(&simulated)),
        ExportFormat::C => {
            let exported = match &thresholds {
                Some(thresholds) => controller_with_alarm(&model, &thresholds.of),
                None => controller(&model),
            };
            ("C", Vec::new(), exported)
        }
    };
    let Exported { text, companion, held, lost, mut notes } = exported;
    let mut files = vec![(file.to_owned(), text)];
    files.extend(companion.map(|header| (file.with_file_name(header.file), header.text)));
    notes.extend(lost_notes(name, &lost));
    notes.extend(without_place.iter().map(|what| format!("omitted: {what}")));
    if let Some(thresholds) = thresholds.as_ref().filter(|t| t.of.expected_alarms < TESTED_ALARMS) {
        notes.push(format!(
            "the recordings without contact are {} as long as the time between false alarms: the rate is that of a continued \
             tail; within a factor of 2 it is known from about {TESTED_ALARMS} times that time on",
            percent(thresholds.of.expected_alarms)
        ));
    }
    let report = ExportReport {
        thresholds,
        schema: "armident.export/1",
        robot: model.chain.robot.clone(),
        model: robot.source.clone(),
        format: name,
        file: file.display().to_string(),
        header: files.get(1).map(|(path, _)| path.display().to_string()),
        joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
        held,
        lost,
        notes,
        warnings: chain_warnings(&model),
    };
    Ok((files, report))
}

/// One note per omitted effect and reason.
fn lost_notes(format: &str, lost: &[Lost]) -> Vec<String> {
    let mut kinds: Vec<(&str, &str, Vec<String>)> = Vec::new();
    for one in lost {
        let values: Vec<String> = one.parameters.iter().map(|p| significant(*p, 3, 0.0)).collect();
        let entry = format!("{} {}", one.joint, values.join(" "));
        match kinds.iter_mut().find(|k| k.0 == one.effect && k.1 == one.reason) {
            Some((_, _, entries)) => entries.push(entry),
            None => kinds.push((&one.effect, one.reason, vec![entry])),
        }
    }
    let sentence = |(effect, reason, entries): &(&str, &str, Vec<String>)| {
        format!("{effect} omitted from {format} ({reason}): {}", entries.join(", "))
    };
    kinds.iter().map(sentence).collect()
}
