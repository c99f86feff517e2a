//! The prior on link inertias (`armident_model::link_errors`), as directions of the standard parameters of all links.

use armident_kinematics::InertialParameters;
use armident_model::{LinkError, link_errors};

use crate::design::observations::JointColumns;

/// Directions of the errors of each link, each an error of relative size 1.
pub(crate) fn inertial_error_directions(links: &[InertialParameters]) -> LinkErrorPrior {
    const COUNT: usize = InertialParameters::COUNT;
    let errors = link_errors(links).unwrap_or_default();
    let direction = |error: &LinkError| {
        let mut direction = vec![0.0; COUNT * links.len()];
        direction[COUNT * error.link..][..COUNT].copy_from_slice(&error.change.to_array());
        direction
    };
    LinkErrorPrior {
        directions: errors.iter().map(direction).collect(),
        links: links.len(),
        free: 0,
    }
}

/// A deviation that leaves the coefficient of a column free: such that the column is as large as the effort to be explained
/// on its joints.
pub(crate) fn as_large_as(effort: &JointColumns, column: &JointColumns) -> f64 {
    let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let there = || effort.iter().zip(column).filter(|(_, c)| !c.is_empty());
    let efforts: f64 = there().map(|(e, _)| square(e)).sum();
    let columns: f64 = there().map(|(_, c)| square(c)).sum();
    (efforts / columns.max(f64::MIN_POSITIVE)).sqrt()
}

impl LinkErrorPrior {
    /// With further columns whose coefficients have these deviations, whatever the inertial errors.
    pub(crate) fn extend(&mut self, deviations: &[f64]) {
        let before = self.directions.first().map_or(0, Vec::len);
        let length = before + deviations.len();
        for direction in &mut self.directions {
            direction.resize(length, 0.0);
        }
        for (k, deviation) in deviations.iter().enumerate() {
            let mut direction = vec![0.0; length];
            direction[before + k] = *deviation;
            self.directions.push(direction);
        }
        self.free += deviations.len();
    }
}

/// Inertial errors of all links as noise: `W = Y D`, coefficients of deviation `s`.
#[derive(Debug, Clone, Default)]
pub(crate) struct LinkErrorPrior {
    /// `D`, `[direction][standard parameter]`
    pub(crate) directions: Vec<Vec<f64>>,
    pub(crate) links: usize,
    /// last directions, which are not inertial
    pub(crate) free: usize,
}
