//! Efforts between samples: how fast the effort of a joint can change at most.
//!
//! With `Ω_i, A_i, J_i` bounds of angular velocity, acceleration and jerk of link `i`, each vector that is fixed in a link
//! has derivatives of at most `Ω, A + Ω², J + 3ΩA + Ω³` times its length, and an inertia tensor
//! `d²(I ω)/dt² <= (J + 6ΩA + 4Ω³) |I|`. Forces and moments of the Newton-Euler recursion (Lin 1992, eq. 1 and 2) are
//! sums of such terms.
//!
//! References: own.

use armident_dynamics::RigidArm;

/// Bounds of the motion of one joint over an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rates {
    /// of the position
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
}

/// Bound of the derivative of each joint's effort \[N m/s or N/s\] over an interval in which the joints keep to `rates`.
pub(crate) fn effort_rates(arm: &RigidArm, rates: &[Rates]) -> Vec<f64> {
    let n = arm.dof();
    let gravity = arm.gravity_e0.norm();
    // of the frame before, then of the link's own
    let (mut w, mut dw, mut ddw) = (0.0, 0.0, 0.0);
    let (mut a, mut da) = (0.0, 0.0);
    let (mut reach, mut reach_rate) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let (mut force, mut force_rate) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let (mut moment, mut moment_rate) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let mut spin = Vec::with_capacity(n);
    for ((joint, link), of) in arm.joints.iter().zip(&arm.links).zip(rates) {
        let turns = joint.kind.is_rotational();
        let slide = if turns { [0.0; 3] } else { [of.velocity, of.acceleration, of.jerk] };
        let along = if turns { joint.frame.d_m } else { joint.frame.d_m.abs() + of.position };
        let s = joint.frame.b_m.hypot(along);
        a += (dw + w * w) * s + 2.0 * w * slide[0] + slide[1];
        da += (ddw + 3.0 * w * dw + w * w * w) * s
            + 3.0 * (dw + w * w) * slide[0]
            + 3.0 * w * slide[1]
            + slide[2];
        reach.push(s);
        reach_rate.push(w * s + slide[0]);
        if turns {
            ddw += of.jerk + 2.0 * w * of.acceleration + (dw + w * w) * of.velocity;
            dw += of.acceleration + w * of.velocity;
            w += of.velocity;
        }
        spin.push(w);
        let (m, k) = (link.mass_kg.abs(), link.first_moment_kgm.norm());
        let inertia = link.inertia_origin_kgm2.norm();
        let felt = a + gravity;
        let (second, third) = (dw + w * w, ddw + 3.0 * w * dw + w * w * w);
        force.push(m * felt + second * k);
        force_rate.push(m * da + third * k);
        moment.push(k * felt + inertia * (dw + 2.0 * w * w));
        moment_rate.push(w * k * felt + k * da + inertia * (ddw + 6.0 * w * dw + 4.0 * w * w * w));
    }
    // from the tip: forces and moments about each joint
    let (mut f, mut df, mut m, mut dm) = (0.0, 0.0, 0.0, 0.0);
    let mut bounds = vec![0.0; n];
    for i in (0..n).rev() {
        if let (Some(r), Some(dr)) = (reach.get(i + 1), reach_rate.get(i + 1)) {
            m += r * f;
            dm += r * df + dr * f;
        }
        f += force[i];
        df += force_rate[i];
        m += moment[i];
        dm += moment_rate[i];
        bounds[i] = match arm.joints[i].kind.is_rotational() {
            true => spin[i] * m + dm,
            false => spin[i] * f + df,
        };
    }
    bounds
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::fourier::FourierJoint;
    use crate::test_arms::{arm, stanford};
    use armident_dynamics::inverse_dynamics;

    /// The bound is above every difference quotient of the efforts of a motion. How wide it is between the samples of a
    /// check is a test of [`crate::search`].
    #[test]
    fn bounds_hold_on_a_motion() {
        for arm in [arm(), stanford()] {
            let n = arm.dof();
            let period_s = 4.0;
            let joints: Vec<FourierJoint> = (0..n)
                .map(|j| {
                    let c = 0.3 + 0.05 * j as f64;
                    FourierJoint::at_rest(0.2, vec![c, -0.4 * c, 0.1], vec![0.2, c, -0.1])
                })
                .collect();
            let rates: Vec<Rates> = joints
                .iter()
                .map(|joint| {
                    let bounds = joint.bounds(period_s);
                    let [velocity, acceleration, jerk] = bounds.derivatives;
                    let position = bounds.position[0].abs().max(bounds.position[1].abs());
                    Rates { position, velocity, acceleration, jerk }
                })
                .collect();
            let bounds = effort_rates(&arm, &rates);
            let efforts = |t: f64| -> Vec<f64> {
                let of = |k: usize| -> Vec<f64> {
                    joints.iter().map(|joint| joint.at(t, period_s)[k]).collect()
                };
                inverse_dynamics(&arm, &of(0), &of(1), &of(2))
            };
            let step_s = 1e-3;
            let mut largest = vec![0.0_f64; n];
            for k in 0..4000 {
                let t = f64::from(k) * step_s;
                let (now, next) = (efforts(t), efforts(t + step_s));
                for (j, most) in largest.iter_mut().enumerate() {
                    *most = most.max((next[j] - now[j]).abs() / step_s);
                }
            }
            for (bound, most) in bounds.iter().zip(&largest) {
                assert!(bound >= most, "{bound} {most}");
            }
        }
    }
}
