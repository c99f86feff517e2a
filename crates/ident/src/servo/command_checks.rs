//! Input checks of commands: is each column what its header states, and does it show the controller?

use armident_model::ArmModel;
use armident_motion::quality;
use armident_numeric::range;
use armident_recording::{Quantity, Recording};

use super::commands::{check, lag, magnitudes};
use super::error::{CommandFault, ServoError};
use super::joint_data::{JointData, is_at_limit};
use super::request::ServoRequest;
use crate::checks::{Check, RecordingCheck, Topic, Verdict, quality_checks};

/// Share of the moving samples at the largest drive signal from which on little of the controller shows, and from which on
/// nothing does.
const SATURATED: [f64; 2] = [0.2, 0.9];
/// Steps of its encoder that a joint must move through to show more than rounding.
const FEWEST_STEPS: f64 = 20.0;

/// Checks recordings of commands and positions.
///
/// # Errors
/// [`ServoError`] of recordings that cannot become a motion or lack a channel; a wrong command is a check.
pub fn check_commands(
    model: &ArmModel,
    recordings: &[Recording],
) -> Result<RecordingCheck, ServoError> {
    let gains = vec![1.0; recordings.len()];
    let request = ServoRequest {
        model,
        train: recordings,
        train_gains: &gains,
        holdout: &[],
        holdout_gains: &[],
        ablations: false,
    };
    request.check()?;
    let names = model.chain.joint_names();
    let data = JointData::of_all(model, recordings, &gains)?;
    let reports: Vec<_> = recordings.iter().map(quality).collect();
    let differences = armident_motion::differences(recordings);
    let mut checks = quality_checks(&reports, &differences);
    let without_sign = magnitudes(&request, &names);
    for (joint, name) in names.iter().enumerate() {
        checks.push(command(&data[joint], name));
        checks.extend(motion(&data[joint], name));
        checks.extend(saturation(recordings, &data[joint], name));
        if without_sign.iter().any(|other| other == name) {
            let message = "the current is never negative while the controller pushes both ways: a magnitude, not used as an effort";
            checks.push(of(Topic::Channel, name, Verdict::Ok, message.to_owned()));
        }
    }
    Ok(RecordingCheck {
        checks,
        channels: Vec::new(),
        order: Vec::new(),
        gravity: None,
        recorded_as: (0..names.len()).collect(),
        mirrored: vec![false; names.len()],
        delay: None,
        effort_low_pass: None,
        effort_clock: None,
        low_pass_or_delay: None,
        link_length: None,
        constants: Vec::new(),
        rank: (0, 0),
        quality: reports,
        differences,
    })
}

fn of(topic: Topic, joint: &str, verdict: Verdict, message: String) -> Check {
    Check::of(topic, Some(joint), verdict, message)
}

/// Whether the column is a command, and how far the position is behind it.
fn command(data: &[JointData], joint: &str) -> Check {
    if let Err(ServoError::Command { fault, source_name, .. }) = check(data, joint) {
        // a joint that is never moved is no fault of its column
        let verdict = match fault {
            CommandFault::Constant => Verdict::Inconclusive,
            _ => Verdict::Wrong,
        };
        let message =
            if data.len() > 1 { format!("{source_name}: {fault}") } else { fault.to_string() };
        return Check {
            advice: Some(fault.advice().to_owned()),
            ..of(Topic::Command, joint, verdict, message)
        };
    }
    let Some(lag) = lag(data) else {
        let message = "the command hardly moves".to_owned();
        return of(Topic::Command, joint, Verdict::Inconclusive, message);
    };
    let ms = |s: f64| format!("{:.0}", 1e3 * s);
    let between = lag.interval_95.map_or_else(String::new, |[low, high]| {
        format!(" (95 % interval {} to {} ms)", ms(low), ms(high))
    });
    Check {
        value: Some(lag.value_s),
        unit: "s",
        interval_95: lag.interval_95,
        ..of(
            Topic::Command,
            joint,
            Verdict::Ok,
            format!("the position follows the command {} ms later{between}", ms(lag.value_s)),
        )
    }
}

/// A joint that hardly moves; none of one that does.
fn motion(data: &[JointData], joint: &str) -> Option<Check> {
    let moved = data.iter().map(|d| range(&d.position) / d.resolution).fold(0.0, f64::max);
    (moved < FEWEST_STEPS).then(|| Check {
        value: Some(moved),
        unit: "1",
        advice: Some(
            "record a motion of this joint, or lock it with --lock JOINT=VALUE".to_owned(),
        ),
        ..of(
            Topic::Excitation,
            joint,
            Verdict::Inconclusive,
            format!("moves by {moved:.0} encoder steps only"),
        )
    })
}

/// A drive signal at its limit.
fn saturation(recordings: &[Recording], data: &[JointData], joint: &str) -> Option<Check> {
    let (mut at_limit, mut moving) = (0_usize, 0_usize);
    for (recording, d) in recordings.iter().zip(data) {
        let channels = recording.joint(joint)?;
        let signal = [Quantity::Voltage, Quantity::Current];
        let Some(signal) = signal.into_iter().find_map(|quantity| channels.channel(quantity))
        else {
            continue;
        };
        let limit = signal.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
        // rounding alone moves a joint at rest by a step a sample
        let moves = |v: &f64| v.abs() > d.resolution / d.sample_s;
        for (u, _) in signal.iter().zip(&d.velocity).filter(|(_, v)| moves(v)) {
            moving += 1;
            at_limit += usize::from(limit > 0.0 && is_at_limit(*u, limit));
        }
    }
    let share = at_limit as f64 / moving.max(1) as f64;
    (share > SATURATED[0]).then(|| {
        let is_all = share > SATURATED[1];
        Check {
            value: Some(share),
            unit: "1",
            advice: Some("record slower or smaller motions".to_owned()),
            ..of(
                Topic::Channel,
                joint,
                if is_all { Verdict::Wrong } else { Verdict::Doubtful },
                format!(
                    "the drive signal is at its limit in {:.0} % of the moving samples: there the position does not depend on the \
                     command",
                    100.0 * share
                ),
            )
        }
    })
}
