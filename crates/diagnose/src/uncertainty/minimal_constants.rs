//! The minimal set of the diagnosed arm: every constant with its standard error and prior share.
//!
//! Links have the prior `π ~ N(π₀, D)` and the laws beside them none; the posterior of both is Gaussian. Constants are linear
//! in the links, `x = T π`, and so is their posterior.
//!
//! Method: linear transformation of the posterior of the links.
//! References: M. Gautier, W. Khalil, Direct calculation of minimum set of inertial parameters of serial robots, IEEE
//! Transactions on Robotics and Automation 6(3), 1990.

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_kinematics::InertialParameters;
use armident_model::ArmModel;
use armident_numeric::dot;
use serde::Serialize;

use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;

/// 97.5 % quantile of the normal distribution.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

/// One constant of the minimal set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConstantEstimate {
    /// Label of the paper.
    pub label: String,
    /// Joint name.
    pub joint: String,
    /// Unit.
    pub unit: &'static str,
    /// Value of the diagnosed model.
    pub value: f64,
    /// Standard error, all findings fitted too.
    pub standard_error: f64,
    /// 95 % interval.
    pub interval_95: [f64; 2],
    /// Value of the given model.
    pub urdf: f64,
    /// Posterior over prior variance, 0 to 1: near 1 the value is that of the given model.
    pub from_prior: f64,
}

/// All constants, and the correlations of their errors.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ConstantEstimates {
    /// Constants in the order of the minimal set.
    pub constants: Vec<ConstantEstimate>,
    /// Correlation of every pair; none of a constant that does not vary.
    #[serde(skip)]
    pub correlation: Vec<Vec<Option<f64>>>,
}

/// The constants of an estimate; none where inertias were not in question or the set cannot be determined.
pub(crate) fn constants(
    given: &ArmModel,
    found: &ArmModel,
    metric: &Marginalised<'_>,
    estimate: &Estimate,
) -> Option<ConstantEstimates> {
    let arm = RigidArm::from_chain(&given.chain);
    let set = MinimalSet::of(&arm).ok()?;
    // columns of T
    let unit_values = |link: usize, number: usize| {
        let mut unit = [0.0; InertialParameters::COUNT];
        unit[number] = 1.0;
        let mut alone = arm.clone();
        alone.links.fill(InertialParameters::zero());
        alone.links[link] = InertialParameters::from_array(&unit);
        set.values(&alone.constants())
    };
    let count = InertialParameters::COUNT * arm.links.len();
    let map: Vec<Vec<f64>> = (0..count)
        .map(|p| unit_values(p / InertialParameters::COUNT, p % InertialParameters::COUNT))
        .collect();
    let through = |spread: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let of = |row: &Vec<f64>| -> Vec<f64> {
            (0..set.len()).map(|c| (0..count).map(|p| map[p][c] * row[p]).sum()).collect()
        };
        spread.iter().map(of).collect()
    };
    // factors of the covariances: rows whose outer products add up
    let posterior = through(&metric.link_factors(&estimate.set, &estimate.fit)?);
    let prior = through(&metric.prior_factors()?);
    let covariance =
        |rows: &[Vec<f64>], a: usize, b: usize| -> f64 { rows.iter().map(|r| r[a] * r[b]).sum() };
    let values = set.values(&RigidArm::from_chain(&found.chain).constants());
    let urdf = set.values(&arm.constants());
    let variance: Vec<f64> = (0..set.len()).map(|c| covariance(&posterior, c, c)).collect();
    let constants = set
        .constants
        .iter()
        .enumerate()
        .map(|(c, constant)| {
            let standard_error = variance[c].sqrt();
            let half = TWO_SIDED_95 * standard_error;
            ConstantEstimate {
                label: constant.label(),
                joint: given.chain.joints[constant.joint].name.clone(),
                unit: constant.unit(),
                value: values[c],
                standard_error,
                interval_95: [values[c] - half, values[c] + half],
                urdf: urdf[c],
                from_prior: (variance[c] / covariance(&prior, c, c)).min(1.0),
            }
        })
        .collect();
    let pair = |a: usize, b: usize| {
        let correlation = covariance(&posterior, a, b) / (variance[a] * variance[b]).sqrt();
        correlation.is_finite().then(|| (100.0 * correlation).round() / 100.0)
    };
    let correlation =
        (0..set.len()).map(|a| (0..set.len()).map(|b| pair(a, b)).collect()).collect();
    Some(ConstantEstimates { constants, correlation })
}

impl Marginalised<'_> {
    /// Observations whose outer products add up to the posterior covariance of all links' parameters, laws fitted
    /// along. None without inertial errors.
    pub(crate) fn link_factors(
        &self,
        set: &[usize],
        fit: &crate::regression::marginalised::LeastSquaresFit,
    ) -> Option<Vec<Vec<f64>>> {
        let [mut rows, sensitivity] = self.inertial_posterior(fit)?;
        // change of the links with the coefficients of laws: through the link errors, and directly
        let mut by_column = sensitivity;
        for candidate in set.iter().map(|g| &self.problem.candidates[*g]) {
            let (Some(transform), Some(&joint)) =
                (&candidate.transform, candidate.location.joints.first())
            else {
                continue;
            };
            for (column, t) in candidate.columns.iter().zip(transform) {
                let Some(k) = fit.columns.iter().position(|c| c == column) else { continue };
                for (p, t) in t.iter().enumerate() {
                    by_column[k][InertialParameters::COUNT * joint + p] += t;
                }
            }
        }
        // Σ = F F' with the rows of F from the fit's own triangle
        for factor in self.coefficient_factors(fit) {
            let row = (0..self.problem.rigid)
                .map(|p| {
                    let column: Vec<f64> = by_column.iter().map(|s| s[p]).collect();
                    dot(&factor, &column)
                })
                .collect();
            rows.push(row);
        }
        Some(rows)
    }
}
