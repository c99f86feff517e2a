//! Parameters of a joint behind a position controller, over its stiffness.

use armident_effects::{
    CoulombFriction, Effect, EffectOnJoint, LoadDependentFriction, RotorInertia, StribeckFriction,
    TorqueOffset, ViscousFriction,
};

/// Values of [`ServoParameter`] in its order.
pub(super) type Values = [f64; 9];

/// A parameter of a joint behind a controller. Of a stiffness `K` that is not determined, what is over `K` is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServoParameter {
    /// `1/K` \[rad/(N m) or m/N\].
    Compliance,
    /// Constant effort over `K` \[rad or m\].
    Offset,
    /// Coulomb friction over `K` \[rad or m\].
    DryFriction,
    /// Viscous friction, back-EMF and derivative gain over `K` \[s\].
    Damping,
    /// Inertia of the rotor over `K` \[s²\].
    Inertia,
    /// Delay of the command \[s\].
    Delay,
    /// Static friction beyond Coulomb friction over `K` \[rad or m\].
    StaticExcess,
    /// Stribeck velocity \[rad/s or m/s\].
    StribeckVelocity,
    /// Dry friction by load \[1\].
    LoadFriction,
}

pub(super) const ALL: [ServoParameter; 9] = [
    ServoParameter::Compliance,
    ServoParameter::Offset,
    ServoParameter::DryFriction,
    ServoParameter::Damping,
    ServoParameter::Inertia,
    ServoParameter::Delay,
    ServoParameter::StaticExcess,
    ServoParameter::StribeckVelocity,
    ServoParameter::LoadFriction,
];

/// An estimate with its standard error; none where the parameter is not fitted or there are too few blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoValue {
    /// What is estimated.
    pub parameter: ServoParameter,
    /// In the unit of the parameter.
    pub value: f64,
    /// In the unit of the parameter.
    pub standard_error: Option<f64>,
}

/// Effects of a joint in N m or N.
pub(super) fn effects(x: &Values, stiffness: f64, joint: &str) -> Vec<EffectOnJoint> {
    let of = |p: ServoParameter| x[p as usize];
    let on =
        |law: &dyn Effect, parameters: Vec<f64>| EffectOnJoint::new(law.slug(), joint, parameters);
    let dry = of(ServoParameter::DryFriction) * stiffness;
    let excess = of(ServoParameter::StaticExcess) * stiffness;
    let by_load = of(ServoParameter::LoadFriction);
    let mut all = vec![
        on(&ViscousFriction, vec![of(ServoParameter::Damping) * stiffness]),
        on(&TorqueOffset, vec![of(ServoParameter::Offset) * stiffness]),
        on(&RotorInertia, vec![of(ServoParameter::Inertia) * stiffness]),
    ];
    let has_excess = excess > 0.0;
    if has_excess {
        let velocity = of(ServoParameter::StribeckVelocity);
        all.push(on(&StribeckFriction, vec![dry + excess, dry, velocity]));
    } else if by_load <= 0.0 {
        all.push(on(&CoulombFriction, vec![dry]));
    }
    if by_load > 0.0 {
        let level = if has_excess { 0.0 } else { dry };
        all.push(on(&LoadDependentFriction, vec![level, by_load]));
    }
    all
}
