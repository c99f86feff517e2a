//! Motors that move several joints.

use crate::recording::Quantity;

/// Smallest pivot over largest entry of a matrix that is inverted: below it motors and joints do
/// not determine each other within the precision of an encoder.
const SMALLEST_PIVOT: f64 = 1e-6;

/// Motors and joints with `q_motor = R q_joint`; by the principle of virtual work
/// `tau_joint = Rᵀ tau_motor`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coupling {
    pub(super) line: u64,
    pub(super) joints: Vec<String>,
    pub(super) motors: Vec<String>,
    /// R, by rows.
    matrix: Vec<Vec<f64>>,
    inverse: Vec<Vec<f64>>,
    /// Added to the joint positions \[rad or m\].
    offset: Vec<f64>,
}

impl Coupling {
    /// # Errors
    /// What is wrong and what to do.
    pub(super) fn new(
        line: u64,
        joints: Vec<String>,
        motors: Vec<String>,
        matrix: Vec<Vec<f64>>,
        offset: Vec<f64>,
    ) -> Result<Self, (String, String)> {
        let n = joints.len();
        let said = |what: String, advice: &str| Err((what, advice.to_owned()));
        if n == 0 || motors.len() != n {
            let what = format!("{n} joints and {} motors are coupled", motors.len());
            return said(what, "give as many motors as joints, at least one");
        }
        if matrix.len() != n || matrix.iter().any(|row| row.len() != n) || offset.len() != n {
            let what = format!("`matrix` must be {n} by {n} and `offset` have {n} numbers");
            return said(what, "one row per motor, one number per joint in it");
        }
        for names in [&joints, &motors] {
            if let Some(name) = names
                .iter()
                .enumerate()
                .find_map(|(k, name)| names[..k].contains(name).then_some(name))
            {
                return said(format!("`{name}` is coupled twice"), "give every name once");
            }
        }
        let Some(inverse) = inverse(&matrix) else {
            let what = "`matrix` cannot be inverted".to_owned();
            return said(what, "give motor positions from joint positions, one row per motor");
        };
        Ok(Self { line, joints, motors, matrix, inverse, offset })
    }

    /// Joint columns from motor columns; none for a quantity that belongs to the motors alone.
    pub(super) fn to_joints(&self, quantity: Quantity, motors: &[&[f64]]) -> Option<Vec<Vec<f64>>> {
        use Quantity::{Acceleration, Effort, MotorPosition, Position, Velocity};
        let n = self.joints.len();
        let samples = motors.first().map_or(0, |column| column.len());
        let weight = |joint: usize, motor: usize| match quantity {
            Effort => self.matrix[motor][joint],
            _ => self.inverse[joint][motor],
        };
        let offset = |joint: usize| match quantity {
            Position | MotorPosition => self.offset[joint],
            _ => 0.0,
        };
        if !matches!(quantity, Position | Velocity | Acceleration | Effort | MotorPosition) {
            return None;
        }
        let one = |joint: usize, k: usize| {
            let sum: f64 = (0..n).map(|motor| weight(joint, motor) * motors[motor][k]).sum();
            sum + offset(joint)
        };
        Some((0..n).map(|joint| (0..samples).map(|k| one(joint, k)).collect()).collect())
    }
}

/// By elimination with pivots; none if a pivot vanishes.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    let largest = matrix.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut left = matrix.to_vec();
    let mut right: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for column in 0..n {
        let pivot =
            (column..n).max_by(|a, b| left[*a][column].abs().total_cmp(&left[*b][column].abs()))?;
        left.swap(column, pivot);
        right.swap(column, pivot);
        let scale = left[column][column];
        if scale.abs() <= SMALLEST_PIVOT * largest {
            return None;
        }
        for row in (0..n).filter(|row| *row != column) {
            let factor = left[row][column] / scale;
            for k in 0..n {
                left[row][k] -= factor * left[column][k];
                right[row][k] -= factor * right[column][k];
            }
        }
        for k in 0..n {
            left[column][k] /= scale;
            right[column][k] /= scale;
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrist() -> Coupling {
        let names = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let matrix = vec![vec![45.0, 0.0], vec![32.0, 32.0]];
        Coupling::new(1, names(["j5", "j6"]), names(["m5", "m6"]), matrix, vec![0.0; 2]).unwrap()
    }

    #[test]
    fn positions_are_those_of_the_joints() {
        let (q5, q6) = (0.3, -0.2);
        let motors = [vec![45.0 * q5], vec![32.0 * (q5 + q6)]];
        let columns: Vec<&[f64]> = motors.iter().map(Vec::as_slice).collect();
        let joints = wrist().to_joints(Quantity::Position, &columns).unwrap();
        assert!((joints[0][0] - q5).abs() < 1e-15 && (joints[1][0] - q6).abs() < 1e-15);
        assert!(wrist().to_joints(Quantity::Current, &columns).is_none());
    }

    #[test]
    fn power_is_preserved() {
        let velocity = [vec![1.5, -20.0], vec![7.0, 3.0]];
        let effort = [vec![0.2, 0.1], vec![-0.4, 0.6]];
        let columns = |motors: &[Vec<f64>; 2], quantity| {
            let columns: Vec<&[f64]> = motors.iter().map(Vec::as_slice).collect();
            wrist().to_joints(quantity, &columns).unwrap()
        };
        let (qd, tau) =
            (columns(&velocity, Quantity::Velocity), columns(&effort, Quantity::Effort));
        for k in 0..2 {
            let power = |v: &[Vec<f64>], e: &[Vec<f64>]| v[0][k] * e[0][k] + v[1][k] * e[1][k];
            assert!((power(&qd, &tau) - power(&velocity, &effort)).abs() < 1e-12);
        }
        assert!((tau[0][0] - (45.0 * 0.2 + 32.0 * -0.4)).abs() < 1e-12);
    }

    #[test]
    fn singular_matrices_are_refused() {
        assert!(inverse(&[vec![1.0, 2.0], vec![2.0, 4.0]]).is_none());
        assert!(inverse(&[vec![0.0]]).is_none());
        assert!(inverse(&[vec![0.0, 1.0], vec![-2.0, 0.0]]).is_some());
    }
}
