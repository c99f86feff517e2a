//! Sections of a result, as parts of a page.

use armident_report::{Block, Cell, Table, percent};

use crate::figures::Figure;
use crate::view::{Grid, Piece, Section};

/// The parts of a page that sections are shown in, each section with its key. Sections that follow each other under
/// the same title are one part. `chart` draws charts by name, where there is data for them.
pub(crate) fn parts<'k>(
    sections: impl IntoIterator<Item = (&'k str, Vec<Block>)>,
    chart: impl Fn(&str) -> Option<Figure>,
) -> Vec<Section> {
    let mut parts: Vec<Section> = Vec::new();
    for (key, blocks) in sections {
        let mut is_new = true;
        for block in blocks {
            let (title, note) = match block {
                Block::Heading { title, note } => (title, note),
                block => {
                    if is_new {
                        parts.push(part(key, key.replace(['_', '-'], " ")));
                        is_new = false;
                    }
                    let part = parts.last_mut();
                    part.into_iter().for_each(|part| add(part, &block, &chart));
                    continue;
                }
            };
            is_new = false;
            if parts.last().is_some_and(|last| last.title == title) {
                continue;
            }
            let mut new = part(key, title);
            // an anchor stands for one part
            if parts.iter().any(|part| part.id == new.id) {
                new.id += &format!("-{}", parts.len());
            }
            if !note.is_empty() {
                new.pieces.push(Piece::Text(format!("{}.", armident_report::capital(&note))));
            }
            parts.push(new);
        }
    }
    parts.retain(|part| !part.pieces.is_empty());
    parts
}

fn part(id: &str, title: String) -> Section {
    Section { id: id.replace('_', "-"), title, pieces: Vec::new() }
}

fn add(part: &mut Section, block: &Block, chart: &impl Fn(&str) -> Option<Figure>) {
    let piece = match block {
        Block::Heading { .. } => return,
        Block::Subheading(title) => Piece::Subheading(title.clone()),
        Block::Paragraph(text) | Block::Line(text) => Piece::Text(text.clone()),
        Block::Item { text, detail } => {
            let entry = (text.clone(), detail.clone());
            if let Some(Piece::List(entries)) = part.pieces.last_mut() {
                entries.push(entry);
                return;
            }
            Piece::List(vec![entry])
        }
        Block::KeyValues(pairs) => {
            let rows = pairs.iter().map(|(name, value)| vec![name.clone(), value.clone()]);
            let caption = part.title.clone();
            Piece::Table(Grid::new(caption, &["quantity", "value"], 2).with(rows.collect()))
        }
        Block::Status { verdict, text, hint } => {
            let entry = (format!("{verdict}: {text}"), hint.clone());
            Piece::List(vec![entry])
        }
        Block::Table(table) => Piece::Table(grid(table, &part.title)),
        Block::Figure(name) => match chart(name) {
            Some(figure) => Piece::Chart(figure),
            None => return,
        },
    };
    // a table without rows is left out
    if !matches!(&piece, Piece::Table(grid) if grid.rows.is_empty()) {
        part.pieces.push(piece);
    }
}

fn grid(table: &Table, title: &str) -> Grid {
    let text = |cell: &Cell| match cell {
        Cell::Text(text) => text.clone(),
        Cell::Bar(whole, part) => percent(part / whole),
    };
    let caption = if table.caption.is_empty() { title } else { &table.caption };
    Grid {
        caption: caption.to_owned(),
        header: table.columns.iter().map(|column| column.head.clone()).collect(),
        numbers: table.columns.iter().map(|c| c.is_number && c.head != "unit").collect(),
        rows: table.rows.iter().map(|row| row.iter().map(text).collect()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_titles_are_one_part() {
        let sections = [
            ("a", vec![Block::heading("Model details"), Block::item("first")]),
            ("b", vec![Block::heading("Model details"), Block::item("second")]),
            ("c", vec![Block::heading("Errors")]),
            ("d_e", vec![Block::Paragraph("text".to_owned())]),
        ];
        let parts = parts(sections, |_| None);
        let titles: Vec<(&str, &str)> =
            parts.iter().map(|part| (part.id.as_str(), part.title.as_str())).collect();
        assert_eq!(titles, [("a", "Model details"), ("d-e", "d e")]);
        assert!(matches!(&parts[0].pieces[..], [Piece::List(entries)] if entries.len() == 2));
    }
}
