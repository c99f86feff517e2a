//! Coupled motors: each moves several joints.

use armident_numeric::{Mat, inverse};

use crate::quantity::Quantity;

/// Smallest pivot over largest entry of an invertible matrix: below it motors and joints do not
/// determine each other within the precision of an encoder.
const SMALLEST_PIVOT: f64 = 1e-6;

/// Motors and joints with `q_motor = R q_joint`; by the principle of virtual work
/// `tau_joint = Rᵀ tau_motor`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coupling {
    pub(super) line: u64,
    pub(super) joints: Vec<String>,
    pub(super) motors: Vec<String>,
    /// `R`, motors by joints.
    matrix: Mat<f64>,
    /// `R⁻¹`.
    inverse: Mat<f64>,
    /// Added to the joint positions \[rad or m\].
    offset: Vec<f64>,
}

impl Coupling {
    /// # Errors
    /// The fault and advice.
    pub(super) fn new(
        line: u64,
        joints: Vec<String>,
        motors: Vec<String>,
        matrix: &[Vec<f64>],
        offset: Vec<f64>,
    ) -> Result<Self, (String, String)> {
        let n = joints.len();
        let fault = |what: String, advice: &str| Err((what, advice.to_owned()));
        if n == 0 || motors.len() != n {
            let what = format!("coupling of {n} joints and {} motors", motors.len());
            return fault(what, "list as many motors as joints, at least one");
        }
        if matrix.len() != n || matrix.iter().any(|row| row.len() != n) || offset.len() != n {
            let what = format!("`matrix` must be {n} by {n} and `offset` must have {n} numbers");
            return fault(what, "write one row per motor with one number per joint");
        }
        for names in [&joints, &motors] {
            if let Some(name) = names
                .iter()
                .enumerate()
                .find_map(|(k, name)| names[..k].contains(name).then_some(name))
            {
                return fault(
                    format!("duplicate name `{name}` in the coupling"),
                    "list every name once",
                );
            }
        }
        let matrix = Mat::from_fn(n, n, |motor, joint| matrix[motor][joint]);
        let Some(inverse) = inverse(&matrix, SMALLEST_PIVOT) else {
            let what = "`matrix` is singular".to_owned();
            return fault(what, "write motor positions from joint positions, one row per motor");
        };
        Ok(Self { line, joints, motors, matrix, inverse, offset })
    }

    /// Joint columns from motor columns; none for a quantity of the motors only.
    pub(super) fn to_joints(&self, quantity: Quantity, motors: &[&[f64]]) -> Option<Vec<Vec<f64>>> {
        use Quantity::{Acceleration, Command, Effort, MotorPosition, Position, Velocity};
        let n = self.joints.len();
        let samples = motors.first().map_or(0, |column| column.len());
        let weight = |joint: usize, motor: usize| match quantity {
            Effort => self.matrix[(motor, joint)],
            _ => self.inverse[(joint, motor)],
        };
        let offset = |joint: usize| match quantity {
            Position | MotorPosition | Command => self.offset[joint],
            _ => 0.0,
        };
        if !matches!(
            quantity,
            Position | Velocity | Acceleration | Effort | MotorPosition | Command
        ) {
            return None;
        }
        let one = |joint: usize, k: usize| {
            let sum: f64 = (0..n).map(|motor| weight(joint, motor) * motors[motor][k]).sum();
            sum + offset(joint)
        };
        Some((0..n).map(|joint| (0..samples).map(|k| one(joint, k)).collect()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrist() -> Coupling {
        let names = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let matrix = vec![vec![45.0, 0.0], vec![32.0, 32.0]];
        Coupling::new(1, names(["j5", "j6"]), names(["m5", "m6"]), &matrix, vec![0.0; 2]).unwrap()
    }

    #[test]
    fn motor_positions_give_joint_positions() {
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
        let names = |letter: char, n: usize| (0..n).map(|k| format!("{letter}{k}")).collect();
        let is_accepted = |matrix: &[Vec<f64>]| {
            let n = matrix.len();
            Coupling::new(1, names('j', n), names('m', n), matrix, vec![0.0; n]).is_ok()
        };
        assert!(!is_accepted(&[vec![1.0, 2.0], vec![2.0, 4.0]]));
        assert!(!is_accepted(&[vec![0.0]]));
        assert!(is_accepted(&[vec![0.0, 1.0], vec![-2.0, 0.0]]));
    }
}
