//! The motion that separates the findings of a diagnosis from their alternatives, as `excite --for` designs it.

use std::collections::BTreeMap;
use std::time::Duration;

use armident_diagnose::Diagnosis;
use armident_excitation::{
    ExcitationError, ExciteRequest, GivenLimits, Part, STANDARD_ERRORS, Suite, SuiteSettings,
    excite,
};
use armident_recording::Recording;
use armident_report::NextMotionResult;

use crate::rivals::{fitted_pairs, open_rivals};

/// Time for the search: a diagnosis takes about as long.
const SEARCH: Duration = Duration::from_secs(5);

/// The motion and what it achieves; no motion where it separates no pair.
pub(crate) fn next_motion(
    diagnosis: &Diagnosis,
    file: &str,
) -> (NextMotionResult, Option<Recording>) {
    let open = diagnosis.open_pairs();
    let models = fitted_pairs(diagnosis, &open);
    let rivals = open_rivals(&diagnosis.model.chain, &open, &models);
    let none = NextMotionResult { pairs: open.len(), ..Default::default() };
    if rivals.is_empty() {
        return (none, None);
    }
    let noise = |(joint, noise): (&String, &f64)| {
        let noise = Some(*noise).filter(|noise| *noise > 0.0);
        (joint.clone(), GivenLimits { noise, ..GivenLimits::default() })
    };
    let limits: BTreeMap<String, GivenLimits> = diagnosis.effort_noise.iter().map(noise).collect();
    let settings = SuiteSettings { budget: SEARCH, ..SuiteSettings::default() };
    let found = excite(&ExciteRequest {
        chain: &diagnosis.model.chain,
        limits: &limits,
        given: &[],
        keep_out: &BTreeMap::new(),
        rivals: &rivals,
        settings: &settings,
    });
    match found {
        Ok(suite) => achieved(suite, none, file),
        // nothing follows from a motion alone
        Err(ExcitationError::Rival { .. }) => (none, None),
        Err(error) => (NextMotionResult { reason: Some(error.to_string()), ..none }, None),
    }
}

fn achieved(
    suite: Suite,
    none: NextMotionResult,
    file: &str,
) -> (NextMotionResult, Option<Recording>) {
    let mut residuals: Vec<f64> =
        suite.separations.iter().map(|pair| pair.standard_errors.unwrap_or(0.0)).collect();
    let separated = residuals.iter().filter(|residual| **residual >= STANDARD_ERRORS).count();
    let is_it = |part: Part, is_rehearsal: bool| part == Part::Separation && !is_rehearsal;
    let motion = suite.motions.into_iter().find(|m| is_it(m.part, m.is_rehearsal));
    let Some(motion) = motion.filter(|_| separated > 0) else { return (none, None) };
    let middle = residuals.len() / 2;
    let separation = armident_numeric::order_statistic(&mut residuals, middle);
    let seconds = motion.motion.time_s.last().copied().unwrap_or(0.0);
    let description = format!("{seconds:.0} s of waves on all joints, inside their limits");
    let result = NextMotionResult {
        file: Some(file.to_owned()),
        description: Some(description),
        separated,
        separation,
        ..none
    };
    (result, Some(motion.motion))
}
