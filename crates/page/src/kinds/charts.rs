//! Charts that sections name.

use armident_report::ConstantRow;

use crate::drawing::Drawing;
use crate::figures::{self, Figure};

/// A chart of the minimal set, by name.
pub(super) fn of_minimal_set(
    name: &str,
    constants: &[ConstantRow],
    drawing: &Drawing,
) -> Option<Figure> {
    match name {
        "intervals" => {
            let rows: Vec<(String, f64, f64)> = constants
                .iter()
                .filter_map(|c| {
                    let error = c.standard_error.filter(|error| *error > 0.0)?;
                    Some((format!("{} {}", c.label, c.joint), c.value? - c.urdf, error))
                })
                .collect();
            figures::intervals(&rows)
        }
        "correlation" => drawing.correlation.as_ref().map(figures::correlation),
        _ => None,
    }
}
