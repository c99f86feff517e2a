//! The page as HTML.

use askama::Template;
use serde_json::Value;

use crate::drawing::{Drawing, Quality, Role};
use crate::figures::Figure;
use crate::kinds;
use crate::pack::{in_script, library, packed};
use armident_report::significant;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// Not JSON.
    #[error("the result is not valid JSON: {message}")]
    NotJson {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// JSON that no command wrote.
    #[error("the file has schema `{found}`, expected one of the commands' results")]
    Schema {
        /// What the file says.
        found: String,
    },
    /// A result with fields of another form.
    #[error("the result is not of the form its schema says: {0}")]
    Form(serde_json::Error),
    /// The page could not be written.
    #[error("the page cannot be formed: {0}")]
    Template(#[from] askama::Error),
    /// The charts could not be packed.
    #[error("the charts cannot be packed: {0}")]
    Packing(#[from] std::io::Error),
}

/// The page of a result, from its JSON.
///
/// # Errors
/// [`PageError`].
pub fn html(result: &str) -> Result<String, PageError> {
    let mut document: Value = serde_json::from_str(result)
        .map_err(|e| PageError::NotJson { line: e.line(), message: e.to_string() })?;
    let schema = document.get("schema").and_then(Value::as_str).unwrap_or("none").to_owned();
    if !schema.starts_with("armident.") {
        return Err(PageError::Schema { found: schema });
    }
    let drawing = match document.as_object_mut().and_then(|d| d.remove("drawing")) {
        Some(drawing) => serde_json::from_value(drawing).map_err(PageError::Form)?,
        None => Drawing::default(),
    };
    let view = kinds::view(&schema, &document, &drawing)?;
    view.html(&document, &drawing)
}

/// Whether the news is good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Tone {
    Good,
    Bad,
    #[default]
    Open,
}

/// One thing to do, with the command that does it.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) text: String,
    pub(crate) command: Option<String>,
}

impl Step {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), command: None }
    }

    pub(crate) fn by(self, command: impl Into<String>) -> Self {
        Self { command: Some(command.into()), ..self }
    }
}

/// A table; the first `left` columns and units are text, the others numbers.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grid {
    pub(crate) caption: String,
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    /// which columns are numbers
    pub(crate) numbers: Vec<bool>,
}

impl Grid {
    pub(crate) fn new(caption: impl Into<String>, header: &[&str], left: usize) -> Self {
        let numbers = header.iter().enumerate().map(|(k, h)| k >= left && *h != "unit").collect();
        let header = header.iter().map(ToString::to_string).collect();
        Self { caption: caption.into(), header, rows: Vec::new(), numbers }
    }

    pub(crate) fn with(self, rows: Vec<Vec<String>>) -> Self {
        Self { rows, ..self }
    }
}

/// A fitted number.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    pub(crate) name: String,
    pub(crate) value: String,
    pub(crate) interval: String,
    pub(crate) unit: String,
}

/// One finding.
#[derive(Debug, Clone)]
pub(crate) struct Card {
    pub(crate) id: String,
    pub(crate) what: String,
    pub(crate) place: String,
    pub(crate) size: String,
    pub(crate) sure: String,
    pub(crate) confidence: String,
    pub(crate) formula: String,
    pub(crate) parameters: Vec<Fitted>,
    pub(crate) why: String,
    pub(crate) regime: String,
    pub(crate) look_alikes: Vec<(String, String)>,
    pub(crate) figure: Option<Figure>,
    pub(crate) open: bool,
}

/// What is shown of one joint.
#[derive(Debug, Clone)]
pub(crate) struct JointCard {
    pub(crate) name: String,
    pub(crate) summary: String,
    pub(crate) figures: Vec<Figure>,
    pub(crate) open: bool,
}

/// A part of the page.
#[derive(Debug, Clone, Default)]
pub(crate) struct Section {
    pub(crate) id: String,
    pub(crate) title: String,
    pub(crate) sentences: Vec<String>,
    pub(crate) tables: Vec<Grid>,
    pub(crate) figures: Vec<Figure>,
}

/// What a page says, whichever command it is about.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    pub(crate) kind: &'static str,
    pub(crate) robot: String,
    pub(crate) tone: Tone,
    pub(crate) headline: String,
    pub(crate) sentences: Vec<String>,
    pub(crate) next: Vec<Step>,
    pub(crate) warnings: Vec<String>,
    pub(crate) overview: Vec<Figure>,
    pub(crate) cards: Vec<Card>,
    pub(crate) joints: Vec<JointCard>,
    pub(crate) skeleton: Option<Figure>,
    pub(crate) sections: Vec<Section>,
}

#[derive(Template)]
#[template(path = "page.html")]
struct Page {
    version: &'static str,
    title: String,
    kind: &'static str,
    robot: String,
    tone: &'static str,
    headline: String,
    sentences: Vec<String>,
    next: Vec<Step>,
    warnings: Vec<String>,
    overview: Vec<Figure>,
    cards: Vec<Card>,
    joints: Vec<JointCard>,
    skeleton: Option<Figure>,
    sections: Vec<Section>,
    provenance: Vec<Grid>,
    result: String,
    figures: String,
    library: String,
}

