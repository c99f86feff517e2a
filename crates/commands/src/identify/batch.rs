//! Ordinary motion, by the batch fit.

use armident_ident::{
    BatchSettings, Identification, IdentifyError, IdentifyRequest, Stage, identify as identified,
};
use armident_page::Correlation;
use armident_recording::Recording;
use armident_report::IdentifyReport;

use super::{Identified, IdentifyOptions, payloads};
use crate::failure::Failure;
use crate::recordings::{joints_with_position, no_effort, notes};
use crate::robot::{GivenRobot, chain_warnings};

/// Identifies an arm from ordinary motion; hold-out recordings are predicted only. `progress` is called at the beginning
/// of each stage.
///
/// # Errors
/// Recordings that cannot be used together; an estimator that does not suit them; payloads of no recording.
pub fn identify(
    robot: &GivenRobot,
    train: Vec<Recording>,
    holdout: Vec<Recording>,
    options: &IdentifyOptions,
    progress: &(dyn Fn(Stage) + Sync),
) -> Result<Identified, Failure> {
    let (given, unused) = robot.links(Some(&joints_with_position(&train)))?;
    let loads = payloads::loads(&options.payloads, &given, [&train, &holdout])?;
    let found = identified(&IdentifyRequest {
        holdout: &holdout,
        cutoff_hz: options.cutoff_hz,
        loads: &loads,
        estimator: options.estimator,
        settings: BatchSettings {
            link_prior: if options.prior { BatchSettings::default().link_prior } else { None },
            ..BatchSettings::default()
        },
        search: options.search,
        project: !options.raw_estimate,
        cross_validate: options.cross_validate,
        progress,
        ..IdentifyRequest::new(&given, &train)
    });
    let mut found = found.map_err(|error| failure(error, [&train, &holdout]))?;
    let [train, holdout] = found.converted.take().unwrap_or([train, holdout]);
    let mut report = IdentifyReport::of_batch(&found, options.estimator.name(), &loads);
    report.recordings = train.iter().map(|r| r.source.clone()).collect();
    report.holdout_recordings = holdout.iter().map(|r| r.source.clone()).collect();
    let motions = found.train_motions.iter().chain(&found.holdout_motions);
    let mut notes = notes(motions);
    notes.extend(unused);
    notes.append(&mut report.notes);
    report.notes = notes;
    let mut warnings = chain_warnings(&given);
    warnings.append(&mut report.warnings);
    report.warnings = warnings;
    report.warnings.extend(report.consistency.iter().flat_map(|links| links.warnings()));
    let correlation = correlation(&found);
    Ok(Identified {
        report,
        model: found.model,
        correlation: Some(correlation),
        training: train,
        holdout,
    })
}

/// Correlation of every pair of estimates, for the page.
fn correlation(found: &Identification) -> Correlation {
    let joints = found.model.chain.joint_names();
    let rounded = |x: f64| (100.0 * x).round() / 100.0;
    let rows = found.estimate.correlations();
    Correlation {
        labels: found.problem.terms.iter().map(|t| found.problem.label(t, &joints)).collect(),
        rows: rows
            .into_iter()
            .map(|row| row.into_iter().map(|x| x.map(rounded)).collect())
            .collect(),
    }
}

/// An error with what to do about it.
pub(super) fn failure(error: IdentifyError, read: [&[Recording]; 2]) -> Failure {
    match error {
        IdentifyError::Recording(error) => error.into(),
        IdentifyError::Estimator(error) => error.into(),
        IdentifyError::Consistency(error) => error.into(),
        IdentifyError::Planned(error) => error.into(),
        IdentifyError::Numeric(error) => error.into(),
        IdentifyError::NoEffort { ref source_name, ref joints } => {
            let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
            let mut all = read.iter().copied().flatten();
            match all.find(|recording| recording.source == *source_name) {
                Some(recording) => no_effort(recording, &joints),
                None => Failure::new(&error, source_name, None::<String>),
            }
        }
        IdentifyError::MixedChannels { ref source_name, .. } => Failure::new(
            &error,
            source_name,
            Some(
                "use recordings with the same channels, or convert currents to efforts with --mapping FILE",
            ),
        ),
        IdentifyError::GainsNotDetermined { ref sources, .. } => Failure::new(
            &error,
            sources.join(", "),
            Some(
                "convert currents with known drive gains (--mapping FILE), add a recording with a known \
                 payload (--payload), or exclude joints with --base and --tip",
            ),
        ),
        other => Failure::new(other, "", None::<String>),
    }
}
