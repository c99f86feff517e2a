//! A springy transmission: the encoder is on the motor side.

use std::f64::consts::TAU;

use armident_dynamics::inverse_dynamics_of_motion;

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::{STEP, derivative, rate};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::{Effect, ShapeStep};
use crate::law::{Law, LawRole, LinkSide, LookAlike, Parameter, Scan, Scope};
use crate::mechanism::Mechanism;
use crate::motion::{ArmColumns, WholeArmMotion};
use crate::transmission::{Transmission, is_transmission_fit};

/// `J dω/dt + τ = effort`, `τ = K (θ - q) + D (ω - v)`.
pub struct JointElasticity;

const LAW: Law = Law {
    slug: "joint_elasticity",
    title: "joint elasticity",
    formula: "motor th (recorded), link q (hidden): J ddth + tJ = effort, tJ = K (th - q) + D (dth - dq), rigid(q) = tJ",
    scope: Scope::ThroughJoint,
    roles: &[LawRole::Inertia],
    parameters: &[
        Parameter::non_negative("stiffness", "N m/rad", "N/m").main(),
        Parameter::non_negative("damping", "N m s/rad", "N s/m"),
        Parameter::non_negative("motor_inertia", "kg m2", "kg"),
    ],
    contains: &["rotor_inertia"],
    scan: Scan::Simulated(LinkSide::Spring),
    look_alikes: &[
        LookAlike {
            slug: "rotor_inertia",
            separated_by: "Excite higher frequencies: elasticity resonates and moves the other joints.",
        },
        LookAlike {
            slug: "backlash",
            separated_by: "Record with and without gravity load: backlash acts only where the transmitted effort changes sign.",
        },
        LookAlike {
            slug: "time_delay",
            separated_by: "Excite high frequencies: elasticity has a resonance peak, a delay does not.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The gear is a spring: the encoder at the motor does not measure the link, which oscillates behind it.",
    sizes: &[
        "Simulators take 20 to 35 Hz with 7 % of critical damping (default of FloBaRoID, not measured)",
        "Stiffnesses of large KUKA arms were identified by Jubien and others (2014) and Dumas and others (2011)",
    ],
    signature: "Ringing at one frequency after every jerk, and at that frequency the opposite of inertia. It takes samples at more than twice the resonance.",
    example: Example::new("elbow_joint", &[900.0, 2.0, 0.2], Against::Time),
};

impl Effect for JointElasticity {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// First order in the compliance: the rigid effort at the link's position, behind the motor by
    /// effort / K, minus that at the motor's position.
    fn arm_columns(&self, joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let load = &motion.rigid_effort[joint];
        let speed = rate(load, motion.rate_hz);
        let curvature = rate(&speed, motion.rate_hz);
        let largest = load.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()));
        vec![derivative(motion, STEP / largest, |step| {
            let behind = |of: &[Vec<f64>], by: &[f64]| {
                let mut moved = of.to_vec();
                moved[joint].iter_mut().zip(by).for_each(|(x, by)| *x -= step * by);
                moved
            };
            inverse_dynamics_of_motion(
                motion.arm,
                &behind(motion.position, load),
                &behind(motion.velocity, &speed),
                &behind(motion.acceleration, &curvature),
            )
        })]
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        let [stiffness, damping, motor_inertia] = [parameters[0], parameters[1], parameters[2]];
        let gap = 0.0;
        Mechanism::Transmission(Transmission { gap, stiffness, damping, motor_inertia })
    }

    fn admits_fit(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        is_transmission_fit(shape, coefficients)
    }

    /// Transmissions resonate, at 5 Hz and above (cobots to large industrial arms); where the damper is stiffer than the spring at
    /// the lowest of these frequencies, nothing resonates: something else is late there.
    fn is_plausible(&self, parameters: &[f64]) -> bool {
        const LOWEST_RESONANCE_HZ: f64 = 5.0;
        TAU * LOWEST_RESONANCE_HZ * parameters[1] < parameters[0]
    }

    /// The damping is not known within a factor at first.
    fn shape_step(&self, constant: usize) -> Option<ShapeStep> {
        Some(match constant {
            1 => ShapeStep::relative(0.6, 0.01),
            _ => ShapeStep::relative(0.16, 0.001),
        })
    }

    /// A spring with little damping resonates with the motion in a narrow range of stiffnesses only; beside it the residual
    /// has a local minimum, at a damping that is too high.
    fn shapes_around(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        /// Stiffness over that of the shape, 2 % of the resonance apart, and damping over it.
        const STIFFNESSES: [f64; 11] =
            [0.8, 0.84, 0.88, 0.92, 0.96, 1.0, 1.04, 1.08, 1.12, 1.16, 1.2];
        const DAMPINGS: [f64; 2] = [0.5, 0.2];
        // a spring too stiff to resonate in the band has no shape
        let &[stiffness, damping] = shape else { return Vec::new() };
        let with = |d: &f64| STIFFNESSES.map(|k| vec![k * stiffness, d * damping]);
        DAMPINGS.iter().flat_map(with).collect()
    }

    fn transmission(&self, shape: &[f64], _link_inertia: f64) -> Option<Transmission> {
        let &[stiffness, damping] = shape else { return None };
        Some(Transmission { gap: 0.0, stiffness, damping, motor_inertia: 0.0 })
    }

    fn parameters_of_transmission(&self, of: &Transmission) -> Vec<f64> {
        vec![of.stiffness, of.damping, of.motor_inertia]
    }

    /// The resonance stays above 6 Hz, and the gear is no rubber: several times what a harmonic drive winds up under its
    /// rated load.
    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let inertia = context.inertia(joint);
        let motor = inertia * random.between(0.08, 0.3);
        let both = motor * inertia / (motor + inertia);
        let twist = if size.kind.is_rotational() { 0.04 } else { 4e-3 };
        let of_resonance = 1.0 / (both * (TAU * 6.0).powi(2));
        let most = of_resonance.min(twist / size.effort_range);
        let parameters = move |x: f64| {
            let stiffness = 1.0 / x;
            vec![stiffness, 2.0 * 0.06 * (stiffness * both).sqrt(), motor]
        };
        Some(DrawnEffect::new(joint, 0.25 * most, parameters).at_most(most))
    }
}
