//! What a motion tells about the constants of an arm.
//!
//! Fisher information of the minimal inertia set and of viscous friction, Coulomb friction and offset of each joint, with
//! independent noise on each recorded effort:
//!
//! ```text
//! F = Σ_joints σ_j⁻² X_jᵀ X_j,    standard errors = sqrt(diag F⁻¹)
//! ```
//!
//! References: V. V. Fedorov, Theory of optimal experiments, Academic Press, 1972.

use armident_dynamics::{ArmMotion, RigidArm, constants_from_links};
use armident_effects::{
    CoulombFriction, Effect, JointMotion, TorqueOffset, ViscousFriction, directions_with,
};
use armident_ident::MinimalSet;
use armident_numeric::{Cholesky, Mat, NumericError, gram_of_columns, symmetric_eigen};

/// Laws of each joint that are estimated beside the minimal set.
pub(crate) const JOINT_LAWS: [&dyn Effect; 3] = [&ViscousFriction, &CoulombFriction, &TorqueOffset];

/// Step of the derivatives of the regressor \[rad, rad/s, rad/s² or the same in m\]: entries are some units, so that
/// differences are right to seven digits.
const STEP: f64 = 1e-6;

/// Speed below which dry friction has no direction \[rad/s or m/s\]: rounding at the ends, where the motion rests.
pub(crate) const REST_SPEED: f64 = 1e-9;

/// Of each joint, the parameter of each column and the columns `[column][sample]`.
pub(crate) type Regressors = Vec<(Vec<usize>, Vec<Vec<f64>>)>;

/// Positions, velocities and accelerations of all joints: `[derivative][joint][sample]`.
pub(crate) type Columns = [Vec<Vec<f64>>; 3];

/// What is estimated on an arm, and from efforts of which noise.
#[derive(Debug)]
pub(crate) struct Parameters<'a> {
    pub(crate) arm: &'a RigidArm,
    pub(crate) set: &'a MinimalSet,
    /// values of the minimal set
    values: Vec<f64>,
    /// standard deviation of one recorded effort by joint \[N m or N\]
    pub(crate) noise: Vec<f64>,
    /// what earlier recordings have given, for as many samples of the new motion as one of the search stands for
    pub(crate) given: Option<Information>,
}

impl<'a> Parameters<'a> {
    pub(crate) fn new(arm: &'a RigidArm, set: &'a MinimalSet, noise: Vec<f64>) -> Self {
        let values = set.values(&constants_from_links(&arm.joints, &arm.links));
        Self { arm, set, values, noise, given: None }
    }

    /// Values of the minimal set.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of parameters.
    pub(crate) fn len(&self) -> usize {
        self.set.len() + JOINT_LAWS.len() * self.arm.dof()
    }

    /// Columns of one joint: the minimal set, then its own laws.
    fn columns(&self, joint: usize, motion: &ArmMotion<'_>, own: [&[f64]; 3]) -> Vec<Vec<f64>> {
        let all: Vec<usize> = (0..self.set.len()).collect();
        let mut columns = self.set.columns().of_arm_motion(self.arm, joint, motion, &all);
        columns.extend(self.law_columns(joint, own, &directions_with(own[1], REST_SPEED)));
        columns
    }

    fn law_columns(
        &self,
        joint: usize,
        [position, velocity, acceleration]: [&[f64]; 3],
        direction: &[f64],
    ) -> Vec<Vec<f64>> {
        let motion = JointMotion {
            kind: self.arm.joints[joint].kind,
            time_s: &[],
            position,
            velocity,
            acceleration,
            direction,
            rigid_effort: &[],
            temperature_c: &[],
        };
        JOINT_LAWS.iter().flat_map(|law| law.columns(&[], &motion)).collect()
    }

    /// Place of each column of a joint among the parameters.
    fn places(&self, joint: usize) -> Vec<usize> {
        let laws = self.set.len() + JOINT_LAWS.len() * joint;
        (0..self.set.len()).chain(laws..laws + JOINT_LAWS.len()).collect()
    }

    /// Efforts of the rigid body `[joint][sample]`.
    pub(crate) fn efforts(&self, [q, dq, ddq]: &Columns) -> Vec<Vec<f64>> {
        ArmMotion::new(q, dq, ddq).efforts(self.arm)
    }

    /// Columns of all parameters on each joint `[joint][column][sample]`, with the parameter of each.
    pub(crate) fn regressors(&self, columns: &Columns) -> Regressors {
        let [q, dq, ddq] = columns;
        let motion = ArmMotion::new(q, dq, ddq);
        (0..self.arm.dof())
            .map(|joint| {
                let own = [0, 1, 2].map(|k| columns[k][joint].as_slice());
                (self.places(joint), self.columns(joint, &motion, own))
            })
            .collect()
    }

