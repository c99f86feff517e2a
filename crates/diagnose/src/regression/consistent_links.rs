//! Projection of the links of an estimate to physically consistent ones.
//!
//! An estimate is linear in the links and has no constraint on masses and inertias: a link with little influence on the
//! efforts may get a negative mass. Such a model cannot be simulated, and it predicts worse.
//!
//! Method: nearest physically consistent links in the metric of the estimate's information, a semidefinite programme; then all
//! other candidates are fitted again with these links.
//! References: S. Traversaro, S. Brossette, A. Escande, F. Nori, Identification of fully physical consistent inertial
//! parameters using optimization on manifolds, IROS 2016; P. M. Wensing, S. Kim, J.-J. E. Slotine, Linear matrix inequalities
//! for physically consistent inertial parameter identification, IEEE Robotics and Automation Letters 3(1), 2018.

use armident_dynamics::RigidArm;
use armident_ident::{ConsistencyProblem, MinimalSet};
use armident_kinematics::{DrivingAxisChain, InertialParameters};
use armident_numeric::{Mat, information_root};

use crate::design::candidate::Candidate;
use crate::regression::admissible::all_admissible;
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::{LeastSquaresFit, Marginalised};
use armident_model::changed;

/// Prior scale of a link that is a candidate of its own: nothing is known of it...
const NAMED: f64 = 3.2;
/// ... and of all others: rounding of a URDF.
const ROUNDED: f64 = 1e-3;
const TEN: usize = InertialParameters::COUNT;

/// Links of an estimate, and the coefficients of the laws beside them.
pub(crate) struct ConsistentEstimate {
    /// change of the standard parameters, ten a link, and of baseline terms with a reference
    pub(crate) change: Vec<f64>,
    /// of every candidate of the estimate
    pub(crate) coefficients: Vec<Vec<f64>>,
    /// distance of the links from the estimate's in standard errors, where these are not consistent
    pub(crate) distance_in_standard_errors: Option<f64>,
}

impl ConsistentEstimate {
    /// The estimate's own links.
    pub(crate) fn of(metric: &Marginalised<'_>, estimate: &Estimate) -> Self {
        let candidates = &metric.problem.candidates;
        let mut change = metric.inertial_errors(&estimate.fit);
        let mut coefficients = Vec::new();
        for &g in &estimate.set {
            let of_candidate = estimate.fit.of_candidate(&candidates[g]);
            candidates[g].add_to_links(&of_candidate, &mut change);
            coefficients.push(of_candidate);
        }
        Self { change, coefficients, distance_in_standard_errors: None }
    }

    /// Whether all links of the arm are physically consistent with this change.
    fn is_consistent(&self, arm: &RigidArm) -> bool {
        let changes = self.change.chunks(TEN);
        arm.links.iter().zip(changes).all(|(link, change)| changed(link, change).is_physical())
    }
}

/// An estimate with physically consistent links: its own, or the projection of these with the laws refitted.
pub(crate) fn consistent_estimate(
    chain: &DrivingAxisChain,
    metric: &Marginalised<'_>,
    estimate: &Estimate,
) -> ConsistentEstimate {
    let arm = RigidArm::from_chain(chain);
    let settled = ConsistentEstimate::of(metric, estimate);
    // where a change is sought, the reference holds the links
    if metric.problem.observations.comparison.seeks_change() || settled.is_consistent(&arm) {
        return settled;
    }
    nearest(&arm, metric, estimate).unwrap_or(settled)
}

fn nearest(
    arm: &RigidArm,
    metric: &Marginalised<'_>,
    estimate: &Estimate,
) -> Option<ConsistentEstimate> {
    let problem = metric.problem;
    let links = arm.links.len();
    // links that are laws of their own become errors of links, which have a size and an information
    let named: Vec<usize> = (estimate.set.iter().map(|g| &problem.candidates[*g]))
        .filter(|candidate| candidate.transform.is_some())
        .filter_map(|candidate| candidate.location.joints.first().copied())
        .collect();
    let size = |link: usize| match named.contains(&link) {
        true => NAMED,
        false => metric.size_of(link).max(ROUNDED),
    };
    let sizes: Vec<f64> = (0..links).map(size).collect();
    let mut elimination = problem.elimination_of(&sizes);
    let marginalised = problem.marginalised_by(&mut elimination);
    let is_law = |g: &usize| problem.candidates[*g].transform.is_none();
    let laws: Vec<usize> = estimate.set.iter().copied().filter(is_law).collect();
    let fit = marginalised.fit(marginalised.columns_of(&laws))?;
    let change = marginalised.inertial_errors(&fit);

    let set = MinimalSet::of(arm).ok()?;
    let consistency = ConsistencyProblem::new(arm, &set, &[]);
    let map = consistency.map();
    let factors = marginalised.link_factors(&laws, &fit)?;
    let through: Vec<Vec<f64>> = (factors.iter())
        .map(|row| {
            (0..set.len()).map(|c| (0..TEN * links).map(|p| map[(c, p)] * row[p]).sum()).collect()
        })
        .collect();
    let covariance = Mat::from_fn(set.len(), set.len(), |a, b| {
        through.iter().map(|row: &Vec<f64>| row[a] * row[b]).sum()
    });
    let found: Vec<f64> = (set.values(&arm.constants()).iter().enumerate())
        .map(|(c, given)| given + (0..TEN * links).map(|p| map[(c, p)] * change[p]).sum::<f64>())
        .collect();
    let consistent = consistency.nearest(&found, &information_root(&covariance).ok()?).ok()?;
    let change: Vec<f64> = (consistent.links.iter().zip(&arm.links))
        .flat_map(|(consistent, given)| {
            let (consistent, given) = (consistent.to_array(), given.to_array());
            (0..TEN).map(move |p| consistent[p] - given[p])
        })
        .collect();
    let coefficients = beside(metric, estimate, &fit, &change)?;
    let distance_in_standard_errors =
        (!consistent.exact).then_some(consistent.distance_in_standard_errors);
    Some(ConsistentEstimate { change, coefficients, distance_in_standard_errors })
}

