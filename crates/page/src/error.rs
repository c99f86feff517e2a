//! Why there is no page.

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
        /// Schema of the file.
        found: String,
    },
    /// A result with fields of another form.
    #[error("the result is not of the form of its schema: {0}")]
    Form(serde_json::Error),
    /// The page could not be written.
    #[error("the page cannot be formed: {0}")]
    Template(#[from] askama::Error),
    /// The charts could not be packed.
    #[error("the charts cannot be packed: {0}")]
    Packing(#[from] std::io::Error),
}
