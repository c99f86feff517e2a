//! Spring and play between the motor of a joint and its link: the one law of a transmission.

use armident_dynamics::{RigidArm, gravity_effort};

/// Rounds in which the twist of resting links and the effort they carry agree.
const RESTING_ROUNDS: usize = 50;

/// Spring, damper and play between the motor of a joint and its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmission {
    /// Play from flank to flank \[rad or m\].
    pub gap: f64,
    /// Stiffness \[N m/rad or N/m\].
    pub stiffness: f64,
    /// Damping \[N m s/rad or N s/m\].
    pub damping: f64,
    /// Inertia of the motor on the joint side \[kg m2 or kg\].
    pub motor_inertia: f64,
}

impl Transmission {
    /// Effort on the link when the motor is ahead of it by `twist`, growing at `rate`. Flanks with
    /// play push and do not pull.
    pub fn effort(&self, twist: f64, rate: f64) -> f64 {
        if self.gap <= 0.0 {
            return self.stiffness * twist + self.damping * rate;
        }
        let beyond = twist.abs() - 0.5 * self.gap;
        if beyond <= 0.0 {
            return 0.0;
        }
        let side = twist.signum();
        side * (self.stiffness * beyond + self.damping * rate * side).max(0.0)
    }

    /// Twist at which the resting transmission carries this effort; in the middle of its play where that is 0.
    pub fn twist_under(&self, effort: f64) -> f64 {
        if effort == 0.0 { 0.0 } else { self.twist_on_flank(effort) }
    }

    /// Twist at which the resting transmission carries this effort, the link against the flank of its sign also where it
    /// is 0.
    pub fn twist_on_flank(&self, effort: f64) -> f64 {
        effort / self.stiffness + 0.5 * self.gap * effort.signum()
    }

    /// Twist of the resting transmission when the effort it carries depends on the twist itself.
    pub fn resting_twist(&self, effort_at: impl Fn(f64) -> f64) -> f64 {
        (0..RESTING_ROUNDS).fold(0.0, |twist, _| self.twist_under(effort_at(twist)))
    }
}

/// Positions of the links at rest when the recorded positions are those of the motors; one transmission or none a joint.
pub fn resting_links(
    arm: &RigidArm,
    transmissions: &[Option<Transmission>],
    recorded: &[f64],
) -> Vec<f64> {
    let mut links = recorded.to_vec();
    if transmissions.iter().all(Option::is_none) {
        return links;
    }
    for _ in 0..RESTING_ROUNDS {
        let weight: Vec<f64> = gravity_effort(arm, &links);
        for (j, link) in links.iter_mut().enumerate() {
            if let Some(transmission) = transmissions[j] {
                *link = recorded[j] - transmission.twist_under(weight[j]);
            }
        }
    }
    links
}

/// Whether a fit of the two columns of a transmission may carry its name. Beside a simulated motion of the link: about as
/// large as simulated, and the inertia of a motor; else a compliance and an inertia.
pub(crate) fn is_transmission_fit(shape: &[f64], coefficients: &[f64]) -> bool {
    if !shape.is_empty() {
        return (0.3..1.7).contains(&coefficients[0]) && coefficients[1] >= 0.0;
    }
    coefficients.len() < 2 || coefficients[0] > 0.0 && coefficients[1] >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resting_twist_carries_its_own_load() {
        let loose = Transmission { gap: 0.02, stiffness: 400.0, damping: 1.0, motor_inertia: 0.1 };
        let load = |twist: f64| 12.0 + 30.0 * twist;
        let twist = loose.resting_twist(load);
        assert!((loose.effort(twist, 0.0) - load(twist)).abs() < 1e-9);
        assert_eq!(loose.effort(0.009, 5.0), 0.0);
        assert_eq!(loose.effort(0.011, -5.0), 0.0);
        assert_eq!((loose.twist_under(0.0), loose.twist_on_flank(0.0)), (0.0, 0.01));
        assert_eq!(loose.twist_under(4.0), loose.twist_on_flank(4.0));
    }
}
