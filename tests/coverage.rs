//! A small fixed sample of the study in `docs/studies/batch_coverage.md`.

use armident_ident::BatchSettings;
use armident_ident::estimators::Huber;

#[allow(dead_code, reason = "its table is not printed here")]
#[path = "../examples/coverage_batch.rs"]
mod study;

/// Intervals of eight recordings hold the truth about as often as they say. Those of one recording go
/// together: the share of a recording has a standard deviation of some 4 %, that of eight of 1.4 %, so the
/// bounds are more than three of it away from 95 %.
#[test]
fn intervals_have_nominal_coverage() {
    let recordings = 8;
    for arms in [study::Arms::HeavierForearm, study::Arms::Drawn] {
        let settings = BatchSettings::default();
        let found = study::study(recordings, &Huber, &settings, arms).unwrap();
        let cases = recordings * found.count as u64;
        let inside: u64 = found.inside.iter().sum();
        let share = inside as f64 / cases as f64;
        assert!((0.90..=0.995).contains(&share), "{arms:?}: {inside} of {cases}");
    }
}
