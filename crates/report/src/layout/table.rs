//! Aligned tables.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, presets};

/// A table without rules: a header, one line a row, columns two spaces apart. The first `left`
/// columns are left-aligned, the others right-aligned. Lines have no trailing spaces.
pub fn aligned(header: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let right: Vec<bool> = (0..header.len()).map(|column| column >= left).collect();
    aligned_columns(header, rows, &right)
}

/// The same, with the alignment of each column.
pub(super) fn aligned_columns(header: &[&str], rows: &[Vec<String>], right: &[bool]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.iter().map(ToString::to_string).collect::<Vec<_>>());
    for row in rows {
        table.add_row(row.clone());
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if k == 0 { 0 } else { 1 }, 1));
        column.set_constraint(ColumnConstraint::ContentWidth);
        column.set_cell_alignment(if right.get(k) == Some(&true) {
            CellAlignment::Right
        } else {
            CellAlignment::Left
        });
    }
    let text = table.to_string();
    let mut lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    lines.push("");
    lines.join("\n")
}
