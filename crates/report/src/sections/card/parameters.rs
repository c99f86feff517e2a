//! Parameters of an identified arm.

use crate::layout::{Block, Table, percent, significant, uncertain};
use crate::results::{ModelCard, NOT_IDENTIFIED};
use crate::section::Section;

/// Constants, friction and drive gains with their standard errors.
pub(crate) struct Parameters;

impl Section<ModelCard> for Parameters {
    fn key(&self) -> &'static str {
        "parameters"
    }

    fn text(&self, card: &ModelCard) -> Vec<Block> {
        let rows = card.parameters.iter().map(|parameter| {
            let (value, error) = match parameter.standard_error {
                Some(error) => uncertain(parameter.value, error),
                None => (significant(parameter.value, 4, 0.0), "-".to_owned()),
            };
            let given = parameter.given.map_or_else(String::new, |x| significant(x, 5, 1e-12));
            let remark = if parameter.undetermined > NOT_IDENTIFIED {
                format!("{} not identified", percent(parameter.undetermined))
            } else {
                String::new()
            };
            vec![
                parameter.parameter.clone(),
                parameter.location.clone(),
                value,
                error,
                given,
                parameter.unit.clone(),
                remark,
            ]
        });
        let table = Table::new("Parameters", &["parameter", "joint"])
            .numbers(&["estimate", "std error", "URDF"])
            .texts(&["unit", ""]);
        vec![Block::heading("Parameters"), Block::Table(table.with(rows).without_empty_columns())]
    }
}
