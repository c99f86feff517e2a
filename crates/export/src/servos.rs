//! Position controllers, which simulators have as actuators.

use armident_effects::{EffectOnJoint, Library, Mechanism, PositionServo};

use crate::Lost;

/// The position controllers among effects, and the other effects.
pub(crate) fn servos(
    library: &Library,
    effects: &[EffectOnJoint],
) -> (Vec<(EffectOnJoint, PositionServo)>, Vec<EffectOnJoint>) {
    let (mut servos, mut others) = (Vec::new(), Vec::new());
    for on in effects {
        match library.resolve(on).map(|effect| effect.mechanism(&on.parameters)) {
            Ok(Mechanism::Servo(servo)) => servos.push((on.clone(), servo)),
            _ => others.push(on.clone()),
        }
    }
    (servos, others)
}

/// What an actuator cannot hold of a position controller, with the reasons for delay and dead band.
pub(crate) fn lost_of_servo(
    on: &EffectOnJoint,
    servo: &PositionServo,
    no_delay: &'static str,
    no_dead_band: &'static str,
) -> Vec<Lost> {
    let parts = [(servo.delay_s, no_delay), (servo.dead_band, no_dead_band)];
    let lost = |(value, reason)| Lost {
        effect: on.effect.clone(),
        joint: on.joint.clone(),
        parameters: vec![value],
        reason,
    };
    parts.into_iter().filter(|(value, _)| *value != 0.0).map(lost).collect()
}
