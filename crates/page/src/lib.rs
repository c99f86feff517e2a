//! Draws results as one self-contained HTML file.
//!
//! A page is made of the JSON of a result ([`html`]), whichever command wrote it. What a result does not say
//! in numbers - efforts over time, where residuals lie, the arm in motion - is in its section `drawing`
//! ([`Drawing`]), which a [`Canvas`] fills from recordings and predictions; without it the page has the
//! verdict and the tables. Charts are drawn by plotly.js, which is packed into the page; nothing is loaded
//! from anywhere, and the page's own policy forbids it.
//!
//! ```
//! let result = r#"{ "schema": "armident.diagnosis/1", "robot": "arm", "joints": ["elbow"],
//!     "sentence": "the recordings show nothing that the model leaves out" }"#;
//! let page = armident_page::html(result)?;
//! assert!(page.contains("The recordings show nothing that the model leaves out"));
//! assert!(armident_page::html("{}").is_err());
//! # Ok::<(), armident_page::PageError>(())
//! ```

mod atlas;
mod canvas;
mod drawing;
mod figures;
mod finding;
mod kinds;
mod pack;
mod page;
mod provenance;
mod reduce;
mod spectrum;

pub use canvas::{Canvas, Compared};
pub use drawing::{
    Channel, Correlation, Drawing, EffortTraces, FindingTraces, FindingView, Input, JointName,
    JointResidual, Map, Provenance, Quality, RecordingTraces, Role, Series, Skeleton,
};
pub use finding::FindingPlace;
pub use page::{PageError, html};
