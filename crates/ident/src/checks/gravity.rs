//! Where gravity points, as the efforts of all joints show.
//!
//! Method: Gauss-Newton over the constants, the friction and the two angles of a direction, about the direction so far, to
//! convergence: no linearisation about the given direction is left, at any angle. The covariance of the direction is that of
//! the jackknife over blocks of time, which counts the correlation of the residual; its radius is the 95 % quantile of
//! Hotelling's T² of two components.
//!
//! References: H. R. Künsch, The jackknife and the bootstrap for general stationary observations, Annals of Statistics 17
//! (1989); H. Hotelling, The generalization of Student's ratio (1931).

use armident_inference::f_quantile;
use armident_numeric::{Cholesky, Mat};
use nalgebra::{Matrix2, Vector2, Vector3};

use super::arm_columns::{ArmColumns, JointProducts, beyond_first};
use super::arm_likelihood::{ArmFit, ConstantPrior, Meaning};

/// Steps of the refinement: each squares the error.
const STEPS: usize = 8;
/// Change of the direction at which it has converged \[rad\].
const CONVERGED_RAD: f64 = 1e-6;
/// Longest step \[rad\]: beyond, the tangent is no direction.
const LONGEST_RAD: f64 = 0.5;

/// The direction of gravity that recordings show.
#[derive(Debug, Clone, PartialEq)]
pub struct GravityDirectionFound {
    /// Gravity in the base link frame \[m/s²\].
    pub gravity_base: [f64; 3],
    /// Angle to the given one \[degrees\].
    pub angle_deg: f64,
    /// Its 95 % interval \[degrees\].
    pub interval_95_deg: [f64; 2],
    /// Radius of the 95 % region of the direction \[degrees\].
    pub radius_95_deg: f64,
}

/// Largest radius of a region within which the axis of the base is as good as the direction found \[degrees\].
const AXIS_WITHIN_DEG: f64 = 2.0;

impl GravityDirectionFound {
    /// Gravity in the base link frame \[m/s²\]: along an axis of the base where the 95 % region holds one.
    pub fn rounded(&self) -> [f64; 3] {
        let found = Vector3::from(self.gravity_base);
        let within = self.radius_95_deg.min(AXIS_WITHIN_DEG).to_radians();
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let near = axes.iter().flat_map(|a| [*a, -a]).find(|a| a.angle(&found) < within);
        near.map_or(found, |axis| axis * found.norm()).into()
    }

    /// The value of `--gravity`.
    pub fn option(&self) -> String {
        let of = |x: f64| {
            let text = format!("{x:.3}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            if text == "-0" { "0".to_owned() } else { text.to_owned() }
        };
        self.rounded().map(of).join(",")
    }
}

/// A direction, and its covariance in the plane across it.
pub(super) struct Direction {
    /// \[m/s²\], in `E_0`
    pub(super) gravity: Vector3<f64>,
    /// two axes across it, and the covariance along them \[rad²\]
    pub(super) across: [Vector3<f64>; 2],
    pub(super) covariance: Matrix2<f64>,
    pub(super) blocks: usize,
}

impl Direction {
    /// Half-width of the 95 % region over the standard deviation along a line across gravity.
    fn quantile(&self) -> f64 {
        let freedom = self.blocks as f64 - 1.0;
        if freedom < 2.0 {
            return f64::INFINITY;
        }
        // T² of two components is 2 f / (f - 1) F(2, f - 1)
        let quantile = f_quantile(0.95, 2.0, freedom - 1.0).unwrap_or(f64::INFINITY);
        (2.0 * freedom / (freedom - 1.0) * quantile).sqrt()
    }

    /// Radius of the 95 % region \[rad\].
    pub(super) fn radius_rad(&self) -> f64 {
        let largest = self.covariance.symmetric_eigenvalues().max().max(f64::MIN_POSITIVE);
        (self.quantile() * largest.sqrt()).min(std::f64::consts::PI)
    }

