//! Files that a model was made of.

use crate::layout::{Block, Table};
use crate::results::ModelCard;
use crate::section::Section;

/// Files with their digests.
pub(crate) struct Inputs;

impl Section<ModelCard> for Inputs {
    fn key(&self) -> &'static str {
        "inputs"
    }

    fn text(&self, card: &ModelCard) -> Vec<Block> {
        let rows = card.inputs.iter().map(|input| {
            let bytes = input.bytes.to_string();
            vec![input.file.clone(), input.used_as.clone(), bytes, input.sha256.clone()]
        });
        let table = Table::new("Files", &["file", "used as"]).numbers(&["bytes"]);
        vec![Block::heading("Files"), Block::Table(table.texts(&["SHA-256"]).with(rows))]
    }
}
