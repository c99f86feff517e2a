//! Blocks as aligned text.

use super::bar::Bars;
use super::block::{Block, Cell, Table};
use super::table::aligned_columns;

/// Width of the verdicts of [`Block::Status`].
const VERDICT: usize = 12;

/// Blocks as text: a blank line before every heading and paragraph. Where bars are ASCII, all is.
pub fn render(blocks: impl IntoIterator<Item = Block>, bars: Bars) -> String {
    let mut text = String::new();
    let mut heading: Option<(String, String)> = None;
    for block in blocks {
        match block {
            Block::Heading { title, note } => {
                let head = Some((title, note));
                if heading == head {
                    continue;
                }
                let (title, note) = head.clone().unwrap_or_default();
                let note = if note.is_empty() { note } else { format!(" ({note})") };
                text += &format!("\n{title}{note}\n");
                heading = head;
            }
            Block::Subheading(title) => text += &format!("\n{title}\n"),
            Block::Paragraph(paragraph) => text += &format!("\n{paragraph}\n"),
            Block::Line(line) => text += &format!("{line}\n"),
            Block::Item { text: item, detail } => {
                text += &format!("  {item}\n");
                if !detail.is_empty() {
                    text += &format!("    {detail}\n");
                }
            }
            Block::KeyValues(pairs) => {
                let width = pairs.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
                for (name, value) in pairs {
                    text += format!("  {name:<width$}  {value}").trim_end();
                    text.push('\n');
                }
            }
            Block::Status { verdict, text: about, hint } => {
                text += &format!("  {verdict:<VERDICT$}  {about}\n");
                if !hint.is_empty() {
                    text += &format!("  {:<VERDICT$}  hint: {hint}\n", "");
                }
            }
            Block::Table(table) => text += &table_text(&table, bars),
            Block::Figure(_) => {}
        }
    }
    match bars {
        Bars::Unicode => text,
        Bars::Ascii => text.replace('\u{b1}', "+/-"),
    }
}

fn table_text(table: &Table, bars: Bars) -> String {
    let header: Vec<&str> = table.columns.iter().map(|column| column.head.as_str()).collect();
    let is_number: Vec<bool> = table.columns.iter().map(|column| column.is_number).collect();
    let cell = |cell: &Cell| match cell {
        Cell::Text(text) => text.clone(),
        Cell::Bar(whole, part) => bars.left(*whole, *part),
    };
    let rows: Vec<Vec<String>> =
        table.rows.iter().map(|row| row.iter().map(cell).collect()).collect();
    aligned_columns(&header, &rows, &is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_headings_are_shared() {
        let blocks = vec![
            Block::heading("Model details"),
            Block::item("first"),
            Block::heading("Model details"),
            Block::Item { text: "second".to_owned(), detail: "of two".to_owned() },
            Block::Paragraph("1 \u{b1} 2".to_owned()),
        ];
        let text = render(blocks, Bars::Ascii);
        assert_eq!(text, "\nModel details\n  first\n  second\n    of two\n\n1 +/- 2\n");
    }

    #[test]
    fn values_are_aligned() {
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        let blocks = [Block::KeyValues(vec![pair("mass", "1 kg"), pair("stiffness", "2 N m/rad")])];
        let text = render(blocks, Bars::Unicode);
        assert_eq!(text, "  mass       1 kg\n  stiffness  2 N m/rad\n");
    }
}
