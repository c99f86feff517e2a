//! The joint-effort regressor: `τ = Y(q, q̇, q̈) π`, linear in the standard parameters and in any
//! linear combinations of them, the minimal constants among them.

use std::collections::BTreeMap;

use armident_kinematics::InertialParameters;
use nalgebra::Vector3;

use crate::arm::RigidArm;
use crate::constants::{BodyConstants, links_from_constants};
use crate::kernels::for_each_row;
use crate::lanes::Column;
use crate::motion::ArmMotion;
use crate::newton_euler::{LinkMotion, Sweep};

const TEN: usize = InertialParameters::COUNT;

/// Effort per unit of each of the ten parameters of a link, at a joint whose axis has the
/// direction `u` and whose motion moves the link's origin by `a = u × s` per radian (both in the
/// link's frame). For a translational joint the axis pushes: `force_axis = u`, `moment_axis = 0`.
#[inline(always)]
fn link_row(
    motion: &LinkMotion,
    moment_axis: &Vector3<f64>,
    force_axis: &Vector3<f64>,
) -> [f64; TEN] {
    let LinkMotion { angular_velocity: w, angular_acceleration: dw, acceleration: a, gradient } =
        motion;
    // F = m a + B mc,  N = I dw + w x I w + mc x a
    let (f, u) = (force_axis, moment_axis);
    // f . B mc = mc . B' f; u . (mc x a) = mc . (a x u)
    let on_moment = gradient.tr_mul(f) + a.cross(u);
    // u . (w x I w) = (u x w) . I w
    let t = u.cross(w);
    [
        f.dot(a),
        on_moment.x,
        on_moment.y,
        on_moment.z,
        u.x * dw.x + t.x * w.x,
        u.x * dw.y + u.y * dw.x + t.x * w.y + t.y * w.x,
        u.x * dw.z + u.z * dw.x + t.x * w.z + t.z * w.x,
        u.y * dw.y + t.y * w.y,
        u.y * dw.z + u.z * dw.y + t.y * w.z + t.z * w.y,
        u.z * dw.z + t.z * w.z,
    ]
}

/// Row of joint `joint` for the sample in `sweep`: entry `10 i + k` belongs to parameter `k` of link
/// `i`; `row` has length `10 n`, entries of links before the joint are zero.
#[inline(always)]
pub fn regressor_row_into(arm: &RigidArm, sweep: &Sweep, joint: usize, row: &mut [f64]) {
    let zero = 0.0;
    row[..TEN * joint].fill(zero);
    let none = Vector3::from_element(zero);
    let mut u = Vector3::new(zero, zero, 1.0);
    let mut s = none;
    let turns = arm.joints[joint].kind.is_rotational();
    for i in joint..arm.dof() {
        if i > joint {
            let pose = &sweep.poses[i];
            u = pose.to_child(&u);
            s = pose.to_child(&(s + pose.s));
        }
        let entries = if turns {
            link_row(&sweep.motions[i], &u, &u.cross(&s))
        } else {
            link_row(&sweep.motions[i], &none, &u)
        };
        row[TEN * i..TEN * (i + 1)].copy_from_slice(&entries);
    }
}

/// Regressor of one sample in the standard parameters: n rows of `10 n` entries, row-major.
///
/// Identity: `Y π = τ` of [`crate::inverse_dynamics`], `π` the links' [`InertialParameters::to_array`]
/// one after another.
pub fn standard_regressor(arm: &RigidArm, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let n = arm.dof();
    let mut sweep = Sweep::new(n);
    sweep.run(arm, q, dq, ddq);
    let mut all = vec![0.0; n * TEN * n];
    for (joint, row) in all.chunks_mut(TEN * n).enumerate() {
        regressor_row_into(arm, &sweep, joint, row);
    }
    all
}

/// Row of one joint in the standard parameters over consecutive samples of a motion.
#[derive(Debug, Clone, Copy)]
pub struct RegressorRow<'a> {
    /// The joint.
    pub joint: usize,
    /// First sample.
    pub first: usize,
    samples: usize,
    columns: &'a [Column],
}

impl RegressorRow<'_> {
    /// Columns of the links that the joint moves, with their index `10 i + k` for parameter `k` of link `i`; the other
    /// columns are zero.
    pub fn columns(&self) -> impl Iterator<Item = (usize, &[f64])> {
        let of_joint = self.columns.iter().enumerate().skip(TEN * self.joint);
        of_joint.map(|(k, column)| (k, &column[..self.samples]))
    }
}

