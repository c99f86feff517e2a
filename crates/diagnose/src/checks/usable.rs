//! Recordings that a diagnosis can use.

use armident_motion::BandMotion;
use armident_recording::{Recording, RecordingError};

/// Why recordings cannot be diagnosed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unusable {
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No recording is long enough.
    #[error("recordings too short to diagnose")]
    TooShort,
    /// No joint moves.
    #[error("no joint moves")]
    NoMotion,
    /// The effort of a joint that moves is one number.
    #[error("the effort column of {0} is constant while the joint moves")]
    ConstantEffort(String),
}

/// The recordings on even grids, if they hold motion and effort.
pub(crate) fn usable_signals(
    names: &[String],
    recordings: &[Recording],
    band_hz: f64,
) -> Result<Vec<BandMotion>, Unusable> {
    let of_all = recordings.iter().map(Recording::len).sum();
    let signals: Vec<BandMotion> = recordings
        .iter()
        .map(|r| Ok(BandMotion::below(r, names, band_hz)?.thinned(of_all)))
        .collect::<Result<_, RecordingError>>()?;
    if signals.iter().any(|s| s.band.kept.len() < 2) {
        return Err(Unusable::TooShort);
    }
    said_something(names, &signals)?;
    Ok(signals)
}

/// Refuses recordings from which every estimate would be invented: channels that hold one number.
pub(crate) fn said_something(names: &[String], signals: &[BandMotion]) -> Result<(), Unusable> {
    let moves = |j: usize| signals.iter().any(|s| !is_constant(&s.recorded_position[j]));
    if !(0..names.len()).any(moves) {
        return Err(Unusable::NoMotion);
    }
    for (j, name) in names.iter().enumerate() {
        let recorded = signals.iter().any(|s| !s.effort[j].is_empty());
        if recorded && moves(j) && signals.iter().all(|s| is_constant(&s.effort[j])) {
            return Err(Unusable::ConstantEffort(name.clone()));
        }
    }
    Ok(())
}

/// The recording without efforts that are one number in each of `all`, where others are not: no sensor, or none read.
pub(crate) fn without_constant_efforts(recording: &Recording, all: &[Recording]) -> Recording {
    let is_dead = |name: &str| {
        let mut efforts = all.iter().filter_map(|r| r.joint(name)?.effort.as_deref());
        efforts.all(is_constant)
    };
    let mut kept = recording.clone();
    let recorded = |r: &Recording| r.joints.iter().filter(|j| j.effort.is_some()).count();
    kept.joints.iter_mut().filter(|j| is_dead(&j.name)).for_each(|j| j.effort = None);
    if recorded(&kept) == 0 { recording.clone() } else { kept }
}

pub(crate) fn is_constant(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[0] == pair[1])
}
