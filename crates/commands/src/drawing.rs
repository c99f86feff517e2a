//! What the page of a result shows beside the result itself.

use armident_diagnose::{Diagnosis, Finding};
use armident_kinematics::DrivingAxisChain;
use armident_model::{ArmModel, PreparedRecording};
use armident_page::{
    Canvas, Compared, Correlation, Drawing, DrawnQuantity, FindingPlace, RecordingRole,
};
use armident_recording::{Quantity, Recording};
use serde::Serialize;

use crate::closed_loop::positions_under;
use crate::failure::Failure;

/// Periods of the cut-off at both ends in which residuals are not counted, as in `identify`.
const EDGE_PERIODS: f64 = 1.5;

/// A result with what is drawn beside it: the JSON that becomes a page.
#[derive(Debug, Serialize)]
pub struct Drawn<'a, T> {
    /// The result.
    #[serde(flatten)]
    pub result: &'a T,
    /// What is drawn.
    pub drawing: &'a Drawing,
}

/// Sentences on the low-pass of a command.
fn filters(cutoff_hz: Option<f64>) -> Vec<String> {
    vec![match cutoff_hz {
        Some(hz) => format!(
            "Positions and efforts are low-passed at {hz:.2} Hz (zero-phase Butterworth, 4th order)."
        ),
        None => "No filter: recorded velocities and accelerations are used.".to_owned(),
    }]
}

/// Recordings with the predictions of some models; `edge_s` at both ends is no error of a model.
fn compared<'a>(
    models: &[&ArmModel],
    recordings: &'a [Recording],
    role: RecordingRole,
    cutoff_hz: Option<f64>,
    edge_s: f64,
) -> Result<Vec<Compared<'a>>, Failure> {
    recordings
        .iter()
        .map(|recording| {
            let predicted = models
                .iter()
                .map(|model| Ok(model.predict(recording, cutoff_hz)?.efforts))
                .collect::<Result<_, Failure>>()?;
            Ok(Compared { recording, role, quantity: DrawnQuantity::Effort, predicted, edge_s })
        })
        .collect()
}

/// What is drawn of recordings beside the efforts of some models of one arm, each with its name.
pub(crate) fn of_models(
    chain: &DrivingAxisChain,
    models: &[(&str, &ArmModel)],
    recorded: &[(&[Recording], RecordingRole)],
    cutoff_hz: Option<f64>,
) -> Result<Drawing, Failure> {
    let (names, models): (Vec<&str>, Vec<&ArmModel>) = models.iter().copied().unzip();
    // as many periods as a fit leaves out at the ends
    let edge_s = cutoff_hz.map_or(0.0, |hz| EDGE_PERIODS / hz);
    let mut all = Vec::new();
    for &(recordings, role) in recorded {
        all.extend(compared(&models, recordings, role, cutoff_hz, edge_s)?);
    }
    let canvas = Canvas::new(chain, &names, &all)?;
    Ok(Drawing { filters: filters(cutoff_hz), ..canvas.drawing() })
}

/// What is drawn of recordings of commands beside the positions of an arm behind its controllers, whose gains are those of each
/// recording.
pub(crate) fn of_positions(
    model: &ArmModel,
    recorded: &[(&[Recording], &[f64], RecordingRole)],
) -> Result<Drawing, Failure> {
    let joints = model.chain.joint_names();
    let mut all = Vec::new();
    for &(recordings, gains, role) in recorded {
        for (recording, gain) in recordings.iter().zip(gains) {
            let column = |joint: &&str| {
                let channels = recording.joint(joint)?;
                channels.channel(Quantity::Command).map(<[f64]>::to_vec)
            };
            let commands = joints.iter().filter_map(column).collect();
            let simulated = positions_under(model, recording, *gain)?;
            all.push(Compared {
                recording,
                role,
                quantity: DrawnQuantity::Position,
                predicted: vec![commands, simulated],
                edge_s: 0.0,
            });
        }
    }
    let canvas = Canvas::new(&model.chain, &["command", "simulated"], &all)?;
    let filters = vec![
        "Positions are not filtered; the arm is simulated from its first recorded position on."
            .to_owned(),
    ];
    Ok(Drawing { filters, ..canvas.drawing() })
}

/// What is drawn of a diagnosis.
pub(crate) fn of_diagnosis(
    diagnosis: &Diagnosis,
    train: &[PreparedRecording<'_>],
    holdout: &[PreparedRecording<'_>],
) -> Result<Drawing, Failure> {
    let before = &diagnosis.believed;
    let models = [before, &diagnosis.rigid, &diagnosis.model];
    let mut all = Vec::new();
    let kept_out = holdout.iter().map(|seen| (seen, RecordingRole::Holdout));
    for (seen, role) in train.iter().map(|seen| (seen, RecordingRole::Training)).chain(kept_out) {
        let predicted =
            models.iter().map(|m| m.predict_prepared(seen)).collect::<Result<_, _>>()?;
        let recording = seen.recording();
        let quantity = DrawnQuantity::Effort;
        all.push(Compared { recording, role, quantity, predicted, edge_s: 0.0 });
    }
    let chain = &before.chain;
    let canvas = Canvas::new(chain, &["given", "links only", "diagnosed"], &all)?;
    let mut drawing = canvas.drawing();
    for finding in &diagnosis.findings {
        let model = finding.ablated_from(&diagnosis.model, before);
        // a finding is looked at on what it was found in
        let mut without =
            train.iter().map(|seen| model.predict_prepared(seen)).collect::<Result<Vec<_>, _>>()?;
        without.resize(all.len(), Vec::new());
        drawing.findings.push(canvas.finding(&place(finding, before), &without));
    }
    drawing.correlation = diagnosis.constants.as_ref().map(|found| Correlation {
        labels: found.constants.iter().map(|c| format!("{} {}", c.label, c.joint)).collect(),
        rows: found.correlation.clone(),
    });
    drawing.filters = vec![format!(
        "Positions are low-passed at 25 Hz before differentiation, the rigid-body part of the predictions at {} Hz \
         (selected on the training recordings). Effort errors are unfiltered.",
        diagnosis.model.band.as_ref().map_or(0.0, |band| band.rigid_cutoff_hz)
    )];
    Ok(drawing)
}

fn place(finding: &Finding, before: &ArmModel) -> FindingPlace {
    let joints = &before.chain.joints;
    let three = |names: [&str; 3]| -> Option<[f64; 3]> {
        let of = |name: &str| finding.parameters.get(name).map(|v| v.value);
        Some([of(names[0])?, of(names[1])?, of(names[2])?])
    };
    FindingPlace {
        effect: finding.effect.clone(),
        joint: joints.iter().position(|j| j.name == finding.evidence.joint).unwrap_or(0),
        link: finding
            .link
            .as_ref()
            .and_then(|link| joints.iter().position(|j| j.child_link == *link)),
        window_s: finding.window,
        recording: finding.recording.clone(),
        force_n: three(["force_x", "force_y", "force_z"]),
        centre_m: three(["com_x", "com_y", "com_z"]),
    }
}
