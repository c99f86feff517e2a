//! The faulty line of a file, with the fault underlined.

use std::io::{BufRead, BufReader};
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use armident_kinematics::UrdfPlace;
use armident_recording::RecordingError;

/// Longest line shown; longer ones are not written by hand.
const LONGEST: usize = 20_000;
/// Width of an excerpt in characters.
const WIDTH: usize = 110;

/// One line of a text file.
#[derive(Debug)]
pub struct Excerpt {
    number: usize,
    text: String,
    /// Faulty bytes of the line.
    span: Range<usize>,
}

impl Excerpt {
    /// The line of a URDF, if it is readable; most faults know their position in it.
    pub fn of_urdf(place: &UrdfPlace) -> Option<Self> {
        let number = place.line? as usize;
        let (start, text) = line(&place.source, number)?;
        let span = match &place.span {
            Some(span) => span.start.checked_sub(start)?..span.end.checked_sub(start)?,
            None => visible(&text),
        };
        Self { number, text, span }.checked()
    }

    /// The line of a recording or a mapping file.
    pub fn of_recording(error: &RecordingError) -> Option<Self> {
        let number = usize::try_from(error.line()?).ok()?;
        let (_, text) = line(error.source_name(), number)?;
        let named = error.column().and_then(|column| {
            let (_, header) = line(error.source_name(), 1)?;
            let is_it =
                |range: &Range<usize>| header[range.clone()].trim_matches([' ', '"']) == column;
            let index = fields(&header).iter().position(is_it)?;
            // in the header the fault is the name itself
            fields(&text).get(index).cloned()
        });
        let span = named.unwrap_or_else(|| visible(&text));
        Self { number, text, span }.checked()
    }

    /// A span of a text in memory.
    pub fn of_text(text: &str, span: &Range<usize>) -> Option<Self> {
        let before = text.get(..span.start)?;
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let number = 1 + before.matches('\n').count();
        let text = text[start..].lines().next()?.to_owned();
        // a text that ends too early has its fault behind the line
        let own = span.start - start..span.end.max(span.start + 1) - start;
        let span = if own.start < text.len() { own } else { visible(&text) };
        Self { number, text, span }.checked()
    }

    /// Line number, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    fn checked(mut self) -> Option<Self> {
        self.span.end = self.span.end.min(self.text.len());
        let whole = self.text.is_char_boundary(self.span.start)
            && self.text.is_char_boundary(self.span.end);
        (whole && self.span.start < self.span.end).then_some(self)
    }

    /// The excerpt with a margin, styled for a terminal.
    pub fn styled(&self) -> String {
        self.rendered(&Renderer::styled())
    }

    /// The same without style.
    pub fn plain(&self) -> String {
        self.rendered(&Renderer::plain())
    }

    fn rendered(&self, renderer: &Renderer) -> String {
        let snippet = Snippet::source(self.text.as_str())
            .line_start(self.number)
            .annotation(AnnotationKind::Primary.span(self.span.clone()));
        let group = Group::with_level(Level::ERROR).element(snippet);
        renderer.clone().term_width(WIDTH).render(&[group])
    }
}

/// Byte offset of a line and its text without the line end.
fn line(path: &str, number: usize) -> Option<(usize, String)> {
    let mut file = BufReader::new(std::fs::File::open(path).ok()?);
    let mut start = 0;
    for _ in 1..number {
        start += file.skip_until(b'\n').ok()?;
    }
    let mut bytes = Vec::new();
    file.read_until(b'\n', &mut bytes).ok()?;
    let text = String::from_utf8(bytes).ok()?;
    let shown = text.trim_end_matches(['\n', '\r']);
    (shown.len() < LONGEST && !shown.contains('\0')).then(|| (start, shown.to_owned()))
}

/// Range of a line without surrounding white space.
fn visible(text: &str) -> Range<usize> {
    let start = text.len() - text.trim_start().len();
    start..text.trim_end().len()
}

/// Fields of a comma-separated line; an empty field is represented by its comma.
fn fields(text: &str) -> Vec<Range<usize>> {
    let text_len = text.len();
    let mut quoted = false;
    let mut start = 0;
    let mut fields = Vec::new();
    for (i, byte) in text.bytes().chain([b',']).enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b',' if !quoted => {
                let field = start..i;
                let text = visible(&text[field.clone()]);
                fields.push(if text.is_empty() {
                    start.saturating_sub(1)..(i + 1).min(text_len)
                } else {
                    start + text.start..start + text.end
                });
                start = i + 1;
            }
            _ => {}
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::{Excerpt, fields};

    #[test]
    fn fields_of_a_row() {
        let row = "0.1, 2,\"a,b\",,x,";
        let texts: Vec<&str> = fields(row).into_iter().map(|range| &row[range]).collect();
        assert_eq!(texts, ["0.1", "2", "\"a,b\"", ",,", "x", ","]);
    }

    #[test]
    fn lines_of_a_text() {
        let text = "a = 1\nbb = 2\n";
        let excerpt = Excerpt::of_text(text, &(6..8)).unwrap();
        assert_eq!((excerpt.number(), excerpt.text.as_str()), (2, "bb = 2"));
        assert!(excerpt.styled().contains("bb = 2"));
        assert_eq!(Excerpt::of_text(text, &(5..5)).unwrap().span, 0..5);
        assert!(Excerpt::of_text(text, &(90..91)).is_none());
    }
}
