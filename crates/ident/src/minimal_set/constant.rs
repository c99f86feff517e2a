//! Names of the inertia constants of Theorem 2.

use std::fmt;

use armident_dynamics::BodyConstants;
use nalgebra::{Matrix3, Vector3};

/// Which number of a composite body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ConstantKind {
    /// `m̂` of a translational joint.
    Mass,
    /// `(U)₁₁ - (U)₂₂`.
    U11MinusU22,
    /// `(U)₃₃`.
    U33,
    /// `(U)₁₂`.
    U12,
    /// `(U)₁₃`.
    U13,
    /// `(U)₂₃`.
    U23,
    /// `(k)_x`.
    Kx,
    /// `(k)_y`.
    Ky,
    /// `(k)_z`.
    Kz,
    /// `C₁ = k · (z × u)` (40), `u` the constant direction of joint r in the frame.
    C1(Vector3<f64>),
    /// `C₂ = k · (z - u_z u)` (43).
    C2(Vector3<f64>),
}

/// One constant: a number of the composite body of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// Joint, from 0.
    pub joint: usize,
    /// Which number.
    pub quantity: ConstantKind,
}

impl Constant {
    /// The label of the paper with the joint counted from 1: `U2_11-U2_22`, `k3_C1`, `m3`.
    pub fn label(&self) -> String {
        let j = self.joint + 1;
        match self.quantity {
            ConstantKind::Mass => format!("m{j}"),
            ConstantKind::U11MinusU22 => format!("U{j}_11-U{j}_22"),
            ConstantKind::U33 => format!("U{j}_33"),
            ConstantKind::U12 => format!("U{j}_12"),
            ConstantKind::U13 => format!("U{j}_13"),
            ConstantKind::U23 => format!("U{j}_23"),
            ConstantKind::Kx => format!("k{j}_x"),
            ConstantKind::Ky => format!("k{j}_y"),
            ConstantKind::Kz => format!("k{j}_z"),
            ConstantKind::C1(_) => format!("k{j}_C1"),
            ConstantKind::C2(_) => format!("k{j}_C2"),
        }
    }

    /// SI unit.
    pub fn unit(&self) -> &'static str {
        match self.quantity {
            ConstantKind::Mass => "kg",
            ConstantKind::Kx
            | ConstantKind::Ky
            | ConstantKind::Kz
            | ConstantKind::C1(_)
            | ConstantKind::C2(_) => "kg m",
            _ => "kg m2",
        }
    }

    /// Whether the constant is a mass, an inertia or a first moment: the order in which Algorithm M
    /// takes them.
    pub(crate) fn rank_in_algorithm_m(&self) -> u8 {
        match self.unit() {
            "kg" => 0,
            "kg m2" => 1,
            _ => 2,
        }
    }

    /// Value of the constant in a set of body constants.
    pub fn value(&self, bodies: &[BodyConstants]) -> f64 {
        let body = &bodies[self.joint];
        let (k, u) = (&body.first_moment_kgm, &body.inertia_origin_kgm2);
        match self.quantity {
            ConstantKind::Mass => body.mass_kg,
            ConstantKind::U11MinusU22 => u[(0, 0)] - u[(1, 1)],
            ConstantKind::U33 => u[(2, 2)],
            ConstantKind::U12 => u[(0, 1)],
            ConstantKind::U13 => u[(0, 2)],
            ConstantKind::U23 => u[(1, 2)],
            ConstantKind::Kx => k.x,
            ConstantKind::Ky => k.y,
            ConstantKind::Kz => k.z,
            ConstantKind::C1(axis) => k.dot(&Vector3::z().cross(&axis)),
            ConstantKind::C2(axis) => k.dot(&(Vector3::z() - axis * axis.z)),
        }
    }

    /// Adds `value` of this constant to body constants that are zero elsewhere.
    ///
    /// `(U)₁₁ - (U)₂₂` goes into `(U)₁₁`; `C₁, C₂` into `k⊥`, the part of `k` normal to `u`.
    pub fn add_to(&self, value: f64, bodies: &mut [BodyConstants]) {
        let body = &mut bodies[self.joint];
        let u = &mut body.inertia_origin_kgm2;
        let mut symmetric = |i: usize, j: usize| {
            u[(i, j)] += value;
            if i != j {
                u[(j, i)] += value;
            }
        };
        match self.quantity {
            ConstantKind::Mass => body.mass_kg += value,
            ConstantKind::U11MinusU22 => symmetric(0, 0),
            ConstantKind::U33 => symmetric(2, 2),
            ConstantKind::U12 => symmetric(0, 1),
            ConstantKind::U13 => symmetric(0, 2),
            ConstantKind::U23 => symmetric(1, 2),
            ConstantKind::Kx => body.first_moment_kgm.x += value,
            ConstantKind::Ky => body.first_moment_kgm.y += value,
            ConstantKind::Kz => body.first_moment_kgm.z += value,
            ConstantKind::C1(axis) => {
                let across = Vector3::z().cross(&axis);
                body.first_moment_kgm += across * (value / across.norm_squared());
            }
            ConstantKind::C2(axis) => {
                let across = Vector3::z() - axis * axis.z;
                body.first_moment_kgm += across * (value / across.norm_squared());
            }
        }
    }
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.label())
    }
}

/// Body constants that are all zero.
pub(crate) fn zero_bodies(dof: usize) -> Vec<BodyConstants> {
    let zero = BodyConstants {
        mass_kg: 0.0,
        first_moment_kgm: Vector3::zeros(),
        inertia_origin_kgm2: Matrix3::zeros(),
    };
    vec![zero; dof]
}
