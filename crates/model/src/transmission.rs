//! The transmission between a motor and its link, as models hold it.
//!
//! What passes for a deflection and its rate is [`armident_effects::Transmission`]; here is that without the inertia of the
//! motor, which is a parameter of the fit and not of the motion behind it.

use armident_effects::Effect;
use serde::{Deserialize, Serialize};

/// Spring, damper and play between motor and link.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FittedTransmission {
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
    pub transmission: FittedTransmission,
    /// Inertia of the motor beyond the model's \[kg m2 or kg\].
    pub motor_inertia: f64,
    /// Fitted size of the difference to a rigid transmission; 1 where the law holds.
    pub share: f64,
}

impl FittedTransmission {
    /// The transmission that a law has for a shape; `link_inertia` is what the joint moves \[kg m2 or kg\]. None where
    /// the law has none.
    pub fn of_law(law: &dyn Effect, shape: &[f64], link_inertia: f64) -> Option<Self> {
        let armident_effects::Transmission { gap, stiffness, damping, .. } =
            law.transmission(shape, link_inertia)?;
        Some(Self { gap, stiffness, damping })
    }

    /// The same with the inertia of its motor.
    pub fn with_motor_inertia(self, motor_inertia: f64) -> armident_effects::Transmission {
        let Self { gap, stiffness, damping } = self;
        armident_effects::Transmission { gap, stiffness, damping, motor_inertia }
    }

    /// The gap that a fitted size of the difference to a rigid transmission stands for. A link goes from flank to flank
    /// faster than the band resolves, so that its efforts grow with the gap: a gap a tenth too large, at
    /// nine tenths of its size, is nearly the same in them, and the residual has its minimum where the assumed flanks blur
    /// impacts as the recordings do.
    pub fn fitted_gap(&self, share: f64) -> f64 {
        share * self.gap
    }

    /// Effort that passes for a deflection and its rate.
    pub fn effort(&self, deflection: f64, rate: f64) -> f64 {
        self.with_motor_inertia(0.0).effort(deflection, rate)
    }

    /// Deflection under an effort, against a flank of a gap.
    pub fn twist_under(&self, effort: f64) -> f64 {
        self.with_motor_inertia(0.0).twist_on_flank(effort)
    }
}

/// A fitted spring, as the columns of links are formed beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Joint, from 0.
    pub joint: usize,
    /// What lies between motor and link.
    pub transmission: FittedTransmission,
    /// Fitted size of the difference to a rigid transmission; 1 where the law holds
    pub share: f64,
}
