//! A card a joint: efforts over time, residual map, spectra.

use armident_report::{ByJoint, percent};

use crate::drawing::{Drawing, RecordingRole};
use crate::figures;
use crate::view::{JointCard, number};

/// Cards of all joints with a recorded effort. `open` are the joints whose cards are open at first; `noise` is the noise
/// of one recorded sample.
pub(super) fn joint_cards(drawing: &Drawing, open: &[String], noise: &ByJoint) -> Vec<JointCard> {
    (drawing.joints.iter().zip(&drawing.residuals).enumerate())
        .filter(|(_, (_, residual))| !residual.rms.is_empty())
        .map(|(j, (joint, residual))| {
            let noise = noise.get(&joint.name).copied();
            let all = [
                figures::efforts(drawing, j, RecordingRole::Training, noise),
                figures::efforts(drawing, j, RecordingRole::Holdout, noise),
                figures::maps(drawing, j, residual),
                figures::spectra(drawing, j, residual),
            ];
            let errors: Vec<String> = drawing
                .models
                .iter()
                .zip(&residual.rms)
                .map(|(model, rms)| {
                    let share = percent(rms / residual.effort_deviation);
                    format!(
                        "{model} {} {} ({share})",
                        number(*rms, 3),
                        drawing.quantity.unit(joint)
                    )
                })
                .collect();
            JointCard {
                name: joint.name.clone(),
                summary: format!("RMS residual: {}", errors.join(", ")),
                figures: all.into_iter().flatten().collect(),
                open: open.contains(&joint.name),
            }
        })
        .collect()
}
