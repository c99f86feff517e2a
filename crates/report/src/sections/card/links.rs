//! Links of an identified arm.

use crate::layout::{Block, Table, significant};
use crate::results::ModelCard;
use crate::section::Section;

/// Masses and centres of mass.
pub(crate) struct Links;

impl Section<ModelCard> for Links {
    fn key(&self) -> &'static str {
        "links"
    }

    fn text(&self, card: &ModelCard) -> Vec<Block> {
        let rows = card.links.iter().map(|link| {
            let centre = link.centre_of_mass_m.map(|x| significant(x, 3, 1e-9));
            let mut row = vec![link.link.clone(), link.joint.clone()];
            row.extend([link.given_mass_kg, link.mass_kg].map(|x| significant(x, 4, 0.0)));
            row.extend(centre);
            row
        });
        let heads = ["URDF mass [kg]", "mass [kg]", "x [m]", "y [m]", "z [m]"];
        let table = Table::new("Links of the model", &["link", "joint"]).numbers(&heads).with(rows);
        let about = "Single masses and centres are those of the model. The recordings determine the parameters above: \
                     other links with the same constants fit equally well.";
        vec![
            Block::heading_with_note("Links", "centre of mass in the driving-axis frame"),
            Block::Line(about.to_owned()),
            Block::Table(table),
        ]
    }
}
