//! `info`: what logs hold, before anything is decided.

use std::path::{Path, PathBuf};

use armident_motion::{QualityReport, quality};
use armident_recording::{Action, Inspection, Mapping, Quantity, ReadSettings, Recording, inspect};
use armident_report::{Bars, Block, Table, counted, render, significant};
use serde::Serialize;

use crate::failure::Failure;
use crate::recordings::ReadingOptions;

/// What logs hold.
#[derive(Debug, Serialize)]
pub struct InfoReport {
    schema: &'static str,
    recordings: Vec<Log>,
}

/// What one log holds.
#[derive(Debug, Serialize)]
struct Log {
    file: String,
    format: &'static str,
    columns: Vec<String>,
    /// `standard`, `mapping`, `guess` or `none`
    names: &'static str,
    /// why the columns have no meaning without a mapping
    fault: Option<String>,
    hint: Option<String>,
    quality: Option<QualityReport>,
    ignored_columns: Vec<String>,
    notes: Vec<String>,
    guess: Option<Guess>,
}

/// The guessed mapping.
#[derive(Debug, Serialize)]
struct Guess {
    time: Option<Time>,
    channels: Vec<Channel>,
    unused: Vec<String>,
    unsure: Vec<String>,
    /// why no recording comes of it
    fault: Option<String>,
    mapping: String,
}

#[derive(Debug, Serialize)]
struct Time {
    column: String,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
struct Channel {
    column: String,
    joint: String,
    quantity: Quantity,
    unit: Option<&'static str>,
}

/// What logs hold. `joints`: of the arm in its order, which name numbered ones; may be empty.
///
/// # Errors
/// A file that cannot be read.
pub fn info(
    files: &[PathBuf],
    joints: &[String],
    reading: &ReadingOptions,
) -> Result<InfoReport, Failure> {
    let mapping = reading.mapping.as_deref().map(Mapping::load).transpose()?;
    let settings = ReadSettings { mapping: mapping.as_ref(), topic: reading.topic.as_deref() };
    let of =
        |file: &PathBuf| Ok(Log::of(file, inspect(file, &settings, joints)?, mapping.is_some()));
    let recordings = files.iter().map(of).collect::<Result<_, Failure>>()?;
    Ok(InfoReport { schema: "armident.info/1", recordings })
}

impl InfoReport {
    /// Human-readable text.
    pub fn text(&self) -> String {
        self.recordings.iter().map(Log::text).collect::<Vec<_>>().join("\n")
    }

    /// Warnings, each with its code in brackets.
    pub fn warnings(&self) -> Vec<String> {
        self.recordings.iter().flat_map(Log::warnings).collect()
    }

    /// The mapping file that the names of the first log suggest.
    ///
    /// # Errors
    /// Names without time or joints map nothing.
    pub fn mapping(&self) -> Result<&str, Failure> {
        let log = self.recordings.first();
        let guess = log.and_then(|log| log.guess.as_ref());
        let guess = guess.filter(|guess| guess.time.is_some() && !guess.channels.is_empty());
        guess.map(|guess| guess.mapping.as_str()).ok_or_else(|| {
            let columns = log.map(|log| listed(&log.columns)).unwrap_or_default();
            Failure::new(
                "the names of the columns suggest no mapping",
                log.map_or("", |log| &log.file),
                Some(format!("write it by hand (docs/mapping.md); columns in the file: {columns}")),
            )
        })
    }
}

impl Log {
    fn of(file: &Path, found: Inspection, is_mapped: bool) -> Self {
        let Inspection { format, columns, recording, guess, guessed } = found;
        let read =
            |recording: &Recording| recording.joints.iter().map(|j| j.channels().count()).sum();
        let by_names: usize = recording.as_ref().map_or(0, read);
        let by_guess: usize = guessed.as_ref().map_or(0, read);
        let names = match is_mapped {
            true if recording.is_ok() => "mapping",
            false if by_names > 0 && by_names >= by_guess => "standard",
            false if by_guess > 0 => "guess",
            _ => "none",
        };
        let (fault, hint) = match &recording {
            Ok(_) => (None, None),
            Err(error) => (Some(error.to_string()), error.hint()),
        };
        let guess = (!is_mapped).then(|| Guess {
            mapping: guess.to_toml(),
            time: guess.time.map(|time| Time { column: time.column, unit: time.unit }),
            channels: (guess.channels.into_iter())
                .map(|c| Channel {
                    column: c.column,
                    joint: c.joint,
                    quantity: c.quantity,
                    unit: c.unit,
                })
                .collect(),
            unused: guess.unused,
            unsure: guess.unsure,
            fault: guessed.as_ref().err().map(ToString::to_string),
        });
        let used = if names == "guess" { guessed.ok() } else { recording.ok() };
        Self {
            file: file.display().to_string(),
            format,
            columns,
            names,
            fault,
            hint,
            quality: used.as_ref().map(quality),
            ignored_columns: used.as_ref().map(|r| r.ignored_columns.clone()).unwrap_or_default(),
            notes: used.map(|r| r.notes).unwrap_or_default(),
            guess,
        }
    }

