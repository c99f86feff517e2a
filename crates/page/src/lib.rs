//! Draws results as one self-contained HTML file.
//!
//! A page is made of the JSON of a result ([`html`]), whichever command wrote it. What a result does not say
//! in numbers - efforts over time, where residuals lie, the arm in motion - is in its section `drawing`
//! ([`Drawing`]), which a [`Canvas`] fills from recordings and predictions; without it the page has the
//! verdict and the tables. Charts are drawn by plotly.js, which is packed into the page; nothing is loaded
//! from anywhere, and the page's own policy forbids it.
//!
//! ```
//! let result = r#"{ "schema": "armident.diagnosis/2", "robot": "arm", "joints": ["elbow"],
//!     "findings": [{ "effect": "payload", "link": "link_6" }] }"#;
//! let page = armident_page::html(result)?;
//! assert!(page.contains("1 effect is missing from the model"));
//! assert!(armident_page::html("{}").is_err());
//! # Ok::<(), armident_page::PageError>(())
//! ```

mod blocks;
mod canvas;
mod drawing;
mod error;
mod figures;
mod filters;
mod finding;
mod html;
mod kinds;
mod pack;
mod provenance;
mod reduce;
mod residual_maps;
mod sheet;
mod spectrum;
mod view;

pub use canvas::Canvas;
pub use drawing::{
    Channel, Correlation, Drawing, DrawnQuantity, EffortTraces, FindingTraces, FindingView,
    JointName, JointResidual, Map, PageInput, PlotSeries, Provenance, Quality, RecordingRole,
    RecordingTraces, Skeleton,
};
pub use error::PageError;
pub use finding::FindingPlace;
pub use html::{html, html_excerpt, html_of_sections};
pub use sheet::Compared;
