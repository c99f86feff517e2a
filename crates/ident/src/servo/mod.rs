//! Arms without recorded efforts: joints behind position controllers, from their commands and positions.
//!
//! ```text
//! K (c(t - T) - q) = rigid(q, q̇, q̈) + f        the effort of a joint is the stiffness times command minus position
//! ```
//!
//! Divided by the stiffness `K`, the equation is linear in `1/K` and in the parameters of the effects over `K`. It gives the
//! start; then the positions that the joint takes under its commands, simulated with dry friction, are fitted to the recorded
//! ones. Only the weight of the links has a known unit: where a joint carries none, parameters are known over its stiffness.

mod command_checks;
mod command_replay;
mod commands;
mod error;
mod joint_data;
mod joint_fit;
mod output_error;
mod parameters;
mod request;
mod start;

use armident_effects::PositionServo;
use armident_model::{ArmModel, ServoTerm};
use rayon::prelude::*;

use joint_data::JointData;
use joint_fit::{JointEstimate, ablations, fit, least_unfelt_stiffness};

pub use command_checks::check_commands;
pub use command_replay::{COMMAND_WINDOW_S, CommandReplay, CommandReplayError, replay_commands};
pub use commands::Lag;
pub use error::{CommandFault, ServoError};
pub use joint_fit::{OF_ROUNDING, ServoAblation};
pub use parameters::{ServoParameter, ServoValue};
pub use request::ServoRequest;

/// Cost over that of a free stiffness beyond which the stiffness of other joints is not taken over: the size of the residuals is then a
/// quarter larger.
const VISIBLY_WORSE: f64 = 1.5;

/// What commands and positions of an arm give.
#[derive(Debug, Clone)]
pub struct ServoIdentification {
    /// The links of the given model with controllers and effects of all joints.
    pub model: ArmModel,
    /// One a joint, from base to tip.
    pub joints: Vec<ServoJointFit>,
    /// Joints whose recorded current is never negative although the controller pushes both ways: a magnitude.
    pub magnitudes: Vec<String>,
}

/// Controller and friction of a joint, and how well they follow the recordings.
#[derive(Debug, Clone)]
pub struct ServoJointFit {
    /// Joint.
    pub joint: String,
    /// Estimates with their standard errors, in the units of [`ServoParameter`].
    pub values: Vec<ServoValue>,
    /// Whether the weight of the links determines the stiffness.
    pub is_determined: bool,
    /// Lag of the position behind the command, friction included; none where the command is nearly constant.
    pub lag: Option<Lag>,
    /// Largest part of the position error that the weight of the links causes \[rad or m\]; none where it is not determined.
    pub sag: Option<f64>,
    /// RMS position error of each training recording in simulation \[rad or m\].
    pub train: Vec<f64>,
    /// RMS position error of each hold-out recording \[rad or m\].
    pub holdout: Vec<f64>,
    /// RMS error of the command itself, scaled, moved and delayed as suits each hold-out recording best, or each training
    /// recording where there is no hold-out \[rad or m\].
    pub command_alone: Vec<f64>,
    /// RMS of command minus position of each training recording, and of each hold-out recording \[rad or m\].
    pub command_error: [Vec<f64>; 2],
    /// Smallest change of the recorded position \[rad or m\].
    pub resolution: f64,
    /// Correlation of the estimates of delay and damping; none from too few recordings.
    pub delay_with_damping: Option<f64>,
    /// The fit without each parameter, where the request has that.
    pub ablations: Vec<ServoAblation>,
}

/// Identifies controllers and friction of an arm whose commands and positions are recorded.
///
/// # Errors
/// [`ServoError`].
pub fn identify_servos(request: &ServoRequest<'_>) -> Result<ServoIdentification, ServoError> {
    request.check()?;
    let names = request.model.chain.joint_names();
    let data = |recordings, gains: &[f64]| JointData::of_all(request.model, recordings, gains);
    let train = data(request.train, request.train_gains)?;
    let holdout = data(request.holdout, request.holdout_gains)?;
    for (joint, name) in names.iter().enumerate() {
        commands::check(&train[joint], name)?;
    }
    let mut estimates: Vec<JointEstimate> =
        train.par_iter().map(|data| fit(data, None)).collect::<Vec<_>>();
    // joints that carry nothing get the stiffness of the others, so that efforts are of one size, unless they would then feel
    // their load or the inertia of their links
    let known: Vec<f64> = (estimates.iter().filter(|found| found.is_determined))
        .map(|found| found.stiffness.ln())
        .collect();
    let usual =
        if known.is_empty() { 1.0 } else { (known.iter().sum::<f64>() / known.len() as f64).exp() };
    let open: Vec<usize> = (0..names.len()).filter(|j| !estimates[*j].is_felt).collect();
    let held = |j: &usize| {
        let least = least_unfelt_stiffness(&train[*j]);
        fit(&train[*j], Some(if least.is_finite() { usual.max(least) } else { usual }))
    };
    let again: Vec<JointEstimate> = open.par_iter().map(held).collect();
    for (j, found) in open.into_iter().zip(again) {
        let follows_worse = found.cost > VISIBLY_WORSE * estimates[j].cost;
        if !follows_worse {
            estimates[j] = found;
        }
    }
    let mut model = request.model.links_only();
    for (name, found) in names.iter().zip(&estimates) {
        model.effects.extend(found.effects(name));
        model.servos.push(ServoTerm {
            joint: (*name).to_owned(),
            servo: found.servo(),
            is_determined: found.is_determined,
            stiffness_error: found.stiffness_error(),
            delay_error_s: found.error(ServoParameter::Delay),
        });
    }
    let sources: Vec<&str> = request.train.iter().map(|r| r.source.as_str()).collect();
    model.provenance.push(format!("controllers and friction fitted to {}", sources.join(", ")));
    let joints = (0..names.len())
        .into_par_iter()
        .map(|j| {
            let found = &estimates[j];
            let alone = if holdout[j].is_empty() { &train[j] } else { &holdout[j] };
            ServoJointFit {
                joint: names[j].to_owned(),
                values: found.values(),
                is_determined: found.is_determined,
                lag: commands::lag(&train[j]),
                sag: found.is_determined.then(|| found.sag(&train[j])),
                train: found.errors(&train[j]),
                holdout: found.errors(&holdout[j]),
                command_alone: alone.iter().map(commands::error_of_command).collect(),
                command_error: [&train[j], &holdout[j]]
                    .map(|of| of.iter().map(commands::position_error).collect()),
                resolution: train[j].iter().map(|d| d.resolution).fold(0.0, f64::max),
                delay_with_damping: found.delay_with_damping,
                ablations: if request.ablations {
                    ablations(&train[j], &holdout[j], found)
                } else {
                    Vec::new()
                },
            }
        })
        .collect();
    Ok(ServoIdentification { model, joints, magnitudes: commands::magnitudes(request, &names) })
}

/// The controller of a joint and the stiffness that its gain multiplies.
impl JointEstimate {
    fn servo(&self) -> PositionServo {
        PositionServo {
            stiffness: self.stiffness,
            delay_s: self.value(ServoParameter::Delay),
            dead_band: 0.0,
            effort_limit: self.error_limit.map(|error| error * self.stiffness),
        }
    }
}
