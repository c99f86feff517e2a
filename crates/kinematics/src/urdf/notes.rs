//! Collects what is doubtful, one warning for all links or joints that share the reason.

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

/// Notes in the order in which their reasons were first met.
#[derive(Default)]
pub(super) struct Notes(Vec<Note>);

impl Notes {
    /// Notes a reason; notes of one code, sentence and kind become one warning.
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
        self.0.into_iter().map(|note| Warning::new(note.code, note.message())).collect()
    }
}

impl Note {
    fn message(&self) -> String {
        let kind = self.concerned.first().map_or("", |first| first.kind);
        let plural = if self.concerned.len() > 1 { "s" } else { "" };
        let names: Vec<String> =
            self.concerned.iter().map(|c| format!("`{}` (line {})", c.name, c.line)).collect();
        format!("{kind}{plural} {}: {}", names.join(", "), self.sentence)
    }
}
