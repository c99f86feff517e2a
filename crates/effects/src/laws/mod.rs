//! The laws, one file each. A new law is a file here, its `mod`, and its line in [`STANDARD`].

mod asymmetric_coulomb_friction;
mod backlash;
mod coulomb_friction;
mod drive_low_pass;
mod encoder_offset;
mod external_contact;
mod friction_drift;
mod friction_temperature;
mod gravity_direction;
mod joint_coupling;
mod joint_elasticity;
mod joint_spring;
mod link_geometry_error;
mod link_inertia_error;
mod load_dependent_friction;
mod payload;
mod position_control;
mod presliding_hysteresis;
mod quadratic_drag;
mod rotor_inertia;
mod stribeck_friction;
mod sublinear_viscous_friction;
mod time_delay;
mod torque_offset;
mod torque_ripple;
mod torque_scale;
mod viscous_friction;

pub use asymmetric_coulomb_friction::AsymmetricCoulombFriction;
pub use backlash::Backlash;
pub use coulomb_friction::CoulombFriction;
pub use drive_low_pass::DriveLowPass;
pub use encoder_offset::EncoderOffset;
pub use external_contact::ExternalContact;
pub use friction_drift::FrictionDrift;
pub use friction_temperature::FrictionTemperature;
pub use gravity_direction::{GravityDirection, tilted};
pub use joint_coupling::JointCoupling;
pub use joint_elasticity::JointElasticity;
pub use joint_spring::JointSpring;
pub use link_geometry_error::LinkGeometryError;
pub use link_inertia_error::LinkInertiaError;
pub use load_dependent_friction::LoadDependentFriction;
pub use payload::Payload;
pub use position_control::PositionControl;
pub use presliding_hysteresis::PreslidingHysteresis;
pub use quadratic_drag::QuadraticDrag;
pub use rotor_inertia::RotorInertia;
pub use stribeck_friction::StribeckFriction;
pub use sublinear_viscous_friction::SublinearViscousFriction;
pub use time_delay::TimeDelay;
pub use torque_offset::TorqueOffset;
pub use torque_ripple::TorqueRipple;
pub use torque_scale::TorqueScale;
pub use viscous_friction::ViscousFriction;

use crate::effect::Effect;

/// All laws, in the order in which tables list them.
pub(crate) const STANDARD: &[&dyn Effect] = &[
    &ViscousFriction,
    &CoulombFriction,
    &TorqueOffset,
    &RotorInertia,
    &AsymmetricCoulombFriction,
    &StribeckFriction,
    &LoadDependentFriction,
    &QuadraticDrag,
    &PreslidingHysteresis,
    &FrictionDrift,
    &JointSpring,
    &TorqueRipple,
    &TorqueScale,
    &JointCoupling,
    &JointElasticity,
    &Backlash,
    &EncoderOffset,
    &Payload,
    &LinkInertiaError,
    &GravityDirection,
    &TimeDelay,
    &ExternalContact,
    &SublinearViscousFriction,
    &PositionControl,
    &LinkGeometryError,
    &DriveLowPass,
    &FrictionTemperature,
];

/// The baseline terms: what every joint has in a plain identification, in the order of its parameter vectors.
pub const BASELINE: &[&dyn Effect] =
    &[&ViscousFriction, &CoulombFriction, &TorqueOffset, &RotorInertia];
