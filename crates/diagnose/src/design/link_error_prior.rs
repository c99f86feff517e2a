//! Inertial errors of all links, as directions of the standard parameters.

use armident_kinematics::InertialParameters;
use nalgebra::{Matrix3, Vector3};

use crate::design::observations::JointColumns;

/// Size of an error of the centre of mass beside its own distance \[m\].
const COM_SIZE_M: f64 = 0.03;
/// Size of an error of an entry of the inertia, as a share of the geometric mean of its diagonal.
const INERTIA_SHARE: f64 = 0.3;
const STEP: f64 = 1e-6;

/// Eleven directions a link, each an error of relative size 1: the mass with all that goes with it,
/// the centre of mass along each axis, the size of the inertia, its six entries.
pub(crate) fn inertial_error_directions(links: &[InertialParameters]) -> LinkErrorPrior {
    let mut directions = Vec::new();
    for (k, link) in links.iter().enumerate() {
        let (mass, com, inertia) = (link.mass_kg, link.com_m(), link.inertia_com_kgm2());
        let base = link.to_array();
        let mut push = |moved: InertialParameters, step: f64| {
            let mut direction = vec![0.0; 10 * links.len()];
            for (p, (new, old)) in moved.to_array().iter().zip(base).enumerate() {
                direction[10 * k + p] = (new - old) / step;
            }
            directions.push(direction);
        };
        let scaled =
            |factor: f64| InertialParameters::from_com(mass * factor, com, inertia * factor);
        push(scaled(1.0 + STEP), STEP);
        // relative to the distance is the error in all: a third of its square along each axis
        let size = (com.norm() + COM_SIZE_M) / 3f64.sqrt();
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            push(InertialParameters::from_com(mass, com + axis * (STEP * size), inertia), STEP);
        }
        push(InertialParameters::from_com(mass, com, inertia * (1.0 + STEP)), STEP);
        for (a, b) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let size = INERTIA_SHARE * (inertia[(a, a)] * inertia[(b, b)]).abs().sqrt();
            let mut change = Matrix3::zeros();
            change[(a, b)] = size * STEP;
            change[(b, a)] = size * STEP;
            push(InertialParameters::from_com(mass, com, inertia + change), STEP);
        }
    }
    LinkErrorPrior { directions, links: links.len(), free: 0 }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// An error of so much of the distance is that much in all, not along each axis.
    #[test]
    fn centre_error_scales_with_distance() {
        let com = Vector3::new(0.3, 0.0, 0.4);
        let link = InertialParameters::from_com(2.0, com, Matrix3::identity() * 0.1);
        let directions = inertial_error_directions(&[link]).directions;
        let moments: f64 = directions[1..4]
            .iter()
            .flat_map(|direction| direction[1..4].iter().map(|x| x * x))
            .sum();
        let off = moments.sqrt() / link.mass_kg;
        assert!((off - (com.norm() + COM_SIZE_M)).abs() < 1e-6, "{off}");
    }
}
