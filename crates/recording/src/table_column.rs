//! What columns of tables hold.

/// Values of a column in one group of rows.
#[derive(Debug, Clone, PartialEq)]
pub enum TableColumn {
    /// Texts.
    Text(Vec<Option<String>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Whole(Vec<Option<i64>>),
    /// A list of numbers in each row, NaN where one is missing.
    Numbers(Vec<Vec<f64>>),
}

impl TableColumn {
    /// Texts, whole numbers as text; none of other columns.
    pub fn into_texts(self) -> Option<Vec<Option<String>>> {
        match self {
            Self::Text(texts) => Some(texts),
            Self::Whole(numbers) => {
                Some(numbers.into_iter().map(|number| Some(number?.to_string())).collect())
            }
            Self::Number(_) | Self::Numbers(_) => None,
        }
    }
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableKind {
    /// [`TableColumn::Text`].
    Text,
    /// [`TableColumn::Number`].
    Number,
    /// [`TableColumn::Whole`].
    Whole,
    /// [`TableColumn::Numbers`].
    Numbers,
}