/// Calls `each` with the rows of all joints over a motion, some samples at a time: the regressor of a long motion is larger than the
/// motion by the number of parameters and need not be kept.
pub fn for_each_regressor_row(
    arm: &RigidArm,
    motion: &ArmMotion<'_>,
    mut each: impl FnMut(RegressorRow<'_>),
) {
    let all = vec![[true; TEN]; arm.dof()];
    for_each_row(arm, &motion.columns(), 0..arm.dof(), &all, |joint, first, samples, columns| {
        each(RegressorRow { joint, first, samples, columns });
    });
}

/// Columns that are fixed linear combinations of the standard parameters.
#[derive(Debug, Clone)]
pub struct ParameterColumns {
    /// per column: (index into the `10 n` standard parameters, coefficient), without zeros
    columns: Vec<Vec<(usize, f64)>>,
}

impl ParameterColumns {
    /// One column for each set of body constants: the effort of an arm that has these constants.
    ///
    /// With "this constant 1, all others 0" the columns are those of the minimal set.
    pub fn from_constants(arm: &RigidArm, constants: &[Vec<BodyConstants>]) -> Self {
        let columns = constants
            .iter()
            .map(|set| {
                let links = links_from_constants(&arm.joints, set);
                let numbers = links.iter().flat_map(InertialParameters::to_array);
                numbers.enumerate().filter(|(_, value)| *value != 0.0).collect()
            })
            .collect();
        Self { columns }
    }

    /// The `10 n` standard parameters themselves.
    pub fn standard(dof: usize) -> Self {
        Self { columns: (0..TEN * dof).map(|k| vec![(k, 1.0)]).collect() }
    }

    /// One column: those in `wanted`, each times its factor.
    #[must_use]
    pub fn combined(&self, wanted: &[usize], factors: &[f64]) -> Self {
        let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
        for (&column, factor) in wanted.iter().zip(factors) {
            for &(k, x) in &self.columns[column] {
                *sum.entry(k).or_default() += factor * x;
            }
        }
        Self { columns: vec![sum.into_iter().collect()] }
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is no column.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// A standard-parameter row mapped to these columns; `out` has one entry per column.
    #[inline(always)]
    pub fn map_row(&self, row: &[f64], out: &mut [f64]) {
        for (out, column) in out.iter_mut().zip(&self.columns) {
            *out = column.iter().fold(0.0, |sum, &(k, factor)| sum + row[k] * factor);
        }
    }

    /// Regressor of one sample: n rows of `len()` entries, row-major.
    pub fn regressor(&self, arm: &RigidArm, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let standard = standard_regressor(arm, q, dq, ddq);
        let mut all = vec![0.0; arm.dof() * self.len()];
        for (row, out) in standard.chunks(TEN * arm.dof()).zip(all.chunks_mut(self.len().max(1))) {
            self.map_row(row, out);
        }
        all
    }

    /// Columns of one joint over a whole motion, `[column][sample]`, for the columns in `wanted`.
    ///
    /// Memory is the result.
    pub fn of_motion(
        &self,
        arm: &RigidArm,
        joint: usize,
        q: &[Vec<f64>],
        dq: &[Vec<f64>],
        ddq: &[Vec<f64>],
        wanted: &[usize],
    ) -> Vec<Vec<f64>> {
        self.of_arm_motion(arm, joint, &ArmMotion::new(q, dq, ddq), wanted)
    }

    /// The same for a motion of the arm.
    pub fn of_arm_motion(
        &self,
        arm: &RigidArm,
        joint: usize,
        motion: &ArmMotion<'_>,
        wanted: &[usize],
    ) -> Vec<Vec<f64>> {
        let chosen: Vec<Vec<(usize, f64)>> = (wanted.iter())
            .map(|&c| {
                let of_links = self.columns[c].iter().copied();
                // links before the joint do not move it
                of_links.filter(|(k, _)| *k >= TEN * joint).collect()
            })
            .collect();
        let mut needed = vec![[false; TEN]; arm.dof()];
        for (k, _) in chosen.iter().flatten() {
            needed[k / TEN][k % TEN] = true;
        }
        let mut result = vec![vec![0.0; motion.samples()]; wanted.len()];
        let rows = joint..joint + 1;
        for_each_row(arm, &motion.columns(), rows, &needed, |_, first, len, row| {
            for (column, terms) in result.iter_mut().zip(&chosen) {
                let out = &mut column[first..first + len];
                for &(k, factor) in terms {
                    for (sum, x) in out.iter_mut().zip(&row[k]) {
                        *sum += factor * x;
                    }
                }
            }
        });
        result
    }
}