impl View {
    fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.overview
            .iter()
            .chain(self.cards.iter().filter_map(|c| c.figure.as_ref()))
            .chain(self.joints.iter().flat_map(|j| &j.figures))
            .chain(&self.skeleton)
            .chain(self.sections.iter().flat_map(|s| &s.figures))
    }

    fn html(mut self, document: &Value, drawing: &Drawing) -> Result<String, PageError> {
        self.sections.extend(quality(drawing));
        let contents: serde_json::Map<String, Value> =
            self.figures().map(|f| (f.id.clone(), f.content.clone())).collect();
        let page = Page {
            version: env!("CARGO_PKG_VERSION"),
            title: format!("{}: {}", self.robot, self.headline),
            kind: self.kind,
            tone: match self.tone {
                Tone::Good => "good",
                Tone::Bad => "bad",
                Tone::Open => "open",
            },
            provenance: provenance(document, drawing),
            result: in_script(&document.to_string()),
            figures: packed(&Value::Object(contents).to_string())?,
            library: packed(&library())?,
            robot: self.robot,
            headline: self.headline,
            sentences: self.sentences,
            next: self.next,
            warnings: self.warnings,
            overview: self.overview,
            cards: self.cards,
            joints: self.joints,
            skeleton: self.skeleton,
            sections: self.sections,
        };
        Ok(page.render()?)
    }
}

pub(crate) fn percent(share: f64) -> String {
    match share {
        s if !s.is_finite() => "-".to_owned(),
        s if s >= 10.0 => format!("{} times", significant(s, 3, 0.0)),
        s => format!("{} %", significant(100.0 * s, 2, 0.0)),
    }
}

pub(crate) fn number(x: f64, digits: usize) -> String {
    significant(x, digits, 0.0)
}

pub(crate) fn optional(x: Option<f64>, digits: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| number(x, digits))
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Training => "fitted",
        Role::Holdout => "hold-out",
    }
}

fn quality(drawing: &Drawing) -> Option<Section> {
    if drawing.quality.is_empty() && drawing.filters.is_empty() {
        return None;
    }
    let header = [
        "recording",
        "use",
        "samples",
        "rate [Hz]",
        "length [s]",
        "jitter",
        "gaps",
        "longest gap [ms]",
    ];
    let rows = drawing
        .quality
        .iter()
        .map(|q| {
            vec![
                q.source.clone(),
                role(q.role).to_owned(),
                q.samples.to_string(),
                number(q.rate_hz, 4),
                number(q.duration_s, 4),
                percent(q.jitter),
                q.gaps.to_string(),
                number(1e3 * q.longest_gap_s, 3),
            ]
        })
        .collect();
    let mut tables = vec![Grid::new("Recordings", &header, 2).with(rows)];
    let doubts: Vec<Vec<String>> = drawing
        .quality
        .iter()
        .flat_map(|q| q.findings.iter().map(|f| vec![q.source.clone(), f.clone()]))
        .collect();
    let quiet = doubts.is_empty();
    if !quiet {
        let caption = "Repaired, or doubtful";
        tables.push(Grid::new(caption, &["recording", "what"], 2).with(doubts));
    }
    if let Some(first) = drawing.quality.first() {
        tables.push(channels(first));
    }
    let mut sentences = drawing.filters.clone();
    if quiet && !drawing.quality.is_empty() {
        sentences.push("Nothing was repaired, and nothing is doubtful in the samples.".to_owned());
    }
    Some(Section {
        id: "data".to_owned(),
        title: "Data quality".to_owned(),
        sentences,
        tables,
        figures: Vec::new(),
    })
}

fn channels(of: &Quality) -> Grid {
    let header = ["channel", "smallest", "largest", "noise", "step", "saturated", "stuck"];
    let rows = of
        .channels
        .iter()
        .map(|c| {
            vec![
                c.name.clone(),
                number(c.smallest, 4),
                number(c.largest, 4),
                optional(c.noise, 2),
                optional(c.step, 2),
                percent(c.saturated_share),
                percent(c.stuck_share),
            ]
        })
        .collect();
    Grid::new(format!("Channels of {} (rad, m, N m, N, s)", of.source), &header, 1).with(rows)
}

fn provenance(document: &Value, drawing: &Drawing) -> Vec<Grid> {
    let from = &drawing.provenance;
    let text = |key: &str| document.get(key).and_then(Value::as_str).unwrap_or("-").to_owned();
    let mut rows = vec![vec!["result".to_owned(), text("schema")]];
    let version = if from.version.is_empty() { env!("CARGO_PKG_VERSION") } else { &from.version };
    rows.push(vec!["armident".to_owned(), version.to_owned()]);
    if !from.command.is_empty() {
        rows.push(vec!["command".to_owned(), from.command.join(" ")]);
    }
    let seed = from.seed.or_else(|| document.get("seed").and_then(Value::as_u64));
    let drawn = "none: no random numbers decide anything".to_owned();
    rows.push(vec!["seed".to_owned(), seed.map_or(drawn, |s| s.to_string())]);
    let mut tables = vec![Grid::new("How it came about", &["what", ""], 2).with(rows)];
    if from.inputs.is_empty() {
        let list = |key: &str| -> Vec<Vec<String>> {
            let named = document.get(key).and_then(Value::as_array).into_iter().flatten();
            named
                .filter_map(|r| Some(vec![r.as_str()?.to_owned(), key.replace('_', " ")]))
                .collect()
        };
        let rows: Vec<_> = [list("recordings"), list("holdout_recordings")].concat();
        if !rows.is_empty() {
            tables.push(Grid::new("Inputs", &["file", "use"], 2).with(rows));
        }
    } else {
        let rows = from
            .inputs
            .iter()
            .map(|i| vec![i.path.clone(), i.sha256.clone(), i.bytes.to_string()])
            .collect();
        tables.push(Grid::new("Inputs", &["file", "SHA-256", "bytes"], 2).with(rows));
    }
    tables
}