    fn warnings(&self) -> Vec<String> {
        match self.names {
            "none" => vec![format!("{}: no joints can be read [no_mapping]", self.file)],
            _ => Vec::new(),
        }
    }

    fn text(&self) -> String {
        let mut pairs = vec![("format", self.format.to_owned())];
        pairs.push(("columns", format!("{}: {}", self.columns.len(), self.meaning())));
        if let Some(quality) = &self.quality {
            let timing = &quality.timing;
            let stamps = match (timing.is_even, timing.gaps.len()) {
                (true, _) => "even".to_owned(),
                (false, 0) => {
                    format!("jitter {} of the step", armident_report::percent(timing.jitter))
                }
                (false, gaps) => format!(
                    "jitter {} of the step, {}",
                    armident_report::percent(timing.jitter),
                    counted(gaps, "gap")
                ),
            };
            let (rate, length) =
                (significant(timing.rate_hz, 4, 0.0), significant(timing.duration_s, 4, 0.0));
            pairs.push((
                "samples",
                format!("{} in {length} s, {rate} Hz, {stamps}", quality.samples),
            ));
        }
        let pairs = pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        let mut blocks = vec![Block::Line(self.file.clone()), Block::KeyValues(pairs)];
        if let Some(quality) = &self.quality {
            blocks.push(Block::heading("Channels"));
            blocks.push(Block::Table(channels(quality)));
            let open: Vec<Block> = (quality.findings.iter())
                .map(|finding| {
                    let action = match finding.action {
                        Action::Repaired => "repaired",
                        Action::Kept => "kept",
                        Action::Refused => "refused",
                    };
                    Block::Item {
                        text: format!("{action}: {}", finding.message),
                        detail: finding.advice.clone().unwrap_or_default(),
                    }
                })
                .collect();
            blocks.push(Block::heading("Quality of rows and stamps"));
            if open.is_empty() {
                blocks.push(Block::item("nothing repaired, nothing doubtful"));
            }
            blocks.extend(open);
        }
        // the guess lists its unused columns itself
        let is_shown =
            |note: &&String| self.names != "guess" || !note.starts_with("ignored columns");
        let notes: Vec<&String> = self.notes.iter().filter(is_shown).collect();
        if !notes.is_empty() {
            blocks.push(Block::heading("Notes on reading"));
            blocks.extend(notes.into_iter().map(Block::item));
        }
        if let Some(guess) = self.guess.as_ref().filter(|_| self.names != "standard") {
            blocks.extend(guess.blocks());
        }
        render(blocks, Bars::Unicode)
    }

    /// What the names of the columns mean.
    fn meaning(&self) -> String {
        let unsure = self.guess.as_ref().is_some_and(|guess| !guess.unsure.is_empty());
        match self.names {
            "standard" => "standard names, no mapping needed".to_owned(),
            "mapping" => "by the mapping".to_owned(),
            "guess" if unsure => {
                "guessed, unsure; write the mapping with --write-mapping FILE and check it"
                    .to_owned()
            }
            "guess" => "guessed; write the mapping with --write-mapping FILE".to_owned(),
            _ => {
                let fault = self.fault.as_deref().unwrap_or("no joints");
                let hint = self.hint.as_ref().map_or_else(String::new, |hint| format!("; {hint}"));
                format!("{fault}{hint}")
            }
        }
    }
}

impl Guess {
    fn blocks(&self) -> Vec<Block> {
        let mut blocks = vec![Block::heading("Guessed mapping")];
        let mut rows: Vec<Vec<String>> = (self.time.iter())
            .map(|t| vec![t.column.clone(), "time".to_owned(), String::new(), t.unit.to_owned()])
            .collect();
        rows.extend(self.channels.iter().map(|c| {
            let unit = c.unit.unwrap_or("SI");
            vec![c.column.clone(), c.quantity.to_string(), c.joint.clone(), unit.to_owned()]
        }));
        let table = Table::new("Guessed mapping", &["column", "quantity", "joint", "unit"]);
        blocks.push(Block::Table(table.with(rows)));
        blocks.extend(self.fault.iter().map(|fault| Block::item(format!("refused: {fault}"))));
        blocks.extend(self.unsure.iter().map(|line| Block::item(format!("unsure: {line}"))));
        if !self.unused.is_empty() {
            blocks.push(Block::item(format!("unused: {}", listed(&self.unused))));
        }
        blocks
    }
}

/// Range and noise of each channel.
fn channels(quality: &QualityReport) -> Table {
    let number = |x: f64| significant(x, 3, 0.0);
    let rows = quality.channels.iter().map(|c| {
        let optional = |x: Option<f64>| x.map_or_else(String::new, number);
        vec![
            c.joint.clone(),
            c.quantity.to_string(),
            number(c.smallest),
            number(c.largest),
            optional(c.noise),
            optional(c.step),
            optional(c.band_edge_hz),
        ]
    });
    Table::new("Channels", &["joint", "quantity"])
        .numbers(&["smallest", "largest", "noise", "step", "motion to [Hz]"])
        .with(rows)
        .without_empty_columns()
}

/// The first names of a list.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    if names.len() > SHOWN {
        text.push(format!("and {} more", names.len() - SHOWN));
    }
    text.join(", ")
}
