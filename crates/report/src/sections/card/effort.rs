//! How well the efforts are predicted.

use crate::layout::{Block, Table, significant};
use crate::results::ModelCard;
use crate::section::Section;

/// Effort errors by joint.
pub(crate) struct Effort;

impl Section<ModelCard> for Effort {
    fn key(&self) -> &'static str {
        "effort"
    }

    fn text(&self, card: &ModelCard) -> Vec<Block> {
        let number = |x: Option<f64>| x.map_or_else(String::new, |x| significant(x, 4, 0.0));
        let rows = card.effort.iter().map(|row| {
            let errors = [row.given, row.training, row.holdout, row.noise].map(number);
            std::iter::once(row.joint.clone()).chain(errors).collect()
        });
        let note = "RMS, low-passed, N m or N";
        let heads = ["URDF only", "training", "hold-out", "noise level"];
        let table = Table::new(format!("Effort error ({note})"), &["joint"]).numbers(&heads);
        let table = table.with::<String>(rows).without_empty_columns();
        vec![Block::heading_with_note("Effort error", note), Block::Table(table)]
    }
}
