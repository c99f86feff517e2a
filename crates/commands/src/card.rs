//! The model card of an identification.

use std::path::{Path, PathBuf};

use armident_page::Provenance;
use armident_recording::Recording;
use armident_report::{CardInput, ModelCard};

use crate::failure::Failure;
use crate::identify::Identified;

/// First stamp that is a time of day \[s since 1970\]: 2001-09-09. Stamps of clocks that begin with the recording are
/// smaller.
const FIRST_DATE_S: f64 = 1e9;
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// Whose arm it is, and when it was recorded.
#[derive(Debug, Clone, Default)]
pub struct CardOptions {
    /// Serial number of the unit.
    pub serial: Option<String>,
    /// Date of the recordings; none: of their stamps, where these count from 1970.
    pub date: Option<String>,
}

/// Files of an identification beside its recordings.
#[derive(Debug, Clone, Copy, Default)]
pub struct CardFiles<'a> {
    /// URDF or model.
    pub robot: Option<&'a Path>,
    /// Mapping of the columns.
    pub mapping: Option<&'a Path>,
    /// Plan of the experiments.
    pub plan: Option<&'a Path>,
}

impl Identified {
    /// The model card: values, errors, unit, date and the digests of the files.
    pub fn card(&self, files: CardFiles<'_>, options: &CardOptions) -> ModelCard {
        let single = |path: Option<&Path>, used_as: &'static str| {
            path.map(|path| (path.to_owned(), used_as)).into_iter()
        };
        let many = |recordings: &[Recording], used_as: &'static str| -> Vec<(PathBuf, &str)> {
            recordings.iter().map(|recording| (PathBuf::from(&recording.source), used_as)).collect()
        };
        let used: Vec<(PathBuf, &str)> = single(files.robot, "robot")
            .chain(many(&self.training, "training"))
            .chain(many(&self.holdout, "hold-out"))
            .chain(single(files.mapping, "mapping"))
            .chain(single(files.plan, "plan"))
            .collect();
        let read = Provenance::of(Vec::new(), used.iter().map(|(path, _)| path.as_path())).inputs;
        let inputs = read.into_iter().zip(&used).map(|(input, (_, used_as))| CardInput {
            file: input.path,
            used_as: (*used_as).to_owned(),
            bytes: input.bytes,
            sha256: input.sha256,
        });
        let date = options.date.clone().or_else(|| date_of(&self.training));
        ModelCard::of(&self.report, &self.model, inputs.collect(), options.serial.clone(), date)
    }
}

/// Day of the first stamp of the recordings, in UTC, `2026-01-31`; none of clocks that do not count from 1970.
fn date_of(recordings: &[Recording]) -> Option<String> {
    let stamps = recordings.iter().filter_map(|recording| recording.time_s.first().copied());
    let first_s = stamps.min_by(f64::total_cmp).filter(|t| *t >= FIRST_DATE_S)?;
    let (year, month, day) = civil((first_s / DAY_S).floor() as i64);
    Some(format!("{year}-{month:02}-{day:02}"))
}

/// Year, month and day of the Gregorian calendar, so many days after 1970-01-01. The year begins in March, so that the leap
/// day is its last.
fn civil(days: i64) -> (i64, i64, i64) {
    // of 400 years, four years and a year, and days before March 1970 since 0000-03-01
    const ERA: i64 = 146_097;
    let since = days + 719_468;
    let (era, day_of_era) = (since.div_euclid(ERA), since.rem_euclid(ERA));
    let year = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    (400 * era + year + i64::from(month <= 2), month, day)
}

/// The page and the JSON of a card, each with its file: the JSON lies beside the page.
///
/// # Errors
/// A file name without the extension `.html`; a page that cannot be made.
pub fn card_files(card: &ModelCard, page: &Path) -> Result<[(PathBuf, String); 2], Failure> {
    let json = serde_json::to_string_pretty(card).map_err(|error| {
        Failure::new(format!("cannot write JSON: {error}"), page.display(), None::<String>)
    })?;
    let html = armident_page::html(&json)
        .map_err(|error| Failure::new(error, page.display(), None::<String>))?;
    Ok([(page.to_owned(), html), (page.with_extension("json"), json + "\n")])
}

/// The two files of a card, or why there are none: its JSON lies beside its page.
///
/// # Errors
/// A file name without the extension `.html`.
pub fn card_paths(page: &Path) -> Result<[PathBuf; 2], Failure> {
    let end = page.extension().map(|end| end.to_string_lossy().to_lowercase());
    match end.as_deref() {
        Some("html") => Ok([page.to_owned(), page.with_extension("json")]),
        _ => Err(Failure::new(
            "the model card is an HTML page with its JSON beside it",
            page.display(),
            Some("end the name in .html, for example --card card.html"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates() {
        assert_eq!(civil(0), (1970, 1, 1));
        assert_eq!(civil(-1), (1969, 12, 31));
        assert_eq!(civil(59), (1970, 3, 1));
        // leap day of a year that 400 divides, and the day after that of one that 4 divides
        assert_eq!(civil(11_016), (2000, 2, 29));
        assert_eq!(civil(19_783), (2024, 3, 1));
        assert_eq!(civil(19_675), (2023, 11, 14));
    }
}
