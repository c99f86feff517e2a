//! Columns of numbers before their joints and units are known.

/// One column of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct RawColumn {
    /// Its name in the file.
    pub name: String,
    /// Values, NaN where missing; none for an ignored column.
    pub values: Option<Vec<f64>>,
}

/// The columns of a file. Their names or a [`Mapping`](crate::Mapping) give the meaning.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawColumns {
    /// Where they come from: a path, or a description.
    pub source: String,
    /// All columns in the order of the file.
    pub columns: Vec<RawColumn>,
    /// Line of each row in a text file; empty for sources without lines.
    pub lines: Vec<u64>,
    /// Notes on reading, one line each.
    pub notes: Vec<String>,
    /// Row, column and text of the first value of each column that is missing, NaN or infinite.
    pub(crate) not_finite: Vec<(usize, usize, String)>,
}

impl RawColumns {
    /// No columns yet.
    pub fn new(source: impl Into<String>) -> Self {
        Self { source: source.into(), ..Self::default() }
    }

    /// The same with one more column.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, values: Vec<f64>) -> Self {
        self.columns.push(RawColumn { name: name.into(), values: Some(values) });
        self
    }

    /// Names of all columns.
    pub fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    /// Rows of the longest column.
    pub(crate) fn rows(&self) -> usize {
        self.columns
            .iter()
            .filter_map(|column| column.values.as_ref().map(Vec::len))
            .max()
            .unwrap_or(0)
    }

    /// Line of a row in the file.
    pub(crate) fn line(&self, row: usize) -> Option<u64> {
        self.lines.get(row).copied()
    }

    /// Text of a value in the file, as far as known.
    pub(crate) fn text(&self, row: usize, column: usize, value: f64) -> String {
        let known = self.not_finite.iter().find(|first| (first.0, first.1) == (row, column));
        known.map_or_else(|| value.to_string(), |(_, _, text)| text.clone())
    }
}
