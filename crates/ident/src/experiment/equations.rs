//! Effort of a held joint while one other joint moves: equations (55)-(61) of Lin 1992.

use armident_dynamics::RigidArm;
use nalgebra::Vector3;

use crate::minimal_set::{Constant, ConstantKind};

/// Which equation of the paper a row is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equation {
    /// Rotational joint moves, rotational joint observed.
    Eq56,
    /// Rotational joint r moves, translational joint before s observed.
    Eq57,
    /// Rotational joint moves and is observed.
    Eq58,
    /// Translational joint moves, rotational joint observed.
    Eq59,
    /// Translational joint moves and is observed.
    Eq60,
    /// Rotational joint moves, translational joint observed.
    Eq61,
    /// Translational joint moves, another translational joint observed: `h = m̂ u_z` of (9).
    Eq9,
}

impl Equation {
    /// `(56)` and so on.
    pub fn number(self) -> &'static str {
        match self {
            Self::Eq56 => "(56)",
            Self::Eq57 => "(57)",
            Self::Eq58 => "(58)",
            Self::Eq59 => "(59)",
            Self::Eq60 => "(60)",
            Self::Eq61 => "(61)",
            Self::Eq9 => "(9)",
        }
    }

    /// The equation for a moving and an observed joint; `unknown_c` when `C₁, C₂` are sought.
    pub fn of(arm: &RigidArm, moving: usize, observed: usize, unknown_c: bool) -> Self {
        let turns = |j: usize| arm.joints[j].kind.is_rotational();
        match (turns(moving), turns(observed), moving == observed) {
            (true, true, true) => Self::Eq58,
            (true, true, false) => Self::Eq56,
            (true, false, _) if unknown_c => Self::Eq57,
            (true, false, _) => Self::Eq61,
            (false, true, _) => Self::Eq59,
            (false, false, true) => Self::Eq60,
            (false, false, false) => Self::Eq9,
        }
    }
}

/// Coefficients of the observed joint's own constants in its effort, while `moving` moves with
/// `dq, ddq` at positions `q` and every other joint is held (52)-(61).
///
/// The whole effort is this row times the constants plus the same row with `ℓ, V` in the place of
/// `k, U`: what belongs to later joints. `constants` must all belong to joint `observed >= moving`.
pub fn single_motion_row(
    arm: &RigidArm,
    moving: usize,
    observed: usize,
    q: &[f64],
    dq: f64,
    ddq: f64,
    constants: &[Constant],
) -> Vec<f64> {
    let poses = arm.poses(q);
    let gravity = arm.gravity_in_frames(&poses)[observed];
    let (u, s) = arm.axis_in_frames(&poses, moving)[observed - moving];
    let dq2 = dq * dq;
    let moving_turns = arm.joints[moving].kind.is_rotational();
    let observed_turns = arm.joints[observed].kind.is_rotational();
    // (55); a moving slide pushes every later origin along its axis
    let a = if moving_turns { u.cross(&s) * ddq + u.cross(&u.cross(&s)) * dq2 } else { u * ddq };
    let felt = a - gravity;
    let (dw, w2) = if moving_turns { (ddq, dq2) } else { (0.0, 0.0) };
    // first moments: on a rotational joint (56), (59); on a translational one (61)
    let on_k = if observed_turns {
        Vector3::new(felt.y, -felt.x, 0.0)
    } else {
        Vector3::new(
            -u.y * dw + u.x * u.z * w2,
            u.x * dw + u.y * u.z * w2,
            -(u.x * u.x + u.y * u.y) * w2,
        )
    };
    constants
        .iter()
        .map(|constant| match constant.quantity {
            ConstantKind::U11MinusU22 => -u.x * u.y * w2,
            ConstantKind::U33 => u.z * dw,
            ConstantKind::U12 => (u.x * u.x - u.y * u.y) * w2,
            ConstantKind::U13 => u.x * dw - u.y * u.z * w2,
            ConstantKind::U23 => u.y * dw + u.x * u.z * w2,
            ConstantKind::Kx => on_k.x,
            ConstantKind::Ky => on_k.y,
            ConstantKind::Kz => on_k.z,
            // (57), (61): the slide carries its composite mass
            ConstantKind::Mass => felt.z,
            // (57), with u constant
            ConstantKind::C1(_) => dw,
            ConstantKind::C2(_) => -w2,
        })
        .collect()
}
