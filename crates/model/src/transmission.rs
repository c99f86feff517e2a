//! The transmission between a motor and its link: what passes for a deflection and its rate.

use serde::{Deserialize, Serialize};

/// The flanks of a gear are stiffer than what the recordings resolve: the link bounces on them at this
/// circular frequency \[rad/s\], with this share of critical damping: lubricated flanks hardly rebound.
pub(crate) const FLANK_RATE: f64 = 350.0;
pub(crate) const FLANK_DAMPING: f64 = 0.8;

/// What lies between motor and link.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transmission {
    /// Gap in which no effort passes \[rad or m\]; 0 for a springy transmission.
    pub gap: f64,
    /// \[N m/rad or N/m\]
    pub stiffness: f64,
    /// \[N m s/rad or N s/m\]
    pub damping: f64,
}

/// A transmission in a model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TransmissionTerm {
    /// Joint.
    pub joint: String,
    /// What lies between.
    pub transmission: Transmission,
    /// Inertia of the motor beyond the model's \[kg m2 or kg\].
    pub motor_inertia: f64,
    /// Fitted size of the difference to a rigid transmission; 1 where the law holds.
    pub share: f64,
}

impl Transmission {
    /// The gap that a fitted size of the difference to a rigid transmission stands for. A link goes from flank to flank
    /// sooner than the band tells, so that its efforts grow with the gap: one a tenth too large taken nine tenths is nearly
    /// the same in them, and the misfit has its bottom where the assumed flanks blur impacts as the recordings do.
    pub fn gap_told(&self, share: f64) -> f64 {
        share * self.gap
    }

    /// Effort that passes for a deflection and its rate.
    pub fn effort(&self, deflection: f64, rate: f64) -> f64 {
        let half = 0.5 * self.gap;
        if self.gap > 0.0 {
            let side = deflection.signum();
            let pressed = deflection.abs() - half;
            if pressed <= 0.0 {
                return 0.0;
            }
            // flanks push, they do not pull
            return side * (self.stiffness * pressed + self.damping * rate * side).max(0.0);
        }
        self.stiffness * deflection + self.damping * rate
    }

    /// Deflection under an effort.
    pub fn twist_under(&self, effort: f64) -> f64 {
        effort / self.stiffness + 0.5 * self.gap * effort.signum()
    }
}

/// The transmission that a shape stands for: stiffness and damping, or a gap.
pub fn of_shape(slug: &str, shape: &[f64], inertia: f64) -> Transmission {
    if slug == "backlash" {
        return Transmission {
            gap: shape[0],
            stiffness: inertia * FLANK_RATE * FLANK_RATE,
            damping: 2.0 * FLANK_DAMPING * inertia * FLANK_RATE,
        };
    }
    Transmission { gap: 0.0, stiffness: shape[0], damping: shape[1] }
}

/// A spring that an answer has found, as the columns of links are formed beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Joint, from 0.
    pub joint: usize,
    /// What lies between motor and link.
    pub transmission: Transmission,
    /// Fitted size of the difference to a rigid transmission; 1 where the law holds
    pub share: f64,
}