/// Coefficients of every candidate of an estimate with the links as they are now; those of links become none.
fn beside(
    metric: &Marginalised<'_>,
    estimate: &Estimate,
    fit: &LeastSquaresFit,
    change: &[f64],
) -> Option<Vec<Vec<f64>>> {
    // of all columns those of the estimate, its candidates numbered as they stand in it
    let (small, _) = metric.problem.restricted(&estimate.set);
    let candidates = || small.candidates.iter().zip(&estimate.set);
    // operating terms and gains of channels keep their coefficients
    let stays = |candidate: &Candidate| candidate.has(|law| law.operating.is_some());
    let mut taken: Vec<(usize, f64)> = change.iter().map(|x| -x).enumerate().collect();
    let mut fitted = Vec::new();
    for (k, (candidate, g)) in candidates().enumerate() {
        if stays(candidate) {
            let own = estimate.fit.of_candidate(&metric.problem.candidates[*g]);
            taken.extend(candidate.columns.iter().copied().zip(own.iter().map(|x| -x)));
        } else if candidate.transform.is_none() {
            fitted.push(k);
        }
    }
    let left = small.with_added(&taken);
    let marginalised = left.marginalised(0.0, &[]);
    let again = marginalised.fit(marginalised.columns_of(&fitted))?;
    let admissible = all_admissible(&left, &fitted, &again);
    let of_candidate = |(candidate, g): (&Candidate, &usize)| {
        let before = &metric.problem.candidates[*g];
        if candidate.transform.is_some() {
            vec![0.0; candidate.columns.len()]
        } else if stays(candidate) {
            estimate.fit.of_candidate(before)
        } else if admissible {
            again.of_candidate(candidate)
        } else {
            fit.of_candidate(before)
        }
    };
    Some(candidates().map(of_candidate).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::fit_set::fit_set;
    use crate::test_arms::{design, ur5};
    use armident_model::OperatingPoint;

    /// The consistent estimate of an arm whose link 5 has this many times its mass and first moment.
    fn consistent_with_mass_factor(factor: f64) -> (RigidArm, ConsistentEstimate) {
        const LINK: usize = 4;
        let chain = ur5();
        let mut other = chain.clone();
        let link = other.joints[LINK].link.to_array();
        let mut change = [0.0; TEN];
        for (change, x) in change.iter_mut().zip(link).take(4) {
            *change = (factor - 1.0) * x;
        }
        other.joints[LINK].link = changed(&other.joints[LINK].link, &change);
        let design = design(&chain, &other, |_, _| 0.0);
        let point = OperatingPoint::of(design.joints());
        let problem = design.problem(&point);
        let named = problem
            .candidates
            .iter()
            .position(|g| g.slug() == "link_inertia_error" && g.location.joints == [LINK]);
        let metric = problem.marginalised(0.0, &[]);
        let found = fit_set(&metric, vec![named.unwrap()]).unwrap();
        (RigidArm::from_chain(&chain), consistent_estimate(&chain, &metric, &found))
    }

    #[test]
    fn negative_mass_is_projected_and_heavy_link_kept() {
        let (arm, heavy) = consistent_with_mass_factor(1.5);
        assert!(heavy.is_consistent(&arm) && heavy.distance_in_standard_errors.is_none());
        let (arm, light) = consistent_with_mass_factor(-2.0);
        assert!(light.is_consistent(&arm));
        // with noise of 0.05 N m the missing 0.6 kg are significant
        assert!(light.distance_in_standard_errors.unwrap() > 10.0);
    }
}
