//! What a section consists of: plain data that a terminal shows as aligned text and a page as HTML.

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// Heading of the section. Sections that follow each other under the same title share it.
    Heading {
        /// Title.
        title: String,
        /// Quantity, unit and other remarks, in brackets on a terminal; may be empty.
        note: String,
    },
    /// Heading inside a section.
    Subheading(String),
    /// Text of its own.
    Paragraph(String),
    /// A line that belongs to what stands above it.
    Line(String),
    /// An entry of a list.
    Item {
        /// The entry.
        text: String,
        /// A remark below it; may be empty.
        detail: String,
    },
    /// Names with their values.
    KeyValues(Vec<(String, String)>),
    /// A verdict with its reason.
    Status {
        /// One word.
        verdict: String,
        /// What it is about.
        text: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// A table.
    Table(Table),
    /// A chart of the page, by name. Terminals, and results without the data of the chart, do without it.
    Figure(String),
}

impl Block {
    /// A heading without a remark.
    pub fn heading(title: impl Into<String>) -> Self {
        Self::Heading { title: title.into(), note: String::new() }
    }

    /// A heading with a remark.
    pub fn heading_with_note(title: impl Into<String>, note: impl Into<String>) -> Self {
        Self::Heading { title: title.into(), note: note.into() }
    }

    /// An entry of a list, without a remark.
    pub fn item(text: impl Into<String>) -> Self {
        Self::Item { text: text.into(), detail: String::new() }
    }
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Head: a noun and a unit.
    pub head: String,
    /// Whether the column holds numbers, which are right-aligned.
    pub is_number: bool,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Text, or a number as text.
    Text(String),
    /// An error as a part of another: the whole bar is the first, the filled part the second.
    Bar(f64, f64),
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

fn of_kept<T>(all: Vec<T>, kept: &[bool]) -> Vec<T> {
    all.into_iter().zip(kept).filter_map(|(one, kept)| kept.then_some(one)).collect()
}

/// A table. Every row has one cell a column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Caption on a page; a terminal shows the heading above only.
    pub caption: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows, of columns of text.
    pub fn new(caption: impl Into<String>, heads: &[&str]) -> Self {
        let columns =
            heads.iter().map(|head| Column { head: (*head).to_owned(), is_number: false });
        Self { caption: caption.into(), columns: columns.collect(), rows: Vec::new() }
    }

    /// The table with further columns of numbers.
    #[must_use]
    pub fn numbers(self, heads: &[&str]) -> Self {
        self.further(heads, true)
    }

    /// The table with further columns of text.
    #[must_use]
    pub fn texts(self, heads: &[&str]) -> Self {
        self.further(heads, false)
    }

    fn further(mut self, heads: &[&str], is_number: bool) -> Self {
        let columns = heads.iter().map(|head| Column { head: (*head).to_owned(), is_number });
        self.columns.extend(columns);
        self
    }

    /// The table with rows.
    #[must_use]
    pub fn with<C: Into<Cell>>(mut self, rows: impl IntoIterator<Item = Vec<C>>) -> Self {
        self.rows.extend(rows.into_iter().map(|row| row.into_iter().map(Into::into).collect()));
        self
    }

    /// The table without the columns that are empty in every row.
    #[must_use]
    pub fn without_empty_columns(mut self) -> Self {
        let is_empty = |cell: &Cell| matches!(cell, Cell::Text(text) if text.is_empty());
        let kept: Vec<bool> = (0..self.columns.len())
            .map(|column| !self.rows.iter().all(|row| is_empty(&row[column])))
            .collect();
        self.columns = of_kept(self.columns, &kept);
        self.rows = self.rows.into_iter().map(|row| of_kept(row, &kept)).collect();
        self
    }
}
