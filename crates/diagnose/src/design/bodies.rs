//! Candidates of link inertia: errors of links, and loads on them.

use armident_dynamics::RigidArm;
use armident_effects::{LinkInertiaError, Payload};
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, symmetric_eigen};
use nalgebra::{Matrix3, Vector3};

use crate::design::candidate::Location;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::{Design, push_law};

/// Root mean square effort of a direction, as a share of the noise, below which it is not excited.
const LEAST_SHOWN: f64 = 0.05;

/// Standard parameters of a link one by one, each with a large value.
fn any_errors() -> Vec<[f64; 10]> {
    const SCALE: [f64; 10] = [1.0, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1];
    let along = |k: usize| std::array::from_fn(|p| if p == k { SCALE[p] } else { 0.0 });
    (0..SCALE.len()).map(along).collect()
}

/// Loads on a link whose centres are not far from this place: a kilogram there, and as much moment as it has 0.3 m off
/// along each axis. To first order in the distance, with which the inertia of a load changes too.
fn loads_near(place_m: &Vector3<f64>) -> Vec<[f64; 10]> {
    const DISTANCE_M: f64 = 0.3;
    let load =
        |at_m: Vector3<f64>| InertialParameters::from_com(1.0, at_m, Matrix3::zeros()).to_array();
    let moved = |axis: usize| -> [f64; 10] {
        let step = Vector3::ith(axis, DISTANCE_M);
        let (ahead, behind) = (load(place_m + step), load(place_m - step));
        // the square of the distance drops out
        std::array::from_fn(|p| 0.5 * (ahead[p] - behind[p]))
    };
    std::iter::once(load(*place_m)).chain((0..3).map(moved)).collect()
}

impl Design<'_> {
    /// An error of each link and a load on the last one; with a reference also loads on the others.
    pub(crate) fn push_links(&self, problem: &mut LinearProblem) {
        for link in 0..self.joints() {
            self.push_link(problem, link, &any_errors());
        }
        let weighed = self.push_payload(problem);
        if self.observations.comparison.seeks_change() {
            let arm = RigidArm::from_chain(self.chain);
            let loaded = self.joints() - usize::from(weighed);
            for (link, body) in arm.links.iter().enumerate().take(loaded) {
                self.push_link(problem, link, &loads_near(&body.com_m()));
            }
        }
    }

    /// A load: mass and first moment of the last link; its own inertia is small beside them. Returns whether its mass is
    /// excited.
    fn push_payload(&self, problem: &mut LinearProblem) -> bool {
        let last = self.joints() - 1;
        let rows = problem.observations.effective();
        let (columns, not_shown): (Vec<usize>, Vec<usize>) = (10 * last..10 * last + 4)
            .partition(|&k| problem.product(k, k) > LEAST_SHOWN * LEAST_SHOWN * rows);
        if columns.first() != Some(&(10 * last)) {
            return false;
        }
        let transform = columns
            .iter()
            .map(|k| (0..10).map(|p| f64::from(u8::from(10 * last + p == *k))).collect())
            .collect();
        let errors = any_errors();
        let hidden = not_shown.iter().map(|k| errors[k - 10 * last].to_vec()).collect();
        let columns = if !self.observations.comparison.seeks_change() {
            columns
        } else {
            columns.iter().map(|&k| self.push_changed(problem, k)).collect()
        };
        let location = Location { joints: vec![last], window: None };
        let candidate = push_law(problem, &Payload, location, &[], columns, 0);
        problem.candidates[candidate].transform = Some(transform);
        problem.candidates[candidate].hidden = hidden;
        true
    }

    /// A link with these errors: their combinations that are excited.
    fn push_link(&self, problem: &mut LinearProblem, link: usize, errors: &[[f64; 10]]) {
        let rows = problem.observations.effective();
        let product = |i: usize, j: usize| -> f64 {
            let across = |p: usize| -> f64 {
                let products = (0..10).map(|q| problem.product(10 * link + p, 10 * link + q));
                products.zip(errors[j]).map(|(product, e)| product * e).sum()
            };
            (0..10).map(|p| errors[i][p] * across(p)).sum::<f64>() / rows
        };
        let count = errors.len();
        let Ok((values, vectors)) = symmetric_eigen(&Mat::from_fn(count, count, product)) else {
            return;
        };
        let (shown, hidden): (Vec<usize>, Vec<usize>) =
            (0..count).rev().partition(|k| values[*k] > LEAST_SHOWN * LEAST_SHOWN);
        if shown.is_empty() {
            return;
        }
        let direction = |k: usize| -> Vec<f64> {
            let entry = |p: usize| (0..count).map(|i| errors[i][p] * vectors[(i, k)]).sum();
            (0..10).map(entry).collect()
        };
        let transform: Vec<Vec<f64>> = shown.into_iter().map(&direction).collect();
        let mut ids = Vec::new();
        for direction in &transform {
            let mut blocks = vec![Vec::new(); self.joints()];
            for (j, block) in blocks.iter_mut().enumerate() {
                if (0..10).all(|p| problem.columns[10 * link + p][j].is_empty()) {
                    continue;
                }
                let mut sum = vec![0.0; self.observations.len()];
                for (p, x) in direction.iter().enumerate() {
                    for (s, c) in sum.iter_mut().zip(&problem.columns[10 * link + p][j]) {
                        *s += x * c;
                    }
                }
                self.observations.fill_before_laws(&mut sum);
                *block = sum;
            }
            ids.push(problem.push_columns(vec![blocks]));
        }
        let location = Location { joints: vec![link], window: None };
        let candidate = push_law(problem, &LinkInertiaError, location, &[], ids, 0);
        problem.candidates[candidate].transform = Some(transform);
        problem.candidates[candidate].hidden = hidden.into_iter().map(direction).collect();
    }

    /// Adds a column that is another one from the change on.
    fn push_changed(&self, problem: &mut LinearProblem, column: usize) -> usize {
        let mut blocks = problem.columns[column].clone();
        for block in blocks.iter_mut().filter(|b| !b.is_empty()) {
            self.observations.fill_before_laws(block);
        }
        problem.push_columns(vec![blocks])
    }
}