    /// Information of a motion, each sample as one recorded effort of each joint.
    pub(crate) fn information(&self, columns: &Columns) -> Information {
        let [q, dq, ddq] = columns;
        let motion = ArmMotion::new(q, dq, ddq);
        let mut information = Information::none(self.len());
        for joint in 0..self.arm.dof() {
            let own = [0, 1, 2].map(|k| columns[k][joint].as_slice());
            let of_joint = self.columns(joint, &motion, own);
            information.add(&self.places(joint), &of_joint, self.noise[joint]);
        }
        information
    }

    /// `log det F` and the efforts, with the derivatives of the former in each sample of the motion, and of a sum of
    /// squares `Σ weight² (effort excess)²`, see `excess`, subtracted from it. None where `F` is singular.
    pub(crate) fn ascent(
        &self,
        columns: &Columns,
        excess: impl Fn(usize, f64) -> (f64, f64),
    ) -> Option<Ascent> {
        let [q, dq, ddq] = columns;
        let n = self.arm.dof();
        let samples = q[0].len();
        let motion = ArmMotion::new(q, dq, ddq);
        let own = |joint: usize| [0, 1, 2].map(|k| columns[k][joint].as_slice());
        let by_joint: Vec<Vec<Vec<f64>>> =
            (0..n).map(|joint| self.columns(joint, &motion, own(joint))).collect();
        let mut information = self.given.clone().unwrap_or_else(|| Information::none(self.len()));
        for joint in 0..n {
            information.add(&self.places(joint), &by_joint[joint], self.noise[joint]);
        }
        let factor = Cholesky::of(self.len(), |i, j| information.matrix[(i, j)])?;
        let inverse = factor.inverse();
        let mut value = factor.log_determinant();
        // dJ/dX: 2 σ⁻² X F⁻¹, and the slope of the penalty in the effort times the values
        let mut slopes: Vec<Mat<f64>> = Vec::with_capacity(n);
        for joint in 0..n {
            let places = self.places(joint);
            let of_joint = &by_joint[joint];
            let weight = 2.0 / self.noise[joint].powi(2);
            let x = Mat::from_fn(samples, places.len(), |t, c| of_joint[c][t]);
            let part = Mat::from_fn(places.len(), places.len(), |a, b| {
                weight * inverse[(places[a], places[b])]
            });
            let mut slope = &x * &part;
            for t in 0..samples {
                let effort: f64 =
                    self.values.iter().zip(of_joint).map(|(value, c)| value * c[t]).sum();
                let (penalty, of_effort) = excess(joint, effort);
                value -= penalty;
                if of_effort != 0.0 {
                    for (c, of) in self.values.iter().enumerate() {
                        slope[(t, c)] -= of_effort * of;
                    }
                }
            }
            slopes.push(slope);
        }
        let mut gradient: Columns = [0, 1, 2].map(|_| vec![vec![0.0; samples]; n]);
        for moved in 0..n {
            // dry friction jumps, and has no slope elsewhere
            let direction = directions_with(own(moved)[1], REST_SPEED);
            for k in 0..3 {
                let mut signals = own(moved);
                let shifted: Vec<f64> = signals[k].iter().map(|x| x + STEP).collect();
                signals[k] = &shifted;
                let other = motion.with_joint(moved, signals);
                for joint in 0..n {
                    let all: Vec<usize> = (0..self.set.len()).collect();
                    let mut changed =
                        self.set.columns().of_arm_motion(self.arm, joint, &other, &all);
                    if joint == moved {
                        changed.extend(self.law_columns(joint, signals, &direction));
                    }
                    for (c, changed) in changed.iter().enumerate() {
                        let before = &by_joint[joint][c];
                        for t in 0..samples {
                            gradient[k][moved][t] +=
                                slopes[joint][(t, c)] * (changed[t] - before[t]) / STEP;
                        }
                    }
                }
            }
        }
        Some(Ascent { value, gradient })
    }
}

/// Value of the objective and its derivatives in the samples of the motion.
pub(crate) struct Ascent {
    pub(crate) value: f64,
    pub(crate) gradient: Columns,
}

/// Fisher information of some motions.
#[derive(Debug, Clone)]
pub struct Information {
    matrix: Mat<f64>,
}

impl Information {
    fn none(parameters: usize) -> Self {
        Self { matrix: Mat::zeros(parameters, parameters) }
    }

    fn add(&mut self, places: &[usize], columns: &[Vec<f64>], noise: f64) {
        let views: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let gram = gram_of_columns(&views);
        let weight = noise.powi(-2);
        for (a, &i) in places.iter().enumerate() {
            for (b, &j) in places.iter().enumerate() {
                self.matrix[(i, j)] += weight * gram[(a, b)];
            }
        }
    }