    /// Angle to another direction, and the half-width that the 95 % region has along it \[rad\].
    pub(super) fn angle_to(&self, other: &Vector3<f64>) -> (f64, f64) {
        let here = self.gravity.normalize();
        let angle = here.angle(other);
        let towards = other - here * here.dot(other);
        let along = Vector2::new(self.across[0].dot(&towards), self.across[1].dot(&towards));
        let radius = self.radius_rad();
        // within the region the angle turns over: to the other direction, or its opposite
        let is_near = angle.min(std::f64::consts::PI - angle) <= radius || along.norm() == 0.0;
        if is_near {
            return (angle, radius);
        }
        let variance = (along.transpose() * self.covariance * along)[(0, 0)] / along.norm_squared();
        (angle, (self.quantile() * variance.max(0.0).sqrt()).min(std::f64::consts::PI))
    }
}

/// The most likely direction near one, and its covariance.
pub(super) fn refine(
    columns: &ArmColumns<'_>,
    products: &[JointProducts],
    prior: &ConstantPrior,
    start: &Vector3<f64>,
    fit_at: &dyn Fn(&Vector3<f64>) -> ArmFit,
) -> Option<Direction> {
    let size = start.norm();
    let mut gravity = *start;
    let mut fit = fit_at(&gravity);
    let whole: Vec<Mat<f64>> = products.iter().map(|of| of.sum(|_| true)).collect();
    for _ in 0..STEPS {
        let step = step(columns, products, &whole, prior, &gravity, &fit)?;
        let across = across(&gravity);
        let short = LONGEST_RAD / step.norm().max(LONGEST_RAD);
        let moved = gravity + size * short * (across[0] * step[0] + across[1] * step[1]);
        gravity = moved * (size / moved.norm());
        fit = fit_at(&gravity);
        if step.norm() < CONVERGED_RAD {
            break;
        }
    }
    let blocks = products.first()?.blocks.len();
    let steps: Vec<Vector2<f64>> = (0..blocks)
        .map(|b| {
            let without: Vec<Mat<f64>> =
                products.iter().zip(&whole).map(|(of, all)| all - &of.blocks[b]).collect();
            step(columns, products, &without, prior, &gravity, &fit)
        })
        .collect::<Option<_>>()?;
    let mean = steps.iter().sum::<Vector2<f64>>() / blocks as f64;
    let spread: Matrix2<f64> =
        steps.iter().map(|s| (s - mean) * (s - mean).transpose()).sum::<Matrix2<f64>>();
    let covariance = spread * ((blocks as f64 - 1.0) / blocks as f64);
    Some(Direction { gravity, across: across(&gravity), covariance, blocks })
}

/// Two axes across a direction.
fn across(gravity: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let along = gravity.normalize();
    let aside = if along.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let first = along.cross(&aside).normalize();
    [first, along.cross(&first)]
}

/// Turn of gravity \[rad\] that these rows ask for about a fit.
fn step(
    columns: &ArmColumns<'_>,
    products: &[JointProducts],
    sums: &[Mat<f64>],
    prior: &ConstantPrior,
    gravity: &Vector3<f64>,
    fit: &ArmFit,
) -> Option<Vector2<f64>> {
    let m = prior.mean.len();
    let size = gravity.norm();
    let tangents = across(gravity).map(|axis| (axis * size, fit.x.clone()));
    let mut information = Mat::<f64>::zeros(m + 2, m + 2);
    let mut rhs = vec![0.0; m + 2];
    for (j, of) in products.iter().enumerate() {
        if fit.variance[j] == f64::INFINITY {
            continue;
        }
        let with_spring = fit.meaning[j] == Meaning::Compliant;
        let all = of.at_gravity(&sums[j], gravity, with_spring, &tangents);
        let first = of.friction + if with_spring { of.spring } else { 0 };
        let beyond = beyond_first(&all, first);
        let z = of.constants.len();
        let weight = columns.independent[of.effort]
            / (columns.samples[of.effort].max(1.0) * fit.variance[j]);
        let b = fit.gain[j];
        // parameters: standardised constants, then the turn
        let design = prior.standardised_with(&of.constants, 2);
        let square = Mat::from_fn(z + 2, z + 2, |i, k| beyond[(i, k)]);
        let half = &square * &design;
        let full = design.transpose() * &half;
        information += Mat::from_fn(m + 2, m + 2, |i, k| weight * b * b * full[(i, k)]);
        // residual at the mean of the prior
        let left: Vec<f64> = (0..z + 2)
            .map(|i| {
                let mean: f64 = (0..z).map(|k| beyond[(i, k)] * prior.mean[of.constants[k]]).sum();
                beyond[(i, z + 2)] - b * mean
            })
            .collect();
        for (k, r) in rhs.iter_mut().enumerate() {
            *r += weight * b * (0..z + 2).map(|i| design[(i, k)] * left[i]).sum::<f64>();
        }
    }
    let scale: Vec<f64> = (0..m + 2)
        .map(|k| (information[(k, k)] + f64::from(u8::from(k < m))).max(f64::MIN_POSITIVE).sqrt())
        .collect();
    let entry = |i: usize, j: usize| {
        let own = if i == j && i < m { 1.0 } else { 0.0 };
        (information[(i, j)] + own) / (scale[i] * scale[j]) + if i == j { 1e-12 } else { 0.0 }
    };
    let scaled: Vec<f64> = rhs.iter().zip(&scale).map(|(r, s)| r / s).collect();
    let solved = Cholesky::of(m + 2, entry)?.solve(&scaled);
    Some(Vector2::new(solved[m] / scale[m], solved[m + 1] / scale[m + 1]))
}
