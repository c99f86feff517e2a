//! Ordinary motion, by the batch fit.

use std::sync::Mutex;

use armident_ident::{
    BatchSettings, Identification, IdentifyError, IdentifyRequest, Stage, StructureSearch, identify,
};
use armident_page::Correlation;
use armident_recording::Recording;

use super::{Identified, notes, payloads, report};
use crate::args::{CouplingArg, IdentifyArgs, PriorArg, ViscousArg};
use crate::commands::recordings;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::robot;

pub(super) fn batch(args: &IdentifyArgs) -> Result<Identified, Failure> {
    let train_files = recordings::expand(&args.recordings)?;
    let holdout_files = recordings::expand(&args.holdout)?;
    let train = recordings::read_all(&train_files, &args.reading, &args.output)?;
    let holdout = recordings::read_all(&holdout_files, &args.reading, &args.output)?;
    let recorded = recordings::joints_with_position(&train);
    let (given, unused) = robot::load_links(&args.robot, &args.chain, Some(&recorded))?;
    let loads =
        payloads::loads(args, &given, &[(&train_files, &train), (&holdout_files, &holdout)])?;
    let stage = Mutex::new(None);
    let progress = |next: Stage| {
        if let Ok(mut current) = stage.lock() {
            // the line of the stage before goes away first
            drop(current.take());
            *current = Some(Progress::of(&args.output, in_words(next)));
        }
    };
    let found = identify(&IdentifyRequest {
        holdout: &holdout,
        cutoff_hz: args.cutoff_hz,
        loads: &loads,
        estimator: args.method,
        settings: BatchSettings {
            link_prior: match args.prior {
                PriorArg::Urdf => BatchSettings::default().link_prior,
                PriorArg::None => None,
            },
            ..BatchSettings::default()
        },
        search: StructureSearch {
            couplings: args.coupling == CouplingArg::Auto,
            sublinear: args.viscous == ViscousArg::Auto,
        },
        project: !args.raw_estimate,
        cross_validate: args.cross_validate,
        progress: &progress,
        ..IdentifyRequest::new(&given, &train)
    });
    drop(stage);
    let mut found = found.map_err(|error| failure(error, [&train, &holdout]))?;
    let [train, holdout] = found.converted.take().unwrap_or([train, holdout]);
    let mut report = report::of_batch(&found, args.method.name(), &loads);
    report.recordings = train.iter().map(|r| r.source.clone()).collect();
    report.holdout_recordings = holdout.iter().map(|r| r.source.clone()).collect();
    report.notes = recordings::notes(found.train_motions.iter().chain(&found.holdout_motions));
    report.notes.extend(unused);
    report.notes.extend(notes::notes(&found));
    report.warnings = given.chain.warnings.iter().map(ToString::to_string).collect();
    report.warnings.extend(notes::warnings(&found));
    report.warnings.extend(report.consistency.iter().flat_map(|links| links.warnings()));
    let correlation = correlation(&found);
    Ok(Identified {
        report,
        model: found.model,
        correlation: Some(correlation),
        read: [train, holdout],
    })
}

fn in_words(stage: Stage) -> &'static str {
    match stage {
        Stage::Motions => "filtering recordings",
        Stage::Structure => "selecting model structure",
        Stage::Fit => "fitting",
        Stage::Projection => "projecting to consistent links",
    }
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
                Some(recording) => recordings::no_effort(recording, &joints),
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