    /// The information of both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let (rows, columns) = (self.matrix.nrows(), self.matrix.ncols());
        let sum = |i, j| self.matrix[(i, j)] + other.matrix[(i, j)];
        Self { matrix: Mat::from_fn(rows, columns, sum) }
    }

    /// That of a share of the samples.
    #[must_use]
    pub(crate) fn times(&self, share: f64) -> Self {
        let (rows, columns) = (self.matrix.nrows(), self.matrix.ncols());
        Self { matrix: Mat::from_fn(rows, columns, |i, j| share * self.matrix[(i, j)]) }
    }

    /// Condition number of the regressor with columns of unit length; infinite where a column is zero.
    ///
    /// # Errors
    /// [`NumericError`] where the eigenvalues do not converge.
    pub fn condition(&self) -> Result<f64, NumericError> {
        let n = self.matrix.nrows();
        let size = |k: usize| self.matrix[(k, k)].sqrt();
        if (0..n).any(|k| size(k) <= 0.0) {
            return Ok(f64::INFINITY);
        }
        let scaled = Mat::from_fn(n, n, |i, j| self.matrix[(i, j)] / (size(i) * size(j)));
        let (values, _) = symmetric_eigen(&scaled)?;
        Ok((values[n - 1].max(0.0) / values[0].max(f64::MIN_POSITIVE)).sqrt())
    }

    /// `log det F`; none where it is singular.
    pub fn log_determinant(&self) -> Option<f64> {
        Cholesky::of(self.matrix.nrows(), |i, j| self.matrix[(i, j)]).map(|f| f.log_determinant())
    }

    /// Standard error of each parameter; infinite where the information is singular.
    pub fn standard_errors(&self) -> Vec<f64> {
        let n = self.matrix.nrows();
        // columns of unit length first: units differ by orders of magnitude
        let size: Vec<f64> =
            (0..n).map(|k| self.matrix[(k, k)].sqrt().max(f64::MIN_POSITIVE)).collect();
        match Cholesky::of(n, |i, j| self.matrix[(i, j)] / (size[i] * size[j])) {
            Some(factor) => {
                let diagonal = factor.inverse_diagonal();
                diagonal.iter().zip(&size).map(|(d, s)| d.sqrt() / s).collect()
            }
            None => vec![f64::INFINITY; n],
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::test_arms::{arm, stanford};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn random(samples: usize, dof: usize) -> Columns {
        let mut random = Pcg64::seed_from_u64(5);
        [0, 1, 2].map(|_| {
            let mut column = || (0..samples).map(|_| random.random_range(-1.5..1.5)).collect();
            (0..dof).map(|_| column()).collect()
        })
    }

    /// Against differences of the value itself.
    #[test]
    fn gradient_is_that_of_the_value() {
        for arm in [arm(), stanford()] {
            let set = MinimalSet::of(&arm).unwrap();
            let parameters = Parameters::new(&arm, &set, vec![0.5; arm.dof()]);
            let columns = random(60, arm.dof());
            let excess = |_: usize, effort: f64| {
                let over = (effort.abs() - 20.0).max(0.0);
                (1e-3 * over * over, 2e-3 * over * effort.signum())
            };
            let found = parameters.ascent(&columns, excess).unwrap();
            let value = |columns: &Columns| parameters.ascent(columns, excess).unwrap().value;
            let h = 1e-5;
            for (k, joint, t) in [(0, 1, 3), (1, 0, 10), (2, 2, 30), (0, 4, 44), (1, 5, 7)] {
                let mut moved = [columns.clone(), columns.clone()];
                moved[0][k][joint][t] -= h;
                moved[1][k][joint][t] += h;
                let expected = (value(&moved[1]) - value(&moved[0])) / (2.0 * h);
                let gradient = found.gradient[k][joint][t];
                assert!(
                    (gradient - expected).abs() < 1e-3 * (1.0 + expected.abs()),
                    "{k} {joint} {t}: {gradient} {expected}"
                );
            }
        }
    }

    /// Twice the samples halve the variance.
    #[test]
    fn standard_errors_fall_with_the_root_of_the_samples() {
        let arm = arm();
        let set = MinimalSet::of(&arm).unwrap();
        let parameters = Parameters::new(&arm, &set, vec![0.5; arm.dof()]);
        let once = parameters.information(&random(80, arm.dof()));
        let twice = once.with(&once);
        for (one, two) in once.standard_errors().iter().zip(twice.standard_errors()) {
            assert!((one / two - 2.0_f64.sqrt()).abs() < 1e-9);
        }
        let [one, two] = [&once, &twice].map(|i| i.condition().unwrap());
        assert!((one / two - 1.0).abs() < 1e-9);
    }
}
