//! Numbers, tables and blocks of text: what every result is laid out with.

mod bar;
mod block;
mod numbers;
mod table;
mod text;

pub use bar::Bars;
pub use block::{Block, Cell, Column, Table};
pub use numbers::{percent, significant, uncertain, unit_after_number};
pub use table::aligned;
pub use text::render;
