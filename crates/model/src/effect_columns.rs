//! Columns of effects over the motion of an arm.

use armident_effects::{Effect, JointMotion, ReversalModel};
use armident_kinematics::JointKind;
use armident_motion::Motion;

/// Share of the root mean square speed below which dry friction reverses, where nothing was fitted.
pub const DEFAULT_SPEED_RESOLUTION: f64 = 0.05;

/// Columns of an effect on one joint of a motion, not filtered.
pub fn effect_columns(
    effect: &dyn Effect,
    shape: &[f64],
    kind: JointKind,
    joint: usize,
    motion: &Motion,
    reversal: Option<ReversalModel>,
) -> Vec<Vec<f64>> {
    let velocity = &motion.velocity[joint];
    let reversal = match (reversal, &motion.filter) {
        // without a low-pass velocities are exact: so is their sign
        (Some(ReversalModel::RegularisedSign { .. }) | None, None) => {
            ReversalModel::regularised(0.0)
        }
        (Some(given), _) => given,
        (None, _) => {
            let squares: f64 = velocity.iter().map(|v| v * v).sum();
            ReversalModel::regularised(
                DEFAULT_SPEED_RESOLUTION * (squares / velocity.len() as f64).sqrt(),
            )
        }
    };
    let direction = reversal.directions(&motion.position[joint], velocity);
    effect.columns(shape, &joint_motion(kind, joint, motion, &direction))
}

/// The motion of one joint as laws take it.
pub fn joint_motion<'a>(
    kind: JointKind,
    joint: usize,
    motion: &'a Motion,
    direction: &'a [f64],
) -> JointMotion<'a> {
    JointMotion {
        kind,
        time_s: &motion.time_s,
        position: &motion.position[joint],
        velocity: &motion.velocity[joint],
        acceleration: &motion.acceleration[joint],
        direction,
        rigid_effort: &[],
        temperature_c: &motion.temperature_c[joint],
    }
}

/// Columns of an effect on two neighbouring joints, `[column][joint]`.
pub fn pair_columns(
    effect: &dyn Effect,
    shape: &[f64],
    joints: [usize; 2],
    kinds: [JointKind; 2],
    motion: &Motion,
) -> Vec<[Vec<f64>; 2]> {
    // the direction is that of the common shaft, which the law forms itself
    let none = vec![0.0; motion.len()];
    let [a, b] = [0, 1].map(|side| joint_motion(kinds[side], joints[side], motion, &none));
    effect.pair_columns(shape, &a, &b)
}
