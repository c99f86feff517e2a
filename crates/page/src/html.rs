//! The page as HTML.

use armident_report::{DiagnosisSection, percent, standard_sections};
use askama::Template;
use serde_json::Value;

use crate::drawing::{Drawing, Quality, RecordingRole};
use crate::error::PageError;
use crate::figures::Figure;
use crate::filters;
use crate::kinds;
use crate::pack::{in_script, library, packed};
use crate::view::{Card, Grid, JointCard, Piece, Section, Step, Tone, View, number, optional};

/// The page of a result, from its JSON.
///
/// # Errors
/// [`PageError`].
pub fn html(result: &str) -> Result<String, PageError> {
    html_of_sections(result, standard_sections::DIAGNOSIS)
}

/// The page of a result; that of a diagnosis has these sections.
///
/// # Errors
/// [`PageError`].
pub fn html_of_sections(
    result: &str,
    sections: &[&dyn DiagnosisSection],
) -> Result<String, PageError> {
    let (view, document, drawing) = read(result, sections)?;
    page(view, &document, &drawing)
}

/// Verdict, findings and tables of a result as a part of another page, without charts, scripts and styles: what a
/// notebook shows.
///
/// # Errors
/// [`PageError`].
pub fn html_excerpt(result: &str) -> Result<String, PageError> {
    let (view, ..) = read(result, standard_sections::DIAGNOSIS)?;
    let View { kind, robot, headline, sentences, next, warnings, cards, joints, sections, .. } =
        view;
    let tone = view.tone.class();
    let excerpt =
        Excerpt { kind, robot, tone, headline, sentences, next, warnings, cards, joints, sections };
    Ok(excerpt.render()?)
}

/// The content of a page, its JSON without the section `drawing`, and that section.
fn read(
    result: &str,
    sections: &[&dyn DiagnosisSection],
) -> Result<(View, Value, Drawing), PageError> {
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
    let view = kinds::view(&schema, &document, &drawing, sections)?;
    Ok((view, document, drawing))
}

#[derive(Template)]
#[template(path = "excerpt.html")]
struct Excerpt {
    kind: &'static str,
    robot: String,
    tone: &'static str,
    headline: String,
    sentences: Vec<String>,
    next: Vec<Step>,
    warnings: Vec<String>,
    cards: Vec<Card>,
    joints: Vec<JointCard>,
    sections: Vec<Section>,
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

impl Tone {
    /// Name of its style.
    fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Open => "open",
        }
    }
}

/// All charts of a page.
fn charts(view: &View) -> impl Iterator<Item = &Figure> {
    (view.overview.iter())
        .chain(view.cards.iter().filter_map(|card| card.figure.as_ref()))
        .chain(view.joints.iter().flat_map(|joint| &joint.figures))
        .chain(&view.skeleton)
        .chain(view.sections.iter().flat_map(Section::charts))
}

fn page(mut view: View, document: &Value, drawing: &Drawing) -> Result<String, PageError> {
    view.sections.extend(quality(drawing));
    let contents: serde_json::Map<String, Value> =
        charts(&view).map(|figure| (figure.id.clone(), figure.content.clone())).collect();
    let page = Page {
        version: env!("CARGO_PKG_VERSION"),
        title: format!("{}: {}", view.robot, view.headline),
        kind: view.kind,
        tone: view.tone.class(),
        provenance: provenance(document, drawing),
        result: in_script(&document.to_string()),
        figures: packed(&Value::Object(contents).to_string())?,
        library: packed(&library())?,
        robot: view.robot,
        headline: view.headline,
        sentences: view.sentences,
        next: view.next,
        warnings: view.warnings,
        overview: view.overview,
        cards: view.cards,
        joints: view.joints,
        skeleton: view.skeleton,
        sections: view.sections,
    };
    Ok(page.render()?)
}

fn role(role: RecordingRole) -> &'static str {
    match role {
        RecordingRole::Training => "training",
        RecordingRole::Holdout => "hold-out",
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
        let caption = "Repairs and doubts";
        tables.push(Grid::new(caption, &["recording", "finding"], 2).with(doubts));
    }
    if let Some(first) = drawing.quality.first() {
        tables.push(channels(first));
    }
    let mut sentences = drawing.filters.clone();
    if quiet && !drawing.quality.is_empty() {
        sentences.push("No sample was repaired, none is doubtful.".to_owned());
    }
    Some(Section::new("data", "Data quality", sentences, tables))
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
    let drawn = "none: nothing depends on random numbers".to_owned();
    rows.push(vec!["seed".to_owned(), seed.map_or(drawn, |s| s.to_string())]);
    let mut tables = vec![Grid::new("Result", &["item", "value"], 2).with(rows)];
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
