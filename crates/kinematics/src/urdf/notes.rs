//! Collects warnings; links or joints with the same reason share one.

use crate::Warning;

/// A link, joint or other element that a warning concerns.
#[derive(Debug, Clone)]
pub(super) struct Concerned {
    /// `link`, `joint`, or another tag.
    pub(super) kind: &'static str,
    /// Its name.
    pub(super) name: String,
    /// Line in the file, from 1.
    pub(super) line: u32,
}

struct Note {
    code: &'static str,
    sentence: String,
    concerned: Vec<Concerned>,
}

/// Notes in the order of their first occurrence.
#[derive(Default)]
pub(super) struct Notes(Vec<Note>);

impl Notes {
    /// Adds a note; notes with the same code, sentence and kind become one warning.
    pub(super) fn add(
        &mut self,
        code: &'static str,
        concerned: Concerned,
        sentence: impl Into<String>,
    ) {
        let sentence = sentence.into();
        let same = |note: &&mut Note| {
            note.code == code
                && note.sentence == sentence
                && note.concerned.first().is_some_and(|first| first.kind == concerned.kind)
        };
        if let Some(note) = self.0.iter_mut().find(same) {
            note.concerned.push(concerned);
        } else {
            self.0.push(Note { code, sentence, concerned: vec![concerned] });
        }
    }

    pub(super) fn into_warnings(self) -> Vec<Warning> {
        let warning = |note: Note| {
            let message = note.message();
            let names = note.concerned.into_iter().map(|c| c.name);
            Warning::new(note.code, message).about(names.filter(|name| !name.is_empty()))
        };
        self.0.into_iter().map(warning).collect()
    }
}

impl Note {
    fn message(&self) -> String {
        let kind = self.concerned.first().map_or("", |first| first.kind);
        let plural = if self.concerned.len() > 1 { "s" } else { "" };
        let names = |with_line: bool| {
            let name = |c: &Concerned| match (c.name.as_str(), with_line) {
                ("", _) => format!("(line {})", c.line),
                (name, true) => format!("`{name}` (line {})", c.line),
                (name, false) => format!("`{name}`"),
            };
            self.concerned.iter().map(name).collect::<Vec<_>>().join(", ")
        };
        // long lists omit the line numbers
        let first = self.concerned.first().map_or(0, |c| c.line);
        let names = match self.concerned.len() {
            0..=3 => names(true),
            _ => format!("{} (from line {first})", names(false)),
        };
        format!("{kind}{plural} {names}: {}", self.sentence)
    }
}

/// A number with four significant digits.
pub(super) fn four_digits(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}
