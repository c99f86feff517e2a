//! Content of a page, whichever result it is of.

use armident_report::significant;

use crate::figures::Figure;

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

/// A piece of a section.
#[derive(Debug, Clone)]
pub(crate) enum Piece {
    Subheading(String),
    Text(String),
    /// entries, each with a remark, which may be empty
    List(Vec<(String, String)>),
    /// texts with the files that they lead to
    Links(Vec<(String, String)>),
    Table(Grid),
    Chart(Figure),
}

/// A part of the page.
#[derive(Debug, Clone, Default)]
pub(crate) struct Section {
    pub(crate) id: String,
    pub(crate) title: String,
    pub(crate) pieces: Vec<Piece>,
}

impl Section {
    /// A section of sentences and tables.
    pub(crate) fn new(
        id: impl Into<String>,
        title: impl Into<String>,
        sentences: Vec<String>,
        tables: Vec<Grid>,
    ) -> Self {
        let sentences = sentences.into_iter().map(Piece::Text);
        let pieces = sentences.chain(tables.into_iter().map(Piece::Table)).collect();
        Self { id: id.into(), title: title.into(), pieces }
    }

    /// Tables of the section.
    pub(crate) fn tables(&self) -> Vec<&Grid> {
        self.pieces
            .iter()
            .filter_map(|piece| match piece {
                Piece::Table(table) => Some(table),
                _ => None,
            })
            .collect()
    }

    /// Charts of the section.
    pub(crate) fn charts(&self) -> impl Iterator<Item = &Figure> {
        self.pieces.iter().filter_map(|piece| match piece {
            Piece::Chart(figure) => Some(figure),
            _ => None,
        })
    }
}

/// Content of a page.
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

pub(crate) fn number(x: f64, digits: usize) -> String {
    significant(x, digits, 0.0)
}

pub(crate) fn optional(x: Option<f64>, digits: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| number(x, digits))
}
